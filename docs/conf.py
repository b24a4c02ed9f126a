"""Sphinx configuration; neither the build nor its pages read anything from the network."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "gallery")]

project = "slipfold"
author = "the slipfold developers"
copyright = "2026, the slipfold developers"
release = installed_version("slipfold")
version = release

extensions = [
    "commands",
    "myst_parser",
    "numpydoc",
    "reproduction",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
    "sphinx-mathjax-offline",
]
exclude_patterns = ["_build", "gallery", "figures"]

# The scripts in gallery/ are run; the pages made of them, which are not kept, go beside them.
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "gallery_pages",
    "filename_pattern": r".*",
    "ignore_pattern": r"(^|/)(comparison|demos)\.py$",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "min_reported_time": 1e9,
    "remove_config_comments": True,
}
html_static_path = ["static"]
html_css_files = ["gallery.css"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"slipfold {release}"

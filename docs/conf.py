"""Sphinx configuration; the build reads nothing from the network."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

project = "slipfold"
author = "the slipfold developers"
copyright = "2026, the slipfold developers"
release = installed_version("slipfold")
version = release

extensions = [
    "myst_parser",
    "numpydoc",
    "reproduction",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
]
exclude_patterns = ["_build"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"slipfold {release}"

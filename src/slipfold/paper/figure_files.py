"""A figure as the files that are written of it."""

from __future__ import annotations

import io

from matplotlib.figure import Figure


def figure_files(canvas: Figure, key: str) -> dict[str, bytes]:
    """Return a figure as PDF and PNG."""
    contents = {}
    for suffix in ("pdf", "png"):
        memory = io.BytesIO()
        # Without the date the same numbers make the same file.
        metadata = {"CreationDate": None} if suffix == "pdf" else None
        canvas.savefig(memory, format=suffix, metadata=metadata)
        contents[f"{key}.{suffix}"] = memory.getvalue()
    return contents

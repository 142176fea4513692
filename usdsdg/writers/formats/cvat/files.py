"""Names of the files of a dataset for CVAT."""

from __future__ import annotations

NAME = "CvatWriter"
ANNOTATIONS, LABELS, PICTURES = "annotations.xml", "labels.json", "images"


def picture(stem: str, extension: str) -> str:
    """Return the file of a picture."""
    return f"{PICTURES}/{stem}.{extension}"

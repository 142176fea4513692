"""Names of the files of a dataset for CVAT."""

from __future__ import annotations

import re

from usdsdg.writers.formats.class_names import CONTROL

NAME = "CvatWriter"
ANNOTATIONS, LABELS, PICTURES = "annotations.xml", "labels.json", "images"
UNFIT = re.compile(CONTROL)  # of names of classes


def picture(stem: str, extension: str) -> str:
    """Return the file of a picture."""
    return f"{PICTURES}/{stem}.{extension}"

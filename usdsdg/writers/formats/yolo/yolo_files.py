"""Names of the files of a YOLO dataset, for its writer and its readers."""

from __future__ import annotations

NAME = "YoloWriter"
IMAGES, LABELS, DESCRIPTION = "images", "labels", "data.yaml"


def image_of(split: str, stem: str, extension: str) -> str:
    """Return the file of a picture."""
    return f"{IMAGES}/{split}/{stem}.{extension}"


def labels_of(split: str, stem: str) -> str:
    """Return the file of a picture's labels."""
    return f"{LABELS}/{split}/{stem}.txt"

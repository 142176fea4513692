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


def stem_of(product: str, frame: int, padding: int, *, several: bool) -> str:
    """Return the name of a frame's files; that of the render product is in it where there are several."""
    return (f"{product}_" if several else "") + f"{frame:0{padding}d}"

"""Names of the files of a Pascal VOC dataset, and the colors of its segments."""

from __future__ import annotations

import re

import numpy as np

NAME = "VocWriter"
PICTURES, ANNOTATIONS, CLASSES, OBJECTS = "JPEGImages", "Annotations", "SegmentationClass", "SegmentationObject"
LABELS = "labelmap.txt"  # index, name and color of each class, as Datumaro and CVAT read it
MAIN, SEGMENTATION = "ImageSets/Main", "ImageSets/Segmentation"
BACKGROUND = "background"
VOID = 255  # what belongs to no class


def picture(stem: str, extension: str) -> str:
    """Return the file of a picture."""
    return f"{PICTURES}/{stem}.{extension}"


def annotation(stem: str) -> str:
    """Return the file of a picture's objects."""
    return f"{ANNOTATIONS}/{stem}.xml"


def segments(folder: str, stem: str) -> str:
    """Return the file of a picture's segments. folder: CLASSES or OBJECTS."""
    return f"{folder}/{stem}.png"


def image_set(folder: str, split: str, name: str = "") -> str:
    """Return the list of the pictures of a part. folder: MAIN or SEGMENTATION; name: of a class."""
    return f"{folder}/{_file_name(name)}_{split}.txt" if name else f"{folder}/{split}.txt"


def _file_name(name: str) -> str:
    return re.sub(r"[^\w.,+-]+", "_", name)


def palette() -> np.ndarray:
    """Return VOC's colors of indices, uint8 (256, 3): the bits of an index dealt to red, green, blue, highest first."""
    colors, rest = np.zeros((256, 3), np.uint8), np.arange(256)
    for shift in range(7, -1, -1):
        for channel in range(3):
            colors[:, channel] |= ((rest >> channel & 1) << shift).astype(np.uint8)
        rest = rest >> 3
    return colors

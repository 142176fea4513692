"""Names of the files of a Pascal VOC dataset, and the colors of its segments."""

from __future__ import annotations

import re

import numpy as np

from usdsdg.writers.formats.class_names import CONTROL

NAME = "VocWriter"
PICTURES, ANNOTATIONS, CLASSES, OBJECTS = "JPEGImages", "Annotations", "SegmentationClass", "SegmentationObject"
LABELS = "labelmap.txt"  # index, name and color of each class, as Datumaro and CVAT read it
MAIN, SEGMENTATION = "ImageSets/Main", "ImageSets/Segmentation"
BACKGROUND = "background"
LONGEST = 255  # bytes of the name of a file, on all common file systems
VOID = 255  # what belongs to no class
# Of names of classes: what separates columns and begins a comment in LABELS, what no file can have in its name, and
# the end of the name that index 0 has.
UNFIT = re.compile(rf'^[#\s]|[:/\\*?"<>|]|{CONTROL}|\s$|(?<=^{BACKGROUND})$')


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
    return f"{folder}/{name}_{split}.txt" if name else f"{folder}/{split}.txt"


def palette() -> np.ndarray:
    """Return VOC's colors of indices, uint8 (256, 3): the bits of an index dealt to red, green, blue, highest first."""
    colors, rest = np.zeros((256, 3), np.uint8), np.arange(256)
    for shift in range(7, -1, -1):
        for channel in range(3):
            colors[:, channel] |= ((rest >> channel & 1) << shift).astype(np.uint8)
        rest = rest >> 3
    return colors

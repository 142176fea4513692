"""KITTI classes by label, with id and color."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from usdsdg.annotators.colors import colors_of_ids
from usdsdg.errors import AssetUnreadable, WriterError

UNLABELLED, BACKGROUND = "class:unlabelled", "class:background"


class KittiClass(NamedTuple):
    """The values of a class in the semantic images."""

    id: int  # 0 to 255
    color: tuple[int, int, int, int]  # RGBA


class KittiClasses:
    """Classes by "type:label", case-insensitive."""

    def __init__(self, mapping: Mapping[str, Any] | None = None) -> None:
        """mapping: (r, g, b, a) or an id, by label or "type:label"; missing ids are the index of the entry.

        None: the classes of Cityscapes, which KITTI's segmentation uses. "unlabelled" is added at the beginning and
        "background" at the end where the mapping lacks them.

        Raises:
            WriterError: a value is neither a color nor an id up to 255.
        """
        named = {_name(label): value for label, value in (_cityscapes() if mapping is None else mapping).items()}
        if UNLABELLED not in named:
            named = {UNLABELLED: (0, 0, 0, 0), **named}
        named.setdefault(BACKGROUND, (0, 0, 0, 0))
        by_name = {name: _class(name, value, index) for index, (name, value) in enumerate(named.items())}
        self._ids = {name: each.id for name, each in by_name.items()}
        self._by_key = {_key(name): each for name, each in by_name.items()}

    def of(self, labels: Mapping[str, str]) -> KittiClass:
        """Return the class of {type: "label[,label]"}: that of the last known label, or "unlabelled"."""
        keys = [_key(f"{kind}:{name}") for kind, text in labels.items() for name in (text, *text.split(","))]
        known = [self._by_key[key] for key in keys if key in self._by_key]
        return known[-1] if known else self._by_key[UNLABELLED]

    def ids(self) -> dict[str, int]:
        """Return the id of each "type:label"."""
        return self._ids


def read_mapping(path: str | os.PathLike) -> dict[str, Any]:
    """Read the mapping of a JSON file.

    Raises:
        AssetUnreadable: it cannot be read, or contains no mapping.
    """
    try:
        mapping = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise AssetUnreadable(f"mapping_path {path} cannot be read: {error}") from error
    if not isinstance(mapping, dict):
        raise AssetUnreadable(f'mapping_path {path} holds no mapping like {{"car": [0, 0, 142, 255]}}.')
    return mapping


def _name(label: Any) -> str:
    if not isinstance(label, str):
        raise WriterError(f"KittiWriter: the mapping has the label {label!r}; expected a text such as 'car'.")
    return (label if ":" in label else f"class:{label}").lower()


def _key(name: str) -> str:
    """Return the key of a name: whether its words are separated by blanks or by underscores does not matter."""
    return name.lower().replace("_", " ")


def _class(key: str, value: Any, index: int) -> KittiClass:
    is_id = isinstance(value, int) and not isinstance(value, bool)
    number = value if is_id else index
    color = colors_of_ids(np.array([number])).tolist()[0] if is_id and number >= 0 else value
    channels = color if isinstance(color, (list, tuple)) and len(color) == 4 else ()
    if not channels or not all(isinstance(part, int) and 0 <= part <= 255 for part in (number, *channels)):
        raise WriterError(
            f"KittiWriter: {key!r} is mapped to {value!r} as entry {index}; expected a color (r, g, b, a) or an "
            "id, from 0 to 255, in one of the first 256 entries."
        )
    red, green, blue, alpha = channels
    return KittiClass(number, (red, green, blue, alpha))


def _cityscapes() -> dict[str, tuple[int, int, int, int]]:
    """Return colors by label, in the order of their ids; void classes are transparent, and background is the sky."""
    found = {}
    for line in _TABLE.strip().splitlines():
        for member in line.split("; "):
            label, _, color = member.partition("=")
            found[label] = (*(int(part) for part in color.split(",")), 255) if color else (0, 0, 0, 0)
    return found


_TABLE = """
unlabelled; ego vehicle; rectification border; out of roi; static; dynamic=111,74,0; ground=81,0,81; road=128,64,128
sidewalk=244,35,232; parking=250,170,160; rail track=230,150,140; building=70,70,70; wall=102,102,156
fence=190,153,153; guard rail=180,165,180; bridge=150,100,100; tunnel=150,120,90; pole=153,153,153
polegroup=153,153,153; traffic light=250,170,30; traffic sign=220,220,0; vegetation=107,142,35; terrain=152,251,152
background=70,130,180; person=220,20,60; rider=255,0,0; car=0,0,142; truck=0,0,70; bus=0,60,100; caravan=0,0,90
trailer=0,0,110; train=0,80,100; motorcycle=0,0,230; bicycle=119,11,32; license plate=0,0,142
"""

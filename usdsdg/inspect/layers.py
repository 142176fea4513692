"""The images of a frame that are laid over its picture: masks, depth, normals, and what only one format has."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from usdsdg.datasets.seen import Ids, Seen, packed, unpacked
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.inspect import image_encoding
from usdsdg.inspect.image_encoding import Encoded

# In the order of the page; others come after these.
KINDS = (
    "normals", "distance_to_camera", "distance_to_image_plane", "semantic_segmentation", "instance_segmentation",
    "instance_id_segmentation",
)  # fmt: skip
_DEPTHS = {"camera": "distance_to_camera", "plane": "distance_to_image_plane"}
_IDS = {"class": "semantic_segmentation", "instance": "instance_segmentation", "gprim": "instance_id_segmentation"}
# Images with more colors than this are no masks.
_COLORS = 256
# Ids of masks count from here: image_encoding leaves 0 clear and makes 1 gray.
_FIRST_ID = 2


@dataclass(frozen=True)
class Layer:
    """An image of a frame. `draw` encodes it with at most that many pixels per side; `size` is its width and height."""

    kind: str
    file: str
    image: np.ndarray
    how: str  # "photograph", "mask" or "depth"

    @property
    def size(self) -> tuple[int, int]:
        return (self.image.shape[1], self.image.shape[0])

    def draw(self, longest: int) -> Encoded:
        """Return the image of the page."""
        return {"photograph": image_encoding.photograph, "mask": image_encoding.mask, "depth": image_encoding.depth}[
            self.how
        ](self.image, longest)


def layers(seen: Seen, objects: Sequence[SeenObject]) -> Iterator[Layer]:
    """Yield the layers of an image that is read with its pixels."""
    for each in seen.normals:
        yield Layer("normals", each.file, each.image, "photograph")
    for each in seen.depths:
        yield Layer(_DEPTHS[each.kind], each.file, each.values, "depth")
    for each in seen.ids:
        if each.kind in _IDS:
            yield Layer(_IDS[each.kind], each.file, _colors(each), "mask")
    if (ids := _mask_ids(seen, objects)) is not None:
        yield Layer("instance_segmentation", seen.labels, ids, "mask")
    for each in seen.segments:
        yield Layer("panoptic", each.picture, each.ids, "mask")
    for name, (file, image) in seen.further_images().items():
        yield Layer(name, file, image, "mask" if _is_mask(image) else "photograph")


def _colors(ids: Ids) -> np.ndarray:
    """Return ids (H, W), or the colors (H, W, 4) that stand for them."""
    if not ids.colored:
        return ids.keys
    keys, places = np.unique(ids.keys, return_inverse=True)
    table = np.array([unpacked(int(key)) for key in keys], np.uint8)
    return table[places.reshape(ids.keys.shape)]


def _mask_ids(seen: Seen, objects: Sequence[SeenObject]) -> np.ndarray | None:
    """Return (H, W) a number for the object of each pixel, from the masks of the objects; None without masks."""
    found = None
    for number, each in enumerate(objects, _FIRST_ID):
        mask = each.mask(seen) if each.mask is not None else None
        if mask is not None:
            found = np.zeros(mask.shape, np.int64) if found is None else found
            if found.shape == mask.shape:
                found[mask] = number
    return found


def _is_mask(image: np.ndarray) -> bool:
    """Return whether an image has few colors, so that it shows ids and no shades."""
    values = image if image.ndim == 2 else packed(image)
    return len(np.unique(values[::4, ::4])) <= _COLORS // 4 and len(np.unique(values)) <= _COLORS

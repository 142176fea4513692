"""Annotators' data as pictures for people (`rep.tools`): masks, boxes, normals, distances and motion in color."""

import colorsys
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.annotators.colors import colors_of_ids, hashed_colors, hsv_to_rgb
from usdsdg.annotators.kinds.amodal import run_lengths
from usdsdg.arguments.parameters import name_parameters
from usdsdg.errors import ArgumentError
from usdsdg.writers.formats import writer_basic
from usdsdg.writers.formats.writer_basic import colorize_normals

__all__ = [
    "binary_mask_to_rle", "colorize_bbox_2d", "colorize_distance", "colorize_motion_vector", "colorize_normals",
    "colorize_segmentation", "data_to_colour", "random_colours", "random_colours_id",
]  # fmt: skip

_CLEAR = (0, 0, 0, 0)


def colorize_segmentation(
    data: np.ndarray, labels: Mapping[Any, Any], mapping: Mapping[str, Sequence[int]] | None = None
) -> Any:
    """Color a mask of ids.

    Args:
        data: (H, W) ids.
        labels: labels by id, as in `idToLabels`: {"2": {"class": "cube"}}; keys may be strings or integers.
        mapping: colors (RGBA, 0 to 255) by the lower-case value of a label's first taxonomy; others are transparent.

    Returns:
        With `mapping` uint8 (H, W, 4). Without it a tuple: the picture in the colors of our segmentations, the labels
        by color, and the ids by color; an id without labels is "UNLABELLED".
    """
    ids, index = np.unique(np.asarray(data), return_inverse=True)
    keys = [str(each) if isinstance(next(iter(labels), ""), str) else int(each) for each in ids]
    if mapping:
        colors = [mapping.get(_first_value(labels[key]), _CLEAR) if key in labels else _CLEAR for key in keys]
        return np.array(colors, np.uint8).reshape(-1, 4)[index].reshape(*np.shape(data), 4)
    palette = colors_of_ids(ids)
    tuples = [tuple(color) for color in palette.tolist()]
    labels_of = {color: labels.get(key, "UNLABELLED") for color, key in zip(tuples, keys, strict=True)}
    return palette[index].reshape(*np.shape(data), 4), labels_of, dict(zip(tuples, keys, strict=True))


def colorize_distance(distance_data: Any, near: float | None = 1e-5, far: float | None = 100.0) -> np.ndarray:
    """Return distances (H, W) [m] as uint8 (H, W), on a logarithmic scale: white at `near`, black at `far` and beyond.

    None takes the smallest or the largest finite distance that there is. Warp arrays are taken too.
    """
    distance = distance_data.numpy() if hasattr(distance_data, "numpy") else np.asarray(distance_data)
    return writer_basic.colorize_distance(distance, near, far)


def colorize_motion_vector(data: np.ndarray) -> np.ndarray:
    """Return motion (H, W, 3 or 4) as uint8 (H, W, 4), with Replicator's colors: full ones of the direction's hue.

    Motion along +x is cyan and along -x red, whatever its length; none is black. A third component makes the color
    darker where it is positive and lighter where it is negative.
    """
    motion = np.asarray(data, np.float64)
    x, y, z = motion[..., 0], motion[..., 1], motion[..., 2]
    hue = (np.arctan2(y, x) + np.pi) / (2 * np.pi)
    lightness = np.arctan2(np.hypot(x, y), z) / np.pi
    # The HSV color of an HLS color of full saturation.
    value = np.minimum(2 * lightness, 1.0)
    saturation = np.minimum(2 - 2 * lightness, 1.0)
    image = np.full((*hue.shape, 4), 255, np.uint8)
    image[..., :3] = (hsv_to_rgb(hue.ravel(), saturation.ravel(), value.ravel()) * 255).reshape(*hue.shape, 3)
    return image


def colorize_bbox_2d(
    image: np.ndarray, data: np.ndarray, xform: np.ndarray | None = None, draw_rotated_boxes: bool = False
) -> np.ndarray:
    """Return a picture (H, W, 3 or 4) with 2D boxes drawn, one color per `semanticId`.

    Args:
        image: uint8 picture; it is not changed.
        data: rows of a 2D box annotator, with x_min, y_min, x_max, y_max (inclusive pixels) and semanticId.
        xform: 3 x 3 matrix that maps row vectors (row, column, 1), of a crop or a rotation of the picture.
        draw_rotated_boxes: draw mapped boxes as the quadrilaterals that they are, not as the boxes around these.

    Raises:
        ArgumentError: `xform` has other than nine numbers.
    """
    from PIL import Image, ImageDraw

    picture = Image.fromarray(np.ascontiguousarray(image))
    draw = ImageDraw.Draw(picture)
    for box in data:
        color = data_to_colour(box["semanticId"])
        corners = _corners(box)
        if xform is not None:
            corners = np.c_[corners, np.ones(4)] @ _matrix(xform)
            corners = corners[:, :2]
        if xform is None or not draw_rotated_boxes:
            low, high = corners.min(axis=0), corners.max(axis=0)
            draw.rectangle([low[1], low[0], high[1], high[0]], outline=color, width=2)
        else:
            draw.polygon([(column, row) for row, column in corners], outline=color, width=2)
    return np.array(picture)


def data_to_colour(data: Any) -> tuple[int, int, int]:
    """Return the color (RGB, 0 to 255) of a label, id or bytes, from its SHA-256; all are about equally bright.

    As in Replicator, an integer n of Python stands for n zero bytes, an integer of NumPy for its own bytes.
    """
    digest = hashlib.sha256(data.encode() if isinstance(data, str) else bytes(data)).digest()
    # The last three of the first four bytes of the digest, least significant first.
    red, green, blue = ((byte + 1) * 33 % 255 for byte in (digest[3], digest[2], digest[1]))
    scale = 128 * 3.0 / max(red + green + blue, 1)
    return int(red * scale), int(green * scale), int(blue * scale)


def random_colours(N: int, enable_random: bool = True, num_channels: int = 4, start: int = 0) -> np.ndarray:
    """Return uint8 (N, num_channels) colors, the same ones every time: those of the ids from `start` on.

    With `enable_random` they are of evenly spaced hues, in a shuffled order, and `start` does not count. (Replicator
    1.12.27 raises TypeError there.)
    """
    if not enable_random:
        return hashed_colors(np.arange(start, start + N))[:, :num_channels]
    order = np.random.default_rng(10).permutation(N)
    rgb = [(*colorsys.hsv_to_rgb((each / N + 0.57) % 1.0, 0.9, 1.0), 1.0) for each in order]
    return (np.array(rgb).reshape(-1, 4)[:, :num_channels] * 255).astype(np.uint8)


def random_colours_id(input_id: int, num_channels: int = 4) -> tuple[int, ...]:
    """Return the color of a segmentation's id from 0 to 255, RGBA or with `num_channels` 3 RGB."""
    return tuple(hashed_colors([input_id])[0, :num_channels].tolist())


def binary_mask_to_rle(binary_mask: np.ndarray) -> dict[str, list[int]]:
    """Return the uncompressed run lengths of a mask (H, W), by columns, as pycocotools reads them."""
    mask = np.asarray(binary_mask) != 0
    return run_lengths(mask, 0, 0, mask.shape)


def _first_value(labels: Any) -> str:
    values: Iterable[Any] = labels.values() if isinstance(labels, Mapping) else [labels]
    return str(next(iter(values), "")).lower()


def _corners(box: Any) -> np.ndarray:
    """Return the corners (4, 2) of a box as rows and columns, around it."""
    top, left, bottom, right = (float(box[name]) for name in ("y_min", "x_min", "y_max", "x_max"))
    return np.array([(top, left), (top, right), (bottom, right), (bottom, left)])


def _matrix(xform: np.ndarray) -> np.ndarray:
    if np.size(xform) != 9:
        raise ArgumentError(f"xform has to be a 3 x 3 matrix, not of shape {np.shape(xform)}.")
    return np.reshape(xform, (3, 3))


name_parameters(globals(), without_turns=None)

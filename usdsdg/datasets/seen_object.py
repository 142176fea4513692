"""What the files of a dataset say about one object in one image, in pixels, independent of their format."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from usdsdg.datasets.seen import Seen


@dataclass
class SeenObject:
    """One object in one image. Pixel coordinates are continuous: the center of the first pixel is (0.5, 0.5).

    box, loose   (x_min, y_min, x_max, y_max) of the visible part, of the whole object
    cuboid       (9, 2) pixels in the order of KEYPOINTS; None if unknown
    edges        (n, 4) pixels of the parts in front of the camera, if the cuboid extends behind it
    axes         (4, 2) pixels: center, then the centers of the faces toward local +x, +y, +z
    outline      polygons (n, 2) in pixels: of a mask, or one with the corners of an oriented box
    mask         returns the visible pixels, (H, W) bool, from the image as it is with its pixels; None if not known
    keypoints    (n, 3) pixel and state: 0 outside of the image or not labeled, 1 hidden, 2 visible
    distance     meters from the camera; visibility and truncation are fractions 0…1
    """

    label: str
    prim_path: str = ""
    box: tuple[float, float, float, float] | None = None
    loose: tuple[float, float, float, float] | None = None
    cuboid: np.ndarray | None = None
    edges: np.ndarray | None = None
    axes: np.ndarray | None = None
    outline: list[np.ndarray] | None = None
    mask: Callable[[Seen], np.ndarray | None] | None = None
    keypoints: np.ndarray | None = None
    distance: float | None = None
    visibility: float | None = None
    truncation: float | None = None

    @property
    def size(self) -> float | None:
        """Side [px] of a square with the area of the visible box, or else of the amodal one."""
        box = self.box or self.loose
        return None if box is None else float(np.sqrt(max(0.0, box[2] - box[0]) * max(0.0, box[3] - box[1])))

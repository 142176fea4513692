"""What annotators can ask of the scene of a frame, beyond its AOVs and masks."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from pxr import Usd

from usdsdg.stage.cameras.camera_view import CameraView

# States of a point in a picture.
NOT_IN_PICTURE, OCCLUDED, VISIBLE = range(3)


class SceneQueries(Protocol):
    """The scene as the frame shows it."""

    @property
    def time(self) -> Usd.TimeCode: ...

    @property
    def gprim_to_world(self) -> np.ndarray:
        """Transform of each entry of the frame's gprims, (G, 4, 4) float64."""
        ...

    def coverage_around(self, groups: Sequence[Sequence[int]]) -> np.ndarray:
        """Amodal pixels and bounds of groups of gprims outside of the picture, (N, 5) int64 as `Frame.coverage`.

        What is outside is as wide and as high as the picture, on each side; columns and rows count from the picture's
        first ones, so that they may be negative.
        """
        ...

    def first_hits(
        self, origins: np.ndarray, directions: np.ndarray, first: np.ndarray, last: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distance (N,) of the first surface on each ray, inf for none, and its gprim (N,), -1 for none."""
        ...

    def follow(self, view: CameraView, captures: int) -> tuple[np.ndarray, np.ndarray]:
        """Where the surface points of this picture, or of that some captures ago, are in the picture of a camera now.

        (H, W, 2) float32 column and row, NaN for none; and (H, W) uint8 states: NOT_IN_PICTURE, OCCLUDED or VISIBLE.
        """
        ...

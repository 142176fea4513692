"""The scene of one frame, of which annotators may ask more than AOVs and masks; and the points of earlier pictures."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd

from usdsdg.annotators.pixels.launch import on_host
from usdsdg.annotators.scene_queries import NOT_IN_PICTURE
from usdsdg.capture.subsets import GprimTable
from usdsdg.session import engines
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView

if TYPE_CHECKING:
    from usdsdg_render.labels.sight import SurfacePoints

# AOVs that tell which points a picture shows.
POINT_AOVS = ("instance", "triangle", "barycentrics")


class EarlierPoints:
    """The points that the latest captured pictures of each render product show."""

    def __init__(self) -> None:
        self._points: dict[str, deque[SurfacePoints]] = {}

    def remember(self, path: str, points: SurfacePoints, captures: int) -> None:
        """Keep the points of a picture for so many captures."""
        kept = self._points.get(path, ())
        self._points[path] = deque([*kept, points], maxlen=captures)

    def of(self, path: str, captures: int) -> SurfacePoints | None:
        """Return the points of the picture some captures ago; None if there is none."""
        kept = self._points.get(path, ())
        return kept[-captures] if captures <= len(kept) else None


class FrameScene:
    """Implements `annotators.SceneQueries` for one render product; valid until the stage changes."""

    def __init__(
        self,
        path: str,
        view: CameraView | TiledView,
        table: GprimTable,
        aovs: Mapping[str, Any],
        earlier: EarlierPoints,
        renderer: engines.Renderer,
    ) -> None:
        self._path, self._view, self._table, self._aovs, self._earlier = path, view, table, aovs, earlier
        self._renderer = renderer
        self.time: Usd.TimeCode = renderer.time

    @property
    def gprim_to_world(self) -> np.ndarray:
        return self._renderer.local_to_world[self._table.meshes]

    def coverage_around(self, groups: Sequence[Sequence[int]]) -> np.ndarray:
        assert isinstance(self._view, CameraView)
        return self._renderer.coverage_around(self._view, groups, faces=self._table.faces)

    def first_hits(
        self, origins: np.ndarray, directions: np.ndarray, first: np.ndarray, last: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        return self._renderer.first_hits(origins, directions, first, last, faces=self._table.faces)

    def follow(self, view: CameraView, captures: int) -> tuple[np.ndarray, np.ndarray]:
        points = self.points() if captures == 0 else self._earlier.of(self._path, captures)
        if points is None:
            shape = self._view.height, self._view.width
            return np.full((*shape, 2), np.nan, np.float32), np.full(shape, NOT_IN_PICTURE, np.uint8)
        return self._renderer.follow(points, view)

    def points(self) -> SurfacePoints:
        """Return the points that this picture shows."""
        aovs = {name: on_host(self._aovs[name]) for name in POINT_AOVS}
        return self._renderer.surface_points(aovs | {"instance": self._table.instances(aovs["instance"])})

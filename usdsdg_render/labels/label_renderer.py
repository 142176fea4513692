"""LabelRenderer: renders labels of a scene that is on a device: AOVs, masks of groups of gprims, lines of sight."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from usdsdg.errors import RenderError
from usdsdg.stage.geometry.pixel_masks import PixelMasks
from usdsdg_render.device import view_batches
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.labels.coverage import LEFT_OUT, UNKNOWN
from usdsdg_render.kernels.scene.visibility import BEHIND_GLASS, BY_THRESHOLD
from usdsdg_render.labels import label_pass, sight
from usdsdg_render.labels.aov import check_names
from usdsdg_render.labels.coverage import Coverage
from usdsdg_render.labels.label_batch import LabelBatch
from usdsdg_render.labels.parts import DividedGprims, FaceEntries
from usdsdg_render.labels.previous_frame import PreviousFrames
from usdsdg_render.labels.sight import SurfacePoints
from usdsdg_render.scene.scene import Scene

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView

# Of scenes whose gprims are not divided into parts.
WHOLE: FaceEntries = MappingProxyType({})

_LABEL_MODES = {"surface": BY_THRESHOLD, "behind": BEHIND_GLASS}


class LabelRenderer:
    """Renders labels of the scene as it is on the device.

    Args:
        scene: what is on the device, or will be when something is rendered.
    """

    def __init__(self, scene: Scene, device: str) -> None:
        self.device = device
        self.threads: int | None = None  # None: all CPUs that this process may use
        self.glass_labels = "surface"
        self._scene = scene
        self._on_device = DeviceScene(device)
        self._previous_frames = PreviousFrames(device)

    @property
    def gprims(self) -> tuple[str, ...]:
        """Prim path of every value of the instance AOV."""
        return self._scene.instances.paths

    @property
    def glass_labels(self) -> str:
        """Which surface labels show at glass: the glass "surface", or what is "behind" it.

        Glass is a material with more than half transmission, or less than half opacity. In both modes labels pass
        through cut-outs without refraction: opacity below `opacityThreshold`, opacity below one half in an opacity
        texture without threshold, or opacity zero.
        """
        return next(name for name, mode in _LABEL_MODES.items() if mode == self._label_mode)

    @glass_labels.setter
    def glass_labels(self, value: str) -> None:
        if value not in _LABEL_MODES:
            raise RenderError(f"glass_labels is {value!r}; it may be {' or '.join(map(repr, _LABEL_MODES))}.")
        self._label_mode = _LABEL_MODES[value]

    def labels(self, view: CameraView, aovs: Collection[str]) -> dict[str, np.ndarray]:
        """Render AOVs with one ray through each pixel center; see `aov.AOVS` for names, units and values.

        Motion vectors are relative to the frame in which this camera last asked for them: before the last `sync`, or at
        another pose of the camera.

        Raises:
            RenderError: an AOV is unknown.
            Unsupported: the projection of the camera is unknown.
        """
        return self.labels_of([view], aovs)[0]

    def labels_of(
        self, views: Sequence[CameraView], aovs: Collection[str], *, faces: FaceEntries = WHOLE, fetched: bool = True
    ) -> list[dict[str, Any]]:
        """Render `labels` of many views; views of the same size share a launch.

        fetched: whether AOVs come to the host as NumPy arrays; False leaves them on a GPU as Warp arrays.

        faces: by gprim, of those that are divided into parts, the entry of each face: entries are all gprims, then all
            parts. The AOV `instance` has entries then.
        """
        results: list[dict[str, Any]] = [{} for _ in views]
        if not aovs:
            return results
        divided = self._divided(faces)
        for indices in view_batches.label_batches(views):
            batch = self._divided_batch([views[k] for k in indices], aovs, divided)
            for k, arrays in zip(indices, batch.numpy() if fetched else batch.in_place(), strict=True):
                results[k] = arrays
        return results

    def label_batch(self, views: Sequence[CameraView], aovs: Collection[str]) -> LabelBatch:
        """Render `labels` of views of one size in one launch, and leave them on the device.

        Raises:
            RenderError: the views differ in size or units, or there is none.
        """
        names = check_names(aovs)
        if len(view_batches.same_size(views)) != 1:
            sizes = sorted({f"{view.width}x{view.height}" for view in views})
            raise RenderError(
                f"a label batch needs views of one size and one stage; these are {', '.join(sizes) or 'none'}"
            )
        arrays = label_pass.render(
            self._on_device,
            self._previous_frames,
            self._scene,
            views,
            names,
            mode=self._label_mode,
            threads=self.threads,
        )
        if "motion_vectors" in names:
            self._previous_frames.remember(views, self._scene)
        return LabelBatch(len(views), arrays, self.threads)

    def _divided(self, faces: FaceEntries) -> DividedGprims:
        return DividedGprims(self._scene, faces, self.device)

    def _divided_batch(self, views: Sequence[CameraView], aovs: Collection[str], divided: DividedGprims) -> LabelBatch:
        """Render `label_batch`, with entries as instances."""
        if not divided.are_there or "instance" not in aovs:
            return self.label_batch(views, aovs)
        batch = self.label_batch(views, {*aovs, "triangle"})
        divided.tell_apart(batch.arrays["instance"], batch.arrays["triangle"])
        return replace(batch, arrays={name: batch.arrays[name] for name in aovs})

    def labels_and_masks(
        self,
        views: Sequence[CameraView],
        aovs: Collection[str],
        groups: Sequence[Sequence[int]],
        *,
        faces: FaceEntries = WHOLE,
        fetched: bool = True,
    ) -> tuple[list[dict[str, Any]], list[PixelMasks]]:
        """Render `labels_of`, and the masks of the same groups of gprims, or of entries, in each of the views."""
        results: dict[int, tuple[dict[str, Any], PixelMasks]] = {}
        divided = self._divided(faces)
        for indices in view_batches.label_batches(views):
            some = [views[k] for k in indices]
            batch = self._divided_batch(some, {*aovs, "instance"}, divided)
            masks: list[PixelMasks] = []
            for part in view_batches.mask_batches(len(some), len(divided.instances)):
                shown = LabelBatch(len(part), {"instance": batch.arrays["instance"][part.start : part.stop]})
                masks += self._coverage(some[part.start : part.stop], groups, shown, divided).pixel_masks()
            images = batch.numpy() if fetched else batch.in_place()
            results |= dict(zip(indices, zip(images, masks, strict=True), strict=True))
        return [results[k][0] for k in range(len(views))], [results[k][1] for k in range(len(views))]

    def pixel_masks(
        self, view: CameraView, groups: Sequence[Sequence[int]], *, instance: np.ndarray | None = None
    ) -> PixelMasks:
        """Compute amodal and modal masks of groups of gprims: the pixels that each covers alone, and those visible.

        A pixel counts once for a group, however many of its gprims are hit there; groups may share gprims. The amodal
        mask is exactly what `labels` of a stage with that group alone would show.

        Args:
            instance: the AOV `instance` of this view as returned by `labels`; None renders it.
        """
        if instance is None:
            return self.labels_and_masks([view], ["instance"], groups)[1][0]
        shown = wp.array(instance[None], dtype=wp.int32, device=self.device)
        return self.coverage_batch([view], groups, LabelBatch(1, {"instance": shown})).pixel_masks()[0]

    def coverage_batch(
        self, views: Sequence[CameraView], groups: Sequence[Sequence[int]], batch: LabelBatch
    ) -> Coverage:
        """Compute the masks of views of one size, and leave them on the device; `batch` holds their AOV `instance`."""
        return self._coverage(views, groups, batch, self._divided(WHOLE))

    def _coverage(
        self, views: Sequence[CameraView], groups: Sequence[Sequence[int]], batch: LabelBatch, divided: DividedGprims
    ) -> Coverage:
        shown = batch.arrays["instance"]
        return Coverage(self._on_device, views, groups, shown, divided, mode=self._label_mode, threads=self.threads)

    def coverage(self, view: CameraView, groups: Sequence[Sequence[int]]) -> np.ndarray:
        """Compute size and bounds of the amodal mask of each group of gprims.

        Returns:
            (len(groups), 5) int64: pixels, x_min, y_min, x_max, y_max (inclusive); -1 bounds for no pixels.
        """
        return self.pixel_masks(view, groups).coverage

    def coverage_around(
        self, view: CameraView, groups: Sequence[Sequence[int]], *, faces: FaceEntries = WHOLE
    ) -> np.ndarray:
        """Compute `coverage` outside of the image, in margins as wide and as high as the image (`CameraView.widened`).

        Bounds are in pixels of the image, from -width to 2 width - 1 and from -height to 2 height - 1. Nothing is
        outside of an image that shows all directions.
        """
        wide = view.widened()
        if wide is None:
            return PixelMasks.nothing((view.height, view.width), len(groups)).coverage
        columns, rows = wide.margin
        shown = np.full((1, wide.height, wide.width), UNKNOWN, np.int32)
        shown[:, rows : rows + view.height, columns : columns + view.width] = LEFT_OUT
        batch = LabelBatch(1, {"instance": wp.array(shown, dtype=wp.int32, device=self.device)})
        found = self._coverage([wide], groups, batch, self._divided(faces)).sums()[0, :, :5].astype(np.int64)
        found[found[:, 0] > 0, 1:] -= (*wide.margin, *wide.margin)
        return found

    @property
    def local_to_world(self) -> np.ndarray:
        """Transform of each gprim, (gprims, 4, 4) float64 for row vectors; must not be written into."""
        return self._scene.instances.local_to_world

    def surface_points(self, aovs: Mapping[str, np.ndarray]) -> SurfacePoints:
        """Return the points of surfaces that an image shows, from its AOVs `sight.POINT_AOVS`."""
        return sight.points_of(self._scene, aovs)

    def follow(self, points: SurfacePoints, view: CameraView) -> tuple[np.ndarray, np.ndarray]:
        """Return where surface points of another image, or of an earlier one, are in the image of a camera now.

        Returns:
            (H, W, 2) float32 column and row from the top left corner, NaN for none; and (H, W) uint8: 0 not in the
            image, 1 hidden, 2 visible.
        """
        return sight.follow(self._on_device, self._scene, points, view, mode=self._label_mode, threads=self.threads)

    def first_hits(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        first: np.ndarray,
        last: np.ndarray,
        *,
        faces: FaceEntries = WHOLE,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the distance (N,) of the first surface on each ray, inf for none, and its gprim (N,), -1 for none.

        Surfaces count as in labels. origins, directions: (N, 3); only distances from `first` to `last` (N,) count.
        """
        rays = {"origins": origins, "directions": directions, "first": first, "last": last}
        divided = self._divided(faces)
        return sight.first_hits(self._on_device, rays, divided, mode=self._label_mode, threads=self.threads)

"""The input of annotators: the AOVs of one render product with the labeled prims in view."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from usdsdg.annotators.labeled_prims import LabeledPrims
from usdsdg.annotators.pixels import look_ups
from usdsdg.annotators.pixels.launch import Pixels
from usdsdg.annotators.pixels.look_up_table import LookUpTable
from usdsdg.annotators.pixels.look_ups import PIXELS
from usdsdg.annotators.scene_queries import SceneQueries
from usdsdg.annotators.selection import Selection
from usdsdg.errors import AnnotatorError, Unsupported
from usdsdg.readback import read_back
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg.stage.geometry.pixel_masks import PixelMasks


@dataclass(frozen=True)
class Frame:
    """One captured frame of one render product: AOVs, camera, and the labeled prims of the stage.

    Arrays are shared by all readers and must never be written into.
    """

    index: int  # number of earlier captures
    view: CameraView | TiledView
    render_product: str  # prim path
    aovs: Mapping[str, Pixels]  # name → (H, W[, C]), where it was rendered; see the renderer's AOV table
    gprims: tuple[str, ...]  # prim path of every value of the "instance" AOV; -1 means no hit
    labeled_prims: LabeledPrims
    amodal_masks: PixelMasks  # of all labeled prims, by row; with the visible part of each
    reference_time: tuple[int, int] = (0, 1)
    scene: SceneQueries | None = None
    memo: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)
    together: list[Frame] = field(default_factory=list, repr=False, compare=False)  # frames of one capture, with this

    def aov(self, name: str) -> np.ndarray:
        """Return the AOV called `name` in the memory of the host; raises as `image`."""
        return self.on_host(self.image(name))

    def on_host(self, image: Pixels) -> np.ndarray:
        """Return an image of this frame in the memory of the host; that of a GPU is copied once."""
        if not isinstance(image, np.ndarray):
            self.fetch([image])
            return self.memo["on host", id(image)][1]
        return image

    def fetch(self, images: Iterable[Pixels]) -> None:
        """Copy images of this frame, those that are on a GPU, to the host together; `on_host` returns the copies."""
        missing = {str(id(each)): each for each in images if not isinstance(each, np.ndarray)}
        missing = {key: each for key, each in missing.items() if ("on host", int(key)) not in self.memo}
        for key, copy in read_back(missing).items():
            self.memo["on host", int(key)] = (missing[key], copy)  # an id is that of one array while that is there

    def hosted(self) -> Frame:
        """Return the frame with all AOVs in the memory of the host, so that it can wait without that of a GPU."""
        if all(isinstance(each, np.ndarray) for each in self.aovs.values()):
            return self
        self.fetch(self.aovs.values())
        return self.derive("hosted", self._on_host)

    def _on_host(self) -> Frame:
        known = {key: self.memo[key] for key in ("sums",) if key in self.memo}
        return replace(self, aovs={name: self.aov(name) for name in self.aovs}, memo=known, together=[])

    def image(self, name: str) -> Pixels:
        """Return the AOV called `name` where it was rendered: a NumPy array, or a Warp array on a device.

        Raises:
            AnnotatorError: it was not rendered: the annotator does not declare it.
        """
        try:
            return self.aovs[name]
        except KeyError:
            raise AnnotatorError(
                f"{self.render_product}: AOV {name!r} was not rendered for this frame (there are: "
                f"{', '.join(sorted(self.aovs)) or 'none'}). An annotator names what it reads in its "
                "aovs, and is attached before the step that it should see."
            ) from None

    @property
    def camera(self) -> CameraView:
        """The camera.

        Raises:
            Unsupported: the render product shows several cameras in tiles.
        """
        if isinstance(self.view, TiledView):
            raise Unsupported(
                f"{self.render_product} shows {len(self.view.views)} cameras in tiles, and an annotator needs one. "
                "Attach that annotator to a render product of each camera (create.render_product)."
            )
        return self.view

    @property
    def queries(self) -> SceneQueries:
        """The scene.

        Raises:
            AnnotatorError: the frame was made without it.
        """
        if self.scene is None:
            raise AnnotatorError(f"{self.render_product}: this frame has no scene; capture it with step().")
        return self.scene

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [pixels]."""
        return self.view.height, self.view.width

    @property
    def coverage(self) -> np.ndarray:
        """Amodal pixel count and bounds of each labeled prim, (N, 5) int64: pixels, x_min, y_min, x_max, y_max."""
        return self.amodal_masks.coverage

    def selection(self, predicate: str | None) -> Selection:
        """Return the labeled prims whose labels pass the filter `predicate`; None lets every label pass."""
        return self.labeled_prims.select(predicate)

    @property
    def sums(self) -> np.ndarray:
        """Visible pixels and their bounds of each gprim, (G, 5) int64 as `coverage`."""
        return self._derive_together("sums", self._sum_together)

    def _sum_together(self, frames: Sequence[Frame]) -> Sequence[np.ndarray]:
        return look_ups.sum_all_by_gprim([each.image("instance") for each in frames], len(self.gprims))

    @property
    def shown_gprims(self) -> np.ndarray:
        """The gprims of which any pixel is visible, int64."""
        return np.flatnonzero(self.sums[:, PIXELS] > 0)

    @property
    def shows_background(self) -> bool:
        """Whether any pixel shows no gprim."""
        return int(self.sums[:, PIXELS].sum()) < self.shape[0] * self.shape[1]

    def look_up(self, table: LookUpTable) -> Pixels:
        """Return the value of each pixel's gprim (H, W, ...), of a table with a last entry for pixels without a hit.

        The image of one table is made once.
        """
        instance = self.image("instance")
        if isinstance(instance, np.ndarray) or not table.is_of_all:  # on a CPU each picture takes its time
            return self.derive(table, lambda: look_ups.look_up(instance, table))
        return self._derive_together(table, lambda frames: self._look_up_together(frames, table))

    def _look_up_together(self, frames: Sequence[Frame], table: LookUpTable) -> Sequence[Pixels]:
        return look_ups.look_up_all([each.image("instance") for each in frames], table)

    @property
    def black(self) -> Pixels:
        """An image of 0, 0, 0, 1, float16 (H, W, 4)."""
        values = np.tile(np.array([0, 0, 0, 1], np.float16), (len(self.gprims) + 1, 1))
        return self.derive("black", lambda: self.look_up(LookUpTable(values)))

    def visible_pixels(self, predicate: str | None) -> np.ndarray:
        """Return (K,) int64: the number of visible pixels of each of the K selected prims."""
        return self.visible(predicate)[:, PIXELS]

    def visible(self, predicate: str | None) -> np.ndarray:
        """Return visible pixels and their bounds of each of the K selected prims, (K, 5) int64 as `coverage`."""
        return self._derive_together(("visible", predicate), lambda frames: self._sum_members(frames, predicate))

    def _sum_members(self, frames: Sequence[Frame], predicate: str | None) -> Sequence[np.ndarray]:
        return list(self.selection(predicate).sum_members(np.stack([each.sums for each in frames])))

    def in_view(self, predicate: str | None) -> np.ndarray:
        """Return the selected prims with any amodal pixel in the picture, as indices into the selection."""
        return np.flatnonzero(self.coverage[self.selection(predicate).rows, PIXELS] > 0)

    def occlusion(self, predicate: str | None) -> np.ndarray:
        """Return (K,) float32: the occluded fraction of each selected prim's amodal pixels; nan out of view."""
        return self.derive(("occlusion", predicate), lambda: self._occlusion(predicate))

    def _occlusion(self, predicate: str | None) -> np.ndarray:
        amodal = self.coverage[self.selection(predicate).rows, PIXELS]
        ratio = np.full(len(amodal), np.nan, np.float32)
        np.divide(amodal - self.visible_pixels(predicate), amodal, out=ratio, where=amodal > 0, casting="unsafe")
        return ratio

    def _derive_together(self, key: Any, make: Callable[[Sequence[Frame]], Sequence[Any]]) -> Any:
        """Do as `derive`, and at once for the other frames of this capture that show the same prims at the same size.

        One pass of NumPy, a launch, and a copy to the host take about as long for one picture as for many.
        """
        if key not in self.memo:
            alike = [each for each in self.together if each is self or each._is_alike(self)] or [self]
            frames = [each for each in alike if key not in each.memo]
            for frame, made in zip(frames, make(frames), strict=True):
                frame.memo[key] = made
        return self.memo[key]

    def _is_alike(self, other: Frame) -> bool:
        is_same_stage = self.labeled_prims.selections is other.labeled_prims.selections and self.gprims is other.gprims
        return is_same_stage and self.shape == other.shape and "instance" in self.aovs

    def derive(self, key: Any, make: Callable[[], Any]) -> Any:
        """Return `make()`, computed once per frame and `key`."""
        if key not in self.memo:
            self.memo[key] = make()
        return self.memo[key]

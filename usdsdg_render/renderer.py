"""WarpRenderer: a USD stage in, label AOVs and path-traced pictures out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np
import warp as wp

from usdsdg.errors import RenderError
from usdsdg_render.device import view_batches
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.device.precompile import precompile
from usdsdg_render.kernels.scene.visibility import BEHIND_GLASS, BY_THRESHOLD
from usdsdg_render.labels import label_pass
from usdsdg_render.labels.aov import check_names
from usdsdg_render.labels.coverage import Coverage
from usdsdg_render.labels.label_batch import LabelBatch
from usdsdg_render.labels.previous_frame import PreviousFrames
from usdsdg_render.path.film import Film, tone_map
from usdsdg_render.path.path_tracer import PathTracer
from usdsdg_render.scene.scene import Scene
from usdsdg_render.settings import PathSettings, ToneSettings
from usdsdg_render.sync.rigid_motion import interpolate

if TYPE_CHECKING:
    from pxr import Usd

    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg.stage.geometry.pixel_masks import PixelMasks

Progress = Callable[[str, int, "int | None"], None]

# Of a GPU's memory that stay with the process between frames.
KEPT_BYTES = 1 << 30

_LABEL_MODES = {"surface": BY_THRESHOLD, "behind": BEHIND_GLASS}


class WarpRenderer:
    """Renders one stage. `sync` reads what changed on it; the other methods render that state.

    Args:
        stage: the stage to read.
        device: "cpu", "cuda:0", …; None takes the first CUDA device, else the CPU.
        progress: told of long work (reading the stage, compiling kernels on first use).

    Raises:
        RenderError: the device does not exist.
    """

    def __init__(self, stage: Usd.Stage, *, device: str | None = None, progress: Progress | None = None) -> None:
        from usdsdg_render.sync.extract import SceneExtractor

        self._start(device, progress)
        extractor = SceneExtractor(stage, progress=progress)
        self._extractor: SceneExtractor | None = extractor
        self._scene = extractor.scene

    @classmethod
    def of_scene(cls, scene: Scene, *, device: str | None = None, progress: Progress | None = None) -> WarpRenderer:
        """A renderer of a scene made by hand; `sync` then reads changes by `scene.versions`."""
        renderer = cls.__new__(cls)
        renderer._start(device, progress)
        renderer._extractor = None
        renderer._scene = scene
        return renderer

    def _start(self, device: str | None, progress: Progress | None) -> None:
        self.device = chosen_device(device)
        self.threads: int | None = None  # None: all CPUs that this process may use
        precompile(self.device, progress)
        keep_memory(self.device)
        self._on_device = DeviceScene(self.device)
        self._previous_frames = PreviousFrames(self.device)
        self._path_tracer = PathTracer(self._on_device)
        self._before = np.zeros((0, 4, 4))  # transforms at the sync before the last
        self.glass_labels = "surface"

    @property
    def gprims(self) -> tuple[str, ...]:
        """Prim path of every value of the instance AOV."""
        return self._scene.instances.paths

    @property
    def glass_labels(self) -> str:
        """What carries labels where glass is: its "surface", or what is "behind" it.

        Glass is what lets more than half of the light through, by opacity or transmission. In both cases labels show
        what is straight behind holes: opacity below `opacityThreshold`, below a half in an opacity texture without
        threshold, or zero.
        """
        return next(name for name, mode in _LABEL_MODES.items() if mode == self._label_mode)

    @glass_labels.setter
    def glass_labels(self, value: str) -> None:
        if value not in _LABEL_MODES:
            raise RenderError(f"glass_labels is {value!r}; it may be {' or '.join(map(repr, _LABEL_MODES))}.")
        self._label_mode = _LABEL_MODES[value]

    @property
    def time(self) -> Usd.TimeCode:
        """The time of the last sync: the default time where nothing on the stage varies."""
        from pxr import Usd

        return Usd.TimeCode.Default() if self._extractor is None else self._extractor.time

    def sync(self, time: Usd.TimeCode | None = None) -> None:
        """Read what changed on the stage since the last call, and what varies with time as it is at `time`.

        Without a time it is the one of the last call, at first the default time.
        """
        before = self._scene.instances.paths, self._scene.instances.local_to_world.copy()
        if self._extractor is not None:
            self._extractor.update(time)
        self._on_device.sync(self._scene)
        self._previous_frames.advance()
        # Rows mean the same things as before only while the paths are the same; else nothing moves.
        now = self._scene.instances
        self._before = before[1] if before[0] == now.paths else now.local_to_world

    def place_between(self, fraction: float) -> None:
        """Show the instances at `fraction` of their way from the sync before the last (0) to the last one (1).

        For motion blur: labels and everything else want 1, where `sync` leaves them.
        """
        after = self._scene.instances.local_to_world
        if self._before.shape == after.shape and not np.array_equal(self._before, after):
            self._on_device.place(self._scene, interpolate(self._before, after, fraction))

    def labels(self, view: CameraView, aovs: Collection[str]) -> dict[str, np.ndarray]:
        """One ray through each pixel center; see `aov.AOVS` for names, units and values.

        Motion vectors count from when this camera last asked for them, before the last `sync` or in another place.

        Raises:
            RenderError: an AOV is not known.
            Unsupported: the projection of the camera is not known.
        """
        return self.labels_of([view], aovs)[0]

    def labels_of(self, views: Sequence[CameraView], aovs: Collection[str]) -> list[dict[str, np.ndarray]]:
        """`labels` of many views, drawn together where they have one size."""
        results: list[dict[str, np.ndarray]] = [{} for _ in views]
        for places in view_batches.of_labels(views):
            batch = self.label_batch([views[k] for k in places], aovs)
            for k, arrays in zip(places, batch.numpy(), strict=True):
                results[k] = arrays
        return results

    def label_batch(self, views: Sequence[CameraView], aovs: Collection[str]) -> LabelBatch:
        """`labels` of views of one size in one launch, left on the device.

        Raises:
            RenderError: the views are of several sizes, or there is none.
        """
        names = check_names(aovs)
        if len(view_batches.alike(views)) != 1:
            sizes = sorted({f"{view.width}x{view.height}" for view in views})
            raise RenderError(
                f"a batch of labels wants views of one size of one stage; these are {', '.join(sizes) or 'none'}"
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

    def labels_and_masks(
        self, views: Sequence[CameraView], aovs: Collection[str], groups: Sequence[Sequence[int]]
    ) -> tuple[list[dict[str, np.ndarray]], list[PixelMasks]]:
        """`labels_of`, and the masks of the same groups of gprims in each of the views."""
        results: dict[int, tuple[dict[str, np.ndarray], PixelMasks]] = {}
        for places in view_batches.of_labels(views):
            some = [views[k] for k in places]
            batch = self.label_batch(some, {*aovs, "instance"})
            covered = []
            for part in view_batches.of_masks(len(some), len(self.gprims)):
                piece = LabelBatch(len(part), {"instance": batch.arrays["instance"][part.start : part.stop]})
                covered += self.coverage_batch(some[part.start : part.stop], groups, piece).pixel_masks()
            results |= dict(zip(places, zip(batch.numpy(), covered, strict=True), strict=True))
        return [results[k][0] for k in range(len(views))], [results[k][1] for k in range(len(views))]

    def pixel_masks(
        self, view: CameraView, groups: Sequence[Sequence[int]], *, instance: np.ndarray | None = None
    ) -> PixelMasks:
        """Pixels that each group of gprims would cover if it were alone, and those in which it is seen.

        A group's pixel counts once, however many of its gprims are met there; groups may share gprims. What is met is
        exactly what `labels` of a stage with that group alone would show.

        Args:
            instance: the AOV of that name that `labels` gave of this view; None makes it.
        """
        if instance is None:
            return self.labels_and_masks([view], ["instance"], groups)[1][0]
        shown = wp.array(instance[None], dtype=wp.int32, device=self.device)
        return self.coverage_batch([view], groups, LabelBatch(1, {"instance": shown})).pixel_masks()[0]

    def coverage_batch(
        self, views: Sequence[CameraView], groups: Sequence[Sequence[int]], batch: LabelBatch
    ) -> Coverage:
        """Masks of views of one size, left on the device; `batch` holds their AOV `instance`."""
        shown = batch.arrays["instance"]
        return Coverage(self._on_device, views, groups, shown, mode=self._label_mode, threads=self.threads)

    def coverage(self, view: CameraView, groups: Sequence[Sequence[int]]) -> np.ndarray:
        """Pixels that each group of gprims would cover if it were alone.

        Returns:
            (len(groups), 5) int64: pixels, x_min, y_min, x_max, y_max (inclusive); -1 bounds for no pixels.
        """
        return self.pixel_masks(view, groups).coverage

    def new_film(self, width: int, height: int) -> Film:
        """An empty film."""
        return Film(width, height, self.device)

    def accumulate(self, film: Film, view: CameraView, *, samples: int, settings: PathSettings) -> None:
        """Add `samples` per pixel of the present state, numbered from `settings.first_sample`.

        For motion blur call this once per sub-frame with `first_sample` counting on.
        """
        self.accumulate_all([film], [view], samples=samples, settings=settings)

    def accumulate_all(
        self, films: Sequence[Film], views: Sequence[CameraView], *, samples: int, settings: PathSettings
    ) -> None:
        """`accumulate` for many views, each with its film; on CUDA those of one size are drawn together.

        Raises:
            RenderError: a film has not the size of its view.
        """
        self._path_tracer.accumulate(films, views, samples=samples, settings=settings, threads=self.threads)

    def develop(self, film: Film, tone: ToneSettings | None = None) -> dict[str, np.ndarray]:
        """Denoise and tone-map a film.

        Returns:
            HdrColor, (H, W, 4) float16 radiance [nits]; LdrColor, (H, W, 4) uint8 sRGB; and the film's light AOVs.
        """
        return tone_map(film, tone or ToneSettings(), threads=self.threads)


def keep_memory(device: str) -> None:
    """Let arrays of one frame serve the next: to ask a driver for memory takes longer than to draw into it."""
    if wp.get_device(device).is_mempool_enabled and wp.get_mempool_release_threshold(device) < KEPT_BYTES:
        wp.set_mempool_release_threshold(device, KEPT_BYTES)


def chosen_device(device: str | None) -> str:
    """The name of the device to render on.

    Raises:
        RenderError: there is no such device.
    """
    if device is None:
        return "cuda:0" if wp.is_cuda_available() else "cpu"
    try:
        return wp.get_device(device).alias
    except (ValueError, RuntimeError) as error:
        known = ", ".join(each.alias for each in wp.get_devices())
        raise RenderError(f"cannot render on {device!r}: {error}. Devices here: {known}.") from error

"""WarpRenderer: renders labels and path-traced images of a USD stage."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from usdsdg.errors import RenderError
from usdsdg.parallel import Later
from usdsdg.warp_start import known_device, quiet_warp
from usdsdg_render.device.forked_cuda import check_not_forked
from usdsdg_render.device.precompile import precompile
from usdsdg_render.labels.label_batch import LabelBatch
from usdsdg_render.labels.label_renderer import LabelRenderer
from usdsdg_render.path.development import develop
from usdsdg_render.path.dropped_samples import DroppedSamples
from usdsdg_render.path.film import Film
from usdsdg_render.path.film_pool import FilmPool
from usdsdg_render.path.path_tracer import PathTracer
from usdsdg_render.scene.scene import Scene
from usdsdg_render.settings import PathSettings, ToneSettings
from usdsdg_render.sync.rigid_motion import RigidMotion
from usdsdg_render.worlds import WorldRenderer

if TYPE_CHECKING:
    from pxr import Sdf, Usd

    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg.stage.world_values import WorldValues
    from usdsdg_render.sync.extract import SceneExtractor

Progress = Callable[[str, int, "int | None"], None]

# Bytes of GPU memory that the process keeps between frames.
KEPT_BYTES = 1 << 30


class WarpRenderer(LabelRenderer):
    """Renders labels and path-traced images of one stage.

    `sync` reads what changed on the stage; the other methods render that state, those of `LabelRenderer` its labels.

    Args:
        stage: the stage to read.
        device: "cpu", "cuda:0", …; None takes the first CUDA device, else the CPU.
        progress: called with (label, done, total) during long work: reading the stage, compiling kernels on first use.

    Raises:
        RenderError: the device does not exist, or the stage is none, as the path of one.
    """

    def __init__(self, stage: Usd.Stage, *, device: str | None = None, progress: Progress | None = None) -> None:
        from pxr import Usd

        from usdsdg_render.sync.extract import SceneExtractor

        if not isinstance(stage, Usd.Stage):
            raise RenderError(
                f"WarpRenderer: stage is {stage!r}; expected a Usd.Stage, as Usd.Stage.Open(path) returns one"
            )
        ready = _ready_device(device, progress)
        extractor = SceneExtractor(stage, progress=progress)
        self._start(extractor.scene, extractor, ready)

    @classmethod
    def of_scene(cls, scene: Scene, *, device: str | None = None, progress: Progress | None = None) -> WarpRenderer:
        """Create a renderer of a scene built without a stage; `sync` then reads changes by `scene.versions`."""
        renderer = cls.__new__(cls)
        renderer._start(scene, None, _ready_device(device, progress))
        return renderer

    def _start(self, scene: Scene, extractor: SceneExtractor | None, device: str) -> None:
        super().__init__(scene, device)
        self._extractor = extractor
        self._path_tracer = PathTracer(self._on_device)
        self._films, self._dropped = FilmPool(device), DroppedSamples()
        self._motion = RigidMotion(*np.zeros((2, 0, 4, 4)))  # from the sync before the last to the last
        self._worlds: WorldRenderer | None = None
        self._reading: Later | None = None  # what still reads the scene on the device

    @property
    def time(self) -> Usd.TimeCode:
        """The time code of the last sync: the default time if nothing on the stage varies with time."""
        from pxr import Usd

        return Usd.TimeCode.Default() if self._extractor is None else self._extractor.time

    def places(self, paths: Sequence[Sdf.Path]) -> tuple[np.ndarray, np.ndarray]:
        """Return which of some prims the last sync has read, as rows, and the matrices (N, 4, 4) of these to the world.

        Float64, row vectors; USD would have to compose them again. Hidden prims may be missing.
        """
        if self._extractor is None:
            return np.zeros(0, np.int64), np.zeros((0, 4, 4))
        return self._extractor.places(paths)

    def look_at_files(self) -> None:
        """Let the next `sync` also read what has changed on disk of images and light profiles, as for a new frame."""
        if self._extractor is not None:
            self._extractor.look_at_files()

    def sync(self, time: Usd.TimeCode | None = None) -> None:
        """Read what changed on the stage since the last call, and time-varying values at `time`.

        None stands for the time of the last call, at first the default time.
        """
        if self._extractor is not None:
            self._extractor.always_show(frozenset())
        self._sync(time)

    def _sync(self, time: Usd.TimeCode | None) -> None:
        before = self._scene.instances
        if self._extractor is not None:
            self._extractor.update(time)
        self._wait_for_readers()
        self._on_device.sync(self._scene)
        self._previous_frames.advance()
        # Rows are the same instances as before only if the keys are the same; else there is no motion blur.
        now = self._scene.instances
        same = before.keys == now.keys
        self._motion = RigidMotion((before if same else now).local_to_world, now.local_to_world)

    def place_between(self, fraction: float) -> None:
        """Interpolate the transforms of instances between the sync before the last (0) and the last one (1).

        For motion blur. Labels are rendered at 1, which `sync` restores.
        """
        if self._motion.moves.any():
            self._wait_for_readers()
            self._on_device.set_transforms(self._scene, self._motion.at(fraction))

    def place_worlds(self, values: WorldValues, time: Usd.TimeCode | None = None) -> WorldRenderer:
        """Read what changed on the stage, as `sync`, and many worlds of it; return what renders these.

        Raises:
            Unsupported: the values of an attribute cannot differ between worlds.
        """
        extractor = self._extractor
        if extractor is None:
            raise RenderError("worlds need a stage, and this renderer was made of a scene")
        shown = {path for path, own in values.values.items() if "visibility" in own}
        extractor.always_show(shown)
        self._sync(time)
        if self._worlds is None:
            self._worlds = WorldRenderer(extractor, self._on_device, self._path_tracer.wavefront, self._dropped)
        self._worlds.place(values)
        return self._worlds

    def world_labels(self, view: CameraView, aovs: Collection[str]) -> LabelBatch:
        """Render `label_batch` of a camera in all worlds that were placed last."""
        assert self._worlds is not None
        return self._worlds.labels(view, aovs, mode=self._label_mode, threads=self.threads)

    def world_pictures(
        self, view: CameraView, *, samples: int, settings: PathSettings, tone: ToneSettings
    ) -> dict[str, wp.array]:
        """Path-trace a camera in all worlds that were placed last; see `WorldRenderer.pictures`."""
        assert self._worlds is not None
        return self._worlds.pictures(view, samples=samples, settings=settings, tone=tone, threads=self.threads)

    def new_film(self, width: int, height: int) -> Film:
        """Return an empty film."""
        return self.new_films(1, width, height)[0]

    def new_films(self, count: int, width: int, height: int) -> list[Film]:
        """Return empty films of one size; `accumulate_all` and `develop_all` serve them together."""
        return self._films.films(count, width, height)

    def accumulate(self, film: Film, view: CameraView, *, samples: int, settings: PathSettings) -> None:
        """Add `samples` per pixel of the current state, numbered from `settings.first_sample`.

        For motion blur, call this once per sub-frame and continue the numbering with `first_sample`.
        """
        self.accumulate_all([film], [view], samples=samples, settings=settings)

    def accumulate_all(
        self, films: Sequence[Film], views: Sequence[CameraView], *, samples: int, settings: PathSettings
    ) -> None:
        """Call `accumulate` for many views, each with its film; on CUDA, views of the same size share a launch.

        Raises:
            RenderError: a film differs in size from its view.
        """
        self._path_tracer.accumulate(films, views, samples=samples, settings=settings, threads=self.threads)

    def later(self, work: Callable[[], None]) -> Later:
        """Call `work`, which may accumulate and develop films, on another thread.

        It sees the scene as it is now: the next `sync` reads the stage meanwhile, and waits before it changes tables
        of the device.
        """
        self._wait_for_readers()
        self._reading = Later(work)
        return self._reading

    def _wait_for_readers(self) -> None:
        if self._reading is not None:
            self._reading.join()
            self._reading = None

    def develop(self, film: Film, tone: ToneSettings | None = None, *, fetched: bool = True) -> dict[str, Any]:
        """Denoise and tone-map a film.

        fetched: as for `labels_of`; light AOVs come to the host in any case.

        Returns:
            HdrColor, (H, W, 4) float16 radiance [nits]; LdrColor, (H, W, 4) uint8 sRGB; and the film's light AOVs.
        """
        return self.develop_all([film], tone, fetched=fetched)[0]

    def develop_all(
        self, films: Sequence[Film], tone: ToneSettings | None = None, *, fetched: bool = True
    ) -> list[dict[str, Any]]:
        """Call `develop` for many films; those of one call of `new_films` share launches."""
        images = develop(films, tone or ToneSettings(), threads=self.threads, fetched=fetched)
        for batch in {id(film.batch): film.batch for film in films}.values():
            self._dropped.look_at(batch)
        return images

    def finish(self) -> None:
        """Wait for what the device still does, and warn of samples of the last images that were not finite."""
        self._dropped.report()


def _ready_device(device: str | None, progress: Progress | None) -> str:
    """Return the name of the device to render on, with kernels that are compiled."""
    name = chosen_device(device)
    precompile(name, progress)
    keep_memory(name)
    return name


def keep_memory(device: str) -> None:
    """Keep freed GPU memory for the next frame: allocation by the driver takes longer than rendering."""
    if wp.get_device(device).is_mempool_enabled and wp.get_mempool_release_threshold(device) < KEPT_BYTES:
        wp.set_mempool_release_threshold(device, KEPT_BYTES)


def chosen_device(device: str | None) -> str:
    """Return the name of the device to render on.

    Raises:
        RenderError: there is no such device, or it is a CUDA device in a process that was forked from one with CUDA.
    """
    quiet_warp()
    if device is None:
        device = "cuda:0" if wp.is_cuda_available() else "cpu"
    try:
        alias = known_device(device)
    except ValueError as error:
        raise RenderError(f"cannot render on {device!r}: {error}") from error
    check_not_forked(alias)
    return alias

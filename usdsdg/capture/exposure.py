"""The path-traced images of one frame: a film for each camera, exposed once per sub-frame."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from usdsdg.capture.render_settings import RenderMode, path_settings, tone_settings
from usdsdg.capture.requests import Requests
from usdsdg.capture.tiles import assembled, view_of, views_of
from usdsdg.session import engines
from usdsdg.session.progress import report
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras.camera_reader import CameraReader
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.ignored_attributes import warn_of_exposure
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg_render.settings import LIGHT_AOVS

if TYPE_CHECKING:
    from usdsdg_render.path.film import Film
    from usdsdg_render.settings import PathSettings, ToneSettings

# Poses within one motion-blur sub-frame: enough that fast objects leave a streak, not a row of copies.
BLUR_STEPS = 4
SAMPLES_PER_CALL = 16


@dataclass(frozen=True)
class Tracing:
    """Samples that are added to the films of one frame in one call, with the settings of that frame."""

    renderer: engines.Renderer
    films: tuple[Film, ...]
    views: tuple[CameraView, ...]
    samples: int
    settings: PathSettings


@dataclass(frozen=True)
class Step:
    """Samples of all films, and what to report when they are added."""

    tracings: tuple[Tracing, ...]
    progress: tuple[str, int, int] | None  # label, samples per pixel so far, and of the frame

    def run(self) -> None:
        """Add the samples."""
        for each in self.tracings:
            each.renderer.accumulate_all(each.films, each.views, samples=each.samples, settings=each.settings)
        if self.progress is not None:
            report(*self.progress)


class Exposure:
    """The films of one frame."""

    def __init__(self, requests: Requests, frame: int, cameras: CameraReader) -> None:
        self._requests = requests
        self._cameras = cameras
        self._frame = frame
        self._films: dict[str, list[Film]] = {}  # by product path, one per tile
        self._images: dict[str, list[dict[str, Any]]] = {}  # those of developed films
        self._renderer: engines.Renderer | None = None
        self._tone: ToneSettings | None = None

    @property
    def exposed(self) -> tuple[str, ...]:
        """The paths of the products that have films."""
        return tuple(self._films)

    def open_shutter(self) -> None:
        """Read the stage as it is now: the poses at which a motion-blurred exposure begins."""
        engines.renderer().sync(stage_time(current_stage()))

    def add(self, mode: RenderMode) -> None:
        """Add the samples of `mode` to every film; creates the films at the first call.

        With motion blur the samples are distributed over the motion since the last exposure or `open_shutter`.
        """
        engines.renderer().sync(stage_time(current_stage()))
        if not mode.motion_blur:
            for step in self.steps(mode):
                step.run()
            return
        parts = mode.split(BLUR_STEPS)
        for number, part in enumerate(parts):
            engines.renderer().place_between((number + 0.5) / len(parts))
            self._step(part, mode.samples * mode.sub_frames).run()
        engines.renderer().place_between(1.0)

    def steps(self, mode: RenderMode) -> list[Step]:
        """Return what adds the samples of `mode` to every film, of a scene that stands still."""
        # Split only to report progress; the image is bit-identical to that of one call.
        return [self._step(part, mode.samples) for part in mode.split(-(-mode.samples // SAMPLES_PER_CALL))]

    def _step(self, mode: RenderMode, total: int) -> Step:
        self._renderer = renderer = engines.renderer()
        self._tone = tone_settings(mode)
        views = self._traced_views()
        self._add_films(renderer, views)
        batches: dict[bool, list[tuple[Film, CameraView]]] = {}  # by whether light AOVs are requested
        for path, cameras in views.items():
            batch = batches.setdefault(self._has_light_aovs(path), [])
            batch += zip(self._films[path], cameras, strict=True)
        tracings = []
        for with_light_aovs, batch in batches.items():
            films, cameras = zip(*batch, strict=True)
            settings = path_settings(mode, self._frame, with_light_aovs=with_light_aovs)
            tracings.append(Tracing(renderer, films, cameras, mode.samples, settings))
        done = min(mode.first_sample + mode.samples, total)
        progress = (f"frame {self._frame}: samples per pixel", done, total) if mode.path_tracing else None
        return Step(tuple(tracings), progress)

    def images(self, path: str, view: CameraView | TiledView) -> dict[str, Any]:
        """Return the tone-mapped AOVs of a product, {} if it has no film, and release its films."""
        if self._films:
            assert self._renderer is not None
            films = [film for films in self._films.values() for film in films]
            images = iter(self._renderer.develop_all(films, self._tone, fetched=False))
            self._images = {each: [next(images) for _ in films] for each, films in self._films.items()}
            self._films = {}
        found = self._images.pop(path, [])
        return assembled(view, found) if found else {}

    def _traced_views(self) -> dict[str, tuple[CameraView, ...]]:
        """Return the cameras of the products whose path-traced images are requested, by product path."""
        assert self._renderer is not None
        traced = {}
        for product in self._requests.products():
            if self._requests.requirements(product.path).path_tracing:
                traced[product.path] = views_of(view_of(product, self._cameras, self._renderer.time))
                for view in traced[product.path]:
                    warn_of_exposure(view.prim_path, view.attributes)
        return traced

    def _add_films(self, renderer: engines.Renderer, views: Mapping[str, Sequence[CameraView]]) -> None:
        """Make the films that are missing, those of one size and kind together."""
        kinds = {
            path: [(camera.width, camera.height, self._has_light_aovs(path)) for camera in cameras]
            for path, cameras in views.items()
            if path not in self._films
        }
        counts = Counter(kind for each in kinds.values() for kind in each)
        films = {kind: iter(renderer.new_films(count, *kind[:2])) for kind, count in counts.items()}
        self._films |= {path: [next(films[kind]) for kind in each] for path, each in kinds.items()}

    def _has_light_aovs(self, path: str) -> bool:
        return not self._requests.requirements(path).aovs.isdisjoint(LIGHT_AOVS)

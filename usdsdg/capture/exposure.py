"""The path-traced images of one frame: a film for each camera, exposed once per sub-frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from usdsdg.capture.render_settings import RenderMode, path_settings, tone_settings
from usdsdg.capture.requests import Requests
from usdsdg.capture.tiles import assembled, view_of, views_of
from usdsdg.session import engines
from usdsdg.session.progress import report
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg_render.settings import LIGHT_AOVS

if TYPE_CHECKING:
    from usdsdg_render.path.film import Film

# Poses within one motion-blur sub-frame: enough that fast objects leave a streak, not a row of copies.
BLUR_STEPS = 4
SAMPLES_PER_CALL = 16


class Exposure:
    """The films of one frame."""

    def __init__(self, requests: Requests, frame: int) -> None:
        self._requests = requests
        self._frame = frame
        self._films: dict[str, list[Film]] = {}  # by product path, one per tile
        self._mode: RenderMode | None = None

    def open_shutter(self) -> None:
        """Read the poses at which a motion-blurred exposure begins."""
        engines.renderer().sync(_now())

    def add(self, mode: RenderMode) -> None:
        """Add the samples of `mode` to every film; creates the films at the first call.

        With motion blur the samples are distributed over the motion since the last exposure or `open_shutter`.
        """
        self._mode = mode
        engines.renderer().sync(_now())
        if not mode.motion_blur:
            # Split only to report progress; the image is bit-identical to that of one call.
            for part in mode.split(-(-mode.samples // SAMPLES_PER_CALL)):
                self._add_samples(part, mode.samples)
            return
        parts = mode.split(BLUR_STEPS)
        for step, part in enumerate(parts):
            engines.renderer().place_between((step + 0.5) / len(parts))
            self._add_samples(part, mode.samples * mode.sub_frames)
        engines.renderer().place_between(1.0)

    def _add_samples(self, mode: RenderMode, total: int) -> None:
        renderer = engines.renderer()
        batches: dict[bool, list[tuple[Film, CameraView]]] = {}  # by whether light AOVs are requested
        for product in self._requests.products():
            needs = self._requests.requirements(product.path)
            if not needs.path_tracing:
                continue
            views = views_of(view_of(product, renderer.time))
            if product.path not in self._films:
                self._films[product.path] = [renderer.new_film(view.width, view.height) for view in views]
            batch = batches.setdefault(not needs.aovs.isdisjoint(LIGHT_AOVS), [])
            batch += zip(self._films[product.path], views, strict=True)
        for with_light_aovs, batch in batches.items():
            films, views = zip(*batch, strict=True)
            settings = path_settings(mode, self._frame, with_light_aovs=with_light_aovs)
            renderer.accumulate_all(films, views, samples=mode.samples, settings=settings)
        if mode.path_tracing:
            report(f"frame {self._frame}: samples per pixel", min(mode.first_sample + mode.samples, total), total)

    def images(self, path: str, view: CameraView | TiledView) -> dict[str, np.ndarray]:
        """Return the tone-mapped AOVs of a product, {} if it has no film, and release its films."""
        films = self._films.pop(path, [])
        if not films:
            return {}
        assert self._mode is not None
        tone = tone_settings(self._mode)
        return assembled(view, [engines.renderer().develop(film, tone) for film in films])


def _now() -> Usd.TimeCode:
    """Return the current time of the timeline as a time code of the stage."""
    return Usd.TimeCode(get_timeline().get_current_time() * current_stage().GetTimeCodesPerSecond())

"""Path-traced pictures of a view that become better while nothing changes."""

from __future__ import annotations

import time
from collections.abc import Hashable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.capture.render_settings import RenderMode, path_settings, tone_settings
from usdsdg.session.engines import Renderer
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.view.scene import Scene

if TYPE_CHECKING:
    from usdsdg_render.path.film import Film

# Samples per pixel at which a picture is complete.
ENOUGH = 256
# How long samples are added before the picture is shown, and the page is heard, again [s].
AT_ONCE_SECONDS = 0.25


class ProgressivePaths:
    """The film of one page: it starts anew when the view or the scene changes."""

    def __init__(self) -> None:
        self._key: Hashable = None
        self._film: Film | None = None
        self._sample_seconds = AT_ONCE_SECONDS

    @property
    def samples(self) -> int:
        """Samples per pixel of the picture."""
        return 0 if self._film is None else self._film.samples

    @property
    def is_complete(self) -> bool:
        """Whether no more samples are added."""
        return self.samples >= ENOUGH

    def forget(self) -> None:
        """Start anew at the next picture."""
        self._key = self._film = None

    def improve(self, scene: Scene, view: CameraView, key: Hashable) -> np.ndarray:
        """Add some samples, at most as many as there are already, and return the picture (H, W, 3) uint8.

        key: of what the picture depends on; another one starts it anew.
        """
        renderer = scene.read()
        if key != self._key or self._film is None:
            self._key, self._film = key, renderer.new_film(view.width, view.height)
        before = self._film.samples
        count = min(max(before, 1), max(int(AT_ONCE_SECONDS / self._sample_seconds), 1), ENOUGH - before)
        begun = time.perf_counter()
        image = traced(renderer, self._film, view, count)
        if count > 0:
            self._sample_seconds = max(time.perf_counter() - begun, 1e-6) / count
        return image


def quick(scene: Scene, view: CameraView, samples: int = 1) -> np.ndarray:
    """Return a picture (H, W, 3) uint8 of a few samples per pixel."""
    renderer = scene.read()
    return traced(renderer, renderer.new_film(view.width, view.height), view, samples)


def traced(renderer: Renderer, film: Film, view: CameraView, samples: int) -> np.ndarray:
    """Add samples to a film, and return its picture (H, W, 3) uint8, the less denoised the more samples it has."""
    mode = RenderMode(True, samples, 1, False, denoise=True, first_sample=film.samples)
    if samples > 0:
        settings = path_settings(mode, 0, with_light_aovs=False)
        renderer.accumulate_all([film], [view], samples=samples, settings=settings)
    tone = tone_settings(replace(mode, denoiser_blend=min(1.0, film.samples / ENOUGH)))
    return np.ascontiguousarray(renderer.develop(film, tone)["LdrColor"][..., :3])

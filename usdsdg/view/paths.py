"""Path-traced pictures of a view that become better while nothing changes."""

from __future__ import annotations

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

# Samples per pixel at which a picture is complete, and the most that are added before it is shown again.
ENOUGH, AT_ONCE = 256, 16


class ProgressivePaths:
    """The film of one page: it starts anew when the view or the scene changes."""

    def __init__(self) -> None:
        self._key: Hashable = None
        self._film: Film | None = None

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
        """Add samples, as many as there are already, and return the picture (H, W, 3) uint8.

        key: of what the picture depends on; another one starts it anew.
        """
        renderer = scene.read()
        if key != self._key or self._film is None:
            self._key, self._film = key, renderer.new_film(view.width, view.height)
        count = min(max(self._film.samples, 1), AT_ONCE, ENOUGH - self._film.samples)
        return traced(renderer, self._film, view, count)


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

"""Path tracers that draw the benchmark scene: what they have in common, and ours."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from usdsdg.stage.cameras import CameraView
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.scene import Scene
from usdsdg_render.settings import PathSettings

# Surfaces that a path may meet.
SURFACES = 3


class PathTracer(Protocol):
    """Draws the scene that it was made of, with paths of SURFACES surfaces and neither clamp nor filter."""

    name: str

    def picture(self, view: CameraView, samples: int, seed: int) -> np.ndarray:
        """(H, W, 3) float32 mean radiance [nits]; each seed gives noise of its own."""
        ...


class Ours:
    """usdsdg's, without what its presets leave out of a picture: no clamp, no widened lobes."""

    name = "usdsdg"

    def __init__(self, scene: Scene, *, threads: int, device: str = "cpu") -> None:
        self._renderer = WarpRenderer.of_scene(scene, device=device)
        self._renderer.threads = threads
        self._renderer.sync()

    def picture(self, view: CameraView, samples: int, seed: int) -> np.ndarray:
        settings = PathSettings(bounces=SURFACES, clamp=0.0, regularization=0.0, seed=seed)
        film = self._renderer.new_film(view.width, view.height)
        self._renderer.accumulate(film, view, samples=samples, settings=settings)
        return film.radiance()

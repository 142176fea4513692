"""Our path tracer without the bias of its presets: no firefly clamp, no roughness regularization."""

from __future__ import annotations

import numpy as np

from benchmarks.path_tracers import SURFACES, View
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.scene.scene import Scene
from usdsdg_render.settings import PathSettings


class Ours:
    """A `PathTracer`."""

    name = "usdsdg"

    def __init__(self, scene: Scene, *, threads: int, device: str = "cpu") -> None:
        self._renderer = WarpRenderer.of_scene(scene, device=device)
        self._renderer.threads = threads
        self._renderer.sync()

    def render(self, view: View, samples: int, seed: int) -> np.ndarray:
        settings = PathSettings(bounces=SURFACES, clamp=0.0, regularization=0.0, seed=seed)
        film = self._renderer.new_film(view.width, view.height)
        self._renderer.accumulate(film, CameraView(**view._asdict()), samples=samples, settings=settings)
        return film.radiance()

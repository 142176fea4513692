"""Images of scenes built by tests: mean radiance in one call."""

from __future__ import annotations

import os

import numpy as np

from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.scene.scene import Scene
from usdsdg_render.settings import PathSettings

# Device of the renderer's tests, for example cuda:0.
DEVICE = os.environ.get("USDSDG_TEST_DEVICE", "cpu")
# Without firefly clamp and path regularization, which bias the result.
EXACT = dict(clamp=0.0, regularization=0.0)


def renderer_of(scene: Scene, *, threads: int = 1) -> WarpRenderer:
    renderer = WarpRenderer.of_scene(scene, device=DEVICE)
    renderer.threads = threads
    renderer.sync()
    return renderer


def radiance(scene: Scene, view: CameraView, *, samples: int, **settings) -> np.ndarray:
    """Mean radiance, (H, W, 3) [nits]."""
    renderer = renderer_of(scene)
    film = renderer.new_film(view.width, view.height)
    renderer.accumulate(film, view, samples=samples, settings=PathSettings(**{**EXACT, **settings}))
    assert film.dropped == 0
    return film.radiance()

"""Path tracer: adds samples to films, row by row on a CPU, as a wavefront on CUDA."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from usdsdg.errors import RenderError, warn_once
from usdsdg.parallel import launch_rows
from usdsdg_render.device import view_batches
from usdsdg_render.device.camera import camera_records, views_of
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.path.cpu_path import add_samples
from usdsdg_render.kernels.path.film import FilmArrays
from usdsdg_render.kernels.path.path_state import PathOptions
from usdsdg_render.path.environment_weight import set_environment_weights
from usdsdg_render.path.film import Film
from usdsdg_render.path.film_batch import FilmBatch
from usdsdg_render.path.wavefront import WavefrontTracer
from usdsdg_render.scene.struct_rows import records_of, uploaded
from usdsdg_render.settings import PathSettings

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView

# Rows that a CPU thread takes at least: its last ones decide how long the other threads wait.
ROWS_AT_ONCE = 4


class PathTracer:
    """Path-traces one scene on its device."""

    def __init__(self, scene: DeviceScene) -> None:
        self._scene = scene
        self.wavefront = WavefrontTracer(scene.device)

    def accumulate(
        self,
        films: Sequence[Film],
        views: Sequence[CameraView],
        *,
        samples: int,
        settings: PathSettings,
        threads: int | None,
    ) -> None:
        """Add `samples` per pixel to the film of each view; on CUDA views of one size are traced together.

        Raises:
            RenderError: a film does not have the size of its view.
        """
        for film, view in zip(films, views, strict=True):
            _check_size(film, view)
            if settings.denoise:
                film.allocate_features()
            if settings.light_aovs:
                film.allocate_light_aovs()
        if not self._scene.lit:
            warn_once("the scene has no light, so images are black: add a UsdLux light, for example a DomeLight")
        for indices in view_batches.same_size(views, films):
            options = path_options(settings, films[indices[0]])
            if not self._scene.has_glass:
                options.glass_bounces = 0
            cameras = camera_records([views[k] for k in indices], self._scene.device)
            table = self._table([films[k] for k in indices])
            trace(self._scene, self.wavefront, table, cameras, options, samples, threads)
        for film in films:
            film.samples += samples

    def _table(self, films: Sequence[Film]) -> wp.array:
        """Return the arrays of films on the device."""
        batch = films[0].batch
        if [(film.batch, film.image) for film in films] == [(batch, image) for image in range(batch.images)]:
            return batch.table
        return uploaded(records_of([film.arrays for film in films], FilmArrays), FilmArrays, self._scene.device)


def trace(
    scene: Any,
    wavefront: WavefrontTracer,
    films: wp.array,
    cameras: np.ndarray,
    options: PathOptions,
    samples: int,
    threads: int | None,
) -> None:
    """Add samples to films, a table of `FilmArrays`, of cameras with images of one size.

    scene: a `DeviceScene`, or what stands for one.
    """
    views = views_of(cameras, scene.device)
    set_environment_weights(scene, views.cameras, threads=threads)
    if scene.device != "cpu":
        wavefront.add_samples(scene.tables, options, views, films, samples)
        return
    options.samples = samples
    shape, inputs = (len(films) * views.height, views.width), [scene.tables, options, views]
    launch_rows(add_samples, shape, inputs, [films], device="cpu", threads=threads, band_rows=ROWS_AT_ONCE)


def path_options(settings: PathSettings, film: Film | FilmBatch) -> PathOptions:
    """Convert settings to the record that kernels read."""
    options = PathOptions()
    options.bounces = max(1, settings.bounces)
    options.glass_bounces = max(0, settings.glass_bounces)
    options.first_sample = settings.first_sample
    options.seed = settings.seed & 0xFFFFFFFF
    options.frame = settings.frame & 0xFFFFFFFF
    options.clamp = settings.clamp
    options.regularization = settings.regularization
    options.features = int(film.has_features)
    options.light_aovs = int(film.has_light_aovs)
    return options


def _check_size(film: Film, view: CameraView) -> None:
    if (film.width, film.height) != (view.width, view.height):
        raise RenderError(
            f"the film is {film.width}x{film.height} but {view.prim_path} renders "
            f"{view.width}x{view.height}: make a new film of that size"
        )

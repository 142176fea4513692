"""WorldRenderer: renders many worlds of one scene, their labels in one launch and their pictures in one wavefront."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np
import warp as wp

from usdsdg.errors import Unsupported
from usdsdg.stage.world_values import WorldValues
from usdsdg_render.device.camera import camera_records, views_of
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.device.world_tables import DeviceWorlds
from usdsdg_render.labels import label_pass
from usdsdg_render.labels.aov import check_names
from usdsdg_render.labels.label_batch import LabelBatch
from usdsdg_render.path.development import developed_batch
from usdsdg_render.path.film_batch import FilmBatch
from usdsdg_render.path.path_tracer import path_options, trace
from usdsdg_render.path.wavefront import WavefrontTracer
from usdsdg_render.settings import PathSettings, ToneSettings

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg_render.path.dropped_samples import DroppedSamples
    from usdsdg_render.scene.scene import Scene
    from usdsdg_render.sync.extract import SceneExtractor
    from usdsdg_render.usd.world_transforms import WorldTransforms


class WorldRenderer:
    """Renders worlds of the stage of a renderer. `place` reads what differs; the other methods render that."""

    def __init__(
        self, extractor: SceneExtractor, on_device: DeviceScene, wavefront: WavefrontTracer, dropped: DroppedSamples
    ) -> None:
        self._extractor, self._wavefront, self._dropped = extractor, wavefront, dropped
        self._worlds = DeviceWorlds(on_device)
        self._transforms: WorldTransforms | None = None
        self._films: dict[tuple[int, int, int], FilmBatch] = {}
        self.device = on_device.device

    @property
    def scene(self) -> Scene:
        """The scene, whose instances all worlds have."""
        return self._extractor.scene

    def place(self, values: WorldValues) -> None:
        """Read and upload worlds of the stage as it was at the last `sync`.

        Raises:
            Unsupported: the values of an attribute cannot differ between worlds.
        """
        worlds, self._transforms = self._extractor.worlds(values)
        self._worlds.place(self.scene, worlds)

    def cameras(self, view: CameraView) -> np.ndarray:
        """Return (worlds, 4, 4) camera-to-world matrices, without scale, of a camera in all worlds."""
        transforms = self._transforms
        assert transforms is not None, "place the worlds first"
        matrices = transforms.at(np.array([self._extractor.node_of(view.prim_path)]))[:, 0]
        matrices = np.array(np.broadcast_to(matrices, (transforms.count, 4, 4)))
        lengths = np.linalg.norm(matrices[:, :3, :3], axis=2, keepdims=True)
        matrices[:, :3, :3] /= np.where(lengths > 0, lengths, 1.0)
        return matrices

    def labels(self, view: CameraView, aovs: Collection[str], *, mode: int, threads: int | None = None) -> LabelBatch:
        """Render AOVs of a camera in all worlds in one launch; see `WarpRenderer.label_batch`.

        Raises:
            Unsupported: motion vectors are asked for, since a world has no frame before.
        """
        names = check_names(aovs)
        if "motion_vectors" in names:
            raise Unsupported("worlds: motion_vectors need an earlier frame, which worlds do not have.")
        images = views_of(self._records(view), self.device)
        units = float(view.meters_per_unit)
        arrays = label_pass.render_views(self._worlds, images, names, meters_per_unit=units, mode=mode, threads=threads)
        return LabelBatch(len(images.cameras), arrays, threads)

    def pictures(
        self, view: CameraView, *, samples: int, settings: PathSettings, tone: ToneSettings, threads: int | None = None
    ) -> dict[str, wp.array]:
        """Path-trace a camera in all worlds; world w has the samples of frame `settings.frame` + w.

        Returns:
            HdrColor (worlds, height, width) vec4h, LdrColor vec4ub on the device; see `WarpRenderer.develop`.

        Raises:
            Unsupported: light AOVs are asked for, or another denoiser than the wavelet filter.
        """
        if settings.light_aovs:
            raise Unsupported("worlds: light AOVs are not rendered for worlds.")
        if settings.denoise:
            _check_denoiser(tone)
        records = self._records(view)
        key = (len(records), view.width, view.height)
        if key not in self._films:
            self._films = {key: FilmBatch(*key, self.device)}
        film = self._films[key]
        film.clear()
        if settings.denoise:
            film.allocate_features()
        options = path_options(settings, film)
        if not self._worlds.has_glass:
            options.glass_bounces = 0
        trace(self._worlds, self._wavefront, film.table, records, options, samples, threads)
        images = developed_batch(film, tone, threads)
        self._dropped.look_at(film)
        return images

    def _records(self, view: CameraView) -> np.ndarray:
        matrices = self.cameras(view)
        records = np.repeat(camera_records([view], self.device), len(matrices))
        records["origin"] = matrices[:, 3, :3]
        records["rotation"] = matrices[:, :3, :3].transpose(0, 2, 1)
        records["world"] = np.arange(len(matrices))
        return records


def _check_denoiser(tone: ToneSettings) -> None:
    if tone.denoise is not False and (tone.denoiser != "wavelet" or tone.denoiser_blend != 0.0):
        raise Unsupported(
            f"worlds: the denoiser {tone.denoiser!r}, blend factor {tone.denoiser_blend:g}, cleans one image "
            "at a time. Set /usdsdg/denoiser to 'wavelet' and blendFactor to 0, or switch denoising off."
        )

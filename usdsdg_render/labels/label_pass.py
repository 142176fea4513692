"""The label pass on the host: allocate what is asked for, and launch it for many pictures at once."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from usdsdg_render.device.camera import views_record
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.device.parallel import launch_rows
from usdsdg_render.kernels.cameras.camera import BAND
from usdsdg_render.kernels.labels.ambient_occlusion import label_ambient
from usdsdg_render.kernels.labels.aov import AovArrays, Past, label_pixels
from usdsdg_render.kernels.labels.lens_motion import label_curved_motion
from usdsdg_render.kernels.labels.material_aov import MaterialArrays, label_materials
from usdsdg_render.labels.previous_frame import History
from usdsdg_render.scene.aov import AMBIENT_REACH, AOVS, MATERIAL_AOVS
from usdsdg_render.scene.scene import Scene

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView

_DTYPES = {(np.int32, ()): wp.int32, (np.float32, ()): wp.float32}
_DTYPES |= {(np.float32, (2,)): wp.vec2, (np.float32, (3,)): wp.vec3}

_OPENNESS = "ambient_occlusion"
_MOTION = "motion_vectors"


def render(
    device_scene: DeviceScene,
    history: History,
    scene: Scene,
    views: Sequence[CameraView],
    names: Collection[str],
    *,
    mode: int,
    threads: int | None,
) -> dict[str, wp.array]:
    """AOVs of views of one size, by name, each (views, height, width) of numbers or vectors on the scene's device.

    Args:
        mode: as for kernels.visibility.closest.
    """
    device, (height, width) = device_scene.device, (views[0].height, views[0].width)
    shape = (len(views), height, width)
    made = {}
    for name in names:
        # The label pass writes every pixel, and its threads share the work of making fresh pages of memory.
        make = wp.zeros if name in MATERIAL_AOVS or name == _OPENNESS else wp.empty
        made[name] = make(shape, dtype=_DTYPES[AOVS[name].dtype, AOVS[name].channels], device=device)
    pictures = views_record(views, device)

    def launch(kernel: Any, band_rows: int, *inputs: Any, out: Any) -> None:
        bands = (len(views) * pictures.bands, width, BAND)
        inputs = (device_scene.tables, pictures, *inputs)
        launch_rows(kernel, bands, inputs, [out], device=device, threads=threads, band_rows=band_rows)

    past = history.past_of(views, scene) if _MOTION in names else Past()
    plain, of_material = AovArrays(), MaterialArrays()
    for name in made.keys() - {_OPENNESS}:
        setattr(of_material if name in MATERIAL_AOVS else plain, name, made[name])
    if not (MATERIAL_AOVS | {_OPENNESS}).issuperset(names):
        launch(label_pixels, 4, past, float(views[0].meters_per_unit), mode, out=plain)
    if not MATERIAL_AOVS.isdisjoint(names):
        launch(label_materials, 4, mode, out=of_material)
    if _OPENNESS in names:
        launch(label_ambient, 2, AMBIENT_REACH / float(views[0].meters_per_unit), mode, out=made[_OPENNESS])
    if _MOTION in names and history.have_lens(views):
        launch(label_curved_motion, 4, past, mode, out=made[_MOTION])
    return made

"""The label pass on the host: allocate the requested AOVs, and launch their kernels for many images at once."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import warp as wp

from usdsdg.parallel import launch_rows
from usdsdg_render.device.camera import views_record
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.cameras.camera import BAND
from usdsdg_render.kernels.labels.ambient_occlusion import AMBIENT_DISTANCE
from usdsdg_render.kernels.labels.aov_table import HEMISPHERE, HIT, MATERIAL, MOTION, PIXEL, SURFACE
from usdsdg_render.kernels.labels.label_kernels import (
    WITH_HIT,
    WITH_MOTION,
    WITH_SURFACE,
    AovImages,
    label_hemispheres,
    label_materials,
    label_pixels,
)
from usdsdg_render.kernels.labels.label_tiles import TILE, label_tiles, tile_memory
from usdsdg_render.kernels.labels.lens_motion import label_lens_motion
from usdsdg_render.kernels.labels.motion import PreviousFrame
from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.labels.aov import AOVS
from usdsdg_render.labels.previous_frame import PreviousFrames
from usdsdg_render.scene.scene import Scene

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView

_MOTION = "motion_vectors"
_ASKED = {MOTION: WITH_MOTION, HIT: WITH_HIT, SURFACE: WITH_SURFACE}


def render(
    device_scene: DeviceScene,
    previous_frames: PreviousFrames,
    scene: Scene,
    views: Sequence[CameraView],
    names: Collection[str],
    *,
    mode: int,
    threads: int | None,
) -> dict[str, wp.array]:
    """Render AOVs of views of one size: by name, (views, height, width) of scalars or vectors on the scene's device.

    Args:
        mode: as for kernels.visibility.closest.
    """
    previous = previous_frames.of(views, scene) if _MOTION in names else PreviousFrame()
    images, meters_per_unit = views_record(views, device_scene.device), float(views[0].meters_per_unit)
    return render_views(
        device_scene,
        images,
        names,
        meters_per_unit=meters_per_unit,
        previous=previous,
        have_lens=_MOTION in names and previous_frames.have_lens(views),
        mode=mode,
        threads=threads,
    )


def render_views(
    device_scene: Any,
    images: Views,
    names: Collection[str],
    *,
    meters_per_unit: float,
    previous: PreviousFrame | None = None,
    have_lens: bool = False,
    mode: int,
    threads: int | None,
) -> dict[str, wp.array]:
    """Render AOVs of the views of a record; see `render`.

    device_scene: a `DeviceScene`, or what stands for one.
    previous: for motion vectors. have_lens: whether a camera has a lens model now, or had one in that frame.
    """
    device, count = device_scene.device, len(images.cameras)
    # Uninitialized: kernels write every pixel, and their threads share the page faults of new memory.
    shape = (count, images.height, images.width)
    made = {name: wp.empty(shape, dtype=AOVS[name].type, device=device) for name in names}
    addresses = AovImages()
    addresses.width, addresses.height = images.width, images.height
    for name, array in made.items():
        setattr(addresses, name, array.ptr)

    def launch(kernel: Any, band_rows: int, *inputs: Any, out: Any = addresses) -> None:
        bands = (count * images.bands, images.width, BAND)
        inputs = (device_scene.tables, images, *inputs)
        launch_rows(kernel, bands, inputs, [out], device=device, threads=threads, band_rows=band_rows)

    reads = {AOVS[name].reads for name in names}
    previous = PreviousFrame() if previous is None else previous
    if reads & {PIXEL, *_ASKED}:
        asked = sum(int(flag) for group, flag in _ASKED.items() if group in reads)
        inputs = (previous, meters_per_unit, asked, mode)
        if device == "cpu" and images.are_pinholes:
            tiles = count * -(-images.height // TILE), -(-images.width // TILE)
            given = [device_scene.tables, images, *inputs, tile_memory(tiles[0])]
            launch_rows(label_tiles, tiles, given, [addresses], device=device, threads=threads, band_rows=2)
        else:
            launch(label_pixels, 4, *inputs)
    if MATERIAL in reads:
        launch(label_materials, 4, mode)
    if HEMISPHERE in reads:
        launch(label_hemispheres, 2, AMBIENT_DISTANCE / meters_per_unit, mode)
    if have_lens:
        launch(label_lens_motion, 4, previous, mode, out=made[_MOTION])
    return made

"""The label pass: kernels that trace one ray through the center of each pixel and write the AOVs of what it hits.

Three kernels, because reading all textures, or tracing rays from surfaces, would slow down the pass for those who ask
for none of this. Every kernel writes every pixel of its AOVs.
"""

import warp as wp

from usdsdg_render.kernels.cameras.camera import Ray
from usdsdg_render.kernels.labels import ambient_occlusion, aov, material_aov  # their functions fill AOVS  # noqa: F401
from usdsdg_render.kernels.labels.aov_table import (
    AOVS,
    HEMISPHERE,
    HIT,
    MATERIAL,
    MOTION,
    PIXEL,
    SURFACE,
    miss_writer,
    struct_of_images,
    writer,
)
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.labels.motion import PreviousFrame
from usdsdg_render.kernels.labels.views import Views, image_row, trace_pixel_center
from usdsdg_render.kernels.scene.surface import Surface, surface_at, with_material
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import Camera, Hit, Material, SceneTables

__all__ = [
    "AOVS",
    "WITH_HIT",
    "WITH_MOTION",
    "WITH_SURFACE",
    "AovImages",
    "label_hemispheres",
    "label_materials",
    "label_pixels",
    "write_label",
]

AovImages = struct_of_images(__name__)

# Which groups of AOVs are asked for: on a CPU a call copies its structs, which takes as long as a short ray.
WITH_MOTION, WITH_HIT, WITH_SURFACE = (wp.constant(1 << k) for k in range(3))

write_pixel = writer(AovImages, PIXEL, hit=Hit, first_instance=int)
write_motion = writer(AovImages, MOTION, tables=SceneTables, camera=Camera, ray=Ray, hit=Hit, previous=PreviousFrame)
write_hit = writer(AovImages, HIT, tables=SceneTables, camera=Camera, ray=Ray, hit=Hit, meters_per_unit=float)
write_surface = writer(AovImages, SURFACE, tables=SceneTables, ray=Ray, hit=Hit, surface=Surface)
write_material = writer(AovImages, MATERIAL, tables=SceneTables, hit=Hit, surface=Surface, material=Material)
write_hemisphere = writer(AovImages, HEMISPHERE, tables=SceneTables, ray=Ray, surface=Surface, distance=float)
miss_pixel = miss_writer(AovImages, HIT, SURFACE)
miss_material = miss_writer(AovImages, MATERIAL)
miss_hemisphere = miss_writer(AovImages, HEMISPHERE)


@wp.func
def write_label(
    out: AovImages,
    v: int,
    y: int,
    x: int,
    tables: SceneTables,
    camera: Camera,
    ray: Ray,
    hit: Hit,
    previous: PreviousFrame,
    meters_per_unit: float,
    asked: int,
):
    """Write the AOVs of a pixel that need neither materials nor more rays."""
    write_pixel(out, v, y, x, hit, tables.first_instance)
    if asked & WITH_MOTION:
        write_motion(out, v, y, x, tables, camera, ray, hit, previous)
    if hit.instance < 0:
        miss_pixel(out, v, y, x)
        return
    if asked & WITH_HIT:
        write_hit(out, v, y, x, tables, camera, ray, hit, meters_per_unit)
    if asked & WITH_SURFACE:
        write_surface(out, v, y, x, tables, ray, hit, surface_at(tables, hit, ray.direction))


@wp.kernel(enable_backward=False, module=LABELS)
def label_pixels(
    tables: SceneTables,
    views: Views,
    previous: PreviousFrame,
    meters_per_unit: float,
    asked: int,  # WITH_* of the AOVs
    mode: int,
    first_band: int,
    # out
    out: AovImages,
):
    band, x, row = wp.tid()
    v, y = image_row(views, first_band + band, row)
    if y >= views.height:
        return
    camera = views.cameras[v]
    tables = in_world(tables, camera.world)
    ray, hit = trace_pixel_center(tables, camera, x, y, mode)
    write_label(out, v, y, x, tables, camera, ray, hit, previous, meters_per_unit, asked)


@wp.kernel(enable_backward=False, module=LABELS)
def label_materials(
    tables: SceneTables,
    views: Views,
    mode: int,
    first_band: int,
    # out
    out: AovImages,
):
    band, x, row = wp.tid()
    v, y = image_row(views, first_band + band, row)
    if y >= views.height:
        return
    camera = views.cameras[v]
    tables = in_world(tables, camera.world)
    ray, hit = trace_pixel_center(tables, camera, x, y, mode)
    if hit.instance < 0:
        miss_material(out, v, y, x)
        return
    surface = surface_at(tables, hit, ray.direction)
    material = tables.materials[surface.material]
    surface = with_material(tables, surface, material)
    write_material(out, v, y, x, tables, hit, surface, material)


@wp.kernel(enable_backward=False, module=LABELS)
def label_hemispheres(
    tables: SceneTables,
    views: Views,
    distance: float,  # up to which surfaces occlude each other [stage units]
    mode: int,
    first_band: int,
    # out
    out: AovImages,
):
    band, x, row = wp.tid()
    v, y = image_row(views, first_band + band, row)
    if y >= views.height:
        return
    camera = views.cameras[v]
    tables = in_world(tables, camera.world)
    ray, hit = trace_pixel_center(tables, camera, x, y, mode)
    if hit.instance < 0:
        miss_hemisphere(out, v, y, x)
        return
    write_hemisphere(out, v, y, x, tables, ray, surface_at(tables, hit, ray.direction), distance)

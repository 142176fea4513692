"""Label pass over materials: what the surface at the centre of each pixel is made of.

A kernel of its own, because reading all textures would make the label pass slower for those who ask for none of this.
"""

import warp as wp

from usdsdg_render.kernels.camera import camera_ray
from usdsdg_render.kernels.surface import bumped, surface_at, with_material
from usdsdg_render.kernels.types import Camera, SceneTables
from usdsdg_render.kernels.visibility import CLEAR, closest


@wp.struct
class MaterialArrays:
    """Outputs, (height, width); an array of no rows is not asked for."""

    bump_normals: wp.array2d(dtype=wp.vec3)
    diffuse: wp.array2d(dtype=wp.vec3)
    specular: wp.array2d(dtype=wp.vec3)
    roughness: wp.array2d(dtype=wp.float32)
    emission: wp.array2d(dtype=wp.vec3)
    transmission: wp.array2d(dtype=wp.vec3)


@wp.kernel(enable_backward=False)
def label_materials(
    tables: SceneTables,
    camera: Camera,
    mode: int,
    first_row: int,
    # out
    out: MaterialArrays,
):
    y, x = wp.tid()
    y += first_row
    ray = camera_ray(camera, float(x) + 0.5, float(y) + 0.5, wp.vec2(0.0))
    hit = closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, mode, 0.5)
    if hit.instance < 0:
        return
    surface = surface_at(tables, hit, ray.direction)
    material = tables.materials[surface.material]
    surface = with_material(tables, surface, material)
    if out.bump_normals.shape[0] > 0:
        normal = surface.normal
        if material.normal_texture >= 0 or material.detail_texture >= 0:
            normal = bumped(tables, hit, surface, material)
        out.bump_normals[y, x] = normal
    if out.diffuse.shape[0] > 0:
        out.diffuse[y, x] = surface.base * (1.0 - surface.metallic)
    if out.specular.shape[0] > 0:
        out.specular[y, x] = surface.specular * (1.0 - surface.metallic) + surface.base * surface.metallic
    if out.roughness.shape[0] > 0:
        out.roughness[y, x] = surface.roughness
    if out.emission.shape[0] > 0:
        out.emission[y, x] = surface.emission
    if out.transmission.shape[0] > 0:
        tint = surface.base
        if material.thin == CLEAR:
            tint = wp.vec3(1.0)
        out.transmission[y, x] = tint * material.transmission

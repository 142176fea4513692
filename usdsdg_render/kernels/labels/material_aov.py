"""Label pass over materials: what the surface at the centre of each pixel is made of.

A kernel of its own, because reading all textures would make the label pass slower for those who ask for none of this.
"""

import warp as wp

from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.labels.views import Views, meet_centre, picture_row
from usdsdg_render.kernels.scene.surface import bumped, surface_at, with_material
from usdsdg_render.scene.structs import CLEAR_PANE, SceneTables


@wp.struct
class MaterialArrays:
    """Outputs, (views, height, width); an empty array is not asked for."""

    bump_normals: wp.array3d(dtype=wp.vec3)
    diffuse: wp.array3d(dtype=wp.vec3)
    specular: wp.array3d(dtype=wp.vec3)
    roughness: wp.array3d(dtype=wp.float32)
    emission: wp.array3d(dtype=wp.vec3)
    transmission: wp.array3d(dtype=wp.vec3)


@wp.kernel(enable_backward=False, module=LABELS)
def label_materials(
    tables: SceneTables,
    views: Views,
    mode: int,
    first_band: int,
    # out
    out: MaterialArrays,
):
    band, x, row = wp.tid()
    v, y = picture_row(views, first_band + band, row)
    if y >= views.height:
        return
    ray, hit = meet_centre(tables, views.cameras[v], x, y, mode)
    if hit.instance < 0:
        return
    surface = surface_at(tables, hit, ray.direction)
    material = tables.materials[surface.material]
    surface = with_material(tables, surface, material)
    if out.bump_normals.shape[0] > 0:
        normal = surface.normal
        if material.normal_texture >= 0 or material.detail_texture >= 0:
            normal = bumped(tables, hit, surface, material)
        out.bump_normals[v, y, x] = normal
    if out.diffuse.shape[0] > 0:
        out.diffuse[v, y, x] = surface.base * (1.0 - surface.metallic)
    if out.specular.shape[0] > 0:
        out.specular[v, y, x] = surface.specular * (1.0 - surface.metallic) + surface.base * surface.metallic
    if out.roughness.shape[0] > 0:
        out.roughness[v, y, x] = surface.roughness
    if out.emission.shape[0] > 0:
        out.emission[v, y, x] = surface.emission
    if out.transmission.shape[0] > 0:
        tint = surface.base
        if material.thin == CLEAR_PANE:
            tint = wp.vec3(1.0)
        out.transmission[v, y, x] = tint * material.transmission

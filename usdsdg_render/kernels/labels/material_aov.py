"""AOVs of the material at the center of each pixel, from all of its textures."""

import warp as wp

from usdsdg_render.kernels.labels.aov_table import MATERIAL, aov
from usdsdg_render.kernels.scene.surface import Surface, mapped_normal
from usdsdg_render.scene.structs import CLEAR_PANE, Hit, Material, SceneTables


@aov(MATERIAL)
def bump_normals(tables: SceneTables, hit: Hit, surface: Surface, material: Material) -> wp.vec3:
    """Normal after the material's normal maps, in world space."""
    normal = surface.normal
    if material.normal_texture >= 0 or material.detail_texture >= 0:
        normal = mapped_normal(tables, hit, surface, material)
    return normal


@aov(MATERIAL)
def diffuse(surface: Surface) -> wp.vec3:
    """Base color of the part that is not metal, linear Rec. 709."""
    return surface.base * (1.0 - surface.metallic)


@aov(MATERIAL)
def specular(surface: Surface) -> wp.vec3:
    """Reflectance at normal incidence, linear Rec. 709."""
    return surface.specular * (1.0 - surface.metallic) + surface.base * surface.metallic


@aov(MATERIAL)
def roughness(surface: Surface) -> wp.float32:
    """From 0, a mirror, to 1."""
    return surface.roughness


@aov(MATERIAL)
def emission(surface: Surface) -> wp.vec3:
    """Emitted radiance [nits], linear Rec. 709."""
    return surface.emission


@aov(MATERIAL)
def transmission(surface: Surface, material: Material) -> wp.vec3:
    """Fraction of light that passes through glass, linear Rec. 709."""
    tint = surface.base
    if material.thin == CLEAR_PANE:
        tint = wp.vec3(1.0)
    return tint * material.transmission

"""Read Omniverse's gltf/pbr.mdl: glTF 2.0 materials with extensions, as its converters write them.

Mirrors https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#materials and KHR_texture_transform, _clearcoat,
_specular, _ior, _transmission and _emissive_strength. Textures are connected shaders `gltf_texture_lookup`.
"""

import math
from dataclasses import replace

from pxr import UsdShade

from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.mdl.inputs import BLACK, WHITE, warn_where
from usdsdg_render.materials.network import Network
from usdsdg_render.materials.preview_surface import reflectance, texture_file
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT, UvTransform

MASK, BLEND = 1, 2
# glTF's wrap modes are OpenGL's constants.
WRAPS = {33071: WRAP_CLAMP, 33648: WRAP_MIRROR, 10497: WRAP_REPEAT}
LOOKUPS = ("gltf_texture_lookup", "gltf_normal_texture_lookup")


def read_gltf(network: Network, shader: UsdShade.Shader) -> Material:
    """Read a gltf_material."""
    base = _lookup(network, shader, "base_color_texture", color=True)
    packed = _lookup(network, shader, "metallic_roughness_texture", color=False)
    coat = _lookup(network, shader, "clearcoat_texture", color=False)
    coat_roughness = _lookup(network, shader, "clearcoat_roughness_texture", color=False)
    normal = _lookup(network, shader, "normal_texture", color=False)
    alpha = network.number(shader, "base_alpha", 1.0)
    mode = network.number(shader, "alpha_mode", 0.0)
    strength = network.number(shader, "emissive_strength", 1.0)
    ior = network.ior(shader, "ior", 1.5)
    specular = network.number(shader, "specular_factor", 1.0) * reflectance(ior)
    specular_color = network.floats(shader, "specular_color_factor", WHITE)
    _warn_of_ignored(network, shader)
    return Material(
        base_color=Input(network.floats(shader, "base_color_factor", WHITE), base),
        metallic=Input((network.number(shader, "metallic_factor", 1.0),), packed, 2),
        roughness=Input((network.number(shader, "roughness_factor", 1.0),), packed, 1),
        specular=Input(tuple(min(specular * c, 1.0) for c in specular_color)),
        opacity=Input((alpha,), base, 3) if mode in (MASK, BLEND) else Input((1.0,)),
        opacity_threshold=max(network.number(shader, "alpha_cutoff", 0.5), 1e-6) if mode == MASK else 0.0,
        transmission=network.limited(shader, "transmission_factor", 0.0),
        ior=ior,
        thin=int(network.number(shader, "thickness_factor", 0.0) <= 0.0),
        emission=Input(
            tuple(strength * c for c in network.floats(shader, "emissive_factor", BLACK)),
            _lookup(network, shader, "emissive_texture", color=True),
        ),
        normal=normal and replace(normal, fallback=(0.5, 0.5, 1.0, 1.0)),
        normal_scale=network.number(shader, "normal_scale_factor", 1.0),
        metal_f90=1.0,
        clearcoat=Input((network.number(shader, "clearcoat_factor", 0.0),), coat, 0),
        clearcoat_roughness=Input((network.number(shader, "clearcoat_roughness_factor", 0.0),), coat_roughness, 1),
        uv_primvar=network.uv_primvar or "",
    )


def _lookup(network: Network, shader: UsdShade.Shader, name: str, *, color: bool) -> TextureUse | None:
    node = network.source(shader, name).shader
    if node is None:
        return None
    identifier = node.GetPrim().GetAttribute("info:mdl:sourceAsset:subIdentifier")
    if not identifier or str(identifier.Get()) not in LOOKUPS:
        network.warn(node, f"it feeds {name} but is no {LOOKUPS[0]}, so it is ignored. Connect a texture.")
        return None
    file = texture_file(network, node, "texture")
    if not file:
        return None
    uv_set = int(network.number(node, "tex_coord_index", 0.0))
    network.use_uv(node, f"st_{uv_set}" if uv_set else "st")
    return TextureUse(
        file,
        color_space="sRGB" if color else "raw",
        color=color,
        wrap_s=WRAPS.get(int(network.number(node, "wrap_s", 10497.0)), WRAP_REPEAT),
        wrap_t=WRAPS.get(int(network.number(node, "wrap_t", 10497.0)), WRAP_REPEAT),
        transform=_transform(network, node),
        shader=str(node.GetPath()),
    )


def _transform(network: Network, node: UsdShade.Shader) -> UvTransform:
    """KHR_texture_transform for texture coordinates (u, 1 - v), since v of glTF points down."""
    x, y = network.floats(node, "offset", (0.0, 0.0))
    width, height = network.floats(node, "scale", (1.0, 1.0))
    rotation = network.number(node, "rotation", 0.0)
    cos, sin = math.cos(rotation), math.sin(rotation)
    return UvTransform(
        (cos * width, -sin * height, x + sin * height), (sin * width, cos * height, 1.0 - y - cos * height)
    )


def _warn_of_ignored(network: Network, shader: UsdShade.Shader) -> None:
    warn_where(network, shader, {"sheen_color_factor": BLACK, "iridescence_factor": (0.0,)})
    textures = ("transmission_texture", "specular_texture", "specular_color_texture", "clearcoat_normal_texture")
    for name in textures:
        if network.source(shader, name).shader is not None:
            network.warn(shader, f"inputs:{name} is not supported; its factor alone is used. Bake it into a constant.")

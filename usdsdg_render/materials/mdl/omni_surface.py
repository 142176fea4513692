"""Read OmniSurface and OmniGlass of Omniverse's MDL templates, as far as the renderer has such layers.

Mirrors https://docs.omniverse.nvidia.com/materials-and-rendering/latest/templates/OmniSurface.html and OmniGlass.html.
Subsurface scattering becomes a diffuse color; glass is tinted where light enters it, not by distance.
"""

from pxr import UsdShade

from usdsdg_render.materials.mdl.inputs import (
    BLACK,
    WHITE,
    blended,
    cutout,
    normal_map,
    number_texture,
    texture,
    textured,
    transform,
    uv_primvar,
    warn_of_projection,
    warn_of_textures,
    warn_where,
)
from usdsdg_render.materials.network import Network
from usdsdg_render.materials.preview_surface import reflectance
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import UvTransform


def read_omni_glass(network: Network, shader: UsdShade.Shader) -> Material:
    """Read OmniGlass or OmniGlass_Opacity."""
    uv = transform(network, shader)
    ior = network.ior(shader, "glass_ior", 1.491)
    roughness = number_texture(network, shader, "roughness_texture", transform=uv)
    influence = network.number(shader, "roughness_texture_influence", 1.0)
    opacity, threshold = Input((1.0,)), 0.0
    if network.flag(shader, "enable_opacity", False):
        constant = network.number(shader, "cutout_opacity", 1.0)
        opacity = cutout(network, shader, "cutout_opacity_texture", "cutout_opacity_mono_source", constant, uv)
        threshold = network.number(shader, "opacity_threshold", 0.0)
    warn_where(network, shader, {"reflection_color": WHITE})
    warn_of_textures(network, shader, ["reflection_color_texture"])
    warn_of_projection(network, shader)
    return Material(
        base_color=textured(
            network.floats(shader, "glass_color", WHITE),
            texture(network, shader, "glass_color_texture", color=True, transform=uv),
        ),
        roughness=blended(network.number(shader, "frosting_roughness", 0.0), roughness, 0, influence),
        specular=Input((reflectance(ior),) * 3),
        opacity=opacity,
        opacity_threshold=max(threshold, 0.0),
        transmission=1.0,
        ior=ior,
        thin=int(network.flag(shader, "thin_walled", False)),
        normal=normal_map(network, shader, "normal_map_texture", uv),
        normal_scale=network.number(shader, "normal_map_strength", 1.0),
        uv_primvar=uv_primvar(network, shader, "uv_space_index"),
    )


def read_omni_surface(network: Network, shader: UsdShade.Shader) -> Material:
    """Read OmniSurface or OmniSurfaceLite, with the texture of each input where it has one."""
    uv = UvTransform.of(
        (network.number(shader, "uvw_s_scale", 1.0), network.number(shader, "uvw_t_scale", 1.0)),
        0.0,
        (network.number(shader, "uvw_s_offset", 0.0), network.number(shader, "uvw_t_offset", 0.0)),
    )

    def scalar(name: str, default: float) -> Input:
        constant = network.number(shader, name, default)
        return textured((constant,), number_texture(network, shader, f"{name}_image", transform=uv))

    ior = network.ior(shader, "specular_reflection_ior", 1.5)
    transmission = 0.0
    if network.flag(shader, "enable_specular_transmission", False):
        transmission = network.limited(shader, "specular_transmission_weight", 0.0)
    _warn_of_unread(network, shader)
    has_opacity = network.flag(
        shader, "enable_opacity", network.source(shader, "geometry_opacity").attribute is not None
    )
    return Material(
        base_color=_base(network, shader, uv, transmission),
        metallic=scalar("metalness", 0.0),
        roughness=scalar("specular_reflection_roughness", 0.2),
        specular=_specular(network, shader, uv, reflectance(ior)),
        opacity=scalar("geometry_opacity", 1.0) if has_opacity else Input((1.0,)),
        opacity_threshold=max(network.number(shader, "geometry_opacity_threshold", 0.0), 0.0) if has_opacity else 0.0,
        transmission=transmission,
        ior=ior,
        thin=int(network.flag(shader, "thin_walled", False)),
        emission=_emission(network, shader, uv),
        normal=normal_map(network, shader, "geometry_normal_image", uv),
        normal_scale=network.number(shader, "geometry_normal_strength", 1.0),
        metal_f90=1.0,
        coat_f0=reflectance(network.ior(shader, "coat_ior", 1.5)),
        clearcoat=scalar("coat_weight", 0.0),
        clearcoat_roughness=scalar("coat_roughness", 0.1),
        uv_primvar=uv_primvar(network, shader, "uvw_uv_set"),
    )


def _warn_of_unread(network: Network, shader: UsdShade.Shader) -> None:
    """Warn of inputs that are not read although they would change the look."""
    nothing = (0.0,)
    names = ("diffuse_reflection_roughness", "specular_reflection_anisotropy", "specular_retro_reflection_weight")
    warn_where(network, shader, dict.fromkeys(names, nothing))
    if network.number(shader, "coat_weight", 0.0) > 0.0:
        names = ("coat_anisotropy", "coat_affect_color", "coat_affect_roughness")
        warn_where(network, shader, {"coat_color": WHITE, **dict.fromkeys(names, nothing)})
    warn_of_textures(network, shader, ["coat_normal_image", "geometry_displacement_image"])


def _base(network: Network, shader: UsdShade.Shader, uv: UvTransform, transmission: float) -> Input:
    """Read the diffuse color, blended with the subsurface color and the transmission color by their weights."""
    weight = network.number(shader, "diffuse_reflection_weight", 0.8)
    color = tuple(weight * c for c in network.floats(shader, "diffuse_reflection_color", WHITE))
    use = texture(network, shader, "diffuse_reflection_color_image", color=True, transform=uv)
    subsurface = 0.0
    if network.flag(shader, "enable_diffuse_transmission", False):
        subsurface = network.limited(shader, "subsurface_weight", 0.0)
    scattered = network.floats(shader, "subsurface_scattering_color", WHITE)
    tint = network.floats(shader, "specular_transmission_color", WHITE)
    color = tuple(c + subsurface * (s - c) for c, s in zip(color, scattered))
    color = tuple(c + transmission * (t - c) for c, t in zip(color, tint))
    return textured(color, use, factor=(weight,) * 3)


def _specular(network: Network, shader: UsdShade.Shader, uv: UvTransform, f0: float) -> Input:
    weight = f0 * network.number(shader, "specular_reflection_weight", 1.0)
    color = network.floats(shader, "specular_reflection_color", WHITE)
    use = texture(network, shader, "specular_reflection_color_image", color=True, transform=uv)
    return textured(tuple(weight * c for c in color), use, factor=(weight,) * 3)


def _emission(network: Network, shader: UsdShade.Shader, uv: UvTransform) -> Input:
    weight = network.number(shader, "emission_weight", 0.0) * network.number(shader, "emission_intensity", 1.0)
    if weight <= 0.0:
        return Input(BLACK)
    use = texture(network, shader, "emission_color_image", color=True, transform=uv)
    color = network.floats(shader, "emission_color", WHITE)
    return textured(tuple(weight * c for c in color), use, factor=(weight,) * 3)

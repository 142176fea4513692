"""Inputs that Omniverse's MDL templates share: texture files, UV transforms, values blended with a texture."""

import math
from collections.abc import Iterable
from dataclasses import replace

from pxr import UsdShade

from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.network import Network
from usdsdg_render.materials.preview_surface import COLOR_SPACES, texture_file
from usdsdg_render.materials.shading import Input
from usdsdg_render.scene.scene import IDENTITY_UV, WRAP_REPEAT, UvTransform

WHITE = (1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0)
_FLAT_NORMAL = (0.5, 0.5, 1.0, 1.0)
# base::mono_mode of MDL: what a number is read of a texture as. Of other values average, the default of the templates.
_ALPHA, _MONOS = 0.0, {2.0: "luminance", 3.0: "maximum"}


def texture(
    network: Network, shader: UsdShade.Shader, name: str, *, color: bool, transform: UvTransform = IDENTITY_UV
) -> TextureUse | None:
    """Read the texture of an asset-valued input; None without a file. Without a color space only colors are sRGB."""
    file = texture_file(network, shader, name)
    if not file:
        return None
    attribute = network.source(shader, name).attribute
    default = "sRGB" if color else "raw"
    authored = str(attribute.GetColorSpace() or "auto") if attribute is not None else "auto"
    if authored not in COLOR_SPACES:
        network.warn(
            shader,
            f"color space {authored!r} of inputs:{name} is not supported; the file counts as {default}. Convert it and "
            "say sRGB or raw.",
        )
    space = COLOR_SPACES.get(authored, "auto")
    space = default if space == "auto" else space
    return TextureUse(
        file,
        color_space=space,
        color=color,
        wrap_s=WRAP_REPEAT,
        wrap_t=WRAP_REPEAT,
        transform=transform,
        shader=str(shader.GetPath()),
    )


def number_texture(
    network: Network, shader: UsdShade.Shader, name: str, *, mono: str = "average", transform: UvTransform
) -> TextureUse | None:
    """Read the texture of a number, which MDL's templates take the mean of a color for."""
    use = texture(network, shader, name, color=False, transform=transform)
    return use and replace(use, mono=mono)


def cutout(
    network: Network, shader: UsdShade.Shader, name: str, mode_name: str, constant: float, transform: UvTransform
) -> Input:
    """Read an opacity: by its texture, as its mode says, or by the constant without one."""
    mode = network.number(shader, mode_name, 1.0)
    mono = "" if mode == _ALPHA else _MONOS.get(mode, "average")
    use = number_texture(network, shader, name, mono=mono, transform=transform)
    return Input((constant,)) if use is None else Input((1.0,), use, 3 if mode == _ALPHA else 0, (constant,))


def normal_map(
    network: Network, shader: UsdShade.Shader, name: str, transform: UvTransform = IDENTITY_UV
) -> TextureUse | None:
    """Read a normal map; MDL's templates flip the green channel by default."""
    use = texture(network, shader, name, color=False, transform=transform)
    if use is None:
        return None
    flips = (network.flag(shader, "flip_tangent_u", False), network.flag(shader, "flip_tangent_v", True))
    scale = (*(-1.0 if flip else 1.0 for flip in flips), 1.0, 1.0)
    bias = (*(1.0 if flip else 0.0 for flip in flips), 0.0, 0.0)
    return replace(use, color_space="raw", scale=scale, bias=bias, fallback=_FLAT_NORMAL)


def transform(network: Network, shader: UsdShade.Shader, prefix: str = "texture") -> UvTransform:
    """Read the scale, rotation [authored in degrees] and translation of texture coordinates."""
    return UvTransform.of(
        network.floats(shader, f"{prefix}_scale", (1.0, 1.0)),
        math.radians(network.number(shader, f"{prefix}_rotate", 0.0)),
        network.floats(shader, f"{prefix}_translate", (0.0, 0.0)),
    )


def warn_of_projection(network: Network, shader: UsdShade.Shader) -> None:
    """Warn of texture coordinates that a template would project onto the object."""
    if network.flag(shader, "project_uvw", False):
        network.warn(
            shader, "project_uvw is approximated by the mesh's texture coordinates. Author them, or switch it off."
        )


def warn_of_textures(network: Network, shader: UsdShade.Shader, names: Iterable[str]) -> None:
    """Warn of textures that are not read."""
    for name in names:
        if getattr(network.value(shader, name), "path", ""):
            network.warn(shader, f"inputs:{name} is not supported and is ignored. Remove it to agree.")


def uv_primvar(network: Network, shader: UsdShade.Shader, name: str) -> str:
    """Read the number of the texture coordinates; return their primvar, "" for the first ones, whatever their name."""
    number = int(network.number(shader, name, 0.0))
    return f"st_{number}" if number > 0 else ""


def textured(value: tuple[float, ...], use: TextureUse | None, *, factor: tuple[float, ...] | None = None) -> Input:
    """Return the texture times a factor; the value without a texture."""
    if use is None:
        return Input(value)
    return Input((1.0,) * len(value) if factor is None else factor, use, 0, value)


def blended(constant: float, use: TextureUse | None, channel: int, influence: float) -> Input:
    """Return lerp(constant, texture, influence)."""
    influence = min(max(influence, 0.0), 1.0)
    if use is None or influence == 0.0:
        return Input((constant,))
    if influence < 1.0:
        use = replace(use, scale=(influence,) * 4, bias=(constant * (1.0 - influence),) * 4)
    return Input((1.0,), use, channel, (constant,))


def warn_where(network: Network, shader: UsdShade.Shader, ignored: dict[str, tuple[float, ...]]) -> None:
    """Warn of inputs that are not read but have another value than the default given here."""
    for name, default in ignored.items():
        if network.floats(shader, name, default) != default:
            network.warn(shader, f"inputs:{name} is not supported and is ignored. Leave it at {default} to agree.")

"""What Omniverse's MDL templates have in common: files, coordinates, and values blended with a texture."""

from __future__ import annotations

import math
from dataclasses import replace

from pxr import UsdShade

from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.preview_surface import texture_file
from usdsdg_render.materials.shading import Input, Network
from usdsdg_render.scene.scene import AS_IT_IS, WRAP_REPEAT, UvTransform

WHITE = (1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0)
_FLAT = (0.5, 0.5, 1.0, 1.0)


def texture(
    network: Network, shader: UsdShade.Shader, name: str, *, color: bool, transform: UvTransform = AS_IT_IS
) -> TextureUse | None:
    """The texture of an asset-valued input, None without a file. Files of no color space are sRGB as colors only."""
    file = texture_file(network, shader, name)
    if not file:
        return None
    attribute = network.source(shader, name).attribute
    space = str(attribute.GetColorSpace() or "auto") if attribute is not None else "auto"
    if space not in ("sRGB", "raw"):
        space = "sRGB" if color else "raw"
    return TextureUse(
        file,
        color_space=space,
        color=color,
        wrap_s=WRAP_REPEAT,
        wrap_t=WRAP_REPEAT,
        transform=transform,
        shader=str(shader.GetPath()),
    )


def normal_map(
    network: Network, shader: UsdShade.Shader, name: str, transform: UvTransform = AS_IT_IS
) -> TextureUse | None:
    """A normal map as the kernels read it: MDL's templates turn the green channel round unless told otherwise."""
    use = texture(network, shader, name, color=False, transform=transform)
    if use is None:
        return None
    turned = (network.flag(shader, "flip_tangent_u", False), network.flag(shader, "flip_tangent_v", True))
    scale = (*(-1.0 if turn else 1.0 for turn in turned), 1.0, 1.0)
    bias = (*(1.0 if turn else 0.0 for turn in turned), 0.0, 0.0)
    return replace(use, color_space="raw", scale=scale, bias=bias, beyond=_FLAT)


def transform(network: Network, shader: UsdShade.Shader, prefix: str = "texture") -> UvTransform:
    """Scale, rotation [authored in degrees] and translation of the templates' textures."""
    return UvTransform.of(
        network.floats(shader, f"{prefix}_scale", (1.0, 1.0)),
        math.radians(network.number(shader, f"{prefix}_rotate", 0.0)),
        network.floats(shader, f"{prefix}_translate", (0.0, 0.0)),
    )


def textured(value: tuple[float, ...], use: TextureUse | None, *, factor: tuple[float, ...] | None = None) -> Input:
    """A texture times a factor, in place of the value where there is one."""
    if use is None:
        return Input(value)
    return Input((1.0,) * len(value) if factor is None else factor, use, 0, value)


def blended(constant: float, use: TextureUse | None, channel: int, influence: float) -> Input:
    """lerp(constant, texture, influence)."""
    influence = min(max(influence, 0.0), 1.0)
    if use is None or influence == 0.0:
        return Input((constant,))
    if influence < 1.0:
        use = replace(use, scale=(influence,) * 4, bias=(constant * (1.0 - influence),) * 4)
    return Input((1.0,), use, channel, (constant,))


def warn_where(network: Network, shader: UsdShade.Shader, ignored: dict[str, tuple[float, ...]]) -> None:
    """Name the inputs that would change the picture but are not read: those with another value than given here."""
    for name, default in ignored.items():
        if network.floats(shader, name, default) != default:
            network.warn(shader, f"inputs:{name} is not supported and is ignored. Leave it at {default} to agree.")

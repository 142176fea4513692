"""Read UsdPreviewSurface networks (https://openusd.org/release/spec_usdpreviewsurface.html)."""

import math
from dataclasses import replace

from pxr import Usd, UsdShade

from usdsdg_render.images import image_files
from usdsdg_render.images.image_files import UDIM
from usdsdg_render.images.textures import ONES, ZEROS, TextureUse
from usdsdg_render.materials.display_color import DEFAULT_COLOR
from usdsdg_render.materials.network import NOTHING, Network, Source, shader_id
from usdsdg_render.materials.shading import Input, Material, PrimvarInput
from usdsdg_render.scene.scene import WRAP_BLACK, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT, UvTransform
from usdsdg_render.scene.structs import CLEAR_PANE
from usdsdg_render.usd.color_spaces import current_color

# PNG and JPEG carry no wrap mode, so `useMetadata`, the fallback, means repeat here, as in Omniverse.
WRAPS = {"repeat": WRAP_REPEAT, "clamp": WRAP_CLAMP, "mirror": WRAP_MIRROR, "black": WRAP_BLACK}
CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3}
COLOR_SPACES = {
    **dict.fromkeys(("auto", "unknown"), "auto"),
    **dict.fromkeys(("sRGB", "srgb_texture", "srgb_rec709_scene"), "sRGB"),
    **dict.fromkeys(("raw", "data", "identity", "linear", "lin_rec709", "lin_rec709_scene", "lin_srgb"), "raw"),
}
# MaterialX has the nodes of UsdPreviewSurface's specification, too, with the same inputs.
_MATERIAL_X_NODES = {
    "ND_UsdUVTexture": "UsdUVTexture",
    "ND_UsdUVTexture_22": "UsdUVTexture",
    "ND_UsdUVTexture_23": "UsdUVTexture",
    "ND_UsdTransform2d": "UsdTransform2d",
    "ND_UsdPrimvarReader_float": "UsdPrimvarReader_float",
    "ND_UsdPrimvarReader_vector2": "UsdPrimvarReader_float2",
    "ND_UsdPrimvarReader_vector3": "UsdPrimvarReader_float3",
    "ND_UsdPrimvarReader_vector4": "UsdPrimvarReader_float4",
}
PREVIEW_SURFACES = ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader")
BLACK = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)
UNSIGNED_FILES = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".webp")
FIELDS = {
    "diffuseColor": "base_color",
    "specularColor": "specular",
    "emissiveColor": "emission",
    "clearcoatRoughness": "clearcoat_roughness",
}


def read_preview_surface(network: Network, surface: UsdShade.Shader) -> Material:
    """Read a UsdPreviewSurface without occlusion, which rays find; warn of displacement and of a constant normal."""
    base = _input(network, surface, "diffuseColor", (0.18, 0.18, 0.18))
    specular_workflow = bool(network.number(surface, "useSpecularWorkflow", 0.0))
    ior = network.ior(surface, "ior", 1.5)
    if specular_workflow:
        metallic, specular = Input((0.0,)), _input(network, surface, "specularColor", BLACK)
    else:
        metallic = _input(network, surface, "metallic", (0.0,))
        specular = Input((reflectance(ior),) * 3)
    _warn_of_ignored(network, surface)
    material = Material(
        name=str(network.material.GetPath()),
        base_color=base,
        metallic=metallic,
        roughness=_input(network, surface, "roughness", (0.5,)),
        specular=specular,
        ior=ior,
        opacity=_input(network, surface, "opacity", (1.0,)),
        opacity_threshold=max(network.number(surface, "opacityThreshold", 0.0), 0.0),
        emission=_input(network, surface, "emissiveColor", BLACK),
        normal=_normal(network, surface),
        coat_f0=reflectance(ior),
        clearcoat=_input(network, surface, "clearcoat", (0.0,)),
        clearcoat_roughness=_input(network, surface, "clearcoatRoughness", (0.01,)),
        uv_primvar=network.uv_primvar or "",
        reads_display_color=network.reads_display_color,
        primvar_inputs=tuple(network.primvar_inputs),
    )
    if str(network.value(surface, "opacityMode") or "transparent") == "presence":
        return material
    return as_pane(material)


def as_pane(material: Material) -> Material:
    """Turn a constant opacity in (0, 1) into a clear pane, which reflects as much as if it were opaque.

    Opacity 0 leaves no surface; with a texture or a threshold, opacity says where there is a surface.
    """
    opacity = material.opacity.value[0]
    if material.opacity.texture is not None or material.opacity_threshold > 0.0 or not 0.0 < opacity < 1.0:
        return material
    return replace(material, opacity=Input((1.0,)), transmission=1.0 - opacity, thin=CLEAR_PANE)


def _warn_of_ignored(network: Network, surface: UsdShade.Shader) -> None:
    displacement = network.source(surface, "displacement")
    if displacement.shader is not None or network.number(surface, "displacement", 0.0) != 0.0:
        network.warn(surface, "displacement is not supported and is ignored. Bake it into the mesh.")
    if network.source(surface, "normal").shader is None and network.floats(surface, "normal", UP) != UP:
        network.warn(surface, "a constant normal is ignored. Author the normals of the mesh or connect a texture.")


def _kind(shader: UsdShade.Shader) -> str:
    """Return the id of a shader; of MaterialX's nodes that of the node of UsdPreviewSurface's specification."""
    name = shader_id(shader)
    return _MATERIAL_X_NODES.get(name, name)


def reflectance(ior: float) -> float:
    """Return the Fresnel reflectance at normal incidence (F0) between air and `ior`."""
    ior = max(ior, 0.0)
    return ((1.0 - ior) / (1.0 + ior)) ** 2


def _input(network: Network, surface: UsdShade.Shader, name: str, default: tuple[float, ...]) -> Input:
    source = network.source(surface, name)
    if source.attribute is not None:
        return Input(network.as_floats(surface, name, current_color(source.attribute), default))
    if source.shader is None:
        return Input(default)
    kind = _kind(source.shader)
    if kind == "UsdUVTexture":
        return _textured(network, source, default)
    if kind.startswith("UsdPrimvarReader_float"):
        return _from_primvar(network, source.shader, name, default)
    network.warn(
        source.shader,
        f"shader '{kind}' feeds {name} of {surface.GetPath()} but is not supported; {default} is used. Connect a "
        f"UsdUVTexture or author a constant.",
    )
    return Input(default)


def _from_primvar(network: Network, reader: UsdShade.Shader, name: str, default: tuple[float, ...]) -> Input:
    variable = str(network.value(reader, "varname") or "").removeprefix("primvars:")
    if name == "diffuseColor" and variable == "displayColor":
        network.reads_display_color = True
        return Input(network.floats(reader, "fallback", DEFAULT_COLOR))
    fallback = network.floats(reader, "fallback", default)
    network.primvar_inputs.append(PrimvarInput(FIELDS.get(name, name), variable, fallback))
    return Input(fallback)


def _textured(network: Network, source: Source, default: tuple[float, ...]) -> Input:
    texture = source.shader
    assert texture is not None
    color = len(default) > 1
    fallback = network.floats(texture, "fallback", (*default, 1.0)[:4] if color else default * 4)
    channel = CHANNELS.get(source.output, 0)
    broadcast = channel if color and source.output in CHANNELS else -1
    use = texture_use(network, texture, color=color or source.output == "a")
    scale, bias = network.floats(texture, "scale", ONES), network.floats(texture, "bias", ZEROS)
    if broadcast >= 0:
        scale, bias, fallback = ((values[channel],) * 4 for values in (scale, bias, (*fallback, 1.0)[:4]))
    fallback = fallback[: len(default)] if color else (fallback[channel],)
    if use is None:
        return Input(fallback)
    if any(bias) or UDIM in use.file:  # more than a factor, so it belongs to the look-up
        use = replace(use, scale=scale, bias=bias, fallback=(*fallback, 1.0) if color else fallback * 4)
        scale = ONES
    factor = scale[: len(default)] if color else (scale[channel],)
    return Input(factor, replace(use, broadcast=broadcast), channel, fallback)


def texture_use(network: Network, texture: UsdShade.Shader, *, color: bool) -> TextureUse | None:
    """Read file, color space, wrap modes and coordinates of a UsdUVTexture; None (with a warning) without a file."""
    file = texture_file(network, texture, "file")
    transform = _coordinates(network, texture)
    if not file:
        warn_without_file(network, texture)
        return None
    return TextureUse(
        file=file,
        color_space=_color_space(network, texture, color=color),
        color=color,
        transform=transform,
        wrap_s=_wrap(network, texture, "wrapS"),
        wrap_t=_wrap(network, texture, "wrapT"),
        shader=str(texture.GetPath()),
    )


def warn_without_file(network: Network, texture: UsdShade.Shader) -> None:
    """Warn of a texture whose `file` is missing or empty."""
    source = network.source(texture, "file")
    if source == NOTHING or (source.attribute and image_files.asset_file(source.attribute) == ("", "")):
        network.warn(texture, "it names no file; the fallback is used. Author inputs:file.")


def texture_file(network: Network, shader: UsdShade.Shader, name: str) -> str:
    """Return the resolved file of an asset-valued input; "" if there is none (with a warning if one is authored)."""
    attribute = network.constant(shader, name)
    if attribute is None:
        return ""
    authored, file = image_files.asset_file(attribute)
    if authored and not file:
        network.warn(
            shader, f"inputs:{name} names {authored}, which does not exist; the fallback is used. Correct the path."
        )
    return file


def _color_space(network: Network, texture: UsdShade.Shader, *, color: bool) -> str:
    authored = network.value(texture, "sourceColorSpace")
    if authored is None:  # metadata of the file attribute, as some exporters write
        attribute = network.source(texture, "file").attribute
        if attribute is not None and color:  # that of a ColorSpaceAPI above it is for colors only
            authored = Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, None)
        else:
            authored = attribute.GetColorSpace() if attribute is not None else None
    name = str(authored or "auto")
    if name not in COLOR_SPACES:
        network.warn(
            texture,
            f"color space {name!r} is not supported; the file counts as sRGB where it is a color of 8 bits, else as "
            f"linear. Convert it and say sRGB or raw.",
        )
    return COLOR_SPACES.get(name, "auto")


def _wrap(network: Network, texture: UsdShade.Shader, name: str) -> int:
    value = str(network.value(texture, name) or "useMetadata")
    value = "repeat" if value == "periodic" else value  # MaterialX's word
    if value not in WRAPS and value != "useMetadata":
        network.warn(texture, f"inputs:{name} {value!r} is none of {', '.join(WRAPS)}; repeat is used. Correct it.")
    return WRAPS.get(value, WRAP_REPEAT)


def _coordinates(network: Network, texture: UsdShade.Shader) -> UvTransform:
    """Read the texture's UV transform and note its primvar, of which a material has one."""
    transform = UvTransform()
    at, name, given = texture, "st", network.source(texture, "st")
    reader = given.shader
    passed = set()
    while reader is not None and _kind(reader) == "UsdTransform2d" and reader.GetPath() not in passed:
        passed.add(reader.GetPath())
        own = UvTransform.of(
            network.floats(reader, "scale", (1.0, 1.0)),
            math.radians(network.number(reader, "rotation", 0.0)),
            network.floats(reader, "translation", (0.0, 0.0)),
        )
        transform = transform.after(own)
        at, name, given = reader, "in", network.source(reader, "in")
        reader = given.shader
    if given.attribute is not None:  # one texel for the whole surface
        return transform.after(UvTransform.at(network.floats(at, name, (0.0, 0.0))))
    primvar = "st"
    if reader is not None and _kind(reader) == "UsdPrimvarReader_float2":
        primvar = str(network.value(reader, "varname") or "st")
    elif reader is not None:
        network.warn(
            reader,
            f"shader '{shader_id(reader)}' as texture coordinates is not supported; primvars:st is used. Connect a "
            f"UsdPrimvarReader_float2, or a UsdTransform2d of one.",
        )
    network.use_uv(texture, primvar.removeprefix("primvars:"))
    return transform


def _normal(network: Network, surface: UsdShade.Shader) -> TextureUse | None:
    """Read a normal map: raw values, whatever its color space says.

    Authored scale and bias count. Without them files of integers hold normals as (normal + 1) / 2, and files of floats
    hold normals.
    """
    source = network.source(surface, "normal")
    if source.shader is None:
        return None
    if _kind(source.shader) != "UsdUVTexture":
        network.warn(
            source.shader,
            f"shader '{shader_id(source.shader)}' as a normal map is not supported and is ignored. Connect a "
            f"UsdUVTexture.",
        )
        return None
    use = texture_use(network, source.shader, color=False)
    if use is None:
        return None
    use = replace(use, color_space="raw", fallback=(0.5, 0.5, 1.0, 1.0))
    if network.value(source.shader, "scale") is None and network.value(source.shader, "bias") is None:
        return replace(use, is_normal=True)
    scale, bias = network.floats(source.shader, "scale", ONES), network.floats(source.shader, "bias", ZEROS)
    if scale[:3] == ONES[:3] and bias[:3] == ZEROS[:3] and use.file.lower().endswith(UNSIGNED_FILES):
        network.warn(
            source.shader,
            "the scale 1 and bias 0 of a normal map in a file without negative numbers point all normals one way. "
            "Author the scale (2, 2, 2, 1) and the bias (-1, -1, -1, 0), or neither.",
        )
    # The kernel computes texel * 2 - 1, so the texel must be (normal + 1) / 2.
    halved = (*(s / 2.0 for s in scale[:3]), 1.0)
    raised = (*((b + 1.0) / 2.0 for b in bias[:3]), 0.0)
    return replace(use, scale=halved, bias=raised)

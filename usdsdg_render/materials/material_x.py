"""Read MaterialX surfaces authored in USD: Standard Surface and OpenPBR with constants and images.

Mirrors https://autodesk.github.io/standard-surface/ and https://academysoftwarefoundation.github.io/OpenPBR/, as far as
the renderer has such layers. Of the nodes between, those are evaluated that select an image, a channel or coordinates.
"""

from dataclasses import replace
from typing import NamedTuple

from pxr import UsdShade

from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.mdl_inputs import BLACK, WHITE, warn_where
from usdsdg_render.materials.network import Network, Source, shader_id
from usdsdg_render.materials.preview_surface import COLOR_SPACES, reflectance, texture_file
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT, UvTransform

WRAPS = {"periodic": WRAP_REPEAT, "clamp": WRAP_CLAMP, "mirror": WRAP_MIRROR, "constant": WRAP_CLAMP}
CHANNELS = {"outr": 0, "outx": 0, "outg": 1, "outy": 1, "outb": 2, "outz": 2, "outa": 3, "outw": 3}
IMAGES = ("ND_image_", "ND_tiledimage_")
CHANNEL_NODES = ("ND_extract_", "ND_separate")


class Names(NamedTuple):
    """Names of the inputs of a surface, some with their defaults; by default those of Standard Surface."""

    base: tuple[str, float] = ("base", 1.0)
    base_color: tuple[str, tuple[float, ...]] = ("base_color", (0.8, 0.8, 0.8))
    metalness: str = "metalness"
    specular: str = "specular"
    roughness: tuple[str, float] = ("specular_roughness", 0.2)
    ior: str = "specular_IOR"
    transmission: str = "transmission"
    transmission_color: str = "transmission_color"
    subsurface: str = "subsurface"
    subsurface_color: tuple[str, tuple[float, ...]] = ("subsurface_color", WHITE)
    coat: str = "coat"
    coat_ior: tuple[str, float] = ("coat_IOR", 1.5)
    coat_roughness: tuple[str, float] = ("coat_roughness", 0.1)
    emission: str = "emission"
    opacity: str = "opacity"
    thin: str = "thin_walled"
    normal: str = "normal"


OPEN_PBR = Names(
    base=("base_weight", 1.0),
    metalness="base_metalness",
    specular="specular_weight",
    roughness=("specular_roughness", 0.3),
    ior="specular_ior",
    transmission="transmission_weight",
    subsurface="subsurface_weight",
    subsurface_color=("subsurface_color", (0.8, 0.8, 0.8)),
    coat="coat_weight",
    coat_ior=("coat_ior", 1.6),
    coat_roughness=("coat_roughness", 0.0),
    emission="emission_luminance",
    opacity="geometry_opacity",
    thin="geometry_thin_walled",
    normal="geometry_normal",
)
SURFACES = {"ND_standard_surface_surfaceshader": Names(), "ND_open_pbr_surface_surfaceshader": OPEN_PBR}


def read_material_x(network: Network, shader: UsdShade.Shader) -> Material:
    """Read a surface of `SURFACES`. Subsurface scattering becomes a diffuse color."""
    names = SURFACES[shader_id(shader)]
    ior = network.ior(shader, names.ior, 1.5)
    f0 = network.number(shader, names.specular, 1.0) * reflectance(ior)
    emission = network.number(shader, names.emission, 0.0)
    transmission = network.limited(shader, names.transmission, 0.0)
    warn_where(network, shader, {"sheen": (0.0,), "fuzz_weight": (0.0,), "thin_film_thickness": (0.0,)})
    base = _base(network, shader, names, transmission)
    return Material(
        name=str(network.material.GetPath()),
        base_color=base,
        metallic=_input(network, shader, names.metalness, (0.0,)),
        roughness=_input(network, shader, names.roughness[0], (names.roughness[1],)),
        specular=_input(network, shader, "specular_color", WHITE, factor=f0),
        opacity=_input(network, shader, names.opacity, (1.0,)),
        transmission=transmission,
        ior=ior,
        thin=int(network.flag(shader, names.thin, False)),
        emission=_input(network, shader, "emission_color", WHITE, factor=emission) if emission > 0.0 else Input(BLACK),
        normal=_normal(network, network.source(shader, names.normal)),
        metal_f90=1.0,
        coat_f0=reflectance(network.ior(shader, *names.coat_ior)),
        clearcoat=_input(network, shader, names.coat, (0.0,)),
        clearcoat_roughness=_input(network, shader, names.coat_roughness[0], (names.coat_roughness[1],)),
        uv_primvar=network.uv_primvar or "",
    )


def _base(network: Network, shader: UsdShade.Shader, names: Names, transmission: float) -> Input:
    weight = network.number(shader, *names.base)
    base = _input(network, shader, *names.base_color, factor=weight)
    if base.texture is not None:
        return base
    subsurface = network.limited(shader, names.subsurface, 0.0)
    scattered = network.floats(shader, *names.subsurface_color)
    tint = network.floats(shader, names.transmission_color, WHITE)
    color = tuple(c + subsurface * (s - c) for c, s in zip(base.value, scattered))
    return Input(tuple(c + transmission * (t - c) for c, t in zip(color, tint)))


def _input(
    network: Network, shader: UsdShade.Shader, name: str, default: tuple[float, ...], *, factor: float = 1.0
) -> Input:
    source = network.source(shader, name)
    constant = tuple(factor * c for c in network.floats(shader, name, default))
    if source.shader is None:
        return Input(constant)
    found = _image(network, source, color=len(default) > 1)
    if found is None:
        return Input(constant)
    return Input((factor,) * len(default), *found, constant)


def _image(network: Network, source: Source, *, color: bool) -> tuple[TextureUse, int] | None:
    """The connected image and its channel; the connection may pass through a node that extracts a channel."""
    node = source.shader
    channel = 0
    if node is not None and shader_id(node).startswith(CHANNEL_NODES):
        channel = CHANNELS.get(source.output, int(network.number(node, "index", 0.0)))
        node = network.source(node, "in").shader
    if node is None:
        return None
    kind = shader_id(node)
    if not kind.startswith(IMAGES):
        network.warn(node, f"MaterialX node '{kind}' is not evaluated; what it feeds has its default. Bake an image.")
        return None
    file = texture_file(network, node, "file")
    if not file:
        return None
    attribute = network.source(node, "file").attribute
    space = str(attribute.GetColorSpace() or "") if attribute is not None else ""
    if (space or "raw") not in COLOR_SPACES:
        network.warn(
            node, f"color space {space!r} of inputs:file is not supported; the file counts as raw. Convert it to sRGB."
        )
    network.use_uv(node, _coordinates(network, node))
    use = TextureUse(
        file,
        color_space="sRGB" if COLOR_SPACES.get(space) == "sRGB" else "raw",
        color=color,
        wrap_s=WRAPS.get(str(network.value(node, "uaddressmode") or "periodic"), WRAP_REPEAT),
        wrap_t=WRAPS.get(str(network.value(node, "vaddressmode") or "periodic"), WRAP_REPEAT),
        transform=UvTransform.of(
            network.floats(node, "uvtiling", (1.0, 1.0)),
            0.0,
            tuple(-offset for offset in network.floats(node, "uvoffset", (0.0, 0.0))),
        ),
        shader=str(node.GetPath()),
    )
    return use, channel


def _coordinates(network: Network, node: UsdShade.Shader) -> str:
    reader = network.source(node, "texcoord").shader
    if reader is None:
        return "st"
    if shader_id(reader).startswith("ND_geompropvalue_"):
        return str(network.value(reader, "geomprop") or "st")
    if not shader_id(reader).startswith("ND_texcoord_"):
        network.warn(reader, f"MaterialX node '{shader_id(reader)}' is not evaluated; primvars:st is used.")
    return "st"


def _normal(network: Network, source: Source) -> TextureUse | None:
    node = source.shader
    if node is None:
        return None
    if shader_id(node).startswith("ND_normalmap"):
        source = network.source(node, "in")
    found = _image(network, source, color=False)
    return found and replace(found[0], color_space="raw", fallback=(0.5, 0.5, 1.0, 1.0))

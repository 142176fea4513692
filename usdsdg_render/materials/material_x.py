"""Read MaterialX surfaces authored in USD: Standard Surface and OpenPBR with constants and images.

Mirrors https://autodesk.github.io/standard-surface/ and https://academysoftwarefoundation.github.io/OpenPBR/, as far as
the renderer has such layers. Of the nodes between, those are evaluated that select an image, a channel or coordinates.
"""

import math
from dataclasses import replace
from typing import NamedTuple

from pxr import UsdShade

from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.mdl.inputs import BLACK, WHITE, warn_where
from usdsdg_render.materials.network import Network, Source, shader_id
from usdsdg_render.materials.preview_surface import COLOR_SPACES, reflectance, texture_file, warn_without_file
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import IDENTITY_UV, WRAP_BLACK, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT, UvTransform
from usdsdg_render.usd.authored_values import as_floats

# Outside of an image, `constant` has the node's `default`, which is 0 unless it is authored.
WRAPS = {"periodic": WRAP_REPEAT, "clamp": WRAP_CLAMP, "mirror": WRAP_MIRROR, "constant": WRAP_BLACK}
CHANNELS = {"outr": 0, "outx": 0, "outg": 1, "outy": 1, "outb": 2, "outz": 2, "outa": 3, "outw": 3}
IMAGES = ("ND_image_", "ND_tiledimage_")
CHANNEL_NODES = ("ND_extract_", "ND_separate")
CONSTANTS, PRODUCTS = "ND_constant_", "ND_multiply_"
# Nodes that pass on what they get, with more or fewer channels.
PASSING_NODES = (*CHANNEL_NODES, CONSTANTS, PRODUCTS, "ND_convert_", "ND_dot_")
FLAT = (0.0,)
Unread = dict[str, tuple[float, ...]]  # inputs that are not read, with the values that change nothing


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
    # What is not read: always, and where there is a transmission or a coat.
    unread: Unread = Unread(diffuse_roughness=FLAT, specular_anisotropy=FLAT, sheen=FLAT, thin_film_thickness=FLAT)
    unread_transmission: Unread = Unread(
        transmission_depth=FLAT, transmission_scatter=BLACK, transmission_dispersion=FLAT,
        transmission_extra_roughness=FLAT,
    )  # fmt: skip
    unread_coat: Unread = Unread(
        coat_color=WHITE, coat_anisotropy=FLAT, coat_affect_color=FLAT, coat_affect_roughness=FLAT
    )


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
    unread=Unread(
        base_diffuse_roughness=FLAT, specular_roughness_anisotropy=FLAT, fuzz_weight=FLAT, thin_film_weight=FLAT
    ),
    unread_transmission=Unread(transmission_depth=FLAT, transmission_scatter=BLACK, transmission_dispersion_scale=FLAT),
    unread_coat=Unread(coat_color=WHITE, coat_roughness_anisotropy=FLAT),
)
SURFACES = {
    "ND_standard_surface_surfaceshader": Names(),
    "ND_standard_surface_surfaceshader_100": Names(base=("base", 0.8), base_color=("base_color", WHITE)),
    "ND_open_pbr_surface_surfaceshader": OPEN_PBR,
}


def read_material_x(network: Network, shader: UsdShade.Shader) -> Material:
    """Read a surface of `SURFACES`. Subsurface scattering becomes a diffuse color."""
    names = SURFACES[shader_id(shader)]
    ior = network.ior(shader, names.ior, 1.5)
    f0 = network.number(shader, names.specular, 1.0) * reflectance(ior)
    emission = network.number(shader, names.emission, 0.0)
    transmission = network.limited(shader, names.transmission, 0.0)
    material = Material(
        name=str(network.material.GetPath()),
        base_color=_base(network, shader, names, transmission),
        metallic=_input(network, shader, names.metalness, (0.0,)),
        roughness=_input(network, shader, names.roughness[0], (names.roughness[1],)),
        specular=_input(network, shader, "specular_color", WHITE, factor=f0),
        opacity=_input(network, shader, names.opacity, (1.0,)),
        transmission=transmission,
        ior=ior,
        thin=int(network.flag(shader, names.thin, False)),
        emission=_input(network, shader, "emission_color", WHITE, factor=emission) if emission > 0.0 else Input(BLACK),
        normal=_normal(network, shader, names),
        normal_scale=_normal_scale(network, shader, names),
        metal_f90=1.0,
        coat_f0=reflectance(network.ior(shader, *names.coat_ior)),
        clearcoat=_input(network, shader, names.coat, (0.0,)),
        clearcoat_roughness=_input(network, shader, names.coat_roughness[0], (names.coat_roughness[1],)),
        uv_primvar=network.uv_primvar or "",
    )
    _warn_of_unread(network, shader, names, material)
    return material


def _warn_of_unread(network: Network, shader: UsdShade.Shader, names: Names, material: Material) -> None:
    """Warn of inputs that are not read although they would change the look."""
    ignored = dict(names.unread)
    if material.transmission > 0.0:
        ignored |= names.unread_transmission
    if material.clearcoat.texture is not None or material.clearcoat.value != FLAT:
        ignored |= names.unread_coat
    warn_where(network, shader, ignored)


def _base(network: Network, shader: UsdShade.Shader, names: Names, transmission: float) -> Input:
    """Read the base color, blended with those of what scatters below and of transmission by their weights."""
    weight = network.number(shader, *names.base)
    base = _input(network, shader, *names.base_color, factor=weight)
    subsurface = network.limited(shader, names.subsurface, 0.0)
    for share, color in ((subsurface, names.subsurface_color), (transmission, (names.transmission_color, WHITE))):
        if share > 0.0:
            base = _mixed(network, shader, base, _input(network, shader, *color), share, color[0])
    return base


def _mixed(network: Network, shader: UsdShade.Shader, base: Input, other: Input, share: float, name: str) -> Input:
    """Return a color between two; where one of them has an image, the one with the larger share, with a warning."""
    if base.texture is None and other.texture is None:
        return Input(tuple(b + share * (o - b) for b, o in zip(base.value, other.value)))
    if share < 1.0:
        network.warn(
            shader,
            f"inputs:{name} counts for {share:g} of the color, where images are not blended; the one with the larger "
            "share is used alone. Bake an image of both.",
        )
    return other if share > 0.5 else base


def _input(
    network: Network, shader: UsdShade.Shader, name: str, default: tuple[float, ...], *, factor: float = 1.0
) -> Input:
    source = network.source(shader, name)
    if source.shader is None:
        return Input(tuple(factor * c for c in network.floats(shader, name, default)))
    end = _passed(network, source)
    factors = tuple(factor * f for f in end.factors[: len(default)])
    if end.node is None:
        return Input(tuple(f * c for f, c in zip(factors, _constant(network, end, len(default)))))
    found = _image(network, end.node, end.channel, color=len(default) > 1)
    constant = _without_file(network, end.node, end.channel, len(default))
    if constant is None:
        constant = tuple(factor * c for c in default)
    else:
        constant = tuple(f * c for f, c in zip(factors, constant))
    return Input(constant) if found is None else Input(factors, *found, constant)


class _End(NamedTuple):
    """Where nodes lead that pass on what they get: to another node, or to the input of the last one of them."""

    node: UsdShade.Shader | None
    channel: int  # that one of them extracts; -1 for all
    last: UsdShade.Shader
    name: str
    factors: tuple[float, ...] = WHITE  # of red, green and blue, or of a number


def _passed(network: Network, source: Source) -> _End:
    """Follow a connection through nodes that extract a channel, add some, hold a constant, or multiply by one."""
    node, channel, passed, factors = source.shader, -1, set(), WHITE
    last, name = node, "in"
    while node is not None and node.GetPath() not in passed and shader_id(node).startswith(PASSING_NODES):
        passed.add(node.GetPath())
        following = "value" if shader_id(node).startswith(CONSTANTS) else "in"
        if shader_id(node).startswith(CHANNEL_NODES):
            channel = CHANNELS.get(source.output, int(network.number(node, "index", 0.0)))
        elif shader_id(node).startswith(PRODUCTS):
            computed = [each for each in ("in1", "in2") if network.source(node, each).shader is not None]
            if len(computed) != 1 or channel > 2:  # colors have three channels
                break
            [following] = computed
            by = network.floats(node, "in2", WHITE) if following == "in1" else network.floats(node, "in1", BLACK)
            factors = tuple(f * b for f, b in zip(factors, by if channel < 0 else (by[channel],) * 3))
        last, name = node, following
        source = network.source(node, name)
        node = source.shader
    return _End(node, channel, last, name, factors)


def _constant(network: Network, end: _End, count: int) -> tuple[float, ...]:
    """Return the constant at the end of nodes, of which an input that is not authored is 0."""
    if end.channel < 0:
        return network.floats(end.last, end.name, (0.0,) * count)
    return network.floats(end.last, end.name, (0.0,) * (end.channel + 1))[-1:] * count


def _without_file(network: Network, node: UsdShade.Shader, channel: int, count: int) -> tuple[float, ...] | None:
    """Return the `default` of an image, which it gives where its file cannot be read; None without one."""
    if not shader_id(node).startswith(IMAGES) or network.value(node, "default") is None:
        return None
    return _constant(network, _End(node, channel, node, "default"), count)


def _image(network: Network, node: UsdShade.Shader, channel: int, *, color: bool) -> tuple[TextureUse, int] | None:
    """Return the image of a node and its channel; -1 stands for the first one of a number, and all of a color."""
    kind = shader_id(node)
    if not kind.startswith(IMAGES):
        network.warn(node, f"MaterialX node '{kind}' is not evaluated; what it feeds has its default. Bake an image.")
        return None
    file = texture_file(network, node, "file")
    if not file:
        warn_without_file(network, node)
        return None
    attribute = network.source(node, "file").attribute
    space = str(attribute.GetColorSpace() or "") if attribute is not None else ""
    if (space or "raw") not in COLOR_SPACES:
        network.warn(
            node, f"color space {space!r} of inputs:file is not supported; the file counts as raw. Convert it to sRGB."
        )
    if kind.endswith("_float"):
        channel = 0
    primvar, placed = _coordinates(network, node)
    network.use_uv(node, primvar)
    use = TextureUse(
        file,
        color_space="sRGB" if COLOR_SPACES.get(space) == "sRGB" else "raw",
        color=color,
        wrap_s=_wrap(network, node, "uaddressmode"),
        wrap_t=_wrap(network, node, "vaddressmode"),
        transform=_transform(network, node).after(placed),
        broadcast=channel if color else -1,
        shader=str(node.GetPath()),
    )
    return use, max(channel, 0)


def _wrap(network: Network, node: UsdShade.Shader, name: str) -> int:
    wrap = WRAPS.get(str(network.value(node, name) or "periodic"), WRAP_REPEAT)
    if wrap == WRAP_BLACK:
        outside = network.value(node, "default")
        if any(as_floats(outside, 3) or as_floats(outside, 1) or FLAT):
            network.warn(
                node, f"inputs:default = {outside} is not read outside of the image, which is black there. Leave it 0."
            )
    return wrap


def _transform(network: Network, node: UsdShade.Shader) -> UvTransform:
    """Read the tiles of an image: coordinates times `uvtiling` minus `uvoffset`, in the units of its real size."""
    tiling = network.floats(node, "uvtiling", (1.0, 1.0))
    size = network.floats(node, "realworldimagesize", (1.0, 1.0))
    tile = network.floats(node, "realworldtilesize", (1.0, 1.0))
    units = [t / s if s else 1.0 for t, s in zip(tile, size)]
    offset = network.floats(node, "uvoffset", (0.0, 0.0))
    return UvTransform.of(
        tuple(t * u for t, u in zip(tiling, units)), 0.0, tuple(-o * u for o, u in zip(offset, units))
    )


def _coordinates(network: Network, node: UsdShade.Shader) -> tuple[str, UvTransform]:
    """Return the primvar of an image's texture coordinates, and how `place2d` nodes transform these."""
    placed, passed = IDENTITY_UV, set()
    given = network.source(node, "texcoord")
    reader = given.shader
    while reader is not None and shader_id(reader) == "ND_place2d_vector2" and reader.GetPath() not in passed:
        passed.add(reader.GetPath())
        placed = placed.after(_place2d(network, reader))
        node, given = reader, network.source(reader, "texcoord")
        reader = given.shader
    if given.attribute is not None:  # one texel for the whole surface
        return "st", placed.after(UvTransform.at(network.floats(node, "texcoord", (0.0, 0.0))))
    if reader is None:
        return "st", placed
    if shader_id(reader).startswith("ND_geompropvalue_"):
        return str(network.value(reader, "geomprop") or "st"), placed
    if not shader_id(reader).startswith("ND_texcoord_"):
        network.warn(reader, f"MaterialX node '{shader_id(reader)}' is not evaluated; primvars:st is used.")
        return "st", placed
    index = int(network.number(reader, "index", 0.0))
    return f"st{index}" if index > 0 else "st", placed


def _place2d(network: Network, node: UsdShade.Shader) -> UvTransform:
    """Read how a node places an image: about its pivot, divided by scale, turned clockwise, minus offset."""
    pivot, offset = (network.floats(node, name, (0.0, 0.0)) for name in ("pivot", "offset"))
    scale = tuple(1.0 / each if each else 1.0 for each in network.floats(node, "scale", (1.0, 1.0)))
    scaled = UvTransform.of(scale, 0.0, (0.0, 0.0))
    turned = UvTransform.of((1.0, 1.0), -math.radians(network.number(node, "rotate", 0.0)), (0.0, 0.0))
    moved = _moved(offset, -1.0)
    is_moved_first = network.number(node, "operationorder", 0.0) == 1.0
    placed = _moved(pivot, -1.0)
    for step in (moved, turned, scaled) if is_moved_first else (scaled, turned, moved):
        placed = step.after(placed)
    return _moved(pivot, 1.0).after(placed)


def _moved(by: tuple[float, ...], factor: float) -> UvTransform:
    return UvTransform.of((1.0, 1.0), 0.0, (factor * by[0], factor * by[1]))


def _normal(network: Network, shader: UsdShade.Shader, names: Names) -> TextureUse | None:
    source = network.source(shader, names.normal)
    if source.shader is None:
        return None
    if shader_id(source.shader).startswith("ND_normalmap"):
        if network.value(source.shader, "space") == "object":
            network.warn(
                source.shader,
                "inputs:space object is not supported; the map counts as one of tangent space. Bake a map of tangent "
                "space.",
            )
        source = network.source(source.shader, "in")
    end = None if source.shader is None else _passed(network, source)
    if end is not None and end.factors != WHITE:
        network.warn(end.last, "factors of a normal map are ignored. Author the scale of the ND_normalmap.")
    found = None if end is None or end.node is None else _image(network, end.node, -1, color=False)
    return found and replace(found[0], color_space="raw", fallback=(0.5, 0.5, 1.0, 1.0))


def _normal_scale(network: Network, shader: UsdShade.Shader, names: Names) -> float:
    """Return how steep the normal map is; of a scale for each direction their mean, with a warning."""
    node = network.source(shader, names.normal).shader
    if node is None or not shader_id(node).startswith("ND_normalmap"):
        return 1.0
    x, y = network.floats(node, "scale", (1.0, 1.0))
    if x != y:
        network.warn(node, f"inputs:scale = ({x:g}, {y:g}) differs by direction; its mean is used. Author one number.")
    return 0.5 * (x + y)

"""UsdPreviewSurface materials of a USD file, with their pictures, also from inside a package."""

from __future__ import annotations

import io
from typing import Any, NamedTuple

import numpy as np
from PIL import Image, ImageChops
from pxr import Ar, Gf, Sdf, UsdShade

from usdsdg.image_files.png16 import SIGNATURE
from usdsdg.meshes.model import Material, Texture
from usdsdg.stage.colors import srgb_to_linear

_COLORS = (Gf.Vec3f, Gf.Vec3d, Gf.Vec3h, Gf.Vec4f, Gf.Vec4d, Gf.Vec4h)
_WRAPS = ("repeat", "clamp", "mirror", "black")
# Inputs of UsdPreviewSurface that our materials do not have, with their fallbacks.
_LEFT_OUT = {"displacement": 0.0, "useSpecularWorkflow": 0}
# Those that ours have as one number, with their fallbacks.
_NUMBERS = {"ior": 1.5, "clearcoat": 0.0, "clearcoatRoughness": 0.01}


class Coordinates(NamedTuple):
    """The UVs of a picture: a primvar, and the rows of what is multiplied with each (u, v, 1) of it."""

    primvar: str = "st"
    rows: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))

    def of(self, values: np.ndarray) -> np.ndarray:
        """Return the UVs (N, 2) of values of the primvar (N, 2)."""
        return np.c_[values, np.ones(len(values))] @ np.array(self.rows).T


class _Picture(NamedTuple):
    image: Image.Image
    name: str
    output: str  # channels that are read: "rgb", "r", ...
    scale: tuple[float, ...]  # factors of r, g, b, a
    coordinates: Coordinates
    wraps: tuple[str, str]  # along u and v
    is_raw: bool  # whether its colors are linear

    @property
    def factor(self) -> float:
        """The factor of the channel that an input of one number reads."""
        return float(self.scale["rgba".index(self.output[:1])])

    def has_alpha_of(self, opacity: _Picture) -> bool:
        """Whether an opacity is the alpha of this picture, looked up alike."""
        same = self.image is opacity.image and self.wraps == opacity.wraps and self.coordinates == opacity.coordinates
        return same and opacity.output == "a" and "A" in self.image.getbands()


class Looks:
    """Materials in the order of their first use."""

    def __init__(self) -> None:
        self.materials: list[Material] = []
        self.files: list[str] = []
        self.notes: list[str] = []
        self._known: dict[Sdf.Path, tuple[int | None, Coordinates]] = {}
        self._images: dict[str, tuple[Image.Image, bool] | None] = {}

    def index(self, material: UsdShade.Material) -> tuple[int | None, Coordinates]:
        """Return where a material is in the list, and its UVs; None for none or an unknown one."""
        if not material:
            return None, Coordinates()
        path = material.GetPath()
        if path not in self._known:
            surface = material.ComputeSurfaceSource()[0]
            if not surface or surface.GetIdAttr().Get() != "UsdPreviewSurface":
                self._known[path] = None, Coordinates()
            else:
                made, coordinates = self._material(path.name, surface)
                self._known[path] = len(self.materials), coordinates
                self.materials.append(made)
        return self._known[path]

    def _material(self, name: str, surface: UsdShade.Shader) -> tuple[Material, Coordinates]:
        pictures = {each.GetBaseName(): self._picture(each) for each in surface.GetInputs()}
        color, opacity = pictures.get("diffuseColor"), pictures.get("opacity")
        normal, glow = pictures.get("normal"), pictures.get("emissiveColor")
        occlusion = pictures.get("occlusion")
        rough, metal = pictures.get("roughness"), pictures.get("metallic")
        is_alpha = color is not None and opacity is not None and color.has_alpha_of(opacity)
        reads_points = color is None and _reads_display_color(surface)
        emission = glow.scale[:3] if glow is not None else _color(surface, "emissiveColor", 0.0)
        for left, fallback in _LEFT_OUT.items():
            if pictures.get(left) is not None or _number(surface, left, fallback) != fallback:
                self.notes.append(f"the material {name}: {left} is left out")
        numbers = {each: _number(surface, each, fallback) for each, fallback in _NUMBERS.items()}
        for each in (each for each in numbers if pictures.get(each) is not None):
            self.notes.append(f"the material {name}: the picture of {each} is left out")
        look = Material(
            name,
            ior=numbers["ior"],
            clearcoat=numbers["clearcoat"],
            clearcoat_roughness=numbers["clearcoatRoughness"],
            is_presence=_token(surface, "opacityMode") == "presence",
            color=_three(color.scale) if color is not None else _color(surface, "diffuseColor", 0.18),
            color_from_points=reads_points,
            color_texture=color and Texture(color.image, color.name, not color.is_raw, color.wraps),
            opacity=opacity.factor if opacity is not None else _number(surface, "opacity", 1.0),
            opacity_from_color=is_alpha,
            opacity_texture=None if opacity is None or is_alpha else _data(opacity, "r"),
            opacity_threshold=_number(surface, "opacityThreshold", 0.0),
            metallic=_factor(metal, surface, "metallic", 0.0),
            metallic_texture=metal and _data(metal, "b"),
            roughness=_factor(rough, surface, "roughness", 0.5),
            roughness_texture=rough and _data(rough, "g"),
            emission=_three(emission),
            emission_texture=None if glow is None else Texture(glow.image, glow.name, not glow.is_raw, glow.wraps),
            normal_texture=None if normal is None else Texture(_upward(normal), normal.name, wraps=normal.wraps),
            normal_scale=1.0 if normal is None or set(normal.scale) == {1.0} else abs(normal.scale[0]) / 2.0,
            occlusion_texture=occlusion and Texture(_channel(occlusion), occlusion.name, wraps=occlusion.wraps),
        )
        used = [each.coordinates for each in pictures.values() if each is not None]
        if len(set(used)) > 1:
            self.notes.append(f"the material {name} has several sets of UVs; that of its first picture is used for all")
        return look, used[0] if used else Coordinates()

    def _picture(self, given: UsdShade.Input) -> _Picture | None:
        """Return the picture that an input of a surface is connected to; None for a value."""
        attributes = UsdShade.Utils.GetValueProducingAttributes(given)
        if not attributes or not UsdShade.Output.IsOutput(attributes[0]):
            return None
        shader = UsdShade.Shader(attributes[0].GetPrim())
        if (kind := shader.GetIdAttr().Get()) != "UsdUVTexture":
            if not _is_display_color(given):
                self.notes.append(f"{shader.GetPath()}: what {kind} gives to {given.GetBaseName()} is left out")
            return None
        file = _value(shader, "file")
        if not isinstance(file, Sdf.AssetPath) or (found := self._image(file)) is None:
            return None
        image, is_wide = found
        scale = _value(shader, "scale")
        output = attributes[0].GetName().partition(":")[2]
        name = file.path.rsplit("/", 1)[-1].rsplit(".", 1)[0]
        bias = _value(shader, "bias")
        if any(bias or ()) and given.GetBaseName() != "normal":
            self.notes.append(f"{shader.GetPath()}: its bias is left out")
        wraps = [_token(shader, key) for key in ("wrapS", "wrapT")]
        return _Picture(
            image,
            name,
            output,
            tuple(scale or (1.0, 1.0, 1.0, 1.0)),
            self._coordinates(shader),
            (wraps[0] if wraps[0] in _WRAPS else "repeat", wraps[1] if wraps[1] in _WRAPS else "repeat"),
            _is_raw(_color_space(shader), image, is_wide=is_wide),
        )

    def _coordinates(self, shader: UsdShade.Shader) -> Coordinates:
        """Return the primvar that a picture's UVs come from, and how they are transformed."""
        given, matrix, passed = shader.GetInput("st"), np.eye(3), set()
        while given:
            attributes = UsdShade.Utils.GetValueProducingAttributes(given)
            if attributes and not UsdShade.Output.IsOutput(attributes[0]):  # one texel for the whole surface
                place = list(attributes[0].Get() or (0.0, 0.0))
                return Coordinates(rows=_rows(matrix @ [[0, 0, place[0]], [0, 0, place[1]], [0, 0, 1]]))
            reader = UsdShade.Shader(attributes[0].GetPrim()) if attributes else None
            kind = reader.GetIdAttr().Get() if reader else None
            if reader and kind == "UsdTransform2d" and reader.GetPath() not in passed:
                passed.add(reader.GetPath())
                matrix = matrix @ _transform(reader)
                given = reader.GetInput("in")
            elif reader and str(kind).startswith("UsdPrimvarReader"):
                varname = reader.GetInput("varname")
                name = UsdShade.Utils.GetValueProducingAttributes(varname) if varname else []
                return Coordinates(str(name[0].Get() or "st") if name else "st", _rows(matrix))
            else:
                break
        return Coordinates(rows=_rows(matrix))

    def _image(self, file: Sdf.AssetPath) -> tuple[Image.Image, bool] | None:
        """Return a picture, and whether its file has more than 8 bits a channel; None where it cannot be read."""
        path = file.resolvedPath
        if (path or file.path) not in self._images:
            try:
                self._images[path or file.path] = _read(path)
                if not Ar.IsPackageRelativePath(path):
                    self.files.append(path)
            except (OSError, ValueError, Image.DecompressionBombError) as error:
                self._images[path or file.path] = None
                why = "is missing" if not path else f"cannot be read ({' '.join(str(error).split())})"
                self.notes.append(f"the picture {file.path} {why}, so its part of the look is left out")
        return self._images[path or file.path]


def _rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(map(float, row)) for row in matrix[:2])


def _transform(shader: UsdShade.Shader) -> np.ndarray:
    """Return the matrix (3, 3) of a UsdTransform2d: scale, then rotation, then translation."""
    values = {name: _value(shader, name) for name in ("scale", "rotation", "translation")}
    scale, angle = values["scale"] or (1.0, 1.0), np.radians(values["rotation"] or 0.0)
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag(list(scale))
    matrix = np.eye(3)
    matrix[:2, :2], matrix[:2, 2] = turned, list(values["translation"] or (0.0, 0.0))
    return matrix


def _token(shader: UsdShade.Shader, name: str) -> str:
    return str(_value(shader, name) or "")


def _color_space(texture: UsdShade.Shader) -> str:
    """Return the color space of a picture: that of the texture, else of the file attribute, as some exporters write."""
    given = texture.GetInput("file")
    attributes = UsdShade.Utils.GetValueProducingAttributes(given) if given else []
    return _token(texture, "sourceColorSpace") or (str(attributes[0].GetColorSpace()) if attributes else "")


def _reads_display_color(surface: UsdShade.Shader) -> bool:
    """Whether the color of a surface is the displayColor of the mesh."""
    given = surface.GetInput("diffuseColor")
    return bool(given) and _is_display_color(given)


def _is_display_color(given: UsdShade.Input) -> bool:
    """Whether an input is the diffuse color, and the displayColor of the mesh."""
    attributes = UsdShade.Utils.GetValueProducingAttributes(given) if given.GetBaseName() == "diffuseColor" else []
    reader = UsdShade.Shader(attributes[0].GetPrim()) if attributes else None
    if not reader or not str(reader.GetIdAttr().Get()).startswith("UsdPrimvarReader"):
        return False
    return _token(reader, "varname").removeprefix("primvars:") == "displayColor"


def _upward(normal: _Picture) -> Image.Image:
    """Return a normal map as OpenGL has it: with green inverted where its scale is negative."""
    image = normal.image.convert("RGB")
    if len(normal.scale) < 2 or normal.scale[1] >= 0.0:
        return normal.image
    red, green, blue = image.split()
    return Image.merge("RGB", (red, ImageChops.invert(green), blue))


def _is_raw(space: str, image: Image.Image, *, is_wide: bool) -> bool:
    """Whether colors are linear; `auto` stands for sRGB where a file has 8 bits and three channels or four."""
    if space in ("raw", "sRGB"):
        return space == "raw"
    return is_wide or image.mode in ("1", "L", "LA", "La")


def _read(path: str) -> tuple[Image.Image, bool]:
    """Read a picture, also one inside a package, and whether its file has more than 8 bits a channel."""
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path)) if path else None
    if not asset:
        raise FileNotFoundError(path)
    with asset as opened:
        content = bytes(opened.GetBuffer())
    with Image.open(io.BytesIO(content)) as image:
        image.load()
        is_wide = content.startswith(SIGNATURE) and content[24] == 16  # of which Pillow keeps 8 in colors
        return image.copy(), is_wide or image.mode[:1] in ("I", "F")


def _channel(picture: _Picture) -> Image.Image:
    """Return the channel of a picture that an input of one number reads, as linear numbers of 8 bits."""
    image = picture.image
    if image.mode == "P" or "transparency" in image.info:
        image = image.convert("RGBA")
    if image.mode.startswith("I;16"):
        image = Image.fromarray((np.asarray(image) // 257).astype(np.uint8))
    wanted = picture.output[:1].upper()
    if wanted == "A":
        return image.getchannel("A") if "A" in image.getbands() else Image.new("L", image.size, 255)
    channel = image.getchannel(wanted if wanted in image.getbands() else 0).convert("L")  # 0: of a gray picture
    if picture.is_raw:
        return channel
    return channel.point((srgb_to_linear(np.arange(256) / 255.0) * 255.0).round().astype(int).tolist())


def _data(picture: _Picture, channel: str) -> Texture:
    """Return a picture with the numbers that an input reads in a channel of it; itself where it has them there."""
    if picture.output == channel and picture.is_raw and picture.image.mode in ("RGB", "RGBA"):
        return Texture(picture.image, picture.name, wraps=picture.wraps)
    return Texture(Image.merge("RGB", [_channel(picture)] * 3), f"{picture.name}_{channel}", wraps=picture.wraps)


def _factor(picture: _Picture | None, surface: UsdShade.Shader, name: str, fallback: float) -> float:
    if picture is None:
        return _number(surface, name, fallback)
    return picture.factor


def _number(surface: UsdShade.Shader, name: str, fallback: float) -> float:
    value = _value(surface, name)
    return float(value) if isinstance(value, int | float) else fallback


def _color(surface: UsdShade.Shader, name: str, fallback: float) -> tuple[float, float, float]:
    value = _value(surface, name)
    if not isinstance(value, _COLORS):
        return fallback, fallback, fallback
    return _three((value[0], value[1], value[2]))


def _three(values: tuple[float, ...]) -> tuple[float, float, float]:
    red, green, blue, *_ = (max(float(each), 0.0) for each in values)
    return red, green, blue


def _value(surface: UsdShade.Shader, name: str) -> Any:
    """Return the value of an input; of a picture that cannot be read its fallback."""
    given = surface.GetInput(name)
    attributes = UsdShade.Utils.GetValueProducingAttributes(given) if given else []
    if not attributes or not UsdShade.Output.IsOutput(attributes[0]):
        return attributes[0].Get() if attributes else None
    fallback = _value(UsdShade.Shader(attributes[0].GetPrim()), "fallback")
    output = attributes[0].GetName().partition(":")[2]
    return fallback["rgba".index(output)] if isinstance(fallback, Gf.Vec4f) and output in tuple("rgba") else fallback

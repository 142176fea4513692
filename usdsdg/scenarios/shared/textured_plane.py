"""A plane that shows a part of a picture: shining like a screen, or lit like a table."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from usdsdg.scenarios.shared.lighting import WHITE
from usdsdg.scenarios.shared.pictures import Picture

# At most so much of each side of a picture is left out.
_CROP = 0.3


class TexturedPlane:
    """A rectangle that faces +Z below a prim, at a height of it."""

    def __init__(
        self, parent: Usd.Prim, half: tuple[float, float], *, height: float, first: Picture, shines: bool
    ) -> None:
        """half: half of its width and of its depth. first: what it shows until `show`. shines: as a screen does."""
        stage, path = parent.GetStage(), parent.GetPath().AppendChild("Plane")
        self._aspect, self._shines = half[0] / half[1], shines
        mesh = UsdGeom.Mesh.Define(stage, path)
        x, y = half
        mesh.CreatePointsAttr(Vt.Vec3fArray([(-x, -y, height), (x, -y, height), (x, y, height), (-x, y, height)]))
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray([4]))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray([0, 1, 2, 3]))
        mesh.CreateSubdivisionSchemeAttr("none")
        uv = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex)
        uv.Set(Vt.Vec2fArray([(0, 0), (1, 0), (1, 1), (0, 1)]))
        self.prim = mesh.GetPrim()
        self._file, self._scale, self._place = _material(stage, path, self.prim, shines)
        self._file.Set(Sdf.AssetPath(first.file))

    def show(self, picture: Picture, generator: np.random.Generator) -> None:
        """Show a random part of a picture, mirrored or not, and of some brightness."""
        self._file.Set(Sdf.AssetPath(picture.file))
        brightness = WHITE * generator.uniform(0.5, 1.1) if self._shines else generator.uniform(0.5, 0.9)
        self._scale.Set(Gf.Vec4f(*(float(brightness),) * 3, 1.0))
        width, height = _part(picture, self._aspect, 1.0 - _CROP * generator.random())
        left, bottom = generator.uniform(0.0, 1.0 - width), generator.uniform(0.0, 1.0 - height)
        if generator.random() < 0.5:
            left, width = left + width, -width
        self._place["scale"].Set(Gf.Vec2f(float(width), float(height)))
        self._place["translation"].Set(Gf.Vec2f(float(left), float(bottom)))


def _part(picture: Picture, aspect: float, zoom: float) -> tuple[float, float]:
    """Return width and height, as fractions of a picture, of a part with the aspect of the view."""
    own = picture.width / picture.height
    width, height = (aspect / own, 1.0) if own > aspect else (1.0, own / aspect)
    return width * zoom, height * zoom


def _material(
    stage: Usd.Stage, path: Sdf.Path, prim: Usd.Prim, shines: bool
) -> tuple[Usd.Attribute, Usd.Attribute, dict[str, Usd.Attribute]]:
    """Bind a material with a texture; return its file, its scale, and scale and translation of its place."""
    material = UsdShade.Material.Define(stage, path.AppendChild("Material"))

    def shader(name: str, kind: str) -> UsdShade.Shader:
        made = UsdShade.Shader.Define(stage, material.GetPath().AppendChild(name))
        made.CreateIdAttr(kind)
        return made

    reader, place = shader("Reader", "UsdPrimvarReader_float2"), shader("Place", "UsdTransform2d")
    texture, surface = shader("Texture", "UsdUVTexture"), shader("Surface", "UsdPreviewSurface")
    types = Sdf.ValueTypeNames
    reader.CreateInput("varname", types.String).Set("st")
    place.CreateInput("in", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
    moved = {name: place.CreateInput(name, types.Float2).GetAttr() for name in ("scale", "translation")}
    texture.CreateInput("st", types.Float2).ConnectToSource(place.CreateOutput("result", types.Float2))
    file, scale = texture.CreateInput("file", types.Asset), texture.CreateInput("scale", types.Float4)
    texture.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
    for axis in ("wrapS", "wrapT"):
        texture.CreateInput(axis, types.Token).Set("clamp")
    shown = surface.CreateInput("emissiveColor" if shines else "diffuseColor", types.Color3f)
    shown.ConnectToSource(texture.CreateOutput("rgb", types.Float3))
    surface.CreateInput("roughness", types.Float).Set(1.0 if shines else 0.7)
    if shines:
        surface.CreateInput("diffuseColor", types.Color3f).Set(Gf.Vec3f(0.0))
        surface.CreateInput("ior", types.Float).Set(1.0)  # no reflections of the sky
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    return file.GetAttr(), scale.GetAttr(), moved

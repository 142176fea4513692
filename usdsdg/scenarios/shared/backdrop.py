"""A picture that fills the view: a plane far behind all objects, which shines as the picture does."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from usdsdg.errors import ConfigError
from usdsdg.scenarios.shared.lighting import WHITE, show
from usdsdg.scenarios.shared.pictures import Picture
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.poses.xform_ops import author_pose

# The plane at distance 1 reaches so far at most: beyond 75 degrees off the axis it would be endless.
_WIDEST = np.tan(np.radians(75.0))
_MARGIN = 1.03
# At most so much of each side of a picture is left out.
_CROP = 0.3


class Backdrop:
    """A plane below the prim of the view; it does not hide the sky from the objects in front of it."""

    def __init__(self, parent: Usd.Prim, view: CameraView, first: Picture) -> None:
        """
        Raises:
            ConfigError: the view is too wide for a plane.
        """
        self._half = half_extent(view)
        stage, path = parent.GetStage(), parent.GetPath().AppendChild("Backdrop")
        self._mesh = UsdGeom.Mesh.Define(stage, path)
        x, y = self._half
        self._mesh.CreatePointsAttr(Vt.Vec3fArray([(-x, -y, -1), (x, -y, -1), (x, y, -1), (-x, y, -1)]))
        self._mesh.CreateFaceVertexCountsAttr(Vt.IntArray([4]))
        self._mesh.CreateFaceVertexIndicesAttr(Vt.IntArray([0, 1, 2, 3]))
        self._mesh.CreateSubdivisionSchemeAttr("none")
        uv = UsdGeom.PrimvarsAPI(self._mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
        )
        uv.Set(Vt.Vec2fArray([(0, 0), (1, 0), (1, 1), (0, 1)]))
        self._file, self._scale, self._place = _material(stage, path, self._mesh.GetPrim())
        self._file.Set(Sdf.AssetPath(first.file))

    def hide(self) -> None:
        """Show the sky."""
        show(self._mesh.GetPrim(), False)

    def show(self, picture: Picture, distance: float, generator: np.random.Generator) -> None:
        """Show a random part of a picture, mirrored or not and of some brightness, at a distance [stage units]."""
        show(self._mesh.GetPrim(), True)
        author_pose(self._mesh.GetPrim(), scale=(distance,) * 3)
        self._file.Set(Sdf.AssetPath(picture.file))
        self._scale.Set(Gf.Vec4f(*(float(WHITE * generator.uniform(0.5, 1.1)),) * 3, 1.0))
        width, height = _part(picture, self._half[0] / self._half[1], 1.0 - _CROP * generator.random())
        left, bottom = generator.uniform(0.0, 1.0 - width), generator.uniform(0.0, 1.0 - height)
        if generator.random() < 0.5:
            left, width = left + width, -width
        self._place["scale"].Set(Gf.Vec2f(float(width), float(height)))
        self._place["translation"].Set(Gf.Vec2f(float(left), float(bottom)))


def half_extent(view: CameraView) -> tuple[float, float]:
    """Return how far a plane at distance 1 reaches to the sides, and up and down, to fill a view.

    Raises:
        ConfigError: the view is wider than a plane can fill.
    """
    x, y = (np.linspace(0.0, extent, 33) for extent in (view.width, view.height))
    edge = np.concatenate(
        [np.stack(np.broadcast_arrays(*each), -1) for each in ((x, 0.0), (x, y[-1]), (0.0, y), (x[-1], y))]
    )
    _, rays = view.rays(edge)
    rays = rays[np.isfinite(rays).all(axis=1)]  # beyond the lens is nothing to fill
    if not len(rays) or (rays[:, 2] >= 0.0).any() or np.abs(rays[:, :2] / rays[:, 2:]).max() > _WIDEST:
        raise ConfigError(
            "backgrounds: pictures fill views up to 150 degrees across; this camera's is wider. Set "
            "backgrounds.share_of_pictures to 0, which shows skies"
        )
    reach = np.abs(rays[:, :2] / rays[:, 2:]).max(axis=0) * _MARGIN
    return float(reach[0]), float(reach[1])


def _part(picture: Picture, aspect: float, zoom: float) -> tuple[float, float]:
    """Return width and height, as fractions of a picture, of a part with the aspect of the view."""
    own = picture.width / picture.height
    width, height = (aspect / own, 1.0) if own > aspect else (1.0, own / aspect)
    return width * zoom, height * zoom


def _material(
    stage: Usd.Stage, path: Sdf.Path, prim: Usd.Prim
) -> tuple[Usd.Attribute, Usd.Attribute, dict[str, Usd.Attribute]]:
    """Bind a material that shines as a texture; return its file, its scale, and scale and translation of its place."""
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
    surface.CreateInput("diffuseColor", types.Color3f).Set(Gf.Vec3f(0.0))
    surface.CreateInput("roughness", types.Float).Set(1.0)
    surface.CreateInput("ior", types.Float).Set(1.0)  # no reflections of the sky
    surface.CreateInput("emissiveColor", types.Color3f).ConnectToSource(texture.CreateOutput("rgb", types.Float3))
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    return file.GetAttr(), scale.GetAttr(), moved

"""The grid environment of `add_default_ground_plane`: a floor with lines, a plane that collides, and a lamp."""

from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Gf, Kind, Usd, UsdGeom, UsdLux, UsdPhysics

from usdsdg.demo import paint, usd_writer
from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.shapes.surface import Surface
from usdsdg.stage.usd_errors import save

HALF = 50.0  # m
TILE = 10.0  # m that one texture covers, with a line at each meter


def floor() -> Asset:
    """A square of 100 m, which faces up."""
    return Asset(
        bodies={"Floor": [_square()]},
        materials={"grid": Material(texture=_lines, roughness=0.7)},
        kind=Kind.Tokens.component,
    )


def write_grid(path: Path) -> None:
    """Write the environment; the collider is where that of Isaac Sim is, at GroundPlane/CollisionPlane."""
    usd_writer.write_asset(path, floor())
    stage = Usd.Stage.Open(str(path))
    root = stage.GetDefaultPrim().GetPath()
    UsdGeom.Xform.Define(stage, root.AppendChild("GroundPlane"))
    plane = UsdGeom.Plane.Define(stage, root.AppendPath("GroundPlane/CollisionPlane"))
    plane.CreatePurposeAttr(UsdGeom.Tokens.guide)
    plane.CreateAxisAttr(UsdGeom.Tokens.z)
    UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
    lamp = UsdLux.SphereLight.Define(stage, root.AppendChild("SphereLight"))
    lamp.CreateIntensityAttr(600000.0)
    UsdGeom.Xformable(lamp).AddTranslateOp().Set(Gf.Vec3d(6.5, 0.0, 12.0))
    save(stage.GetRootLayer())


def _square() -> Surface:
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)
    return Surface(
        points=HALF * corners, counts=np.array([4]), indices=np.arange(4), normals=np.tile([0.0, 0.0, 1.0], (4, 1)),
        st=HALF / TILE * corners[:, :2], material="grid",
    )  # fmt: skip


def _lines() -> Image.Image:
    image = paint.tinted((1000, 1000), (112, 120, 132))
    for meter in range(int(TILE)):
        wide = 0.0015 if meter else 0.004
        at = meter / TILE
        color = (172, 182, 194) if meter else (210, 220, 232)
        paint.rectangle(image, (at, 0.0, at + wide, 1.0), color)
        paint.rectangle(image, (0.0, at, 1.0, at + wide), color)
    return image

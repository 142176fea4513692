"""A sphere whose variant set `colorVariant` makes it red, green or blue, as an asset of Replicator's examples has."""

from pathlib import Path

from pxr import Gf, Kind, UsdGeom

from usdsdg.demo import usd_writer
from usdsdg.stage.usd_errors import save

RADIUS = 0.5  # m
COLORS = {"red": (1.0, 0.0, 0.0), "green": (0.0, 1.0, 0.0), "blue": (0.0, 0.0, 1.0)}


def write_color_variants(path: Path) -> None:
    """Write the sphere; red is selected."""
    stage = usd_writer.new_stage(path, Kind.Tokens.component)
    root = stage.GetDefaultPrim()
    sphere = UsdGeom.Sphere.Define(stage, root.GetPath().AppendChild("Sphere"))
    sphere.CreateRadiusAttr(RADIUS)
    sphere.CreateExtentAttr([Gf.Vec3f(-RADIUS), Gf.Vec3f(RADIUS)])
    variants = root.GetVariantSets().AddVariantSet("colorVariant")
    for name, color in COLORS.items():
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            sphere.CreateDisplayColorAttr([Gf.Vec3f(*color)])
    variants.SetVariantSelection(next(iter(COLORS)))
    save(stage.GetRootLayer())

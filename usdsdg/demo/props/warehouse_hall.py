"""The warehouse stage: a hall with lamps, racks and some of the other props."""

from pathlib import Path

from PIL import Image
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux

from usdsdg.demo import paint, usd_writer
from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.shapes.box import box
from usdsdg.demo.shapes.surface import Surface
from usdsdg.stage.usd_errors import save

WIDTH, DEPTH, HEIGHT = 14.0, 20.0, 6.0
PROPS = "Props"

# Prop, (x, y, z) in meters, turn about z in degrees.
PLACED = (
    ("SM_CardBoxA_01_414", (-5.6, -4.0, 1.06), 4.0),
    ("SM_CardBoxA_01_414", (-5.7, -2.9, 1.06), -7.0),
    ("SM_CardBoxD_04_1847", (-5.6, -1.6, 1.06), 12.0),
    ("SM_CardBoxD_04_1847", (-5.6, 2.2, 2.36), -4.0),
    ("SM_CardBoxA_01_414", (-5.6, 3.4, 2.36), 2.0),
    ("SM_CardBoxA_01_414", (-2.2, 5.6, 0.0), 24.0),
    ("SM_CardBoxA_01_414", (-2.15, 5.62, 0.30), 9.0),
    ("SM_CardBoxD_04_1847", (-1.5, 5.9, 0.0), -18.0),
    ("SM_BarelPlastic_B_03", (5.6, 4.6, 0.0), 30.0),
    ("SM_BarelPlastic_B_03", (5.0, 5.2, 0.0), 110.0),
    ("SM_BarelPlastic_B_03", (5.7, 5.7, 0.0), 200.0),
    ("S_TrafficCone", (3.0, -3.2, 0.0), 0.0),
    ("S_TrafficCone", (3.8, -2.2, 0.0), 0.0),
    ("S_WetFloorSign", (3.2, -0.8, 0.0), 70.0),
)


def hall() -> Asset:
    """Floor, walls, roof and two racks in one asset; the origin is the center of the floor."""
    return Asset(
        bodies={
            "floor": [_floor()],
            "walls": _walls(),
            "roof": _roof(),
            "rack_left": _rack(-5.6),
            "rack_back": _rack(5.9),
        },
        materials={
            "concrete": Material(texture=_concrete, roughness=0.55),
            "panel": Material(texture=_panel, roughness=0.7),
            "white": Material(color=(0.62, 0.63, 0.64), roughness=0.8),
            "blue": Material(color=(0.02, 0.07, 0.24), roughness=0.4),
            "orange": Material(color=(0.75, 0.20, 0.02), roughness=0.4),
            "board": Material(color=(0.42, 0.30, 0.18), roughness=0.8),
        },
        kind=Kind.Tokens.component,
    )


def write_warehouse(path: Path) -> None:
    """Write the hall as an asset, and to `path` an assembly of the hall, props and lamps."""
    hall_path = path.parent / PROPS / "SM_Hall_01.usd"
    usd_writer.write_asset(hall_path, hall())
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/Root").GetPrim()
    stage.SetDefaultPrim(root)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.assembly)
    _place(stage, "Hall", hall_path.stem, (0.0, 0.0, -0.1), 0.0)
    for number, (prop, position, turn) in enumerate(PLACED):
        _place(stage, f"{prop}_{number:02d}", prop, position, turn)
    for number, (x, y) in enumerate((x, y) for x in (-3.0, 3.0) for y in (-6.0, 0.0, 6.0)):
        _lamp(stage, f"/Root/Lights/Rect_{number:02d}", x, y)
    save(stage.GetRootLayer())


def _place(stage: Usd.Stage, name: str, prop: str, position: tuple[float, float, float], turn: float) -> None:
    prim = UsdGeom.Xform.Define(stage, Sdf.Path("/Root").AppendChild(name))
    prim.GetPrim().GetReferences().AddReference(f"./{PROPS}/{prop}.usd")
    prim.AddTranslateOp().Set(Gf.Vec3d(*position))
    prim.AddRotateXYZOp().Set(Gf.Vec3f(0.0, 0.0, turn))


def _lamp(stage: Usd.Stage, path: str, x: float, y: float) -> None:
    lamp = UsdLux.RectLight.Define(stage, path)
    lamp.CreateWidthAttr(1.2)
    lamp.CreateHeightAttr(2.4)
    lamp.CreateIntensityAttr(15000.0)
    lamp.CreateEnableColorTemperatureAttr(True)
    lamp.CreateColorTemperatureAttr(5600.0)
    UsdGeom.Xformable(lamp).AddTranslateOp().Set(Gf.Vec3d(x, y, HEIGHT - 0.5))


def _floor() -> Surface:
    return box((WIDTH, DEPTH, 0.1), "concrete", atlas=False).moved(z=0.05)


def _walls() -> list[Surface]:
    wide, deep = box((WIDTH, 0.1, HEIGHT), "panel", atlas=False), box((0.1, DEPTH, HEIGHT), "panel", atlas=False)
    middle = 0.1 + HEIGHT / 2
    return [wide.moved(0.0, side * (DEPTH / 2 + 0.05), middle) for side in (-1, 1)] + [
        deep.moved(side * (WIDTH / 2 + 0.05), 0.0, middle) for side in (-1, 1)
    ]


def _roof() -> list[Surface]:
    plate = box((WIDTH, DEPTH, 0.1), "white", atlas=False).moved(z=HEIGHT + 0.15)
    beams = [box((WIDTH, 0.18, 0.30), "blue", atlas=False).moved(y=y, z=HEIGHT - 0.06) for y in (-7.5, -2.5, 2.5, 7.5)]
    return [plate, *beams]


def _rack(x: float) -> list[Surface]:
    """A 10 m long shelf rack of three levels along y, uprights blue and beams orange."""
    parts = []
    for y in (-5.0, -2.5, 0.0, 2.5, 5.0):
        for dx in (-0.45, 0.45):
            parts.append(box((0.08, 0.08, 4.0), "blue", atlas=False).moved(x + dx, y, 2.1))
    for z in (1.06, 2.36, 3.66):
        for dx in (-0.45, 0.45):
            parts.append(box((0.05, 10.0, 0.12), "orange", atlas=False).moved(x + dx, 0.0, z + 0.02))
        parts.append(box((0.92, 10.0, 0.03), "board", atlas=False).moved(x, 0.0, z + 0.085))
    return parts


def _concrete() -> Image.Image:
    size = (1024, 716)
    shade = 0.25 * (paint.fractal(size, (8, 6), "concrete", octaves=6) - 0.5)
    image = paint.tinted(size, (150, 148, 142), shade)
    for x in (0.32, 0.68):
        paint.rectangle(image, (x, 0.0, x + 0.007, 1.0), (222, 184, 40))
    for joint in (0.25, 0.5, 0.75):
        paint.rectangle(image, (0.0, joint, 1.0, joint + 0.002), (110, 108, 102))
    return image


def _panel() -> Image.Image:
    size = (256, 512)
    image = paint.tinted(size, (196, 200, 202), 0.06 * (paint.fractal(size, (4, 8), "panel") - 0.5))
    paint.rectangle(image, (0.0, 0.80, 1.0, 1.0), (74, 96, 120))
    for x in range(32):
        paint.rectangle(image, (x / 32, 0.0, x / 32 + 0.002, 1.0), (160, 164, 168))
    return image

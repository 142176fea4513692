"""Props of a warehouse; the origin is the center of the bottom."""

from functools import partial

from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.props import prop_textures
from usdsdg.demo.shapes.box import box
from usdsdg.demo.shapes.lathe import cylinder, lathe, rounded_profile
from usdsdg.demo.shapes.sweep import prism

MATTE_BLACK = Material(color=(0.02, 0.02, 0.022), roughness=0.8)


def card_box_a() -> Asset:
    return _carton((0.50, 0.40, 0.30), "A", "USD 414")


def card_box_d() -> Asset:
    return _carton((0.36, 0.36, 0.42), "D", "SDG 1847")


def traffic_cone() -> Asset:
    """0.70 m tall; the square foot is a separate body, so that two convex hulls follow the shape."""
    skirt = [(0.0, 0.0), (0.150, 0.0), (0.150, 0.012), (0.130, 0.030)]
    cone = [(0.130, 0.030), (0.026, 0.660), (0.020, 0.668), (0.0, 0.668)]
    foot = box((0.36, 0.36, 0.034), "rubber", rounding=0.012, atlas=False).moved(z=0.017)
    return Asset(
        bodies={
            "cone": [lathe(skirt, "rubber").moved(z=0.030), lathe(cone, "orange", segments=48).moved(z=0.030)],
            "foot": [foot],
        },
        materials={"orange": Material(texture=prop_textures.traffic_cone, roughness=0.5), "rubber": MATTE_BLACK},
        mass=3.0,
    )


def wet_floor_sign() -> Asset:
    """Two boards that lean against each other, 0.62 m tall."""
    outline = [(-0.145, 0.0), (0.145, 0.0), (0.110, 0.630), (0.095, 0.645), (-0.095, 0.645), (-0.110, 0.630)]
    leaf = prism(outline, 0.014, "yellow")
    front = leaf.rotated("x", -14.0).moved(y=-0.160)
    return Asset(
        bodies={
            "front": [front],
            "back": [front.rotated("z", 180.0)],
            "hinge": [box((0.17, 0.020, 0.020), "yellow_edge", rounding=0.009, atlas=False).moved(z=0.626)],
        },
        materials={
            "yellow": Material(texture=prop_textures.floor_sign, roughness=0.4, clearcoat=0.2),
            "yellow_edge": Material(color=(0.9, 0.60, 0.01), roughness=0.4),
        },
        mass=1.1,
    )


def plastic_barrel() -> Asset:
    """A 0.92 m drum with two rolling hoops and a lid with two plugs."""
    hoops: list[tuple[float, float]] = []
    for z in (0.31, 0.61):
        hoops += [(0.284, z - 0.030), (0.296, z - 0.014), (0.296, z + 0.014), (0.284, z + 0.030)]
    wall = [(0.0, 0.0), (0.262, 0.0), (0.278, 0.030), *hoops, (0.284, 0.86), (0.266, 0.905), (0.266, 0.920)]
    lid = [(0.266, 0.920), (0.252, 0.920), (0.250, 0.900), (0.0, 0.902)]
    plugs = [cylinder(0.032, 0.022, "plug", rim=0.004).moved(x, 0.0, 0.895) for x in (-0.15, 0.17)]
    return Asset(
        bodies={
            "barrel": [lathe(rounded_profile(wall, 0.012), "blue", segments=56), lathe(lid, "lid", segments=56), *plugs]
        },
        materials={
            "blue": Material(texture=prop_textures.plastic_barrel, roughness=0.42),
            "lid": Material(color=(0.008, 0.06, 0.27), roughness=0.5),
            "plug": Material(color=(0.75, 0.75, 0.72), roughness=0.5),
        },
        mass=9.0,
    )


def _carton(size: tuple[float, float, float], name: str, code: str) -> Asset:
    material = Material(texture=partial(prop_textures.cardboard, name, code), roughness=0.85)
    return Asset(
        bodies={"carton": [box(size, "cardboard", rounding=0.004, steps=2)]},
        materials={"cardboard": material},
        mass=2.0,
    )

"""Props of a hospital; the origin is the center of the bottom."""

from functools import partial

import numpy as np

from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.props import prop_textures
from usdsdg.demo.shapes.box import box
from usdsdg.demo.shapes.lathe import cylinder, lathe, rounded_profile
from usdsdg.demo.shapes.surface import Surface
from usdsdg.demo.shapes.sweep import arc, prism, tube

STEEL = Material(color=(0.55, 0.56, 0.58), roughness=0.3, metallic=1.0)
RUBBER = Material(color=(0.02, 0.02, 0.022), roughness=0.8)


def gas_cart() -> Asset:
    """An oxygen cylinder on a two-wheeled trolley, 1.22 m tall."""
    wall = [(0.0, 0.0), (0.100, 0.0), (0.105, 0.02), (0.105, 0.72), (0.085, 0.80), (0.034, 0.842), (0.030, 0.880)]
    bottle = lathe(rounded_profile(wall, 0.03), "green", segments=40).moved(0.0, -0.04, 0.095)
    valve = cylinder(0.031, 0.07, "steel", rim=0.004).moved(0.0, -0.04, 0.965)
    gauge = cylinder(0.032, 0.022, "white", rim=0.004).rotated("x", 90.0).moved(0.05, -0.06, 1.01)
    wheels = [
        cylinder(0.085, 0.040, "rubber", rim=0.010, segments=32)
        .rotated("y", side * 90.0)
        .moved(side * 0.150, 0.10, 0.085)
        for side in (-1, 1)
    ]
    hubs = [
        cylinder(0.040, 0.044, "white", rim=0.004).rotated("y", side * 90.0).moved(side * 0.150, 0.10, 0.085)
        for side in (-1, 1)
    ]
    plate = box((0.26, 0.24, 0.014), "steel", rounding=0.004, atlas=False).moved(0.0, -0.03, 0.085)
    clamps = [
        box((0.236, 0.028, 0.036), "steel", rounding=0.006, atlas=False).moved(0.0, 0.072, z) for z in (0.38, 0.70)
    ]
    return Asset(
        bodies={
            "bottle": [bottle, valve, gauge],
            "frame": [plate, *_cart_frame(), *clamps],
            "wheels": [*wheels, *hubs],
        },
        materials={
            "green": Material(texture=prop_textures.gas_label, roughness=0.35, clearcoat=0.3),
            "white": Material(color=(0.82, 0.82, 0.80), roughness=0.4),
            "steel": STEEL,
            "rubber": RUBBER,
        },
        mass=22.0,
    )


def medical_bag() -> Asset:
    """A soft first-aid bag with straps, 0.46 m wide; the cross is on its broad sides."""
    body = box((0.46, 0.24, 0.27), "cloth", rounding=0.06, steps=5).moved(z=0.135)
    pocket = box((0.30, 0.05, 0.13), "pocket", rounding=0.022, steps=4, atlas=False).moved(0.0, 0.128, 0.085)
    zip_line = tube(_ring(0.212, 0.100, 0.262), 0.004, "black", sides=6)
    handles = [tube(_loop(0.085, 0.245, 0.090, y), 0.010, "black", sides=10, flatten=0.6) for y in (-0.05, 0.05)]
    straps = [
        box((0.034, 0.246, 0.276), "strap", rounding=0.06, atlas=False).moved(x=x, z=0.135) for x in (-0.17, 0.17)
    ]
    return Asset(
        bodies={"bag": [body, pocket, zip_line, *straps], "handles": handles},
        materials={
            "cloth": Material(
                texture=partial(prop_textures.first_aid, (190, 34, 38), (246, 244, 238), "FIRST AID", "bag"),
                roughness=0.8,
            ),
            "pocket": Material(color=(0.36, 0.02, 0.025), roughness=0.85),
            "strap": Material(color=(0.75, 0.74, 0.70), roughness=0.7),
            "black": RUBBER,
        },
        mass=3.5,
    )


def medical_box() -> Asset:
    """A hard case with a green cross, 0.36 m wide, two latches and a folding grip."""
    case = box((0.36, 0.17, 0.25), "case", rounding=0.018, steps=4).moved(z=0.125)
    seam = box((0.364, 0.008, 0.254), "grey", rounding=0.003, atlas=False).moved(z=0.125)
    latches = [
        box((0.045, 0.030, 0.020), "grey", rounding=0.005, atlas=False).moved(x=x, z=0.252) for x in (-0.11, 0.11)
    ]
    grip = tube(_loop(0.060, 0.246, 0.040, 0.0), 0.009, "grey", sides=10)
    return Asset(
        bodies={"case": [case, seam, *latches], "grip": [grip]},
        materials={
            "case": Material(
                texture=partial(
                    prop_textures.first_aid, (240, 242, 240), prop_textures.SAFETY_GREEN, "FIRST AID", "box"
                ),
                roughness=0.4,
                clearcoat=0.2,
            ),
            "grey": Material(color=(0.16, 0.17, 0.18), roughness=0.45),
        },
        mass=1.8,
    )


def towel_dispenser() -> Asset:
    """A wall unit with rounded front, window, and a sheet hanging out; its back is at +y."""
    profile = [(-0.15, 0.06), (0.15, 0.06), (0.15, 0.36), (0.13, 0.385), (-0.13, 0.385), (-0.15, 0.36)]
    shell = prism(profile, 0.20, "white")
    lid = box((0.286, 0.06, 0.29), "white", rounding=0.028, steps=4, atlas=False).moved(0.0, -0.092, 0.225)
    window = box((0.06, 0.008, 0.16), "smoke", rounding=0.003, atlas=False).moved(0.0, -0.122, 0.235)
    mouth = box((0.25, 0.10, 0.012), "smoke", rounding=0.005, atlas=False).moved(0.0, -0.03, 0.058)
    lock = cylinder(0.009, 0.008, "steel", rim=0.002).rotated("x", 90.0).moved(0.10, -0.120, 0.34)
    sheet = box((0.21, 0.003, 0.075), "paper", atlas=False).rotated("x", -6.0).moved(0.0, -0.032, 0.034)
    return Asset(
        bodies={"unit": [shell, lid, window, mouth, lock], "sheet": [sheet]},
        materials={
            "white": Material(color=(0.80, 0.81, 0.82), roughness=0.3, clearcoat=0.3),
            "smoke": Material(color=(0.03, 0.035, 0.045), roughness=0.12, clearcoat=0.5),
            "paper": Material(color=(0.82, 0.80, 0.76), roughness=0.95),
            "steel": STEEL,
        },
        mass=1.6,
    )


def _cart_frame() -> list[Surface]:
    posts = [
        tube([(x, 0.10, 0.09), (x, 0.10, 0.60), (x, 0.11, 0.95), (x, 0.17, 1.12), (x, 0.19, 1.20)], 0.012, "steel")
        for x in (-0.10, 0.10)
    ]
    bars = [tube([(-0.112, 0.19, 1.20), (0.112, 0.19, 1.20)], 0.016, "rubber")]
    bars += [tube([(-0.10, 0.10, z), (0.10, 0.10, z)], 0.009, "steel") for z in (0.30, 0.55, 0.80)]
    axle = tube([(-0.15, 0.10, 0.085), (0.15, 0.10, 0.085)], 0.010, "steel")
    return [*posts, *bars, axle]


def _loop(half_width: float, foot: float, rise: float, y: float) -> np.ndarray:
    """A handle: half an ellipse standing on z = foot."""
    path = arc((0.0, y, foot), 1.0, 180.0, 0.0, steps=20)
    return (path - (0.0, 0.0, foot)) * (half_width, 1.0, rise) + (0.0, 0.0, foot)


def _ring(half_width: float, half_depth: float, z: float) -> np.ndarray:
    return arc((0.0, 0.0, z), 1.0, 0.0, 360.0, plane="xy", steps=36) * (half_width, half_depth, 1.0)

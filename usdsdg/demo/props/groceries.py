"""Groceries after the YCB object set: same names and sizes, origin at the center of the bounding box."""

from collections.abc import Callable

import numpy as np
from PIL import Image

from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.props import packaging_textures
from usdsdg.demo.shapes.box import box
from usdsdg.demo.shapes.lathe import cylinder, lathe, rounded_profile, superellipse
from usdsdg.demo.shapes.surface import Surface
from usdsdg.demo.shapes.sweep import arc, tube

TIN = Material(color=(0.72, 0.73, 0.75), roughness=0.32, metallic=1.0)


def cracker_box() -> Asset:
    return _carton((0.072, 0.164, 0.214), packaging_textures.cracker_box, mass=0.411)


def sugar_box() -> Asset:
    return _carton((0.045, 0.092, 0.176), packaging_textures.sugar_box, mass=0.514)


def pudding_box() -> Asset:
    return _carton((0.090, 0.113, 0.038), packaging_textures.pudding_box, mass=0.187)


def tomato_soup_can() -> Asset:
    body = [(0.0330, 0.004), (0.0330, 0.0975)]
    foot = [(0.0, 0.002), (0.0295, 0.002), (0.0310, 0.0), (0.0338, 0.0005), (0.0340, 0.003), (0.0330, 0.004)]
    head = [(radius, 0.1015 - z) for radius, z in reversed(foot)]
    return Asset(
        bodies={"can": [lathe(body, "label"), lathe(foot, "tin"), lathe(head, "tin")]},
        materials={"label": Material(texture=packaging_textures.soup_wrap, roughness=0.38, clearcoat=0.3), "tin": TIN},
        origin_at_bottom=False,
        mass=0.349,
    )


def mustard_bottle() -> Asset:
    wall = [(0.0, 0.0), (0.86, 0.0), (0.97, 0.004), (1.0, 0.014), (0.98, 0.045), (0.95, 0.075), (0.97, 0.105)]
    shoulder = [(0.93, 0.122), (0.78, 0.137), (0.50, 0.1475), (0.36, 0.151), (0.34, 0.155)]
    body = lathe(rounded_profile([*wall, *shoulder], 0.02, steps=2), "wrap", segments=56, crease=60.0)
    body = body.scaled(0.048, 0.029, 1.0)
    skirt = lathe(rounded_profile([(0.0165, 0.150), (0.0175, 0.151), (0.0170, 0.166), (0.0110, 0.170)], 0.004), "cap")
    nozzle = lathe(rounded_profile([(0.0110, 0.170), (0.0062, 0.174), (0.0036, 0.1905), (0.0, 0.191)], 0.003), "cap")
    return Asset(
        bodies={"bottle": [body, skirt, nozzle]},
        materials={
            "wrap": Material(texture=packaging_textures.mustard_wrap, roughness=0.30, clearcoat=0.4),
            "cap": Material(color=(0.62, 0.03, 0.03), roughness=0.35),
        },
        origin_at_bottom=False,
        mass=0.603,
    )


def potted_meat_can() -> Asset:
    foot = [(0.0, 0.002), (0.93, 0.002), (0.95, 0.0), (1.0, 0.0005), (1.0, 0.003), (0.97, 0.0045)]
    head = [(radius, 0.083 - z) for radius, z in reversed(foot)]
    parts = [lathe([(0.97, 0.0045), (0.97, 0.0785)], "label", segments=64)]
    parts += [lathe(rim, "tin", segments=64) for rim in (foot, head)]
    return Asset(
        bodies={"can": [superellipse(part, 5.0).scaled(0.051, 0.0285) for part in parts]},
        materials={"label": Material(texture=packaging_textures.meat_wrap, roughness=0.36, clearcoat=0.3), "tin": TIN},
        origin_at_bottom=False,
        mass=0.370,
    )


def banana() -> Asset:
    """A curved tube that is thin at both ends."""
    along = np.linspace(0.0, 1.0, 29)
    girth = 0.0185 * np.clip(np.sin(np.pi * (0.06 + 0.86 * along)), 0.0, 1.0) ** 0.45
    girth[-4:] = (0.0105, 0.0068, 0.0062, 0.0066)
    spine = arc((0.0, -0.085, 0.0), 0.112, 34.0, 146.0, plane="xy", steps=28)
    return Asset(
        bodies={"banana": [tube(spine, girth, "skin", sides=20)]},
        materials={"skin": Material(texture=packaging_textures.banana_skin, roughness=0.45)},
        origin_at_bottom=False,
        mass=0.066,
    )


def power_drill() -> Asset:
    """Motor, handle and battery, lying on its side with the bit toward -x."""
    yellow, dark = "shell", "rubber"
    motor = cylinder(0.027, 0.104, yellow, segments=32, rim=0.006).rotated("y", -90.0).moved(0.066, 0.064)
    back = cylinder(0.0245, 0.018, dark, segments=32, rim=0.006).rotated("y", 90.0).moved(0.062, 0.064)
    collar = lathe([(0.0, 0.0), (0.025, 0.0), (0.021, 0.018), (0.0, 0.018)], dark, segments=32)
    chuck = lathe(
        rounded_profile([(0.0, 0.0), (0.017, 0.0), (0.0165, 0.028), (0.008, 0.042), (0.0, 0.043)], 0.002), "steel"
    )
    front = [collar.rotated("y", -90.0).moved(-0.038, 0.064), chuck.rotated("y", -90.0).moved(-0.056, 0.064)]
    grip = box((0.040, 0.098, 0.036), yellow, rounding=0.014, atlas=False).rotated("z", 10.0).moved(0.034, 0.002)
    pad = box((0.034, 0.080, 0.038), dark, rounding=0.014, atlas=False).rotated("z", 10.0).moved(0.039, 0.000)
    battery = box((0.088, 0.038, 0.052), dark, rounding=0.008, atlas=False).moved(0.026, -0.060)
    plate = box((0.062, 0.026, 0.0535), yellow, rounding=0.004, atlas=False).moved(0.024, -0.058)
    trigger = box((0.012, 0.028, 0.020), "red", rounding=0.004, atlas=False).moved(0.010, 0.026)
    parts: list[Surface] = [motor, back, *front]
    return Asset(
        bodies={"motor": parts, "handle": [grip, pad, trigger], "battery": [battery, plate]},
        materials={
            yellow: Material(color=(0.85, 0.48, 0.02), roughness=0.42),
            dark: Material(color=(0.02, 0.02, 0.022), roughness=0.75),
            "steel": Material(color=(0.42, 0.42, 0.44), roughness=0.3, metallic=1.0),
            "red": Material(color=(0.6, 0.02, 0.02), roughness=0.4),
        },
        origin_at_bottom=False,
        mass=0.895,
    )


def _carton(size: tuple[float, float, float], texture: Callable[[], Image.Image], *, mass: float) -> Asset:
    return Asset(
        bodies={"carton": [box(size, "print", rounding=0.0015, steps=2)]},
        materials={"print": Material(texture=texture, roughness=0.42, clearcoat=0.15)},
        origin_at_bottom=False,
        mass=mass,
    )

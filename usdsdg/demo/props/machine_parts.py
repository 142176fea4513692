"""Machine parts for bins: a bolt, a pipe elbow, a flanged bushing, an angle bracket, a lever."""

from collections.abc import Callable

import numpy as np

from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.shapes.box import box
from usdsdg.demo.shapes.lathe import cylinder, lathe, rounded_profile
from usdsdg.demo.shapes.surface import Surface
from usdsdg.demo.shapes.sweep import arc, prism, tube

STEEL = Material(color=(0.42, 0.43, 0.45), roughness=0.38, metallic=1.0)
BRASS = Material(color=(0.62, 0.45, 0.17), roughness=0.34, metallic=1.0)
CAST = Material(color=(0.06, 0.065, 0.07), roughness=0.62)
GREEN = Material(color=(0.05, 0.22, 0.12), roughness=0.45, clearcoat=0.3)
RED = Material(color=(0.42, 0.035, 0.02), roughness=0.5)


def bolt() -> Asset:
    """A hexagon bolt of 60 mm with a washer face; its thread is a row of ridges."""
    hexagon = [(0.0105 * np.cos(angle), 0.0105 * np.sin(angle)) for angle in np.radians(np.arange(0, 360, 60))]
    head = prism(hexagon, 0.008, "steel").rotated("x", 90.0).moved(0.0, 0.0, 0.004)
    thread = [(0.0050 if k % 2 else 0.0058, 0.028 + 0.0016 * k) for k in range(20)]
    shank = lathe([*thread, (0.0, 0.060)], "steel", segments=24)
    collar = lathe([(0.0058, 0.008), (0.0058, 0.029)], "steel", segments=24)
    return _asset({"bolt": [head, collar, shank]}, {"steel": STEEL})


def elbow() -> Asset:
    """A pipe elbow of 90 degrees with a flange at both ends."""
    bend = tube(arc((0.0, 0.0, 0.0), 0.038, 0.0, 90.0, plane="xz", steps=14), 0.0125, "cast", sides=24)
    ring = cylinder(0.0215, 0.007, "cast", segments=32, rim=0.001)
    lower = ring.moved(0.038, 0.0, -0.006)
    upper = ring.rotated("y", 90.0).moved(-0.006, 0.0, 0.038)
    return _asset({"bend": [bend], "lower": [lower], "upper": [upper]}, {"cast": RED})


def bushing() -> Asset:
    """A brass bushing with a flange; its bore is a dark disk."""
    outline = [(0.0, 0.0), (0.024, 0.0), (0.024, 0.007), (0.0155, 0.007), (0.0155, 0.032), (0.0, 0.032)]
    body = lathe(rounded_profile(outline, 0.0012), "brass", segments=40)
    bore = cylinder(0.0095, 0.0004, "dark", segments=32).moved(0.0, 0.0, 0.0319)
    back = cylinder(0.0095, 0.0004, "dark", segments=32).moved(0.0, 0.0, -0.0003)
    return _asset({"bushing": [body, bore, back]}, {"brass": BRASS, "dark": CAST})


def bracket() -> Asset:
    """An angle bracket with a rib between its legs."""
    foot = box((0.070, 0.040, 0.006), "paint", rounding=0.0015, atlas=False).moved(0.0, 0.0, 0.003)
    wall = box((0.006, 0.040, 0.050), "paint", rounding=0.0015, atlas=False).moved(-0.032, 0.0, 0.028)
    rib = prism([(-0.029, 0.006), (0.014, 0.006), (-0.029, 0.042)], 0.005, "paint")
    bolts = [cylinder(0.005, 0.0012, "steel", segments=20).moved(0.022, y, 0.0055) for y in (-0.011, 0.011)]
    return _asset({"foot": [foot, *bolts], "wall": [wall], "rib": [rib]}, {"paint": GREEN, "steel": STEEL})


def lever() -> Asset:
    """A lever: a bar with a hub at one end and a pin at the other."""
    bar = box((0.085, 0.016, 0.009), "cast", rounding=0.002, atlas=False).moved(0.0, 0.0, 0.008)
    hub = cylinder(0.0175, 0.022, "cast", segments=36, rim=0.0015).moved(-0.045, 0.0, -0.003)
    bore = cylinder(0.0085, 0.0004, "steel", segments=28).moved(-0.045, 0.0, 0.0189)
    pin = cylinder(0.006, 0.030, "steel", segments=24, rim=0.001).moved(0.040, 0.0, 0.004)
    return _asset({"bar": [bar], "hub": [hub, bore], "pin": [pin]}, {"cast": CAST, "steel": STEEL})


def _asset(bodies: dict[str, list[Surface]], materials: dict[str, Material]) -> Asset:
    return Asset(bodies=bodies, materials=materials, origin_at_bottom=False)


PARTS: dict[str, Callable[[], Asset]] = {
    "bolt": bolt,
    "bracket": bracket,
    "bushing": bushing,
    "elbow": elbow,
    "lever": lever,
}

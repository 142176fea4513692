"""Shapes that stand around the origin on a lit floor, for pictures of lenses."""

import math

import usdsdg as rep

_COLORS = [(0.65, 0.08, 0.05), (0.08, 0.25, 0.6), (0.1, 0.45, 0.15), (0.8, 0.55, 0.08), (0.4, 0.12, 0.5)]


def add(places: list[tuple[float, float]], *, height: float, colors: int) -> None:
    """Add a floor, a sky, a sun, and a shape at each angle [radians] and radius, of so many colors in turn."""
    rep.create.plane(scale=60, material=rep.create.material_omnipbr(diffuse=(0.55, 0.53, 0.5), roughness=0.8))
    rep.create.light(light_type="Dome", intensity=450)
    rep.create.light(light_type="Distant", intensity=2200, rotation=(38, 22, 0))
    paints = [rep.create.material_omnipbr(diffuse=color, roughness=0.35) for color in _COLORS[:colors]]
    makers = (rep.create.cube, rep.create.sphere, rep.create.cone, rep.create.cylinder)
    for k, (angle, radius) in enumerate(places):
        position = (radius * math.cos(angle), radius * math.sin(angle), height)
        makers[k % 4](position=position, rotation=(0, 0, 37 * k), material=paints[k % colors])

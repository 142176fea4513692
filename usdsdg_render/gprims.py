"""The gprims of a stage that are drawn, and where: once each, or many times by point instancers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg import errors

from .instancer import expand
from .scene import Prototype
from .shading import Material
from .stage_tree import GPRIMS, INSTANCER, Tree, kind_of


@dataclass
class Gprim:
    """One gprim to draw, however often."""

    prim: Usd.Prim
    path: Sdf.Path
    kind: int
    subsets: list[Usd.Prim]
    casts_shadow: int
    materials: list[Material] = field(default_factory=list)  # one a slot
    colored: bool = False  # drawn with its own displayColor, which varies
    prototype: Prototype | None = None


@dataclass
class Placements:
    """Where gprims are drawn, in stage order; point instances carry a matrix to their instancer."""

    gprims: list[int] = field(default_factory=list)
    paths: list[str] = field(default_factory=list)
    nodes: list[int] = field(default_factory=list)
    offsets: dict[int, np.ndarray] = field(default_factory=dict)

    def add(self, gprim: int, path: str, node: int, offset: np.ndarray | None = None) -> None:
        if offset is not None:
            self.offsets[len(self.gprims)] = offset
        self.gprims.append(gprim)
        self.paths.append(path)
        self.nodes.append(node)


def find_gprims(tree: Tree) -> tuple[list[Gprim], Placements]:
    """All gprims with a drawn purpose, in stage order."""
    gprims: list[Gprim] = []
    placements = Placements()
    drawn_by_points: dict[Sdf.Path, int] = {}
    for node in tree.of_kind(*GPRIMS, INSTANCER):
        if not tree.drawn[node]:
            continue
        prim = tree.prims[node]
        if tree.kinds[node] != INSTANCER:
            placements.add(len(gprims), prim.GetPath().pathString, node)
            gprims.append(_gprim(prim, tree.subsets.get(node, [])))
            continue
        for point in expand(prim, tree.time):
            path = point.prim.GetPath()
            if path not in drawn_by_points:
                drawn_by_points[path] = len(gprims)
                gprims.append(_gprim(point.prim, point.subsets))
            placements.add(drawn_by_points[path], point.path, node, point.to_instancer)
    return gprims, placements


def _gprim(prim: Usd.Prim, subsets: list[Usd.Prim]) -> Gprim:
    # Omniverse's primvar: nothing in UsdGeom says so.
    shadowless = prim.GetAttribute("primvars:doNotCastShadows")
    casts = 0 if shadowless and shadowless.Get() is True else 1
    return Gprim(prim, prim.GetPath(), kind_of(prim), subsets, casts)


def display_colour(prim: Usd.Prim, time: Usd.TimeCode) -> tuple[tuple[float, ...] | None, float | None, bool]:
    """(displayColor, displayOpacity, whether one of them varies) as one value each: the mean where they vary."""
    values: list[tuple[float, ...] | None] = []
    varies = False
    for name, width in (("displayColor", 3), ("displayOpacity", 1)):
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        value = primvar.Get(time) if primvar else None
        array = np.asarray(value, np.float64).reshape(-1, width) if value is not None and len(value) else None
        if array is None or not np.isfinite(array).all():
            values.append(None)
            continue
        varies |= bool((array != array[0]).any())
        values.append(tuple(np.clip(array.mean(axis=0), 0.0, None).tolist()))
    colour, opacity = values
    return colour, None if opacity is None else opacity[0], varies


def warn_of_mean(prim: Usd.Prim) -> None:
    """Say that a colour that varies is not drawn so."""
    errors.warn_once(
        f"{prim.GetPath()}: displayColor or displayOpacity varies over the gprim; its mean is used. Bind a "
        f"material with a texture instead, or none where other inputs have textures."
    )

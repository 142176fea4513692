"""The gprims of a stage that are drawn, and where: once each, or many times by point instancers."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg import errors
from usdsdg_render.materials.shading import BRIGHTEST, Material
from usdsdg_render.scene.scene import Prototype
from usdsdg_render.sync.invalidation import Plan
from usdsdg_render.usd.authored_values import as_array
from usdsdg_render.usd.point_instancer import PointInstance, expand
from usdsdg_render.usd.prim_kinds import GPRIMS, INSTANCER, is_below, kind_of
from usdsdg_render.usd.stage_tree import Tree


@dataclass(eq=False)
class Gprim:
    """One gprim to draw, however often, and what is known of it; None is what must be read."""

    prim: Usd.Prim
    path: Sdf.Path
    name: str  # the path
    kind: int
    subsets: list[Usd.Prim]
    casts_shadow: int
    bound: list[Sdf.Path | None] = field(default_factory=list)  # a material for each slot, or none
    is_bound: bool = False  # `bound` still holds
    materials: list[Material] | None = None  # one a slot
    stand_in: tuple[Material, bool] | None = None  # and whether its color varies over the gprim
    colored: bool = False  # drawn with its own displayColor, which varies
    geometry: tuple[str, bool, Prototype | None] | None = None  # UV primvar, whether with its own colors

    @property
    def prototype(self) -> Prototype | None:
        """None where it has no surface."""
        return None if self.geometry is None else self.geometry[2]


@dataclass
class Placements:
    """Where gprims are drawn, in stage order; point instances carry a matrix to their instancer."""

    gprims: list[Gprim] = field(default_factory=list)
    paths: list[str] = field(default_factory=list)
    nodes: list[int] = field(default_factory=list)
    offsets: dict[int, np.ndarray] = field(default_factory=dict)

    def add(self, gprim: Gprim, path: str, node: int, offset: np.ndarray | None = None) -> None:
        if offset is not None:
            self.offsets[len(self.gprims)] = offset
        self.gprims.append(gprim)
        self.paths.append(path)
        self.nodes.append(node)


class Gprims:
    """All gprims with a drawn purpose. Hidden ones are kept while they are few, because what hides shows again."""

    def __init__(self) -> None:
        self.drawn: list[Gprim] = []  # each once, in stage order
        self.placements = Placements()
        self.known: dict[Sdf.Path, Gprim] = {}
        self._points: dict[Sdf.Path, list[PointInstance]] = {}  # of instancers
        self._sources: dict[Sdf.Path, set[Sdf.Path]] = {}  # prims that they draw with all below

    @property
    def sources(self) -> dict[Sdf.Path, list[Sdf.Path]]:
        """Which instancers draw a prim with all below it."""
        found: dict[Sdf.Path, list[Sdf.Path]] = {}
        for instancer, sources in self._sources.items():
            for source in sources:
                found.setdefault(source, []).append(instancer)
        return found

    def forget(self, plan: Plan) -> None:
        """Read again what a plan says."""
        for path in plan.gprims:
            self.known.pop(path, None)
        for path in plan.shapes & self.known.keys():
            gprim = self.known[path]
            gprim.geometry = None
            if gprim.colored:  # its materials show the triangles that it has now
                gprim.materials = None
        if stale := plan.roots | plan.below:
            for path in [path for path in self.known if is_below(path, stale)]:
                del self.known[path]
        if plan.bound:
            for path, gprim in self.known.items():
                gprim.is_bound = gprim.is_bound and not is_below(path, plan.bound)
        if stale := plan.roots | plan.instancers:
            for path in [path for path in self._points if is_below(path, stale)]:
                del self._points[path], self._sources[path]

    def forget_looks(self, materials: Set[Sdf.Path]) -> None:
        """Look again at what has one of these materials."""
        for gprim in self.known.values():
            if not materials.isdisjoint(gprim.bound):
                gprim.materials = None

    def forget_hidden(self) -> None:
        """Keep only what is drawn: nobody follows what else changes with time."""
        self.known = {gprim.path: gprim for gprim in self.drawn}

    def find(self, tree: Tree) -> None:
        """List what is drawn, and where."""
        self.placements = Placements()
        drawn: dict[Sdf.Path, Gprim] = {}
        points, self._points = self._points, {}
        for node in tree.of_kind(*GPRIMS, INSTANCER):
            if not tree.drawn[node]:
                continue
            prim, path = tree.prims[node], tree.paths[node]
            if tree.kinds[node] != INSTANCER:
                gprim = drawn[path] = self._gprim(prim, path, tree.subsets.get(path, []))
                self.placements.add(gprim, gprim.name, node)
                continue
            if path not in points:
                sources = self._sources[path] = set()
                points[path] = expand(prim, tree.time, sources)
            self._points[path] = points[path]
            for point in points[path]:
                source = point.prim.GetPath()
                if source not in drawn:
                    drawn[source] = self._gprim(point.prim, source, point.subsets)
                self.placements.add(drawn[source], point.path, node, point.to_instancer)
        self._sources = {path: self._sources[path] for path in self._points}
        self.drawn = list(drawn.values())
        if len(self.known) > 2 * len(drawn) + 64:
            self.known = drawn

    def _gprim(self, prim: Usd.Prim, path: Sdf.Path, subsets: list[Usd.Prim]) -> Gprim:
        gprim = self.known.get(path)
        if gprim is None:
            # Omniverse's primvar: nothing in UsdGeom says so.
            shadowless = prim.GetAttribute("primvars:doNotCastShadows")
            casts = 0 if shadowless and shadowless.Get() is True else 1
            gprim = self.known[path] = Gprim(prim, path, path.pathString, kind_of(prim), subsets, casts)
        return gprim


def display_color(prim: Usd.Prim, time: Usd.TimeCode) -> tuple[tuple[float, ...] | None, float | None, bool]:
    """(displayColor, displayOpacity, whether one of them varies) as one value each: the mean where they vary."""
    values: list[tuple[float, ...] | None] = []
    varies = False
    for name, width in (("displayColor", 3), ("displayOpacity", 1)):
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        value = primvar.Get(time) if primvar else None
        array = as_array(primvar.GetAttr(), value, (3,) if width == 3 else ()) if primvar else None
        if array is None or not len(array):
            values.append(None)
            continue
        array = array.astype(np.float64).reshape(-1, width)
        if not np.isfinite(array).all():
            errors.warn_once(f"{primvar.GetAttr().GetPath()} holds NaN or infinity, so it is ignored. Correct it.")
            values.append(None)
            continue
        if (array > BRIGHTEST).any():
            errors.warn_once(f"{primvar.GetAttr().GetPath()}: more than {BRIGHTEST:g} counts as that. Correct it.")
            array = np.minimum(array, BRIGHTEST)
        varies |= bool((array != array[0]).any())
        values.append(tuple(np.clip(array.mean(axis=0), 0.0, None).tolist()))
    color, opacity = values
    return color, None if opacity is None else opacity[0], varies


def warn_of_no_coordinates(prim: Usd.Prim) -> None:
    """Say that textures have nothing to be looked up by."""
    errors.warn_once(
        f"{prim.GetPath()}: its material has textures but the mesh no texture coordinates, so they show one texel. "
        f"Author primvars:st."
    )


def warn_of_mean(prim: Usd.Prim) -> None:
    """Say that a color that varies is not drawn so."""
    errors.warn_once(
        f"{prim.GetPath()}: displayColor or displayOpacity varies over the gprim; its mean is used. Bind a "
        f"material with a texture instead, or none where other inputs have textures."
    )

"""From what changed on the stage to what the extractor must read again: the one place that says what a change means."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field

from pxr import Sdf, Usd

from usdsdg.stage.changes import Changes
from usdsdg_render.usd.prim_kinds import (
    DOME,
    GPRIMS,
    IGNORED_PREFIXES,
    INSTANCER,
    LIGHT,
    MESH,
    PASS,
    SKIP,
    SUBSET,
    is_below,
    kind_of,
)
from usdsdg_render.usd.stage_tree import Tree

ROOT = Sdf.Path.absoluteRootPath
# Properties that change nothing that is drawn, beside those with IGNORED_PREFIXES.
IGNORED_NAMES = {"extent", "extentsHint", "kind", ""}


@dataclass
class Plan:
    """What to read again, as paths. Of a subtree the root is named; "/" names everything of its kind."""

    roots: set[Sdf.Path] = field(default_factory=set)  # subtrees in which prims came, went, or changed as a whole
    shown: set[Sdf.Path] = field(default_factory=set)  # subtrees that were hidden or shown, or got another purpose
    bound: set[Sdf.Path] = field(default_factory=set)  # subtrees in which other materials may be bound
    below: set[Sdf.Path] = field(default_factory=set)  # subtrees whose gprims inherit something else
    gprims: set[Sdf.Path] = field(default_factory=set)
    shapes: set[Sdf.Path] = field(default_factory=set)  # gprims of which the geometry alone changed
    instancers: set[Sdf.Path] = field(default_factory=set)  # where they put what
    materials: set[Sdf.Path] = field(default_factory=set)  # prims of shading networks
    moved: set[Sdf.Path] = field(default_factory=set)
    moved_nodes: list[int] = field(default_factory=list)  # more of these, by number
    lights: set[Sdf.Path] = field(default_factory=set)  # domes too; and subtrees of lights
    skinned: bool = False  # how skeletons shape meshes

    @classmethod
    def of_everything(cls) -> Plan:
        return cls(roots={ROOT}, bound={ROOT}, lights={ROOT}, skinned=True)

    @property
    def everything(self) -> bool:
        return ROOT in self.roots

    @property
    def regrown(self) -> set[Sdf.Path]:
        """Subtrees in which other prims may be drawn."""
        return self.roots | self.shown

    @property
    def listed(self) -> bool:
        """Whether other gprims may be drawn, or elsewhere by points."""
        return bool(self.roots or self.shown or self.below or self.gprims or self.instancers)


class Planner:
    """Sorts changes into a `Plan`, by what their prims are in the tree.

    Args:
        sources: for each prim that point instancers draw with all below it, the instancers that do.
    """

    def __init__(self, stage: Usd.Stage, tree: Tree, sources: Mapping[Sdf.Path, Collection[Sdf.Path]]) -> None:
        self._stage = stage
        self._tree = tree
        self._sources = sources
        self._has_prototypes = bool(stage.GetPrototypes())
        self._plan = Plan()

    def plan(self, changes: Changes) -> Plan:
        plan = self._plan = Plan(moved_nodes=changes.known)
        for root in changes.resynced:
            plan.roots.update(map(self._owner, self._places(root)))
        if plan.roots:
            self._plan_roots()
        if ROOT in changes.changed:  # up axis, units
            plan.lights.add(ROOT)
        for path, names in changes.changed.items():
            for place in self._places(path) if self._has_prototypes else (path,):
                self._plan_prim(place, names)
        return plan

    def _places(self, path: Sdf.Path) -> Iterator[Sdf.Path]:
        """The path, and where instances show it if it lies in a prototype that they share."""
        yield path
        if not Usd.Prim.IsPathInPrototype(path):
            return
        top = path.GetPrefixes()[0]
        prototype = self._stage.GetPrimAtPath(top)
        for instance in prototype.GetInstances() if prototype else ():
            yield from self._places(path.ReplacePrefix(top, instance.GetPath()))

    def _owner(self, path: Sdf.Path) -> Sdf.Path:
        """The mesh where `path` is its subset: what stands below a mesh says something of it."""
        above = path.GetParentPath()
        return above if path != ROOT and self._kind_at(above) == MESH else path

    def _plan_roots(self) -> None:
        plan = self._plan
        # A material or a collection that came or went may count anywhere.
        plan.bound.add(ROOT)
        plan.lights |= plan.roots
        for source, instancers in self._sources.items():
            if is_below(source, plan.roots) or any(root.HasPrefix(source) for root in plan.roots):
                plan.instancers.update(instancers)

    def _plan_prim(self, path: Sdf.Path, names: set[str]) -> None:
        plan = self._plan
        others = [name for name in names if not name.startswith("xformOp")]
        if len(others) < len(names):
            plan.moved.add(path)
            if not self._plan_points(path):
                self._tree.note_movers(path, names.difference(others))
        kind = self._kind_at(path) if others else PASS
        for name in others:
            if name in ("visibility", "purpose"):
                plan.shown.add(path)
                self._plan_points(path)
            elif name.startswith("material:binding"):
                plan.bound.add(path)
            elif name.startswith("collection:"):  # anybody may refer to it
                plan.bound.add(ROOT)
                plan.lights.add(ROOT)
            elif name in IGNORED_NAMES or name.startswith(IGNORED_PREFIXES):
                continue
            elif kind in (LIGHT, DOME):
                plan.lights.add(path)
            elif kind in GPRIMS:
                # What UsdGeom says of a shape has no namespace; primvars and lights look like something.
                (plan.gprims if ":" in name else plan.shapes).add(path)
            elif kind == INSTANCER:
                plan.instancers.add(path)
                self._plan_points(path)
            elif kind == SKIP:
                plan.materials.add(path)
            elif kind == SUBSET:
                # Which subsets count is noted in the tree.
                plan.roots.add(path.GetParentPath())
                self._plan_points(path)
            elif name.startswith("primvars:"):
                plan.below.add(path)

    def _kind_at(self, path: Sdf.Path) -> int:
        node = self._tree.index.get(path)
        if node is not None:
            return self._tree.kinds[node]
        prim = self._stage.GetPrimAtPath(path)
        return kind_of(prim) if prim else PASS

    def _plan_points(self, path: Sdf.Path) -> bool:
        """What point instancers draw, they place and show themselves; whether this is such a thing."""
        if not self._sources or not is_below(path, self._sources):
            return False
        for prefix in path.GetPrefixes():
            self._plan.instancers.update(self._sources.get(prefix, ()))
        return True

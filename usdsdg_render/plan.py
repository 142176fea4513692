"""From what changed on the stage to what the extractor must read again."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from pxr import Sdf, Usd

from usdsdg.stage.changes import Changes

from .stage_tree import (
    DOME,
    GPRIMS,
    IGNORED_PREFIXES,
    INSTANCER,
    LIGHT,
    PASS,
    SKIP,
    SUBSET,
    Tree,
    kind_of,
)

# Properties that change nothing that is drawn, beside those with IGNORED_PREFIXES.
IGNORED_NAMES = {"extent", "extentsHint", "kind", ""}


@dataclass
class Plan:
    """What to read again."""

    structure: bool = False  # which prims are drawn, with what
    everything: bool = False
    gprims: set[Sdf.Path] = field(default_factory=set)
    roots: set[Sdf.Path] = field(default_factory=set)  # whole subtrees
    shapes: set[Sdf.Path] = field(default_factory=set)  # gprims of which the geometry alone changed
    skinned: bool = False  # how skeletons shape meshes
    materials: set[Sdf.Path] = field(default_factory=set)
    moved: set[int] = field(default_factory=set)  # nodes of the tree
    lights: bool = False


class Planner:
    """Sorts changed properties into a `Plan`, by what their prim is in the tree."""

    def __init__(self, stage: Usd.Stage, tree: Tree, *, has_points: bool) -> None:
        self._stage = stage
        self._tree = tree
        # Prims outside the tree are drawn only by point instancers, so without one they do not matter.
        self._has_points = has_points
        self._plan = Plan()

    def plan(self, changes: Changes) -> Plan:
        plan = self._plan = Plan(roots=set(changes.resynced))
        if plan.roots:
            plan.structure = True
            plan.everything = any(map(_is_all, plan.roots))
        for path, names in changes.changed.items():
            self._plan_prim(path, names)
        return plan

    def _plan_prim(self, path: Sdf.Path, names: set[str]) -> None:
        plan = self._plan
        if path == Sdf.Path.absoluteRootPath:  # up axis, units
            plan.lights = True
            return
        if _is_all(path):
            plan.everything = plan.structure = True
            return
        node = self._tree.index.get(path)
        kind = PASS if node is None else self._tree.kinds[node]
        for name in names:
            if name.startswith("xformOp"):
                if node is None:
                    self._plan_hidden(path)
                else:
                    plan.moved.add(node)
            elif name in ("visibility", "purpose") or name.startswith(("material:binding", "collection:")):
                plan.structure = True
            elif name in IGNORED_NAMES or name.startswith(IGNORED_PREFIXES):
                continue
            elif kind in (LIGHT, DOME):
                plan.lights = True
            elif kind in GPRIMS:
                plan.gprims.add(path)
                plan.structure = True
            elif kind == INSTANCER:
                plan.structure = True
            else:
                self._plan_other(path, name)

    def _plan_other(self, path: Sdf.Path, name: str) -> None:
        """A property of a prim that is not drawn itself: of a shader, a subset, an inherited primvar, or nothing."""
        plan = self._plan
        prim = self._stage.GetPrimAtPath(path)
        kind = kind_of(prim) if prim else PASS
        if kind == SKIP:
            plan.materials.add(path)
        elif kind == SUBSET:
            plan.gprims.add(path.GetParentPath())
            plan.structure = True
        elif name.startswith("primvars:"):
            plan.roots.add(path)
            plan.structure = True
        else:
            self._plan_hidden(path)

    def _plan_hidden(self, path: Sdf.Path) -> None:
        if self._has_points:
            self._plan.gprims.add(path)
            self._plan.structure = True


def _is_all(path: Sdf.Path) -> bool:
    """The whole stage, or inside a prototype that instances share, where one edit shows in many places."""
    return path == Sdf.Path.absoluteRootPath or path.pathString.startswith("/__Prototype_")


def is_below(path: Sdf.Path, roots: Collection[Sdf.Path]) -> bool:
    """Whether `path` is one of `roots` or below one."""
    while path != Sdf.Path.absoluteRootPath and not path.isEmpty:
        if path in roots:
            return True
        path = path.GetParentPath()
    return False

"""Translate stage changes into a dirty set: the one place that knows what a changed property invalidates."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field

from pxr import Sdf, Usd

from usdsdg.stage.changes import Changes
from usdsdg_render.usd import prim_kinds
from usdsdg_render.usd.prim_kinds import is_below, kind_of
from usdsdg_render.usd.stage_tree import StageTree

ROOT = Sdf.Path.absoluteRootPath
# Properties that never change an image, beside those with IGNORED_PREFIXES.
IGNORED_NAMES = {"extent", "extentsHint", "kind", ""}


@dataclass
class DirtySet:
    """What must be read again, as paths. A subtree is given by its root; "/" stands for everything of its kind."""

    resynced: set[Sdf.Path] = field(default_factory=set)  # subtrees whose prims were added, removed or recomposed
    visibility: set[Sdf.Path] = field(default_factory=set)  # subtrees hidden or shown, or with another purpose
    bindings: set[Sdf.Path] = field(default_factory=set)  # subtrees in which other materials may be bound
    inherited: set[Sdf.Path] = field(default_factory=set)  # subtrees whose gprims inherit other primvars
    gprims: set[Sdf.Path] = field(default_factory=set)
    geometry: set[Sdf.Path] = field(default_factory=set)  # gprims of which only the geometry changed
    instancers: set[Sdf.Path] = field(default_factory=set)
    materials: set[Sdf.Path] = field(default_factory=set)  # prims of shading networks
    transforms: set[Sdf.Path] = field(default_factory=set)
    transform_nodes: list[int] = field(default_factory=list)  # more of these, as nodes of the tree
    lights: set[Sdf.Path] = field(default_factory=set)  # lights, domes, and subtrees of them
    skinning: bool = False  # a skeleton, its animation, or a binding to it changed
    stale_materials: bool = False  # whether any material that was read is among `materials` or `resynced`

    @classmethod
    def everything(cls) -> DirtySet:
        return cls(resynced={ROOT}, bindings={ROOT}, lights={ROOT}, skinning=True)

    @property
    def is_everything(self) -> bool:
        return ROOT in self.resynced

    @property
    def subtrees(self) -> set[Sdf.Path]:
        """Subtrees in which other prims may be visible."""
        return self.resynced | self.visibility

    @property
    def has_other_gprims(self) -> bool:
        """Whether other gprims may be drawn, or point instancers may place them elsewhere."""
        return bool(self.resynced or self.visibility or self.inherited or self.gprims or self.instancers)

    @property
    def concerns_gprims(self) -> bool:
        """Whether anything but the transform of a gprim changed."""
        return bool(self.has_other_gprims or self.bindings or self.geometry or self.stale_materials)

    @property
    def has_other_transforms(self) -> bool:
        return bool(self.transforms or self.transform_nodes)


class DirtySetBuilder:
    """Sorts changes into a `DirtySet`, by the kinds of their prims.

    Args:
        instancers_of: the point instancers that draw a prim and all below it as a prototype, by its path.
    """

    def __init__(
        self, stage: Usd.Stage, tree: StageTree, instancers_of: Mapping[Sdf.Path, Collection[Sdf.Path]]
    ) -> None:
        self._stage = stage
        self._tree = tree
        self._instancers_of = instancers_of
        self._has_prototypes = bool(stage.GetPrototypes())
        self._dirty = DirtySet()

    def build(self, changes: Changes) -> DirtySet:
        dirty = self._dirty = DirtySet(transform_nodes=changes.indices)
        for root in changes.resynced:
            dirty.resynced.update(map(self._owner, self._instances_of(root)))
        if dirty.resynced:
            self._add_resynced()
        if ROOT in changes.changed:  # up axis, units
            dirty.lights.add(ROOT)
        for names, paths in changes.by_names.items():
            if all(map(_is_ignored, names)):
                continue
            for path in paths:
                for instance in self._instances_of(path) if self._has_prototypes else (path,):
                    self._add_properties(instance, names)
        return dirty

    def _instances_of(self, path: Sdf.Path) -> Iterator[Sdf.Path]:
        """The path, and the instance proxies of it if it lies in a scene-graph prototype."""
        yield path
        if not Usd.Prim.IsPathInPrototype(path):
            return
        top = path.GetPrefixes()[0]
        prototype = self._stage.GetPrimAtPath(top)
        for instance in prototype.GetInstances() if prototype else ():
            yield from self._instances_of(path.ReplacePrefix(top, instance.GetPath()))

    def _owner(self, path: Sdf.Path) -> Sdf.Path:
        """The mesh of a prim below it, such as a subset, which is read with its mesh; else the path itself."""
        parent = path.GetParentPath()
        return parent if path != ROOT and self._kind_at(parent) == prim_kinds.MESH else path

    def _add_resynced(self) -> None:
        dirty = self._dirty
        # A material or a collection that was added or removed may matter anywhere.
        dirty.bindings.add(ROOT)
        dirty.lights |= dirty.resynced
        for prototype, instancers in self._instancers_of.items():
            if is_below(prototype, dirty.resynced) or any(root.HasPrefix(prototype) for root in dirty.resynced):
                dirty.instancers.update(instancers)

    def _add_properties(self, path: Sdf.Path, names: frozenset[str]) -> None:
        dirty = self._dirty
        others = [name for name in names if not name.startswith("xformOp")]
        if len(others) < len(names):
            dirty.transforms.add(path)
            if not self._add_instancers(path):
                self._tree.note_xform_ops(path, names.difference(others))
        kind = self._kind_at(path) if others else prim_kinds.OTHER
        for name in others:
            if name in ("visibility", "purpose"):
                dirty.visibility.add(path)
                self._add_instancers(path)
            elif name.startswith("material:binding"):
                dirty.bindings.add(path)
            elif name.startswith("collection:"):  # any binding or light may refer to it
                dirty.bindings.add(ROOT)
                dirty.lights.add(ROOT)
            elif _is_ignored(name):
                continue
            elif kind in (prim_kinds.LIGHT, prim_kinds.DOME):
                dirty.lights.add(path)
            elif kind in prim_kinds.GPRIMS:
                # UsdGeom's attributes of shape have no namespace; primvars and light inputs, which change the material
                # too, have one.
                (dirty.gprims if ":" in name else dirty.geometry).add(path)
            elif kind == prim_kinds.INSTANCER:
                dirty.instancers.add(path)
                self._add_instancers(path)
            elif kind == prim_kinds.SHADING:
                dirty.materials.add(path)
            elif kind == prim_kinds.SUBSET:
                # The tree holds the material subsets of each mesh, so it must be traversed again.
                dirty.resynced.add(path.GetParentPath())
                self._add_instancers(path)
            elif name.startswith("primvars:"):
                dirty.inherited.add(path)

    def _kind_at(self, path: Sdf.Path) -> int:
        node = self._tree.index.get(path)
        if node is not None:
            return self._tree.kinds[node]
        prim = self._stage.GetPrimAtPath(path)
        return kind_of(prim) if prim else prim_kinds.OTHER

    def _add_instancers(self, path: Sdf.Path) -> bool:
        """Add the point instancers that draw the prim at `path`; whether there are any."""
        if not self._instancers_of or not is_below(path, self._instancers_of):
            return False
        for prefix in path.GetPrefixes():
            self._dirty.instancers.update(self._instancers_of.get(prefix, ()))
        return True


def _is_ignored(name: str) -> bool:
    """Whether a property of this name never changes an image."""
    return name in IGNORED_NAMES or name.startswith(prim_kinds.IGNORED_PREFIXES)

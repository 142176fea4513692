"""Translate stage changes into a dirty set: the one place that knows what a changed property invalidates."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from pxr import Sdf, Usd

from usdsdg.stage.changes import Changes, is_below
from usdsdg.stage.prims.instances import places_of
from usdsdg_render.materials.binding_owners import BindingOwners
from usdsdg_render.materials.plain_inputs import PlainInput
from usdsdg_render.sync.plain_colors import PlainColor
from usdsdg_render.usd import prim_kinds
from usdsdg_render.usd.prim_kinds import UNREAD
from usdsdg_render.usd.stage_tree import StageTree

ROOT = Sdf.Path.absoluteRootPath
# Properties that never change an image, beside those with IGNORED_PREFIXES.
IGNORED_NAMES = {"extent", "extentsHint", "kind", ""}


@dataclass
class DirtySet:
    """What must be read again, as paths. A subtree is given by its root; "/" stands for everything of its kind."""

    resynced: set[Sdf.Path] = field(default_factory=set)  # subtrees whose prims were added, removed or recomposed
    visibility: set[Sdf.Path] = field(default_factory=set)  # subtrees hidden or shown
    purposes: set[Sdf.Path] = field(default_factory=set)  # subtrees with another purpose
    bindings: set[Sdf.Path] = field(default_factory=set)  # subtrees in which other materials may be bound
    inherited: set[Sdf.Path] = field(default_factory=set)  # subtrees whose gprims inherit other primvars
    gprims: set[Sdf.Path] = field(default_factory=set)
    geometry: set[Sdf.Path] = field(default_factory=set)  # gprims of which only the geometry changed
    primvars: set[Sdf.Path] = field(default_factory=set)  # gprims of which only primvars changed
    colors: set[Sdf.Path] = field(default_factory=set)  # gprims of which only displayColor changed
    plain_colors: list[PlainColor] = field(default_factory=list)  # more of these
    opacities: set[Sdf.Path] = field(default_factory=set)  # gprims of which only displayOpacity changed
    instancers: set[Sdf.Path] = field(default_factory=set)
    materials: set[Sdf.Path] = field(default_factory=set)  # prims of shading networks
    inputs: dict[Sdf.Path, frozenset[str]] = field(default_factory=dict)  # and those of which only these inputs changed
    plain_inputs: list[PlainInput] = field(default_factory=list)  # more of these
    transforms: set[Sdf.Path] = field(default_factory=set)
    transform_nodes: list[int] = field(default_factory=list)  # more of these, as nodes of the tree
    lights: set[Sdf.Path] = field(default_factory=set)  # lights, domes, and subtrees of them
    emissions: set[Sdf.Path] = field(default_factory=set)  # lights of which only brightness or color changed
    skinning: bool = False  # a skeleton, its animation, or a binding to it changed
    stale_materials: bool = False  # whether any material that was read is among `materials` or `resynced`

    @classmethod
    def everything(cls) -> DirtySet:
        return cls(resynced={ROOT}, bindings={ROOT}, lights={ROOT}, skinning=True)

    @property
    def is_everything(self) -> bool:
        return ROOT in self.resynced

    @property
    def has_other_gprims(self) -> bool:
        """Whether other gprims may be drawn, or point instancers may place them elsewhere."""
        return bool(self.has_other_prims or self.inherited or self.gprims or self.instancers)

    @property
    def has_other_prims(self) -> bool:
        """Whether other prims may be visible."""
        return bool(self.resynced or self.visibility or self.purposes)

    @property
    def concerns_gprims(self) -> bool:
        """Whether anything but the transform of a gprim changed."""
        primvars = self.primvars or self.colors or self.opacities
        return bool(self.has_other_gprims or self.bindings or self.geometry or primvars or self.stale_materials)

    @property
    def has_other_transforms(self) -> bool:
        return bool(self.transforms or self.transform_nodes)


class DirtySetBuilder:
    """Sorts changes into a `DirtySet`, by the kinds of their prims.

    Args:
        instancers_of: the point instancers that draw a prim and all below it as a prototype, by its path.
        binding_owners: the prims with material bindings that were read.
    """

    def __init__(
        self,
        stage: Usd.Stage,
        tree: StageTree,
        instancers_of: Mapping[Sdf.Path, Collection[Sdf.Path]],
        binding_owners: BindingOwners,
    ) -> None:
        self._stage = stage
        self._tree = tree
        self._instancers_of = instancers_of
        self._binding_owners = binding_owners
        self._has_prototypes = bool(stage.GetPrototypes())
        self._dirty = DirtySet()

    def build(self, changes: Changes) -> DirtySet:
        dirty = self._dirty = DirtySet()
        handles = changes.handles_by_type
        dirty.plain_inputs, dirty.plain_colors = handles.get(PlainInput, []), handles.get(PlainColor, [])
        dirty.transform_nodes = [node for node in handles.get(int, ()) if node != UNREAD]
        for root in changes.resynced:
            dirty.resynced.update(map(self._owner, places_of(self._stage, root)))
        if dirty.resynced:
            self._add_resynced()
        if ROOT in changes.changed:  # up axis, units
            dirty.lights.add(ROOT)
        for names, paths in changes.by_names.items():
            if not self._instancers_of:
                ignored = set(filter(_is_ignored, names))
                for path in paths:
                    self._tree.note_unread(path, ignored)
                if ignored == names:
                    continue
            if self._has_prototypes:
                paths = [place for path in paths for place in places_of(self._stage, path)]
            by_kind: dict[int, list[Sdf.Path]] = {}
            for path in paths:
                by_kind.setdefault(self._tree.kind_at(path), []).append(path)
            for kind, some in by_kind.items():
                for part in _stale_parts(kind, names):
                    self._add_part(part, some, names)
        # Which of their points are inactive is metadata.
        places = (place for path in changes.metadata for place in places_of(self._stage, path))
        instancers = [place for place in places if self._tree.kind_at(place) == prim_kinds.INSTANCER]
        self._add_part("instancers", instancers, frozenset())
        return dirty

    def _owner(self, path: Sdf.Path) -> Sdf.Path:
        """The mesh of a prim below it, such as a subset, which is read with its mesh; else the path itself."""
        parent = path.GetParentPath()
        return parent if path != ROOT and self._tree.kind_at(parent) == prim_kinds.MESH else path

    def _add_resynced(self) -> None:
        dirty = self._dirty
        dirty.bindings |= dirty.resynced
        # A material that was added or removed matters wherever a binding names it.
        dirty.bindings.update(map(self._owner, self._binding_owners.take_concerned(dirty.resynced)))
        dirty.lights |= dirty.resynced
        for prototype, instancers in self._instancers_of.items():
            if is_below(prototype, dirty.resynced) or any(root.HasPrefix(prototype) for root in dirty.resynced):
                dirty.instancers.update(instancers)

    def _add_part(self, part: str, paths: list[Sdf.Path], names: frozenset[str]) -> None:
        """Add prims, of which these properties changed, to one of the parts that `_stale_part` names."""
        dirty = self._dirty
        if part == "transforms":
            dirty.transforms.update(paths)
            ops = [name for name in names if name.startswith(_XFORM_OP)]
            for path in paths:
                if not self._add_instancers(path):
                    self._tree.note_xform_ops(path, ops)
        elif part == "collections":  # any binding or light may refer to it
            dirty.bindings.add(ROOT)
            dirty.lights.add(ROOT)
        elif part == "bindings":
            dirty.bindings.update(map(self._owner, paths))
        elif part == "subsets":
            # The tree holds the material subsets of each mesh, so it must be traversed again.
            dirty.resynced.update(path.GetParentPath() for path in paths)
        elif part == "color spaces":  # of all colors at and below
            dirty.resynced.update(paths)
            dirty.lights.update(paths)
        elif part == "inputs":
            dirty.inputs.update(dict.fromkeys(paths, names))
        else:
            getattr(dirty, part).update(paths)
        if part in ("visibility", "purposes", "instancers", "subsets"):
            for path in paths:
                self._add_instancers(path)
        if part in PRIMVARS:
            dirty.inherited.update(filter(self._tree.has_children, paths))

    def _add_instancers(self, path: Sdf.Path) -> bool:
        """Add the point instancers that draw the prim at `path`; whether there are any."""
        if not self._instancers_of or not is_below(path, self._instancers_of):
            return False
        for prefix in path.GetPrefixes():
            self._dirty.instancers.update(self._instancers_of.get(prefix, ()))
        return True


@lru_cache(maxsize=4096)
def _stale_parts(kind: int, names: frozenset[str]) -> frozenset[str]:
    """The parts of a `DirtySet` that a prim belongs to if these properties of it changed."""
    return frozenset(part for name in names if (part := _stale_part(kind, name)))


def _stale_part(kind: int, name: str) -> str:
    """What changed with a property: a field of `DirtySet`, "collections", "subsets", "color spaces", "" for nothing."""
    if _is_xform_op(name):
        return "transforms"
    if name in _OF_SUBTREES:
        return _OF_SUBTREES[name]
    for prefix, part in _PARTS_OF_PREFIX:
        if name.startswith(prefix):
            return part
    if _is_ignored(name):
        return ""
    if kind in prim_kinds.GPRIMS:
        return _stale_part_of_gprim(name)
    if kind == prim_kinds.SHADING:
        return "inputs" if name.startswith("inputs:") else "materials"
    if kind == prim_kinds.LIGHT and name in EMISSION:
        return "emissions"
    if kind in _PART_OF_KIND:
        return _PART_OF_KIND[kind]
    return "inherited" if name.startswith("primvars:") else ""


_PARTS_OF_PREFIX = (("material:binding", "bindings"), ("collection:", "collections"), ("colorSpace", "color spaces"))
_PART_OF_KIND = {
    prim_kinds.LIGHT: "lights",
    prim_kinds.DOME: "lights",
    prim_kinds.INSTANCER: "instancers",
    prim_kinds.SUBSET: "subsets",
}
# What `light_values.emitted_color` reads.
EMISSION = {
    f"inputs:{name}" for name in ("color", "intensity", "exposure", "enableColorTemperature", "colorTemperature")
}
# Namespaces of properties with which gprims are read: those of meshes that are lights, which change the material, too,
# of skeletons, and of draw modes. Others, such as a script's own, change no image.
_GPRIM_NAMESPACES = {"primvars", "inputs", "outputs", "light", "shadow", "shaping", "texture", "skel", "model"}
# Parts that gprims below a gprim may inherit.
PRIMVARS = ("primvars", "colors", "opacities")


def _stale_part_of_gprim(name: str) -> str:
    namespace, separator, _ = name.partition(":")
    if not separator:  # as UsdGeom's attributes of shape
        return "geometry"
    whole = name.removesuffix(":indices")
    if whole == "primvars:displayColor":
        return "colors"
    if whole == "primvars:displayOpacity":
        return "opacities"
    if namespace == "primvars" and name != "primvars:doNotCastShadows":
        return "primvars"
    return "gprims" if namespace in _GPRIM_NAMESPACES else ""


_OF_SUBTREES = {"visibility": "visibility", "purpose": "purposes"}
_XFORM_OP = "xformOp:"


def _is_xform_op(name: str) -> bool:
    """Whether a property is an op, or their order."""
    return name.startswith(_XFORM_OP) or name == "xformOpOrder"


def _is_ignored(name: str) -> bool:
    """Whether a property of this name never changes an image."""
    return name in IGNORED_NAMES or name.startswith(prim_kinds.IGNORED_PREFIXES)

"""The drawn gprims of a stage and their placements: once each, or many times through point instancers."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdSkel

from usdsdg.stage.changes import is_below
from usdsdg.stage.geometry.point_names import Prototypes, PrototypeUse, prototypes_of
from usdsdg_render.lights.mesh_lights import is_light
from usdsdg_render.materials.display_color import DisplayColor, Shown
from usdsdg_render.materials.material_table import AnyMaterial
from usdsdg_render.materials.materials import Update
from usdsdg_render.materials.plain_inputs import FieldEdits
from usdsdg_render.scene.scene import Prototype
from usdsdg_render.sync.invalidation import DirtySet
from usdsdg_render.sync.plain_colors import PlainColor
from usdsdg_render.usd.point_instancer import PointInstances, expand
from usdsdg_render.usd.prim_kinds import GPRIMS, INSTANCER, kind_of
from usdsdg_render.usd.stage_tree import StageTree


@dataclass(eq=False)
class Gprim:
    """One drawn gprim, however many times it is placed, and what has been read of it; None must be read."""

    prim: Usd.Prim
    path: Sdf.Path
    name: str  # the path
    kind: int
    subsets: list[Usd.Prim]
    casts_shadow: int
    is_light: bool
    shown: tuple[Usd.Attribute, Usd.Attribute]  # its own displayColor and displayOpacity
    bound: list[Sdf.Path | None] = field(default_factory=list)  # material of each slot; None = none bound
    is_bound: bool = False  # whether `bound` still holds
    materials: list[AnyMaterial] | None = None  # one for each slot
    has_own_materials: bool = False  # whether it made any of them of a bound one
    color: Shown | None = None  # displayColor
    opacity: Shown | None = None  # displayOpacity
    is_recolored: bool = False  # whether its displayColor was edited, and must be read again
    plain_color: PlainColor | None = None  # made when it was edited first
    colored: tuple[int, ...] = ()  # slots that are drawn with its own displayColor, which varies over it
    averaged: tuple[int, ...] = ()  # slots that are drawn with the mean of one that varies
    # The UV primvars and `colored` that it was read with, and its triangles.
    geometry: tuple[tuple[str, ...], tuple[int, ...], Prototype | None] | None = None

    @property
    def prototype(self) -> Prototype | None:
        """None where it has no surface."""
        return None if self.geometry is None else self.geometry[2]

    @property
    def color_varies(self) -> bool:
        """Whether its displayColor or displayOpacity, if they were read, vary over it."""
        color, opacity = self.color, self.opacity
        return (color is not None and color.varies) or (opacity is not None and opacity.varies)

    @property
    def is_plain(self) -> bool:
        """Whether it has no material but one displayColor all over it."""
        return not self.color_varies and all(type(material) is DisplayColor for material in self.materials or ())

    def drop_color(self) -> None:
        """Let its displayColor be read again."""
        self.color, self.is_recolored = None, True
        self._drop_shown()

    def drop_opacity(self) -> None:
        """Let its displayOpacity be read again."""
        self.opacity = None
        self._drop_shown()

    def _drop_shown(self) -> None:
        self.materials = None
        if self.colored:  # its triangles have the colors
            self.geometry = None


@dataclass
class Placements:
    """Where gprims are drawn, in stage order, as parallel lists."""

    gprims: list[Gprim] = field(default_factory=list)
    paths: list[str] = field(default_factory=list)
    nodes: list[int] = field(default_factory=list)  # of the gprim, or of its instancer
    # Of those that are point instances: the first one of an instancer, and (N, 4, 4) of it and the next ones.
    to_instancer: list[tuple[int, np.ndarray]] = field(default_factory=list)
    lasting_paths: list[str] = field(default_factory=list)

    def add(self, gprim: Gprim, path: str, node: int) -> None:
        self.gprims.append(gprim)
        self.paths.append(path)
        self.lasting_paths.append(path)
        self.nodes.append(node)

    def add_points(self, gprims: Sequence[Gprim], instances: PointInstances, node: int) -> None:
        """gprims: of each part of `instances`."""
        self.to_instancer.append((len(self.gprims), instances.to_instancer))
        self.gprims += [gprims[part] for part in instances.part_of.tolist()]
        self.paths += instances.paths
        self.lasting_paths += instances.lasting_paths
        self.nodes += [node] * len(instances.paths)


class Gprims:
    """All gprims with a drawn purpose. Hidden ones are kept while they are few, for scripts that hide and show them."""

    def __init__(self) -> None:
        self.drawn: list[Gprim] = []  # each once, in stage order
        self.placements = Placements()
        self.known: dict[Sdf.Path, Gprim] = {}
        self.prototype_skel_roots: set[Sdf.Path] = set()  # SkelRoots in prototypes of instancers, which no tree has
        self._users: dict[Sdf.Path, list[Gprim]] | None = None  # of materials; None must be found
        self._point_instances: dict[Sdf.Path, PointInstances] = {}  # of each instancer
        self._prototypes: dict[Sdf.Path, set[Sdf.Path]] = {}  # prototype roots of each instancer, nested ones included
        self._all_prototypes: Prototypes | None = None
        self._has_other_instancers = True  # than `_all_prototypes` has

    @property
    def instancers_of(self) -> dict[Sdf.Path, list[Sdf.Path]]:
        """Prototype root -> the instancers that draw it."""
        found: dict[Sdf.Path, list[Sdf.Path]] = {}
        for instancer, prototypes in self._prototypes.items():
            for prototype in prototypes:
                found.setdefault(prototype, []).append(instancer)
        return found

    def invalidate(self, dirty: DirtySet) -> None:
        """Drop what must be read again."""
        if dirty.has_other_gprims:
            self.forget_users()
        for path in dirty.gprims:
            self.known.pop(path, None)
        for path in dirty.geometry & self.known.keys():
            gprim = self.known[path]
            gprim.geometry = None
            if gprim.colored:  # its materials refer to the color texture of its triangles
                gprim.materials = None
        for path in dirty.primvars & self.known.keys():
            self.known[path].geometry = self.known[path].materials = None
        for path in dirty.colors & self.known.keys():
            self.known[path].drop_color()
        for path in dirty.opacities & self.known.keys():
            self.known[path].drop_opacity()
        if stale := dirty.resynced | dirty.inherited:
            for path in [path for path in self.known if is_below(path, stale)]:
                del self.known[path]
        if dirty.bindings:
            for path, gprim in self.known.items():
                gprim.is_bound = gprim.is_bound and not is_below(path, dirty.bindings)
        if dirty.resynced:  # hidden instancers may have come or gone, too
            self._has_other_instancers = True
        if stale := dirty.resynced | dirty.instancers:
            for path in [path for path in self._point_instances if is_below(path, stale)]:
                del self._point_instances[path], self._prototypes[path]

    def invalidate_materials(self, materials: Set[Sdf.Path]) -> None:
        """Drop the materials of gprims to which one of these is bound."""
        for path in materials:
            for gprim in self._users_of(path):
                gprim.materials = None

    def replace_materials(self, updates: Mapping[Sdf.Path, Update]) -> None:
        """Replace materials that are bound to gprims; drop those that gprims have made their own ones of."""
        for path, update in updates.items():
            for gprim in self._users_of(path):
                for slot, bound in enumerate(gprim.bound):
                    if gprim.materials is None or bound != path:
                        continue
                    if gprim.materials[slot] is update.before:
                        gprim.materials[slot] = update.after
                    else:
                        gprim.materials = None

    def keep_materials(self, edits: FieldEdits) -> None:
        """Drop materials that gprims have made of those that were edited in place."""
        if not any(gprim.has_own_materials for gprim in self.known.values()):
            return
        users = self._all_users()
        for path, material in zip(edits.paths, edits.materials):
            for gprim in users.get(path, ()):
                for bound, each in zip(gprim.bound, gprim.materials or ()):
                    if each is not material and bound == path:
                        gprim.materials = None

    def _users_of(self, material: Sdf.Path) -> Sequence[Gprim]:
        """The gprims to which a material is bound."""
        return self._all_users().get(material, ())

    def _all_users(self) -> dict[Sdf.Path, list[Gprim]]:
        if self._users is None:
            self._users = {}
            for gprim in self.known.values():
                for path in {path for path in gprim.bound if path is not None}:
                    self._users.setdefault(path, []).append(gprim)
        return self._users

    def forget_users(self) -> None:
        """Let the gprims of each material be found again, since others are known, or bound to others."""
        self._users = None

    def drop_hidden(self) -> None:
        """Keep only drawn gprims: `Animation` does not survey hidden ones, so they would miss a change of time."""
        self.known = {gprim.path: gprim for gprim in self.drawn}
        self.forget_users()

    def collect(self, tree: StageTree) -> None:
        """List the drawn gprims and their placements."""
        self.forget_users()
        self.placements = Placements()
        drawn: dict[Sdf.Path, Gprim] = {}
        self.prototype_skel_roots = set()
        shared = self._read_shared([tree.prims[node] for node in tree.of_kind(INSTANCER)])
        point_instances, self._point_instances = self._point_instances, {}
        for node in tree.of_kind(*GPRIMS, INSTANCER):
            if not tree.drawn[node]:
                continue
            prim, path = tree.prims[node], tree.paths[node]
            if tree.kinds[node] != INSTANCER:
                gprim = drawn[path] = self._gprim(prim, path, tree.subsets.get(path, []))
                self.placements.add(gprim, gprim.name, node)
                continue
            if path not in point_instances:
                prototypes = self._prototypes[path] = set()
                point_instances[path] = expand(prim, tree.time, prototypes, shared)
            self._point_instances[path] = instances = point_instances[path]
            for part in instances.parts:
                source = part.prim.GetPath()
                if source not in drawn:
                    drawn[source] = self._gprim(part.prim, source, part.subsets)
                    if root := UsdSkel.Root.Find(part.prim):
                        self.prototype_skel_roots.add(root.GetPath())
            self.placements.add_points([drawn[part.prim.GetPath()] for part in instances.parts], instances, node)
        self._prototypes = {path: self._prototypes[path] for path in self._point_instances}
        self.drawn = list(drawn.values())
        if len(self.known) > 2 * len(drawn) + 64:
            self.known = drawn

    def _read_shared(self, visible: Sequence[Usd.Prim]) -> frozenset[PrototypeUse]:
        """Return the prototypes that several instancers draw; if they are other ones, points have other names."""
        before = self._all_prototypes
        known = before.of if before is not None and not self._has_other_instancers else {}
        if before is not None and all(known.get(each.GetPath()) == prototypes_of(each) for each in visible):
            return before.shared
        self._has_other_instancers = False
        self._all_prototypes = now = Prototypes(visible[0].GetStage()) if visible else None
        shared = now.shared if now is not None else frozenset()
        if before is not None and before.shared != shared:
            self._point_instances.clear()
            self._prototypes.clear()
        return shared

    def _gprim(self, prim: Usd.Prim, path: Sdf.Path, subsets: list[Usd.Prim]) -> Gprim:
        gprim = self.known.get(path)
        if gprim is None:
            # Omniverse's primvar; UsdGeom has none for this.
            shadowless = prim.GetAttribute("primvars:doNotCastShadows")
            casts = 0 if shadowless and shadowless.Get() is True else 1
            shown = prim.GetAttribute("primvars:displayColor"), prim.GetAttribute("primvars:displayOpacity")
            gprim = self.known[path] = Gprim(
                prim, path, path.pathString, kind_of(prim), subsets, casts, is_light(prim), shown
            )
        return gprim

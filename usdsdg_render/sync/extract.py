"""USD stage to `scene.Scene`: everything once, then only what changed.

Point instances have no prim of their own; their path is that of the gprim in the prototype followed by `[id]`, the
id of the point (its index where no ids are authored). `point_instancer.source_path` gives the prim path back.
"""

from collections.abc import Sequence, Set

import numpy as np
from pxr import Sdf, Usd

from usdsdg.errors import Unsupported
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes, is_below
from usdsdg.stage.geometry.uv_primvars import UV_NAMES
from usdsdg.stage.prims.handles import Handles
from usdsdg.stage.time_code import time_context
from usdsdg.stage.world_values import WorldValues
from usdsdg_render.geometry.prim_surface import PrimSurface
from usdsdg_render.geometry.prototypes import PrototypeCache
from usdsdg_render.images.textures import Progress
from usdsdg_render.lights.stage_lights import StageLights
from usdsdg_render.scene.scene import Scene
from usdsdg_render.scene.worlds import Worlds
from usdsdg_render.sync.animation import Animation
from usdsdg_render.sync.gprim_materials import GprimMaterials
from usdsdg_render.sync.gprims import Gprim, Gprims
from usdsdg_render.sync.instance_table import InstanceTable
from usdsdg_render.sync.invalidation import DirtySet, DirtySetBuilder
from usdsdg_render.sync.world_reader import Parts, read_worlds
from usdsdg_render.sync.world_slots import WorldSlots
from usdsdg_render.usd.prim_kinds import MESH, SHAPE
from usdsdg_render.usd.stage_tree import StageTree
from usdsdg_render.usd.world_transforms import WorldTransforms


class SceneExtractor:
    """Keeps `scene` up to date with a stage. `scene.versions` says which tables an update touched.

    Each update builds a `DirtySet` of what changed, drops that, and reads what is missing then.
    """

    def __init__(self, stage: Usd.Stage, progress: Progress | None = None, *, time: Usd.TimeCode | None = None) -> None:
        self.scene = Scene()
        self._stage = stage
        self._progress = progress
        self._requested_time = self._time = Usd.TimeCode.Default() if time is None else time
        self._animation = Animation(stage)
        self._tracker = ChangeTracker(stage)
        self._tree: StageTree | None = None
        # What properties do that were written before: the node of the tree that they move, or the field of a material.
        self._handles = Handles()
        self._gprims = Gprims()
        self._materials = GprimMaterials(stage, self.scene, self._handles, progress)
        self._prototypes = PrototypeCache()
        self._index_of: dict[int, int] = {}  # id of a prototype -> its index in the scene
        self._skinned: set[Sdf.Path] = set()  # gprims that a skeleton deforms
        self._instances = InstanceTable(self.scene)
        self._world_slots = WorldSlots()
        self._always_shown: frozenset[Sdf.Path] = frozenset()
        self._toggled: set[Sdf.Path] = set()  # that are now, or were, always shown
        self._lights = StageLights(stage, self.scene)
        self._looks_at_files = False  # at the next update

    @property
    def time(self) -> Usd.TimeCode:
        """The time code of `scene`: the default one where nothing on the stage varies."""
        return self._time

    def update(self, time: Usd.TimeCode | None = None) -> None:
        """Bring `scene` up to date with the stage as it is at `time` (None: the time that was requested last)."""
        if time is not None:
            self._requested_time = time
        dirty = self._take_dirty_set()
        with time_context(self._time):
            self._invalidate(dirty)
            self._read(dirty)

    def look_at_files(self) -> None:
        """Let the next update read images and light profiles again that have changed on disk.

        Nothing notifies of these, and looking costs a call of the system for each file.
        """
        self._looks_at_files = True

    def always_show(self, paths: Set[Sdf.Path]) -> None:
        """Keep prims in `scene` although their visibility says that they are hidden, from the next update on."""
        if paths != self._always_shown:
            self._toggled |= paths ^ self._always_shown
            self._always_shown = frozenset(paths)
            if self._tree is not None:
                self._tree.always_shown = self._always_shown

    def worlds(self, values: WorldValues) -> tuple[Worlds, WorldTransforms]:
        """Return many worlds of the stage as it was at the last update.

        Raises:
            Unsupported: the values of an attribute cannot differ between worlds.
        """
        assert self._tree is not None
        first_slots = self._materials.first_slots
        parts = Parts(
            self._stage, self.scene, self._tree, self._gprims, self._instances, first_slots, self._world_slots
        )
        return read_worlds(parts, values)

    def node_of(self, path: str) -> int:
        """Return the row of a prim in `WorldTransforms`.

        Raises:
            Unsupported: it is hidden, or inside of an instance.
        """
        assert self._tree is not None
        node = self._tree.index.get(Sdf.Path(path))
        if node is None or self._tree.is_hidden(node):
            raise Unsupported(f"worlds: {path} is hidden, so its pose is not read. Show it.")
        return node

    def places(self, paths: Sequence[Sdf.Path]) -> tuple[np.ndarray, np.ndarray]:
        """Return what `StageTree.places` returns, as of the last update."""
        assert self._tree is not None
        return self._tree.places(paths)

    def close(self) -> None:
        """Stop listening to the stage."""
        self._tracker.close()

    # What changed

    def _take_dirty_set(self) -> DirtySet:
        changes = self._take_changes()
        was_animated = self._animation.is_animated
        self._animation.apply(changes)
        # Without time samples every time code reads the same.
        now = self._requested_time if self._animation.is_animated else Usd.TimeCode.Default()
        before, self._time = self._time, now
        # Even an attribute with a single sample differs between the default time and other time codes.
        if self._tree is None or was_animated != self._animation.is_animated or now.IsDefault() != before.IsDefault():
            return DirtySet.everything()
        owners = self._materials.binding_owners
        dirty = DirtySetBuilder(self._stage, self._tree, self._gprims.instancers_of, owners).build(changes)
        dirty.visibility |= self._toggled
        self._toggled = set()
        dirty.skinning = self._prototypes.skinning.is_affected_by(self._stage, changes)
        if now != before:
            self._tree.set_time(now)
            self._gprims.drop_hidden()
            self._animation.add_to(dirty, now)
            dirty.geometry |= self._skinned
        if dirty.skinning:  # meshes that were not skinned may be now
            dirty.geometry.update(path for path in self._gprims.known if is_below(path, self._skel_roots))
        return dirty

    @property
    def _skel_roots(self) -> Set[Sdf.Path]:
        own = self._tree.skel_roots if self._tree is not None else set()
        return own | self._gprims.prototype_skel_roots

    def _take_changes(self) -> Changes:
        tree = self._tree
        if tree is None:
            return self._tracker.take()
        # Skinning and animation need the paths of the properties, not only the nodes that they move.
        handles = None if self._skel_roots or self._animation.is_animated else self._handles
        return self._tracker.take(is_relevant=tree.has_other_schemas, handles=handles)

    def _invalidate(self, dirty: DirtySet) -> None:
        if dirty.skinning:
            self._prototypes.skinning.invalidate()
        dirty.stale_materials = self._materials.invalidate(dirty, self._gprims)
        if self._looks_at_files:
            self._looks_at_files = False
            dirty.stale_materials |= self._materials.look_at_files()
            dirty.lights |= self._lights.with_other_files()
        self._gprims.invalidate(dirty)
        self._lights.invalidate(dirty.lights)
        self._lights.invalidate_emission(dirty.emissions)

    # What is read again

    def _read(self, dirty: DirtySet) -> None:
        if dirty.is_everything:
            self._tree = StageTree(self._stage, self._time, self._handles, self._always_shown)
        tree = self._tree
        assert tree is not None  # the first sync reads everything
        if not dirty.is_everything and dirty.has_other_prims:
            self._read_prims(tree, dirty)
        if dirty.has_other_transforms:
            tree.update_transforms(dirty.transforms, dirty.transform_nodes)
        if dirty.has_other_gprims:
            self._gprims.collect(tree)
            self._handles.forget()  # point instancers may draw other prims, whose moves then concern them
        if self._animation.is_animated and (dirty.has_other_gprims or not self._animation.is_surveyed):
            self._animation.survey(tree, self._gprims)
        replaced = dirty.concerns_gprims and self._read_gprims(everything=dirty.has_other_gprims)
        if replaced or dirty.has_other_transforms:
            self._instances.write(tree.world, self._index_of, self._materials.first_slots, always=replaced)
        if dirty.has_other_prims or dirty.lights or dirty.emissions or dirty.has_other_transforms:
            self._lights.read(tree, always=bool(dirty.lights or dirty.emissions))

    @staticmethod
    def _read_prims(tree: StageTree, dirty: DirtySet) -> None:
        first_shown = {path for path in dirty.visibility if path not in tree.index}
        if subtrees := dirty.resynced | dirty.purposes | first_shown:
            # Other prims come or go, so that nodes after them are not where they were noted.
            dirty.transforms.update(tree.paths[node] for node in dirty.transform_nodes)
            dirty.transform_nodes = []
            tree.resync(subtrees)
        tree.show(dirty.visibility)

    def _read_gprims(self, *, everything: bool) -> bool:
        """Read what is missing of the drawn gprims; return whether instances may be other ones, or have other columns.

        everything: other gprims may be drawn than before.
        """
        drawn = self._gprims.drawn
        self._materials.bind(self._gprims)
        changed = [gprim for gprim in drawn if gprim.materials is None]
        self._materials.read(changed, self._time)
        if everything:
            self._find_skinned()
        replaced = self._read_geometry(changed) or everything
        if replaced:
            self._write_prototypes()
        if everything or changed or not self._materials.are_written:
            if self._animation.is_animated:
                self._animation.survey_materials({path for gprim in drawn for path in gprim.bound if path is not None})
            self._materials.apply_colors(changed, self._index_of.keys(), self._time)
            slots = self._materials.first_slots
            self._materials.write(drawn, None if everything else changed)
            replaced = replaced or self._materials.first_slots is not slots
        if replaced:
            self._instances.set_placements(self._gprims.placements)
        return replaced

    def _find_skinned(self) -> None:
        skinning, has_skeletons = self._prototypes.skinning, bool(self._skel_roots)
        known = self._gprims.known.values()
        self._skinned = {g.path for g in known if has_skeletons and skinning.is_skinned(g.prim)}

    def _read_geometry(self, changed: Sequence[Gprim]) -> bool:
        """Read the prototypes of gprims that have none yet, or whose material asks for another UV set or for colors.

        Returns:
            Whether there are any.
        """
        missing = (gprim for gprim in self._gprims.drawn if gprim.geometry is None)
        variants = {gprim: (_uv_names(gprim), gprim.colored) for gprim in (*missing, *changed)}
        unread = [(g, variant) for g, variant in variants.items() if g.geometry is None or g.geometry[:2] != variant]
        self._prototypes.begin_pass()
        for done, (gprim, (uv_names, colored)) in enumerate(unread):
            if gprim.kind == SHAPE:
                prototype = self._prototypes.shape(gprim.prim, self._time)
            else:
                own = gprim.path in self._skinned or gprim.path in self._animation.geometry
                surface = PrimSurface(gprim.prim, self._time, uv_names, tuple(gprim.subsets), colored)
                prototype = self._prototypes.points(surface, own=own)
            gprim.geometry = uv_names, colored, prototype
            if self._progress is not None:
                self._progress("geometry", done + 1, len(unread))
        return bool(unread)

    def _write_prototypes(self) -> None:
        """Old prototypes keep their order, idle ones too for as long as the cache has them; new ones follow."""
        scene = self.scene
        used = {id(g.prototype): g.prototype for g in self._gprims.drawn if g.prototype is not None}
        kept = self._prototypes.drop_idle(used)
        prototypes = [prototype for prototype in scene.prototypes if id(prototype) in kept]
        listed = {id(prototype) for prototype in prototypes}
        prototypes += [prototype for number, prototype in used.items() if number not in listed]
        if list(map(id, scene.prototypes)) != list(map(id, prototypes)):
            scene.prototypes = prototypes
            scene.touch("prototypes")
        self._index_of = {id(prototype): k for k, prototype in enumerate(prototypes)}


def _uv_names(gprim: Gprim) -> tuple[str, ...]:
    """The UV primvar that the materials read, or that of each where they differ; none where any will do."""
    if gprim.kind == SHAPE:
        return ()
    materials = gprim.materials or ()
    if gprim.kind != MESH:  # curves and points have texture coordinates of their own where they have none
        return tuple(each.uv_primvar or UV_NAMES[0] for each in materials[:1] if each.textures)
    named = tuple(dict.fromkeys(material.uv_primvar for material in materials if material.uv_primvar))
    if not named or all(each.uv_primvar == named[0] or not each.textures for each in materials):
        return named
    # Those of slots without textures do not matter.
    return tuple(each.uv_primvar if each.uv_primvar or each.textures else named[0] for each in materials)

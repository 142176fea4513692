"""USD stage to `scene.Scene`: everything once, then only what changed.

Point instances have no prim of their own; their path is that of the gprim in the prototype followed by `[id]`, the
id of the point (its index where no ids are authored). `instancer.source_path` gives the prim path back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pxr import Sdf, Usd

from usdsdg import errors
from usdsdg.stage.changes import Changes, ChangeTracker
from usdsdg_render.geometry.primvar_colors import ColorPictures
from usdsdg_render.geometry.prototypes import PrototypeCache
from usdsdg_render.images.textures import Progress, TexturePool
from usdsdg_render.lights.mesh_lights import emissive_material, is_light
from usdsdg_render.lights.stage_lights import StageLights
from usdsdg_render.materials.material_slots import MaterialSlots
from usdsdg_render.materials.materials import MaterialLibrary, MaterialTable, bound_materials, stand_in
from usdsdg_render.materials.shading import Material
from usdsdg_render.scene.scene import Instances, Scene
from usdsdg_render.sync.animation import Animation
from usdsdg_render.sync.gprims import Gprim, Gprims, display_color, warn_of_mean, warn_of_no_coordinates
from usdsdg_render.sync.invalidation import Plan, Planner
from usdsdg_render.usd.prim_kinds import MESH, SHAPE, is_below, matrix_product
from usdsdg_render.usd.stage_tree import Tree
from usdsdg_render.usd.time_code import reading_at


class SceneExtractor:
    """Keeps `scene` up to date with a stage. `scene.versions` says which tables an update touched.

    Each update makes a `Plan` of what changed and forgets that; then it reads what is not known.
    """

    def __init__(self, stage: Usd.Stage, progress: Progress | None = None, *, time: Usd.TimeCode | None = None) -> None:
        self.scene = Scene()
        self._stage = stage
        self._progress = progress
        self._asked_time = self._time = Usd.TimeCode.Default() if time is None else time
        self._animation = Animation(stage)
        self._tracker = ChangeTracker(stage)
        self._tree: Tree | None = None
        self._gprims = Gprims()
        self._library = MaterialLibrary(stage)
        self._textures = TexturePool()
        self._table = MaterialTable()
        self._slots = MaterialSlots()
        self._colors = ColorPictures()
        self._prototypes = PrototypeCache()
        self._index_of: dict[int, int] = {}  # id of a prototype -> its place in the scene
        self._skinned: set[Sdf.Path] = set()
        self._nodes = np.zeros(0, np.int64)  # tree node of each placement
        self._points = np.zeros(0, np.int64)  # placements that are point instances
        self._point_matrices = np.zeros((0, 4, 4))  # of those, to the instancer
        self._has_surface = np.zeros(0, bool)
        self._drawn = np.zeros(0, np.int64)  # placements that became instances
        self._stage_lights = StageLights(stage, self.scene)

    @property
    def time(self) -> Usd.TimeCode:
        """The time that `scene` shows: the default time where nothing on the stage varies."""
        return self._time

    def update(self, time: Usd.TimeCode | None = None) -> None:
        """Bring `scene` up to date with the stage as it is at `time` (None: the time that was asked for last)."""
        if time is not None:
            self._asked_time = time
        plan = self._make_plan()
        with reading_at(self._time):
            self._carry_out(plan)

    def close(self) -> None:
        """Stop listening to the stage."""
        self._tracker.close()

    def _make_plan(self) -> Plan:
        changes = self._take_changes()
        was_animated = self._animation.animated
        self._animation.notice(changes)
        # Where nothing has a time, all times are one.
        now = self._asked_time if self._animation.animated else Usd.TimeCode.Default()
        before, self._time = self._time, now
        # Between the default time and others even what has a single sample changes.
        if self._tree is None or was_animated != self._animation.animated or now.IsDefault() != before.IsDefault():
            return Plan.of_everything()
        plan = Planner(self._stage, self._tree, self._gprims.sources).plan(changes)
        plan.skinned = self._prototypes.skinning.concerns(self._stage, changes)
        if now != before:
            self._tree.set_time(now)
            self._gprims.forget_hidden()
            self._animation.add_to(plan, now)
            plan.shapes |= self._skinned
        if plan.skinned:  # what was not may be now
            plan.shapes.update(path for path in self._gprims.known if is_below(path, self._tree.skeletons))
        return plan

    def _take_changes(self) -> Changes:
        tree = self._tree
        if tree is None:
            return self._tracker.take()
        # Skeletons and animations want to know of their own parts.
        known = None if tree.skeletons or self._animation.animated else tree.movers
        return self._tracker.take(matters=tree.has_other_schemas, known=known)

    def _carry_out(self, plan: Plan) -> None:
        if plan.skinned:
            self._prototypes.skinning.forget()
        looks = self._library.forget(plan.materials, plan.roots) if plan.materials or plan.roots else set()
        self._gprims.forget(plan)
        if looks:
            self._gprims.forget_looks(looks)
        self._stage_lights.invalidate(plan.lights)
        if plan.everything:
            self._tree = Tree(self._stage, self._time)
        if plan.regrown and not plan.everything:
            self._tree.regrow(plan.regrown)
        moved = bool(plan.moved or plan.moved_nodes)
        if moved:
            self._tree.move(plan.moved, plan.moved_nodes)
        if plan.listed:
            self._gprims.find(self._tree)
            self._tree.movers.clear()  # points may draw others
        if self._animation.animated and (plan.listed or not self._animation.is_surveyed):
            self._animation.survey(self._tree, self._gprims)
        drawn = bool(plan.listed or plan.bound or plan.shapes or looks)
        if drawn:
            self._read_gprims(anew=plan.listed)
        if drawn or moved:
            self._place(anew=drawn)
        if plan.regrown or plan.lights or moved:
            self._stage_lights.read(self._tree, always=bool(plan.lights))

    # What is drawn

    def _read_gprims(self, *, anew: bool) -> None:
        """What is not known of them: their materials, and their geometry where the material asks for another UV set.

        anew: others may be drawn than before.
        """
        drawn = self._gprims.drawn
        self._bind()
        changed = [gprim for gprim in drawn if gprim.materials is None]
        for gprim in changed:
            self._read_looks(gprim)
        if anew:
            skinning, has_skeletons = self._prototypes.skinning, bool(self._tree.skeletons)
            known = self._gprims.known.values()
            self._skinned = {g.path for g in known if has_skeletons and skinning.is_skinned(g.prim)}
        self._read_geometry(changed)
        self._write_prototypes()
        if anew or changed:
            if self._animation.animated:
                bound = {path for gprim in drawn for path in gprim.bound if path is not None}
                self._animation.survey_materials(bound)
            self._paint(changed)
            self._write_materials()
        self._note_placements()

    def _bind(self) -> None:
        """Ask what is bound where that may be another material; others stay as they look."""
        unbound = [gprim for gprim in self._gprims.drawn if not gprim.is_bound]
        found = iter(bound_materials([prim for gprim in unbound for prim in (*gprim.subsets, gprim.prim)]))
        for gprim in unbound:
            prims = [next(found) for _ in range(len(gprim.subsets) + 1)]
            bound = [None if prim is None else prim.GetPath() for prim in prims]
            if bound != gprim.bound:
                gprim.materials = None
            gprim.bound, gprim.is_bound = bound, True
        if unbound:
            self._library.keep_only({path for g in self._gprims.known.values() for path in g.bound if path is not None})

    def _read_looks(self, gprim: Gprim) -> None:
        gprim.colored = gprim.kind != SHAPE
        gprim.materials = [
            self._finished(gprim, None if path is None else self._library.read(self._stage.GetPrimAtPath(path)))
            for path in gprim.bound
        ]
        if is_light(gprim.prim):
            gprim.materials = [emissive_material(material, gprim.prim) for material in gprim.materials]

    def _finished(self, gprim: Gprim, material: Material | None) -> Material:
        """The material, with the gprim's own color where it asks for that or there is no material."""
        if material is not None and material.from_gprim:
            material = material.of_gprim(gprim.prim, self._time)
        if material is not None and not material.color_from_gprim:
            gprim.colored = False
            return material
        if gprim.stand_in is None:
            *mean, varies = display_color(gprim.prim, self._time)
            gprim.stand_in = stand_in(*mean), varies
        own, varies = gprim.stand_in
        if not varies or (material is not None and material.textures):
            gprim.colored = False
        return own if material is None else material.with_base_color(own.base_color.value)

    def _read_geometry(self, changed: Sequence[Gprim]) -> None:
        """Prototypes of those that have none yet, or whose material asks for another one."""
        lost = (gprim for gprim in self._gprims.drawn if gprim.geometry is None)
        forms = {gprim: (_uv_name(gprim), gprim.colored) for gprim in (*lost, *changed)}
        unread = [(g, form) for g, form in forms.items() if g.geometry is None or g.geometry[:2] != form]
        self._prototypes.begin_pass()
        for done, (gprim, (uv_name, colored)) in enumerate(unread):
            if gprim.kind == SHAPE:
                prototype = self._prototypes.shape(gprim.prim, self._time)
            else:
                own = gprim.path in self._skinned or gprim.path in self._animation.shapes
                prototype = self._prototypes.points(
                    gprim.prim, self._time, uv_name, gprim.subsets, own=own, colored=colored
                )
            gprim.geometry = uv_name, colored, prototype
            if self._progress is not None:
                self._progress("geometry", done + 1, len(unread))

    def _paint(self, changed: Sequence[Gprim]) -> None:
        """Give gprims their varying colors; those that cannot have them are named."""
        for gprim in changed:
            if gprim.prototype is None:
                continue
            if gprim.prototype.corner_colors is not None:
                gprim.materials = [self._colors.painted(each, gprim.prototype) for each in gprim.materials or ()]
            elif gprim.stand_in is not None and gprim.stand_in[1]:
                warn_of_mean(gprim.prim)
            textured = gprim.kind == MESH and any(each.textures for each in gprim.materials or ())
            if textured and not gprim.prototype.corner_uvs.any():
                warn_of_no_coordinates(gprim.prim)
        self._colors.keep_only(set(self._index_of))
        for use, texture in self._colors.textures():
            self._textures.keep(use, texture)

    def _write_prototypes(self) -> None:
        """Old prototypes keep their order, also idle ones for as long as the cache has them; new ones follow."""
        scene = self.scene
        used = {id(g.prototype): g.prototype for g in self._gprims.drawn if g.prototype is not None}
        kept = self._prototypes.forget_idle(used)
        prototypes = [prototype for prototype in scene.prototypes if id(prototype) in kept]
        listed = {id(prototype) for prototype in prototypes}
        prototypes += [prototype for number, prototype in used.items() if number not in listed]
        if not _same_objects(scene.prototypes, prototypes):
            scene.prototypes = prototypes
            scene.touch("prototypes")
        self._index_of = {id(prototype): k for k, prototype in enumerate(prototypes)}

    def _write_materials(self) -> None:
        scene, slots = self.scene, self._slots
        materials = slots.assign(self._gprims.drawn)
        table, textures = self._table.build(materials, self._textures, self._progress)
        if not _same_objects(scene.textures, textures):
            scene.textures = list(textures)
            scene.touch("textures")
        if not np.array_equal(slots.rows, scene.material_slots) or table.tobytes() != scene.materials.tobytes():
            scene.materials, scene.material_slots = table, slots.rows
            scene.touch("materials")

    # Where it is drawn

    def _note_placements(self) -> None:
        placements = self._gprims.placements
        self._nodes = np.array(placements.nodes, np.int64)
        self._points = np.array(list(placements.offsets), np.int64)
        self._point_matrices = np.array(list(placements.offsets.values())).reshape(-1, 4, 4)
        self._has_surface = np.array([gprim.prototype is not None for gprim in placements.gprims], bool)

    def _place(self, *, anew: bool) -> None:
        """Matrices of all instances; those without a usable one are not drawn."""
        placements = self._gprims.placements
        world = self._tree.world[self._nodes]
        if len(self._points):
            world[self._points] = matrix_product(self._point_matrices, world[self._points])
        usable = invertible(world)
        for k in np.flatnonzero(self._has_surface & ~usable):
            errors.warn_once(
                f"{placements.paths[k]}: its transform is NaN, infinite, scaled to zero or so far out of "
                f"proportion that 32-bit numbers lose it, so it is not drawn. Correct the xformOps of it or of a prim "
                f"above."
            )
        drawn = np.flatnonzero(self._has_surface & usable)
        if anew or not np.array_equal(drawn, self._drawn):
            self._write_instances(drawn)
        scene = self.scene
        if not np.array_equal(scene.instances.local_to_world, world[drawn]):
            scene.instances = replace(scene.instances, local_to_world=world[drawn])
            scene.touch("transforms")

    def _write_instances(self, drawn: np.ndarray) -> None:
        placements, old = self._gprims.placements, self.scene.instances
        gprims = [placements.gprims[k] for k in drawn]
        new = Instances(
            paths=tuple(placements.paths[k] for k in drawn),
            prototype=np.array([self._index_of[id(gprim.prototype)] for gprim in gprims], np.int32),
            local_to_world=old.local_to_world,
            slot_offset=np.array([self._slots.begins[gprim.path] for gprim in gprims], np.int32),
            casts_shadow=np.array([gprim.casts_shadow for gprim in gprims], np.int32),
        )
        self._drawn = drawn
        columns = ("prototype", "slot_offset", "casts_shadow")
        if old.paths != new.paths or any(not np.array_equal(getattr(old, c), getattr(new, c)) for c in columns):
            self.scene.instances = new
            self.scene.touch("instances")


def _uv_name(gprim: Gprim) -> str:
    """The UV primvar that the materials ask for; "" where any will do."""
    if gprim.kind != MESH:
        return ""
    return next((material.uv_primvar for material in gprim.materials or () if material.uv_primvar), "")


def invertible(matrices: np.ndarray) -> np.ndarray:
    """(N,) which (N, 4, 4) matrices are finite and have an inverse, in 32-bit numbers too."""
    linear = matrices[:, :3, :3]
    with np.errstate(invalid="ignore", over="ignore"):
        a, b, c = linear.transpose(1, 2, 0)
        volume = np.abs(
            a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        product = np.sqrt(np.einsum("nij,nij->ni", linear, linear)).prod(axis=1)
        within = (np.abs(matrices) < 1e17).all(axis=(1, 2))  # not of NaN
        return within & (product > 1e-30) & (volume > 1e-9 * product)


def _same_objects(a: Sequence, b: Sequence) -> bool:
    return len(a) == len(b) and all(x is y for x, y in zip(a, b))

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
from usdsdg.stage.changes import ChangeTracker
from usdsdg.stage.transforms import meters_per_unit

from . import stage_tree
from .animation import Animation
from .corner_colors import ColorPictures
from .domes import DomeBuilder, DomeLight, read_dome
from .gprims import Gprim, Placements, display_colour, find_gprims, warn_of_mean
from .light_reader import read_lights
from .material_slots import MaterialSlots
from .materials import MaterialLibrary, bound_materials, build_table, stand_in
from .mesh_lights import glowing, is_light
from .moment import reading_at
from .plan import Plan, Planner, is_below
from .prototypes import PrototypeCache
from .scene import Instances, Prototype, Scene
from .shading import Material
from .stage_tree import DOME, MESH, SHAPE, Tree
from .textures import Progress, TexturePool


class SceneExtractor:
    """Keeps `scene` up to date with a stage. `scene.versions` says which tables an update touched."""

    def __init__(self, stage: Usd.Stage, progress: Progress | None = None, *, time: Usd.TimeCode | None = None) -> None:
        self.scene = Scene()
        self._stage = stage
        self._progress = progress
        self._asked_time = self._time = Usd.TimeCode.Default() if time is None else time
        self._animation = Animation(stage)
        self._tracker = ChangeTracker(stage)
        self._tree: Tree | None = None
        self._library = MaterialLibrary(stage)
        self._textures = TexturePool()
        self._prototypes = PrototypeCache()
        self._dome_builder = DomeBuilder()
        # gprim -> (UV primvar, whether with its own colours, prototype)
        self._known: dict[Sdf.Path, tuple[str, bool, Prototype | None]] = {}
        self._stand_ins: dict[Sdf.Path, tuple[Material, bool]] = {}  # and whether its colour varies over the gprim
        self._colors = ColorPictures()
        self._gprims: list[Gprim] = []
        self._skinned: set[Sdf.Path] = set()
        self._own: set[Sdf.Path] = set()  # gprims that share no geometry by their specs
        self._placements = Placements()
        self._nodes = np.zeros(0, np.int64)  # tree node of each placement
        self._points = np.zeros(0, np.int64)  # placements that are point instances
        self._point_matrices = np.zeros((0, 4, 4))  # of those, to the instancer
        self._has_surface = np.zeros(0, bool)
        self._drawn = np.zeros(0, np.int64)  # placements that became instances
        self._slots = MaterialSlots()
        self._domes: list[DomeLight] = []
        self._light_matrices = b""
        self._linked_instances: tuple[str, ...] | None = None  # by which light links were read

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

    def _carry_out(self, plan: Plan) -> None:
        if plan.everything:
            self._library.forget_all()
            self._known.clear()
            self._stand_ins.clear()
        if plan.materials or plan.roots:
            self._library.forget(plan.materials | plan.roots)
        if plan.skinned:
            self._prototypes.skinning.forget()
        if plan.structure:
            plan.gprims |= plan.shapes
            self._forget_gprims(plan)
            self._tree = Tree(self._stage, self._time)
            self._gprims, self._placements = find_gprims(self._tree)
            self._note_own_shapes()
        elif plan.moved:
            self._tree.move(plan.moved)
        if plan.structure or plan.materials:
            self._read_gprims()
        if plan.shapes and not plan.structure:
            self._read_shapes(plan.shapes)
        if plan.structure or plan.materials or plan.moved or plan.shapes:
            self._place(structure=plan.structure or bool(plan.materials) or bool(plan.shapes))
        if plan.structure or plan.lights or plan.moved:
            self._read_lights(always=plan.lights or plan.structure)

    def _make_plan(self) -> Plan:
        changes = self._tracker.take()
        was_animated = self._animation.animated
        self._animation.notice(changes)
        # Where nothing has a time, all times are one.
        now = self._asked_time if self._animation.animated else Usd.TimeCode.Default()
        before, self._time = self._time, now
        if self._tree is None or was_animated != self._animation.animated:
            return Plan(structure=True, everything=True, lights=True, skinned=True)
        plan = Planner(self._stage, self._tree, has_points=bool(self._placements.offsets)).plan(changes)
        plan.skinned = self._prototypes.skinning.concerns(self._stage, changes)
        if now != before:
            self._tree.set_time(now)
            self._animation.add_to(plan, now)
            plan.shapes |= self._skinned
        if plan.skinned:
            plan.shapes |= self._skinned
        return plan

    def _note_own_shapes(self) -> None:
        """Gprims whose geometry is not what their specs say alone."""
        skinning = self._prototypes.skinning
        self._skinned = {
            gprim.path for gprim in self._gprims if self._tree.has_skeletons and skinning.is_skinned(gprim.prim)
        }
        self._own = set(self._skinned)
        if self._animation.animated:
            points = bool(self._placements.offsets)
            self._animation.survey(self._tree, self._gprims, points=points, time=self._time)
            self._own |= self._animation.shapes

    def close(self) -> None:
        """Stop listening to the stage."""
        self._tracker.close()

    def _forget_gprims(self, plan: Plan) -> None:
        for table in (self._known, self._stand_ins):
            for path in plan.gprims:
                table.pop(path, None)
            if plan.roots:
                for path in [path for path in table if is_below(path, plan.roots)]:
                    del table[path]

    # What is drawn

    def _read_gprims(self) -> None:
        """Materials of all gprims, and the geometry of those that are new or whose material asks for another UV set."""
        self._bind()
        self._prototypes.begin_pass()
        new = sum(gprim.path not in self._known for gprim in self._gprims)
        done = 0
        for gprim in self._gprims:
            done += gprim.path not in self._known
            self._read_prototype(gprim)
            if self._progress is not None and new:
                self._progress("geometry", done, new)
        self._write_prototypes()
        self._paint()
        self._write_materials()
        self._note_placements()

    def _read_shapes(self, paths: set[Sdf.Path]) -> None:
        """The geometry of some gprims; their materials are what they were."""
        changed = [gprim for gprim in self._gprims if gprim.path in paths]
        for gprim in changed:
            self._known.pop(gprim.path, None)
        if any(gprim.colored for gprim in changed):  # their materials show the triangles that they have now
            self._read_gprims()
            return
        self._prototypes.begin_pass()
        for gprim in changed:
            self._read_prototype(gprim)
        self._write_prototypes()
        self._note_placements()

    def _note_placements(self) -> None:
        placed = self._placements.gprims
        self._nodes = np.array(self._placements.nodes, np.int64)
        self._points = np.array(list(self._placements.offsets), np.int64)
        self._point_matrices = np.array(list(self._placements.offsets.values())).reshape(-1, 4, 4)
        self._has_surface = np.array([self._gprims[k].prototype is not None for k in placed], bool)

    def _bind(self) -> None:
        targets = [prim for gprim in self._gprims for prim in (*gprim.subsets, gprim.prim)]
        bound = iter(bound_materials(targets))
        used: set[Sdf.Path] = set()
        for gprim in self._gprims:
            gprim.materials = []
            gprim.colored = gprim.kind != SHAPE
            for _ in range(len(gprim.subsets) + 1):
                prim = next(bound)
                material = None
                if prim is not None:
                    used.add(prim.GetPath())
                    material = self._library.read(prim)
                gprim.materials.append(self._finished(gprim, material))
            if is_light(gprim.prim):
                gprim.materials = [glowing(material, gprim.prim) for material in gprim.materials]
        self._library.keep_only(used)
        if self._animation.animated:
            self._animation.survey_materials(used)

    def _finished(self, gprim: Gprim, material: Material | None) -> Material:
        """The material, with the gprim's own colour where it asks for that or there is no material."""
        if material is not None and material.from_gprim:
            material = material.of_gprim(gprim.prim, self._time)
        if material is not None and not material.colour_from_gprim:
            gprim.colored = False
            return material
        if gprim.path not in self._stand_ins:
            *mean, varies = display_colour(gprim.prim, self._time)
            self._stand_ins[gprim.path] = stand_in(*mean), varies
        own, varies = self._stand_ins[gprim.path]
        if not varies or (material is not None and material.textures()):
            gprim.colored = False
        return own if material is None else material.with_base_color(own.base_color.value)

    def _read_prototype(self, gprim: Gprim) -> None:
        uv_name = ""
        if gprim.kind == MESH:
            uv_name = next((material.uv_primvar for material in gprim.materials if material.uv_primvar), "")
        known = self._known.get(gprim.path)
        if known is None or known[:2] != (uv_name, gprim.colored):
            if gprim.kind == SHAPE:
                prototype = self._prototypes.shape(gprim.prim, self._time)
            else:
                own = gprim.path in self._own
                prototype = self._prototypes.points(
                    gprim.prim, self._time, uv_name, gprim.subsets, own=own, colored=gprim.colored
                )
            known = self._known[gprim.path] = (uv_name, gprim.colored, prototype)
        gprim.prototype = known[2]

    def _paint(self) -> None:
        """Give gprims their varying colours; those that cannot have them are named."""
        for gprim in self._gprims:
            colors = gprim.prototype is not None and gprim.prototype.corner_colors is not None
            if colors:
                gprim.materials = [self._colors.painted(material, gprim.prototype) for material in gprim.materials]
            elif gprim.path in self._stand_ins and self._stand_ins[gprim.path][1] and gprim.prototype is not None:
                warn_of_mean(gprim.prim)
        self._colors.keep_only(set(self._index_of))
        for use, texture in self._colors.textures():
            self._textures.keep(use, texture)

    def _write_prototypes(self) -> None:
        """Old prototypes keep their order, also idle ones for as long as the cache has them; new ones follow."""
        scene = self.scene
        used = {id(g.prototype): g.prototype for g in self._gprims if g.prototype is not None}
        kept = self._prototypes.forget_idle(used.values())
        prototypes = [prototype for prototype in scene.prototypes if id(prototype) in kept]
        listed = {id(prototype) for prototype in prototypes}
        prototypes += [prototype for number, prototype in used.items() if number not in listed]
        if not _same_objects(scene.prototypes, prototypes):
            scene.prototypes = prototypes
            scene.touch("prototypes")
        self._index_of = {id(prototype): k for k, prototype in enumerate(prototypes)}

    def _write_materials(self) -> None:
        scene, slots = self.scene, self._slots
        table, textures = build_table(slots.assign(self._gprims), self._textures, self._progress)
        if not _same_objects(scene.textures, textures):
            scene.textures = list(textures)
            scene.touch("textures")
        if not np.array_equal(slots.rows, scene.material_slots) or table.tobytes() != scene.materials.tobytes():
            scene.materials, scene.material_slots = table, slots.rows
            scene.touch("materials")

    # Where it is drawn

    def _place(self, *, structure: bool) -> None:
        """Matrices of all instances; those without a usable one are not drawn."""
        placements = self._placements
        world = self._tree.world[self._nodes]
        if len(self._points):
            world[self._points] = stage_tree.matrix_product(self._point_matrices, world[self._points])
        usable = invertible(world)
        for k in np.flatnonzero(self._has_surface & ~usable):
            errors.warn_once(
                f"{placements.paths[k]}: its transform is NaN, infinite or scaled to zero, so it is not drawn. "
                f"Correct the xformOps of it or of a prim above."
            )
        drawn = np.flatnonzero(self._has_surface & usable)
        if structure or not np.array_equal(drawn, self._drawn):
            self._write_instances(drawn)
        scene = self.scene
        if not np.array_equal(scene.instances.local_to_world, world[drawn]):
            scene.instances = replace(scene.instances, local_to_world=world[drawn])
            scene.touch("transforms")

    def _write_instances(self, drawn: np.ndarray) -> None:
        placements, old = self._placements, self.scene.instances
        gprims = [self._gprims[placements.gprims[k]] for k in drawn]
        new = Instances(
            paths=tuple(placements.paths[k] for k in drawn),
            prototype=np.array([self._index_of[id(gprim.prototype)] for gprim in gprims], np.int32),
            local_to_world=old.local_to_world,
            slot_offset=self._slots.begins[np.array(placements.gprims, np.int64)[drawn]],
            casts_shadow=np.array([gprim.casts_shadow for gprim in gprims], np.int32),
        )
        self._drawn = drawn
        columns = ("prototype", "slot_offset", "casts_shadow")
        if old.paths != new.paths or any(not np.array_equal(getattr(old, c), getattr(new, c)) for c in columns):
            self.scene.instances = new
            self.scene.touch("instances")

    # Lights

    def _read_lights(self, *, always: bool) -> None:
        tree = self._tree
        nodes = [node for node in tree.of_kind(stage_tree.LIGHT, DOME)]
        matrices = tree.world[nodes].tobytes()
        instances = self.scene.instances.paths
        same_links = self._linked_instances is None or self._linked_instances is instances
        if not always and same_links and matrices == self._light_matrices:
            return
        self._light_matrices = matrices
        lights = [node for node in nodes if tree.kinds[node] == stage_tree.LIGHT]
        read = read_lights([tree.prims[k] for k in lights], tree.world[lights], meters_per_unit(self._stage), instances)
        read.write(self.scene)
        self._linked_instances = instances if read.linked else None
        domes = [read_dome(tree.prims[node], tree.world[node]) for node in nodes if tree.kinds[node] == DOME]
        present = [dome for dome in domes if dome is not None]
        if present != self._domes:
            self._domes = present
            self.scene.dome = self._dome_builder.build(present)
            self.scene.touch("dome")


def invertible(matrices: np.ndarray) -> np.ndarray:
    """(N,) which (N, 4, 4) matrices are finite and have an inverse, whatever their scale."""
    linear = matrices[:, :3, :3]
    with np.errstate(invalid="ignore", over="ignore"):
        lengths = np.linalg.norm(linear, axis=2)
        volume = np.abs(np.einsum("ni,ni->n", linear[:, 0], np.cross(linear[:, 1], linear[:, 2])))
        return np.isfinite(matrices).all(axis=(1, 2)) & (volume > 1e-9 * lengths.prod(axis=1))


def _same_objects(a: Sequence, b: Sequence) -> bool:
    return len(a) == len(b) and all(x is y for x, y in zip(a, b))

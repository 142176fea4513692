"""Many worlds of one scene on the device: one table of instances, materials and lights for all, and a TLAS for each.

A TLAS for each world, and not one over all of them: rays of a world then meet its own instances only, its trees are
small and are built beside each other, and nothing else of the kernels needs to know of worlds.
"""

from typing import Any

import numpy as np
import warp as wp

from usdsdg.errors import Unsupported
from usdsdg.parallel import launch_rows
from usdsdg_render.bvh.acceleration_structure import tlas_node_dtype
from usdsdg_render.bvh.forest import ForestBuilder
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.device.placement import RECORD, warn_of_singular
from usdsdg_render.kernels.scene.instance_transforms import InstanceTransforms, set_instance_transforms
from usdsdg_render.lights.emissive_instances import find_emissive_instances
from usdsdg_render.memory.frame_memory import FrameMemory, Table
from usdsdg_render.memory.staging_buffer import shared
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import MATERIAL, Scene
from usdsdg_render.scene.struct_rows import copy_rows, dtype_of
from usdsdg_render.scene.worlds import Worlds

# Instances whose matrices one CPU thread writes at a time, at least.
INSTANCES_AT_ONCE = 2048


class DeviceWorlds:
    """Worlds of a scene for kernels; stands for a `DeviceScene` where views say which world they are in."""

    def __init__(self, base: DeviceScene) -> None:
        self.device = base.device
        self._base = base
        self._sizes: tuple[int, ...] = ()
        self._materials = 0  # for how many there is memory
        self.tables = structs.SceneTables()
        self.lit = self.has_local_and_environment_light = self.has_glass = False

    @property
    def supports(self) -> Any:
        """Support functions of the instances of a world."""
        return self._base.supports

    def place(self, scene: Scene, worlds: Worlds) -> None:
        """Upload worlds of a scene that the base is in sync with.

        Raises:
            Unsupported: an instance is an area light by its material.
        """
        if find_emissive_instances(scene):
            raise Unsupported(
                "worlds: a mesh emits light, which worlds cannot sample. Use a light, or render without worlds."
            )
        count, instances = worlds.shown.shape
        lights, surface_count = self._base.lights.rows_of(scene, worlds.lights)
        materials = len(scene.materials) + worlds.own_materials.size
        sizes = (count, instances, worlds.material_slots.size, lights.size)
        if sizes != self._sizes or materials > self._materials:
            # The table of materials grows and shrinks with what is in view.
            self._sizes, self._materials = sizes, materials + materials // 4
            self._fit(count, instances, self._materials, worlds.material_slots.size, lights.size)
        memory = self._memory
        memory.begin()
        self._place_instances(scene, worlds)
        rows, own = memory.host("materials"), len(scene.materials)
        copy_rows(rows[:own], scene.materials)
        copy_rows(rows[own:materials], worlds.own_materials.reshape(-1))
        memory.host("slots")[:] = worlds.material_slots.reshape(-1)
        copy_rows(memory.host("lights"), lights.reshape(-1))
        self._fill_worlds(scene, worlds)
        memory.upload()
        self._fill_tables(worlds, surface_count)

    def _fit(self, count: int, instances: int, materials: int, slots: int, lights: int) -> None:
        total, node = count * instances, tlas_node_dtype(self.device)
        self._memory = FrameMemory(
            {
                "nodes": Table(total, node.base, None, node.shape),
                "instances": Table(total, RECORD, structs.Instance),
                "order": Table(total, np.int32, wp.int32),
                "materials": Table(materials, MATERIAL, structs.Material),
                "slots": Table(slots, np.int32, wp.int32),
                "lights": Table(lights, dtype_of(structs.Light), structs.Light),
                "worlds": Table(count, dtype_of(structs.World), structs.World),
            },
            self.device,
        )
        self._written: dict[int, tuple[int, int]] = {}  # what the instances were last written from, by turn
        self._forest = ForestBuilder(count, instances, self.device)
        self._invertible = np.zeros(total, np.uint8)

    def _place_instances(self, scene: Scene, worlds: Worlds) -> None:
        """Write the records of instances and the trees over them."""
        count, instances = worlds.shown.shape
        base, memory = self._base.placement, self._memory
        rows = memory.host("instances").reshape(count, instances)
        slots_of_world = worlds.material_slots.shape[1]
        if self._written.get(memory.turn) != (base.version, slots_of_world):
            # All but the transforms, which are written for every frame.
            self._written[memory.turn] = (base.version, slots_of_world)
            copy_rows(rows, np.broadcast_to(base.rows, rows.shape))
            rows["slot_offset"] += (np.arange(count, dtype=np.int32) * slots_of_world)[:, None]
        matrices = np.ascontiguousarray(worlds.local_to_world).reshape(-1, 4, 4)
        prototype = np.tile(base.prototype, count)
        transforms = InstanceTransforms()
        transforms.matrices, transforms.prototype = shared(matrices, wp.mat44d), shared(prototype, wp.int32)
        transforms.supports = shared(base.supports.reshape(len(base.supports), -1), wp.float64)
        transforms.instances = shared(rows.reshape(-1), structs.Instance)
        transforms.lower = shared(self._forest.lower, wp.vec3)
        transforms.upper = shared(self._forest.upper, wp.vec3)
        transforms.invertible = shared(self._invertible, wp.uint8)
        size = (count * instances,)
        launch_rows(set_instance_transforms, size, [transforms], [], device="cpu", band_rows=INSTANCES_AT_ONCE)
        warn_of_singular(self._invertible.reshape(count, instances).all(0), scene.instances.paths)
        placed = self._invertible.reshape(count, instances).astype(bool) & base.filled & worlds.shown
        self._placed = self._forest.build(placed, memory.host("nodes"), memory.host("order"))

    def _fill_worlds(self, scene: Scene, worlds: Worlds) -> None:
        count, memory = len(worlds), self._memory
        rows, numbers = memory.host("worlds"), np.arange(count)
        rows["nodes"] = memory.address("nodes") + numbers * self._forest.node_bytes
        rows["instance_count"] = self._placed
        rows["first_instance"] = numbers * worlds.shown.shape[1]
        of_world = worlds.lights.shape[1] * dtype_of(structs.Light).itemsize
        rows["lights"] = memory.address("lights") + numbers * of_world
        unit, strength = self._base.dome_light(scene, worlds.dome_color)
        rows["unit"], rows["strength"] = unit, strength
        rows["dome_from_world"] = worlds.dome_from_world

    def _fill_tables(self, worlds: Worlds, surface_count: int) -> None:
        base, memory = self._base.tables, self._memory
        tables: Any = structs.SceneTables()
        for name in ("textures", "texel_values", "albedo_table", "instance_light", "dome"):
            setattr(tables, name, getattr(base, name))
        tables.worlds = memory.device("worlds")
        tables.tlas.nodes = memory.address("nodes")
        tables.tlas.instances, tables.tlas.order = memory.device("instances"), memory.device("order")
        tables.tlas.instance_count = int(self._placed.max(initial=0))
        tables.slots, tables.materials = memory.device("slots"), memory.device("materials")
        tables.lights, tables.light_count = memory.device("lights"), worlds.lights.shape[1]
        tables.surface_count, tables.emissive_count = surface_count, 0
        tables.cutouts = base.cutouts
        self.tables = tables
        lights, strength = memory.host("lights"), memory.host("worlds")["strength"]
        distant = lights["kind"] == structs.LIGHT_DISTANT
        local = bool((lights["strength"][~distant] > 0).any())
        far = bool((lights["strength"][distant] > 0).any()) or bool((strength > 0).any())
        self.lit, self.has_local_and_environment_light = local or far, local and far
        self.has_glass = self._base.has_glass

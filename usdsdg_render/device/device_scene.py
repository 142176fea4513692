"""The scene on the device: tables of `scene.Scene` for kernels, uploaded again where they changed."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from usdsdg.stage.colors import srgb_to_linear
from usdsdg_render.bvh.acceleration_structure import Blas
from usdsdg_render.device.albedo_table import albedo_table
from usdsdg_render.device.light_tables import LightTables
from usdsdg_render.device.placement import Placement
from usdsdg_render.geometry.support_function import SUPPORT_SHAPE, support_table
from usdsdg_render.kernels.scene.support_function import SupportFunctions
from usdsdg_render.lights.environment import EnvironmentMaps
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import TEXELS_HALF, TEXELS_RAW, TEXELS_SHORT, TEXELS_SRGB, Prototype, Scene, Texture
from usdsdg_render.scene.struct_rows import records, uploaded

# Flags of structs.Texture.special, read by lookup.cpp.
ADJUSTED, TILED = 1, 2


class _PrototypeMemory:
    """Device memory of one prototype: triangle records and BLAS.

    Args:
        like: of a prototype with the same points and triangles, which has the same BLAS.
    """

    def __init__(self, prototype: Prototype, device: str, like: _PrototypeMemory | None) -> None:
        self.prototype = prototype  # keeps its id from being reused
        self.triangles = uploaded(_triangle_records(prototype), structs.Triangle, device)
        if like is not None:
            self.blas, self.support = like.blas, like.support
        else:
            self.blas = Blas(prototype.points, prototype.triangles, device)
            used = np.zeros(len(prototype.points), bool)
            used[prototype.triangles] = True
            self.support = support_table(prototype.points[used])
        self.slots = int(prototype.triangle_slots.max(initial=0)) + 1  # material slots of an instance


class DeviceScene:
    """Uploads a `Scene` and keeps alive what its tables point to. Instances keep their row numbers."""

    def __init__(self, device: str) -> None:
        self.device = device
        self.tables = structs.SceneTables()
        self.tables.texel_values = self._array(_texel_values(), wp.float32)
        self.tables.albedo_table = self._array(albedo_table().reshape(-1, 2), wp.vec2)
        self._versions: dict[str, int] = {}
        self._prototypes: dict[int, _PrototypeMemory] = {}
        self._textures: dict[int, tuple[Texture, wp.array]] = {}
        self._tile_tables: list[wp.array] = []
        self._cutouts = np.zeros(0, bool)  # of each instance
        self._transparent = np.zeros(0, bool)  # of each material
        self._has_emission = False
        self._materials: wp.array | None = None
        self._slots = np.zeros(0, np.int32)
        self.lit = False  # whether anything emits light
        self.has_local_and_environment_light = False
        self.has_glass = False
        self.lights = LightTables(device)
        self._environment = EnvironmentMaps(device)
        self.placement = Placement(device)
        self.supports = SupportFunctions()

    def sync(self, scene: Scene) -> None:
        """Upload what changed in `scene` since the last call."""
        changed = {key for key, version in scene.versions.items() if self._versions.get(key) != version}
        if "textures" in changed:
            self._upload_textures(scene)
        if "materials" in changed:
            self._upload_materials(scene)
        if "prototypes" in changed:
            self._upload_prototypes(scene)
        cutouts, slots = self._cutouts, self._slots
        if changed & {"prototypes", "instances", "materials"}:
            self._cutouts = self._find_cutouts(scene)
        # Materials concern the records of instances only by what rays may pass through.
        replaced = bool(changed & {"prototypes", "instances"}) or not np.array_equal(cutouts, self._cutouts)
        if replaced:
            self._upload_instances(scene)
        if not np.array_equal(slots, scene.material_slots):
            self._slots = scene.material_slots.copy()
            self.tables.slots = self._array(self._slots, wp.int32)
        if "transforms" in changed or replaced:
            self.set_transforms(scene, scene.instances.local_to_world)
        if "lights" in changed or ((self._has_emission or self.tables.emissive_count > 0) and changed):
            self.lights.upload(scene, self.tables)
        if "dome" in changed:
            self.tables.dome = self._environment.upload(scene.dome)
        # Where there is no dome it is a number of Warp's, which takes 0.2 ms to be added to.
        far = self.lights.distant_strength + float(self.tables.dome.strength)
        self.lit = self._has_emission or self.lights.local_strength + far > 0
        self.has_local_and_environment_light = self.lights.local_strength > 0 and far > 0
        self._versions = dict(scene.versions)

    def _array(self, values: np.ndarray, dtype: Any) -> wp.array:
        return wp.array(values, dtype=dtype, device=self.device)

    def _upload_textures(self, scene: Scene) -> None:
        """Upload rows of the scene's textures, followed by rows of their tiles."""
        tiles = [tile for texture in scene.textures for _, tile in texture.tiles]
        rows = records(structs.Texture, len(scene.textures) + len(tiles))
        kept = {}
        for row, texture in zip(rows, [*scene.textures, *tiles], strict=True):
            held = kept.get(id(texture.texels)) or self._textures.get(id(texture.texels))
            if held is None:
                held = (texture, self._texel_memory(texture.texels))
            kept[id(texture.texels)] = held
            fill_texture(row, texture)
            row["texels"] = held[1].ptr
        self._textures = kept
        self._tile_tables = _tile_tables(scene.textures, rows, self.device)
        self.tables.textures = uploaded(rows, structs.Texture, self.device)

    def _texel_memory(self, texels: np.ndarray) -> wp.array:
        """Upload texels; on a CPU the kernels read the decoded image itself."""
        words = np.ascontiguousarray(texels).view(np.uint32).reshape(-1)
        return wp.array(words, dtype=wp.uint32, device=self.device, copy=self.device != "cpu")

    def _upload_materials(self, scene: Scene) -> None:
        materials = scene.materials
        self._materials = uploaded(materials, structs.Material, self.device, into=self._materials)
        self.tables.materials = self._materials
        self._transparent = _may_be_transparent(materials)
        self.tables.cutouts = int(self._transparent.any())
        self.has_glass = bool((materials["transmission"] > 0).any())
        self._has_emission = bool((materials["emission"] > 0).any())

    def _upload_prototypes(self, scene: Scene) -> None:
        kept = {}
        # Meshes on which something else is painted keep the arrays of their triangles.
        of_triangles = {id(memory.prototype.triangles): memory for memory in self._prototypes.values()}
        for prototype in scene.prototypes:
            key, triangles = id(prototype), id(prototype.triangles)
            if len(prototype.triangles):
                memory = self._prototypes.get(key)
                memory = memory or _PrototypeMemory(prototype, self.device, of_triangles.get(triangles))
                kept[key] = of_triangles[triangles] = memory
        self._prototypes = kept

    def _find_cutouts(self, scene: Scene) -> np.ndarray:
        """Return for each instance whether rays may pass through a part of it."""
        instances = scene.instances
        if not self._transparent.any():
            return np.zeros(len(instances.prototype), bool)
        memories = [self._prototypes.get(id(prototype)) for prototype in scene.prototypes]
        slots = np.array([0 if memory is None else memory.slots for memory in memories], np.int64)
        return _any_of(self._transparent[scene.material_slots], instances.slot_offset, slots[instances.prototype])

    def _upload_instances(self, scene: Scene) -> None:
        """Upload the instances' records, without their transforms."""
        instances = scene.instances
        memories = [self._prototypes.get(id(prototype)) for prototype in scene.prototypes]
        parts = records(structs.Instance, len(memories))
        supports = np.zeros((len(memories), *SUPPORT_SHAPE))
        for k, memory in enumerate(memories):
            if memory is not None:
                parts[k]["triangles"] = memory.triangles.ptr
                parts[k]["nodes"], parts[k]["blocks"] = memory.blas.nodes, memory.blas.blocks
                supports[k] = memory.support
        rows = parts[instances.prototype]
        rows["slot_offset"] = instances.slot_offset
        rows["casts_shadow"] = instances.casts_shadow
        rows["cutout"] = self._cutouts
        filled = np.array([memory is not None for memory in memories], bool)[instances.prototype]
        self.placement.set_instances(rows, instances.prototype, supports, filled)
        self.supports.values = self._array(supports.reshape(len(memories), int(np.prod(SUPPORT_SHAPE))), wp.float32)
        self.supports.prototype = self._array(instances.prototype, wp.int32)

    def dome_light(self, scene: Scene, colors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return for (N, 3) colors of the dome its units (N, 3) and strengths (N,); zeros where there is no dome."""
        return self._environment.light_of(scene.dome, colors)

    def set_transforms(self, scene: Scene, local_to_world: np.ndarray) -> None:
        """Set the transforms of instances, (N, 4, 4) as in `Instances`: those of the scene, or interpolated ones."""
        self.placement.set_transforms(self.tables.tlas, local_to_world, scene.instances.paths)


def fill_texture(row: Any, texture: Texture) -> None:
    """Fill a texture's record, without the addresses of its texels and tiles."""
    row["height"], row["width"] = texture.texels.shape[:2]
    row["format"] = {"uint16": TEXELS_SHORT, "float16": TEXELS_HALF}.get(
        texture.texels.dtype.name, TEXELS_SRGB if texture.srgb else TEXELS_RAW
    )
    row["wrap_s"], row["wrap_t"] = texture.wrap_s, texture.wrap_t
    row["u_row"], row["v_row"] = texture.transform
    row["scale"], row["bias"] = texture.scale, texture.bias
    adjusted = any(factor != 1.0 for factor in texture.scale) or any(texture.bias)
    row["special"] = (ADJUSTED if adjusted else 0) + (TILED if texture.tiles else 0)


def _tile_tables(textures: list[Texture], rows: np.ndarray, device: str) -> list[wp.array]:
    """Upload the tile tables of tiled textures, and write their addresses into the records."""
    tables = []
    next_row = len(textures)
    for k, texture in enumerate(textures):
        if not texture.tiles:
            continue
        tile_rows = max(slot for slot, _ in texture.tiles) // 10 + 1
        # Outside of its tiles the texture's own texels are read.
        table = np.full(10 * tile_rows + 1, k, np.int32)
        table[[slot for slot, _ in texture.tiles]] = np.arange(next_row, next_row + len(texture.tiles))
        next_row += len(texture.tiles)
        tables.append(wp.array(table, dtype=wp.int32, device=device))
        rows[k]["tiles"], rows[k]["tile_rows"] = tables[-1].ptr, tile_rows
    return tables


def _triangle_records(prototype: Prototype) -> np.ndarray:
    rows = records(structs.Triangle, len(prototype.triangles))
    corners = prototype.points[prototype.triangles]
    for k in range(3):
        rows[f"p{k}"] = corners[:, k]
        rows[f"n{k}"] = prototype.normals[:, k]
        rows[f"uv{k}"] = prototype.uvs[:, k]
    rows["slot"] = prototype.triangle_slots
    rows["face"] = prototype.triangle_faces
    return rows


def _may_be_transparent(rows: np.ndarray) -> np.ndarray:
    """Return for each material whether rays may pass through it."""
    return (rows["opacity"] < 1.0) | (rows["opacity_texture"] >= 0) | (rows["transmission"] > 0.0)


def _any_of(flags: np.ndarray, first: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Return for each row whether any of `flags[first : first + count]` is set."""
    running = np.append(0, np.cumsum(flags))
    return running[first + count] > running[first]


def _texel_values() -> np.ndarray:
    """Return the linear value of each 8-bit texel: 256 for images in sRGB, then 256 for raw ones."""
    raw = np.arange(256) / 255.0
    return np.concatenate([srgb_to_linear(raw), raw]).astype(np.float32)

"""Values of attributes in many worlds to `scene.worlds.Worlds`, from what has been read of the stage itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.errors import Unsupported
from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg.stage.world_values import WorldValues
from usdsdg_render.lights.world_lights import lights_in_worlds
from usdsdg_render.materials.display_color import DisplayColor
from usdsdg_render.materials.shading import MAX_COLOR
from usdsdg_render.materials.world_materials import WorldMaterials
from usdsdg_render.scene.scene import Scene
from usdsdg_render.scene.worlds import Worlds
from usdsdg_render.sync.gprims import Gprim, Gprims
from usdsdg_render.sync.instance_table import InstanceTable
from usdsdg_render.usd.prim_kinds import DOME, LIGHT
from usdsdg_render.usd.stage_tree import StageTree
from usdsdg_render.usd.world_transforms import WorldTransforms

COLOR = "primvars:displayColor"


class Parts(NamedTuple):
    """What has been read of a stage."""

    stage: Usd.Stage
    scene: Scene
    tree: StageTree
    gprims: Gprims
    instances: InstanceTable
    first_slots: Mapping[Sdf.Path, int]
    materials: WorldMaterials


class _Columns(NamedTuple):
    """Columns of the material of some slots in all worlds."""

    slots: list[int]
    columns: dict[str, np.ndarray]  # (worlds, ...) by name


def read_worlds(parts: Parts, values: WorldValues) -> tuple[Worlds, WorldTransforms]:
    """Return what differs between worlds, and the transforms of all prims.

    Raises:
        Unsupported: the values of an attribute cannot differ between worlds; names what has drawn them.
    """
    tree, scene = parts.tree, parts.scene
    transforms = tree.in_worlds(values)
    nodes = tree.of_kind(LIGHT, DOME)
    prims = [tree.prims[node] for node in nodes]
    lights = lights_in_worlds(scene, values, prims, transforms.at(np.array(nodes)), meters_per_unit(parts.stage))
    hidden = _hidden(values)
    for path, visible in hidden.items():
        for prim in prims:
            if prim.GetPath().HasPrefix(path) and not visible.all():
                error = Unsupported("a light cannot be hidden in worlds, but its intensity can be 0")
                raise values.refusal(prim.GetPath(), error)
    materials, slots = _materials(parts, values)
    worlds = Worlds(
        local_to_world=parts.instances.in_worlds(transforms),
        shown=_shown(scene.instances.paths, hidden, values.count),
        materials=materials,
        material_slots=slots,
        lights=lights.table,
        dome_color=lights.dome_color,
        dome_from_world=lights.dome_from_world,
    )
    return worlds, transforms


def _hidden(values: WorldValues) -> dict[Sdf.Path, np.ndarray]:
    """By path, in which worlds (worlds,) a prim and those below it are shown."""
    return {path: own["visibility"] for path, own in values.values.items() if "visibility" in own}


def _shown(paths: tuple[str, ...], visible: Mapping[Sdf.Path, np.ndarray], count: int) -> np.ndarray:
    shown = np.ones((count, len(paths)), bool)
    for path, column in visible.items():
        above = f"{path}/"
        rows = [k for k, each in enumerate(paths) if each == str(path) or each.startswith(above)]
        shown[:, rows] &= column[:, None]
    return shown


def _materials(parts: Parts, values: WorldValues) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of all materials, of the scene and then of the worlds, and (worlds, slots) int32 of these."""
    scene, count = parts.scene, values.count
    edits = _edits(parts, values)
    edited = sorted({slot for edit in edits for slot in edit.slots})
    place = {slot: k for k, slot in enumerate(edited)}
    own = np.tile(scene.materials[scene.material_slots[edited]], (count, 1))
    for edit in edits:
        where = [place[slot] for slot in edit.slots]
        for name, column in edit.columns.items():
            own[name][:, where] = column[:, None]
    slots = np.tile(scene.material_slots, (count, 1))
    numbers = np.arange(count * len(edited), dtype=np.int32).reshape(count, len(edited))
    slots[:, edited] = len(scene.materials) + numbers
    rows = np.empty(len(scene.materials) + own.size, scene.materials.dtype)
    rows[: len(scene.materials)], rows[len(scene.materials) :] = scene.materials, own.reshape(-1)
    return rows, slots


def _edits(parts: Parts, values: WorldValues) -> list[_Columns]:
    """Return the columns of materials that differ; the last ones win."""
    by_material: dict[Sdf.Path, list[int]] = {}
    by_path: dict[Sdf.Path, Gprim] = {}
    for gprim in parts.gprims.drawn:
        by_path[gprim.path] = gprim
        for k, bound in enumerate(gprim.bound):
            if bound is not None:
                by_material.setdefault(bound, []).append(parts.first_slots[gprim.path] + k)
    edits = []
    for path, all_values in values.values.items():
        own = {
            name: column
            for name, column in all_values.items()
            if not name.startswith("xformOp:") and name != "visibility"
        }
        prim = parts.stage.GetPrimAtPath(path)
        if not own or parts.tree.kind_at(path) in (LIGHT, DOME):
            continue
        try:
            if prim.IsA(UsdShade.Shader):
                edits += _shader_edits(parts, path, own, by_material)
            elif list(own) == [COLOR] and UsdGeom.Gprim(prim):
                if path in by_path:
                    edits.append(_color_edit(parts, by_path[path], own[COLOR]))
            else:
                raise Unsupported(f"{path}: {', '.join(own)} cannot differ between worlds")
        except Unsupported as error:
            raise values.refusal(path, error) from None
    return edits


def _shader_edits(
    parts: Parts, shader: Sdf.Path, own: dict[str, np.ndarray], by_material: Mapping[Sdf.Path, list[int]]
) -> list[_Columns]:
    material = next((path for path in reversed(shader.GetPrefixes()) if path in by_material), None)
    if material is None:
        return []  # bound to nothing that is drawn
    slots = by_material[material]
    row = parts.scene.materials[parts.scene.material_slots[slots[0]]]
    columns = parts.materials.columns(parts.stage, material, shader, own, row)
    return [_Columns(slots, columns)] if columns else []


def _color_edit(parts: Parts, gprim: Gprim, colors: np.ndarray) -> _Columns:
    """Return the columns of a gprim's own color, (worlds, 1, 3)."""
    materials = gprim.materials or []
    if colors.shape[1] != 1 or not gprim.is_plain:
        raise Unsupported(f"{gprim.path}: colors that vary over a gprim cannot differ between worlds")
    first = parts.first_slots[gprim.path]
    slots = [first + k for k, each in enumerate(materials) if isinstance(each, DisplayColor)]
    return _Columns(slots, {"base_color": np.clip(colors[:, 0].astype(np.float64), 0.0, MAX_COLOR)})

"""Materials in many worlds: rows of their own for the slots whose materials differ."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.errors import Unsupported
from usdsdg.stage.world_values import WorldValues
from usdsdg_render.materials.display_color import DisplayColor
from usdsdg_render.materials.world_materials import DISPLAY_COLOR, Rule, rule_of
from usdsdg_render.scene.scene import NO_TEXTURE, Scene
from usdsdg_render.scene.struct_rows import copy_rows
from usdsdg_render.sync.gprims import Gprim, Gprims
from usdsdg_render.usd.color_spaces import refuse_other_space
from usdsdg_render.usd.prim_kinds import DOME, LIGHT
from usdsdg_render.usd.stage_tree import StageTree

COLOR = "primvars:displayColor"
# Difference of a column between 32 bits and 64.
_ROUNDING = 1e-4
Key = tuple[Sdf.Path, str]  # prim and name of an attribute


class _Group(NamedTuple):
    """Attributes that become one column by one rule."""

    rule: Rule
    constants: np.ndarray  # (attributes, numbers)
    keys: list[Key]
    sources: np.ndarray  # for each row that they fill, which of the attributes does
    rows: np.ndarray  # those rows, among the rows of one world


class _Plan(NamedTuple):
    """What fills which rows, as long as the same attributes differ and the same materials are bound."""

    basis: tuple
    slots: np.ndarray  # those with rows of their own
    groups: list[_Group]


class WorldSlots:
    """Keeps the plan of one stage from step to step."""

    def __init__(self) -> None:
        self._plan: _Plan | None = None

    def read(
        self, stage: Usd.Stage, scene: Scene, tree: StageTree, gprims: Gprims, first: Mapping[Sdf.Path, int],
        values: WorldValues,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Return rows (worlds, rows) of `scene.MATERIAL` beside those of the scene, and (worlds, slots) int32.

        Rows are numbered from those of the scene on, world by world.

        Raises:
            Unsupported: the values of an attribute cannot differ between worlds; names what has drawn them.
        """
        keys = [(path, name) for path, own in values.values.items() for name in own if _is_other(name)]
        keys = [key for key in keys if tree.kind_at(key[0]) not in (LIGHT, DOME)]
        basis = (keys, [gprim.bound for gprim in gprims.drawn], dict(first))
        plan = self._plan
        if plan is None or plan.basis != basis or not _agrees(plan, scene, values):
            basis = (keys, [list(gprim.bound) for gprim in gprims.drawn], dict(first))
            plan = self._plan = _planned(basis, stage, scene, gprims, first, values)
        own = np.empty((values.count, len(plan.slots)), scene.materials.dtype)
        base = scene.materials[scene.material_slots[plan.slots]]
        copy_rows(own, np.broadcast_to(base, own.shape))
        for group in plan.groups:
            own[group.rule.column][:, group.rows] = _converted(group, values)[:, group.sources]
        slots = np.empty((values.count, len(scene.material_slots)), np.int32)
        slots[:] = scene.material_slots
        slots[:, plan.slots] = len(scene.materials) + np.arange(own.size).reshape(own.shape)
        return own, slots


def _is_other(name: str) -> bool:
    return name != "visibility" and not name.startswith("xformOp:")


def _converted(group: _Group, values: WorldValues, world: slice = slice(None)) -> np.ndarray:
    """(worlds, attributes, ...) the column of a group of attributes."""
    columns = [values.values[path][name][world] for path, name in group.keys]
    stacked = np.stack(columns, 1).astype(np.float64)
    return group.rule.convert(stacked[:, :, 0] if group.rule is DISPLAY_COLOR else stacked, group.constants)


def _agrees(plan: _Plan, scene: Scene, values: WorldValues) -> bool:
    """Whether the plan gives for world 0 what the stage shows; else other inputs of the shaders have changed."""
    shown = scene.materials[scene.material_slots[plan.slots]]
    return all(
        np.abs(_converted(group, values, slice(1))[0][group.sources] - shown[group.rule.column][group.rows]).max()
        < _ROUNDING
        for group in plan.groups
    )


def _planned(
    basis: tuple, stage: Usd.Stage, scene: Scene, gprims: Gprims, first: Mapping[Sdf.Path, int], values: WorldValues
) -> _Plan:
    by_material: dict[Sdf.Path, list[int]] = {}
    by_path: dict[Sdf.Path, Gprim] = {}
    for gprim in gprims.drawn:
        by_path[gprim.path] = gprim
        for k, bound in enumerate(gprim.bound):
            if bound is not None:
                by_material.setdefault(bound, []).append(first[gprim.path] + k)
    found: dict[Rule, list[tuple[Key, tuple[float, ...], list[int]]]] = {}
    for path, name in basis[0]:
        try:
            prim = stage.GetPrimAtPath(path)
            refuse_other_space(prim.GetAttribute(name))
            if prim.IsA(UsdShade.Shader):
                material = next((each for each in reversed(path.GetPrefixes()) if each in by_material), None)
                rule = None if material is None else rule_of(stage, material, path, name)
                if material is None or rule is None:
                    continue  # bound to nothing that is drawn, or not read
                entry = ((path, name), rule[1], by_material[material])
                found.setdefault(rule[0], []).append(entry)
                _check_textures(scene, rule[0], entry)
            elif name == COLOR and UsdGeom.Gprim(prim):
                if path in by_path:
                    slots = _color_slots(by_path[path], first[path], values.values[path][name])
                    found.setdefault(DISPLAY_COLOR, []).append(((path, name), (), slots))
            else:
                raise Unsupported(f"{path}: {name} cannot differ between worlds")
        except Unsupported as error:
            raise values.refusal(path, error) from None
    slots = sorted({slot for entries in found.values() for *_, own in entries for slot in own})
    place = {slot: k for k, slot in enumerate(slots)}
    groups = [
        _Group(
            rule,
            np.array([constants for _, constants, _ in entries]),
            [key for key, *_ in entries],
            np.array([k for k, (*_, own) in enumerate(entries) for _ in own], np.int64),
            np.array([place[slot] for *_, own in entries for slot in own], np.int64),
        )
        for rule, entries in found.items()
    ]
    return _Plan(basis, np.array(slots, np.int64), [group for group in groups if len(group.rows)])


def _check_textures(scene: Scene, rule: Rule, entry: tuple[Key, tuple[float, ...], list[int]]) -> None:
    rows = scene.materials[scene.material_slots[entry[2]]]
    if (rows[f"{rule.column}_texture"] != NO_TEXTURE).any():
        path, name = entry[0]
        raise Unsupported(f"{path}: {name} cannot differ between worlds, since a texture is read")


def _color_slots(gprim: Gprim, first: int, colors: np.ndarray) -> list[int]:
    """Return the slots that show a gprim's own color, (worlds, 1, 3)."""
    if colors.shape[1] != 1 or not gprim.is_plain:
        raise Unsupported(f"{gprim.path}: colors that vary over a gprim cannot differ between worlds")
    return [first + k for k, each in enumerate(gprim.materials or ()) if isinstance(each, DisplayColor)]

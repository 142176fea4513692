"""Values of attributes in many worlds to `scene.worlds.Worlds`, from what has been read of the stage itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd

from usdsdg.errors import Unsupported
from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg.stage.world_values import WorldValues
from usdsdg_render.lights.world_lights import lights_in_worlds
from usdsdg_render.scene.scene import Scene
from usdsdg_render.scene.worlds import Worlds
from usdsdg_render.sync.gprims import Gprims
from usdsdg_render.sync.instance_table import InstanceTable
from usdsdg_render.sync.world_slots import WorldSlots
from usdsdg_render.usd.prim_kinds import DOME, LIGHT
from usdsdg_render.usd.stage_tree import StageTree
from usdsdg_render.usd.world_transforms import WorldTransforms


class Parts(NamedTuple):
    """What has been read of a stage."""

    stage: Usd.Stage
    scene: Scene
    tree: StageTree
    gprims: Gprims
    instances: InstanceTable
    first_slots: Mapping[Sdf.Path, int]
    slots: WorldSlots


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
    own, slots = parts.slots.read(parts.stage, scene, tree, parts.gprims, parts.first_slots, values)
    worlds = Worlds(
        local_to_world=parts.instances.in_worlds(transforms),
        shown=_shown(scene.instances.paths, hidden, values.count),
        own_materials=own,
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

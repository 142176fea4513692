"""Pushes and sleep of single bodies, which the interfaces of `omni.physx` have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Sdf

from usdsdg.compat.carb import Float3, Float4
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.physics_schema_tools import intToSdfPath
from usdsdg.compat.wrappers import poses
from usdsdg.errors import ArgumentError
from usdsdg.session import engines
from usdsdg.session.stage_context import current_stage

_MODES = ("Force", "Impulse")


def push_at(path: str | Sdf.Path, force: Any, position: Any, mode: str) -> None:
    """Push a body during the next step at a point of the world.

    Raises:
        ArgumentError: `mode` is not one that PhysX takes for a force at a point.
        PhysicsError: physics does not play, or the path is no rigid body.
    """
    if mode not in _MODES:
        raise ArgumentError(
            f"{path}: a force at a point is a 'Force' or an 'Impulse', not {mode!r}; multiply it by the body's mass"
        )
    forces = np.array([_vector(force)])
    if mode == "Impulse":
        forces = forces / simulation().scene().get_dt()
    engines.physics().apply_forces([str(path)], forces, positions=np.array([_vector(position)]))


class BodyCommands:
    """Commands of the simulation interface; bodies are integers of `PhysicsSchemaTools.sdfPathToInt`.

    `stage_id` is not looked at, since one stage is simulated.
    """

    def apply_force_at_pos(self, stage_id: int, body_path: int, force: Any, pos: Any, mode: str = "Force") -> None:
        """Push a body during the next step at a point of the world; see `push_at`.

        Args:
            force: (3,) world, in the stage's units of mass, length and s⁻²; with the mode "Impulse" in s⁻¹.
            pos: (3,) world [stage units].
        """
        push_at(intToSdfPath(body_path), force, pos, mode)

    def apply_torque(self, stage_id: int, body_path: int, torque: Any) -> None:
        """Turn a body during the next step: (3,) world, in the stage's units of mass, length² and s⁻².

        Raises:
            PhysicsError: physics does not play, or the path is no rigid body.
        """
        engines.physics().apply_forces([str(intToSdfPath(body_path))], None, np.array([_vector(torque)]))

    def wake_up(self, stage_id: int, body_path: int) -> None:
        """Let a body move again.

        Raises:
            PhysicsError: physics does not play.
        """
        engines.physics().wake_up([str(intToSdfPath(body_path))])

    def put_to_sleep(self, stage_id: int, body_path: int) -> None:
        """Stop a body and hold it until something touches it.

        Raises:
            PhysicsError: physics does not play.
        """
        engines.physics().put_to_sleep([str(intToSdfPath(body_path))])


def transformation_of(path: str | Sdf.Path) -> dict[str, Any]:
    """Return {"ret_val": False}, or True with "position" and "rotation" (x, y, z, w) of a simulated body."""
    physics = engines.physics_if_made()
    if physics is None or str(path) not in physics.rigid_bodies:
        return {"ret_val": False}
    positions, turns = poses.world_poses([current_stage().GetPrimAtPath(str(path))])
    w, x, y, z = turns[0].tolist()
    return {"ret_val": True, "position": Float3(*positions[0].tolist()), "rotation": Float4(x, y, z, w)}


def _vector(values: Any) -> list[float]:
    """Return three numbers of a carb.Float3, Gf.Vec3f or sequence."""
    numbers: Sequence[float] = [values.x, values.y, values.z] if hasattr(values, "x") else values
    return [float(each) for each in numbers]

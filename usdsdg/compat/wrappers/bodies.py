"""Velocities, masses and switches of rigid bodies on the stage, as arrays with one row per prim.

Velocities are world vectors, as physics reads and writes them: linear ones in stage units per second.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdPhysics

from usdsdg.compat.wrappers import poses
from usdsdg.compat.wrappers.runtime_values import keep_until_stop
from usdsdg.session import engines
from usdsdg.stage.physics.rigid_bodies import apply_rigid_body_schemas
from usdsdg.stage.poses.rotations import matrix_from_quat


def make_rigid(prims: Iterable[Usd.Prim]) -> None:
    """Apply the schemas of rigid bodies."""
    for prim in prims:
        apply_rigid_body_schemas(prim)


def is_simulating() -> bool:
    """Whether physics has begun to simulate the current stage."""
    physics = engines.physics_if_made()
    return physics is not None and physics.is_playing


def place_links() -> None:
    """Let links be where their bases were just put, on the stage too, and not only after the next step."""
    physics = engines.physics_if_made()
    if physics is not None and physics.is_playing:
        physics.read_edits()


def set_velocities(prims: Sequence[Usd.Prim], linear: np.ndarray | None, angular: np.ndarray | None) -> None:
    """Author linear (N, 3) and angular velocities (N, 3) [rad/s]; None keeps what is there."""
    for index, prim in enumerate(prims):
        body = UsdPhysics.RigidBodyAPI(prim)
        if linear is not None:
            body.CreateVelocityAttr().Set(Gf.Vec3f(*linear[index].tolist()))
        if angular is not None:
            body.CreateAngularVelocityAttr().Set(Gf.Vec3f(*np.degrees(angular[index]).tolist()))


def push(
    prims: Sequence[Usd.Prim],
    forces: np.ndarray | None,
    torques: np.ndarray | None,
    positions: np.ndarray | None,
    *,
    local: bool = False,
) -> None:
    """Push bodies during the next physics step; see `apply_forces` of the physics engine.

    Args:
        local: The rows are in the bodies' own axes, positions from their origins.

    Raises:
        PhysicsError: physics does not play.
    """
    if local:
        origins, turns = poses.world_poses(prims)
        axes = matrix_from_quat(poses.xyzw(turns))
        forces, torques, positions = (
            None if rows is None else np.einsum("ni,nij->nj", rows, axes) for rows in (forces, torques, positions)
        )
        positions = None if positions is None else positions + origins
    engines.physics().apply_forces([str(prim.GetPath()) for prim in prims], forces, torques, positions=positions)


def masses(prims: Sequence[Usd.Prim]) -> np.ndarray:
    """Return the authored masses (N, 1), float32; of simulated bodies without one, that of the simulation, else 0."""
    values = read(prims, UsdPhysics.MassAPI, UsdPhysics.MassAPI.GetMassAttr, 0.0)
    if is_simulating():
        simulated = set(engines.physics().rigid_bodies)
        rows = [row for row, prim in enumerate(prims) if str(prim.GetPath()) in simulated and values[row, 0] == 0.0]
        if rows:
            values[rows, 0] = engines.physics().mass_properties([str(prims[row].GetPath()) for row in rows]).mass
    return values


def set_masses(prims: Sequence[Usd.Prim], values: Sequence[float | bool | str]) -> None:
    """Author masses; those of bodies that are simulated act until physics stops."""
    keep_until_stop(prims, [UsdPhysics.Tokens.physicsMass])
    write(prims, UsdPhysics.MassAPI, "Mass", values)


def read(
    prims: Sequence[Usd.Prim], api: Any, attribute: Callable[[Any], Usd.Attribute], default: float | bool
) -> np.ndarray:
    """Return an attribute of an applied schema (N, 1), float32 or bool; `default` where the schema is not applied."""
    found = [attribute(api(prim)).Get() if prim.HasAPI(api) else default for prim in prims]
    return np.array(found, bool if isinstance(default, bool) else np.float32).reshape(-1, 1)


def write(prims: Sequence[Usd.Prim], api: Any, attribute: str, values: Sequence[float | bool | str]) -> None:
    """Apply a schema and author one of its attributes, named as in `CreateMassAttr`: "Mass"."""
    for prim, value in zip(prims, values, strict=True):
        getattr(api.Apply(prim), f"Create{attribute}Attr")().Set(value)

"""Add the bodies of a scene to a Newton builder."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.model.mass import MassProperties
from usdsdg_physics.scene.records import Body, Scene

if TYPE_CHECKING:
    import newton

# Times the mass or moment of inertia, along and about axes that are locked: more would drown the others in rounding.
LOCKED_SHARE = 1e3


@dataclass(frozen=True)
class BuiltBodies:
    """Where the bodies of a scene are in the arrays of a model."""

    index: dict[str, int]  # by prim path
    # (N,) where a body's pose and velocity are in joint_q and joint_qd; -1 for links, which joints move, and bases.
    coordinate: np.ndarray
    dof: np.ndarray


def add_bodies(
    builder: newton.ModelBuilder, scene: Scene, masses: Sequence[MassProperties], links: Collection[str]
) -> BuiltBodies:
    """Add all bodies, those at the paths `links` without a joint, since joints of the scene will hold them."""
    import newton
    import warp as wp

    index: dict[str, int] = {}
    coordinate, dof = np.full(len(masses), -1, np.int32), np.full(len(masses), -1, np.int32)
    # One set of axes for all, which `add_body` would make six times for each body: most of the time that it takes.
    free = newton.ModelBuilder.JointDofConfig.create_unlimited
    axes = [free(axis) for axis in (newton.Axis.X, newton.Axis.Y, newton.Axis.Z)]
    for row, (body, mass) in enumerate(zip(scene.bodies.values(), masses)):
        added = index[body.path] = builder.add_link(
            xform=wp.transform(*body.pose),
            mass=mass.mass,
            com=wp.vec3(*mass.center),
            inertia=wp.mat33(*mass.inertia.ravel()),
            lock_inertia=True,
            is_kinematic=body.kinematic,
            label=body.path,
            custom_attributes=_steel_attributes(body),
        )
        if body.path in links:
            continue
        coordinate[row], dof[row] = builder.joint_coord_count, builder.joint_dof_count
        joint = builder.add_joint(
            newton.JointType.FREE,
            -1,
            added,
            linear_axes=axes,
            angular_axes=axes,
            label=f"{body.path}_free_joint",
        )
        builder.joint_q[coordinate[row] :] = list(builder.body_q[added])
        builder.add_articulation([joint], label=f"{body.path}_articulation")
        _lock_axes(builder, dof[row], body, mass)
    return BuiltBodies(index, coordinate, dof)


def _steel_attributes(body: Body) -> dict[str, float]:
    return {
        "steel:rigid_body_linear_damping": body.linear_damping,
        "steel:rigid_body_angular_damping": body.angular_damping,
        "steel:rigid_body_max_depenetration_velocity": body.max_depenetration_velocity,
    }


def _lock_axes(builder: newton.ModelBuilder, dof: int, body: Body, mass: MassProperties) -> None:
    """Give a body so much more inertia along and about its locked axes, which are the world's, that it does not move.

    What is left is taken away by `LockedAxes`.
    """
    for axis in range(3):
        if body.locked_position & (1 << axis):
            builder.joint_armature[dof + axis] = LOCKED_SHARE * mass.mass
        if body.locked_rotation & (1 << axis):
            builder.joint_armature[dof + 3 + axis] = LOCKED_SHARE * np.trace(mass.inertia)

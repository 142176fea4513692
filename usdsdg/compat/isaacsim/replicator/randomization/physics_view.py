"""`domain_randomization.physics_view`: what both spellings have: randomize registered views, and step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.compat.isaacsim.replicator.randomization.context import trigger_randomization
from usdsdg.compat.isaacsim.replicator.randomization.write_view import randomize
from usdsdg.distribution import Distribution

Randomized = Distribution | Sequence[float] | float


def step_randomization(reset_inds: Sequence[int] | np.ndarray | None = None) -> None:
    """Randomize one frame; the environments with these numbers, in any array type, are reset first."""
    rows = [] if reset_inds is None else reset_inds
    trigger_randomization(np.asarray(rows.cpu() if hasattr(rows, "cpu") else rows))  # pyright: ignore


def randomize_simulation_context(operation: str = "direct", gravity: Randomized | None = None) -> None:
    """Randomize gravity [stage units/s²]: of the values for several environments, the first one's counts.

    Args:
        operation: "direct" writes a value, "additive" adds it to the value since the last reset, "scaling" multiplies.

    Raises:
        GraphError: (a ValueError) it is not inside of a gate, or nothing is registered.
    """
    randomize("randomize_simulation_context", "scene", "simulation_context", operation, None, {"gravity": gravity})


def randomize_rigid_prim_view(
    view_name: str,
    operation: str = "direct",
    num_buckets: int | None = None,
    position: Randomized | None = None,
    orientation: Randomized | None = None,
    linear_velocity: Randomized | None = None,
    angular_velocity: Randomized | None = None,
    velocity: Randomized | None = None,
    force: Randomized | None = None,
    mass: Randomized | None = None,
    inertia: Randomized | None = None,
    material_properties: Randomized | None = None,
    contact_offset: Randomized | None = None,
    rest_offset: Randomized | None = None,
) -> None:
    """Randomize rigid bodies. Values are distributions or constants; those for several bodies differ.

    Args:
        operation: as in `randomize_simulation_context`; a force is always applied as it is, during one step.
        num_buckets: number of different values of material_properties.
        orientation: angles about the world's x, y and z, applied in this order [rad].
        velocity: linear and angular, six numbers; angular ones are in rad/s.
        inertia: the diagonal.
        material_properties: static friction, dynamic friction, restitution.

    Raises:
        GraphError: (a ValueError) it is not inside of a gate, or there is no such view.
    """
    randomize(
        "randomize_rigid_prim_view",
        "rigid",
        view_name,
        operation,
        num_buckets,
        {
            "position": position,
            "orientation": orientation,
            "linear_velocity": linear_velocity,
            "angular_velocity": angular_velocity,
            "velocity": velocity,
            "force": force,
            "mass": mass,
            "inertia": inertia,
            "material_properties": material_properties,
            "contact_offset": contact_offset,
            "rest_offset": rest_offset,
        },
    )


def randomize_articulation_view(
    view_name: str,
    operation: str = "direct",
    num_buckets: int | None = None,
    stiffness: Randomized | None = None,
    damping: Randomized | None = None,
    joint_friction: Randomized | None = None,
    position: Randomized | None = None,
    orientation: Randomized | None = None,
    linear_velocity: Randomized | None = None,
    angular_velocity: Randomized | None = None,
    velocity: Randomized | None = None,
    joint_positions: Randomized | None = None,
    joint_velocities: Randomized | None = None,
    lower_dof_limits: Randomized | None = None,
    upper_dof_limits: Randomized | None = None,
    max_efforts: Randomized | None = None,
    joint_armatures: Randomized | None = None,
    joint_max_velocities: Randomized | None = None,
    joint_efforts: Randomized | None = None,
    body_masses: Randomized | None = None,
    body_inertias: Randomized | None = None,
    material_properties: Randomized | None = None,
    tendon_stiffnesses: Randomized | None = None,
    tendon_dampings: Randomized | None = None,
    tendon_limit_stiffnesses: Randomized | None = None,
    tendon_lower_limits: Randomized | None = None,
    tendon_upper_limits: Randomized | None = None,
    tendon_rest_lengths: Randomized | None = None,
    tendon_offsets: Randomized | None = None,
) -> None:
    """Randomize articulations: the root's position and orientation, and what moves joints without forces.

    Joints have one number each, in the order of `Articulation.dof_names`; angles are in rad.

    Raises:
        GraphError: (a ValueError) it is not inside of a gate, or there is no such view.
        Unsupported: an attribute belongs to forces, masses or tendons of joints, which are not simulated.
    """
    randomize(
        "randomize_articulation_view",
        "robots",
        view_name,
        operation,
        num_buckets,
        {
            "stiffness": stiffness,
            "damping": damping,
            "joint_friction": joint_friction,
            "position": position,
            "orientation": orientation,
            "linear_velocity": linear_velocity,
            "angular_velocity": angular_velocity,
            "velocity": velocity,
            "joint_positions": joint_positions,
            "joint_velocities": joint_velocities,
            "lower_dof_limits": lower_dof_limits,
            "upper_dof_limits": upper_dof_limits,
            "max_efforts": max_efforts,
            "joint_armatures": joint_armatures,
            "joint_max_velocities": joint_max_velocities,
            "joint_efforts": joint_efforts,
            "body_masses": body_masses,
            "body_inertias": body_inertias,
            "material_properties": material_properties,
            "tendon_stiffnesses": tendon_stiffnesses,
            "tendon_dampings": tendon_dampings,
            "tendon_limit_stiffnesses": tendon_limit_stiffnesses,
            "tendon_lower_limits": tendon_lower_limits,
            "tendon_upper_limits": tendon_upper_limits,
            "tendon_rest_lengths": tendon_rest_lengths,
            "tendon_offsets": tendon_offsets,
        },
    )

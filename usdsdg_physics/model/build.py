"""Build the Newton model of a scene, its collision pipeline and its solver."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg.errors import warn_once
from usdsdg_physics.model.bodies import add_bodies
from usdsdg_physics.model.hull_edges import hull_edges_found_once
from usdsdg_physics.model.joints import BuiltJoints, add_joints, scene_trees
from usdsdg_physics.model.mass import MassProperties, body_mass
from usdsdg_physics.model.mesh_boundaries import mesh_boundaries_left_out
from usdsdg_physics.model.narrow_phase_kernels import (
    narrow_phase_kernels_made_once,
    narrow_phase_of_fast_hulls,
    narrow_phase_of_one_kind,
)
from usdsdg_physics.scene.contact_coefficients import (
    MAX_STAND_INS,
    CoefficientTable,
    StandIn,
    coefficient_table,
)
from usdsdg_physics.scene.records import STATIC, Collider, Joint, Scene, Shape, Solid
from usdsdg_physics.solver.rebounds import rebound_at_surfaces
from usdsdg_physics.solver.separated_pairs import drop_separated_pairs
from usdsdg_physics.solver.sweep_pairs import sweep_pairs_alone
from usdsdg_physics.solver.sweeps import sweep_by_island

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.contact_solver.solver import ContactSolver

# Sweeps of the solver that move bodies, out of each other too, and sweeps after them that correct their velocities, so
# that the former push no energy into a scene. Ten cubes of 20 cm on each other need that many to stand.
ITERATIONS = 48
VELOCITY_ITERATIONS = 16
# What a gripper holds turns by a degree with fewer, because drives and contacts are solved against each other.
ITERATIONS_WITH_JOINTS = 64
# Part of a penetration that a substep removes; below one, since contacts of one body add up.
PENETRATION_SHARE = 0.8
# Some of the solver's kernels run over the whole capacity, so it is kept near what dense piles need.
CONTACTS_PER_BODY = 18
MIN_CONTACTS = 1000
CONSTRAINT_ROWS_PER_BODY = 16
MIN_CONSTRAINT_ROWS = 8192
MIN_CONSTRAINT_ROWS_CUDA = 4096

# With these the solver would look for bodies that are too fast, whose rows it would solve; `Stabilization` clamps them.
UNUSED_ATTRIBUTES = ("steel:rigid_body_max_linear_velocity", "steel:rigid_body_max_angular_velocity")
UNLIMITED = 1e9  # m or rad, beyond which a joint has no limit

COLLIDES, DISABLED = 1, 0  # collision groups: Newton pairs no shape of group zero


@dataclass(frozen=True)
class BuiltModel:
    """A Newton model, the index of each prim in its arrays, and the mass properties of its bodies."""

    model: newton.Model
    body_index: dict[str, int]  # by prim path
    shape_index: dict[str, int]  # by collider path
    mass: np.ndarray  # (N,) kg
    center: np.ndarray  # (N, 3) center of mass in the body's frame, m
    inertia_per_mass: np.ndarray  # (N,) mean moment of inertia over the mass, m²
    inertia: np.ndarray  # (N, 3, 3) about the center of mass, axes of the body frame, kg m²
    coefficients: CoefficientTable | None  # of pairs of materials; None where the mean of two is right
    stand_in_index: np.ndarray  # shape of each of its stand-ins
    smooth_shapes: dict[str, int]  # by body of distance joints: a shape without friction, which collides with nothing
    joints: BuiltJoints
    # (N,) where a body's pose and velocity are in joint_q and joint_qd; -1 for links, which joints move, and bases.
    coordinate: np.ndarray
    dof: np.ndarray

    @property
    def pose_coordinate(self) -> np.ndarray:
        """(N,) likewise in joint_q, for bases that carry links too."""
        found = self.coordinate.copy()
        for path, (start, _) in self.joints.bases.items():
            found[self.body_index[path]] = start
        return found


def build_model(scene: Scene, *, device: str | None = None) -> BuiltModel:
    """Build a model of all bodies and colliders; `device` is "cpu", "cuda:0" or None for Warp's default.

    Disabled colliders are built like the others: the pipeline only knows the shapes that collide when it is made.
    """
    import newton

    builder = newton.ModelBuilder()
    newton.solvers.SolverSteel.register_custom_attributes(builder)
    for name in UNUSED_ATTRIBUTES:
        builder.custom_attributes.pop(name, None)
    colliders_of: dict[str, list[Collider]] = {path: [] for path in (STATIC, *scene.bodies)}
    for collider in scene.colliders.values():
        colliders_of[collider.body].append(collider)

    masses = _body_masses(scene, colliders_of)
    trees = scene_trees(scene)
    links = {path for tree in trees for path in tree.bodies}
    bodies = add_bodies(builder, scene, masses, links)
    body_index = bodies.index
    joints = add_joints(builder, trees, scene, body_index)
    meshes: dict[str, newton.Mesh] = {}
    shape_index = {
        collider.path: _add_shape(builder, body_index.get(collider.body, -1), collider, meshes)
        for group in colliders_of.values()
        for collider in group
    }
    coefficients = _coefficients(scene)
    stand_ins = [_add_stand_in(builder, body_index, each) for each in (coefficients.stand_ins if coefficients else ())]
    smooth = {
        path: _add_stand_in(builder, body_index, StandIn(path, 0.0, 0.0))
        for path in dict.fromkeys(path for joint in distance_joints(scene) for path in (joint.body0, joint.body1))
    }
    for a, b in sorted(scene.filtered):
        builder.add_shape_collision_filter_pair(shape_index[a], shape_index[b])

    # Our inertias are already positive and balanced; Newton's check would only compile another kernel.
    with mesh_boundaries_left_out(), hull_edges_found_once():
        model = builder.finalize(device=device, skip_validation_inertia=True)
    model.set_gravity(scene.gravity)
    return BuiltModel(
        model,
        body_index,
        shape_index,
        np.array([mass.mass for mass in masses]),
        np.array([mass.center for mass in masses]).reshape(-1, 3),
        np.array([np.trace(mass.inertia) / 3.0 / mass.mass for mass in masses]),
        np.array([mass.inertia for mass in masses]).reshape(-1, 3, 3),
        coefficients,
        np.array(stand_ins, int),
        smooth,
        joints,
        bodies.coordinate,
        bodies.dof,
    )


def _body_masses(scene: Scene, colliders_of: Mapping[str, list[Collider]]) -> list[MassProperties]:
    """Return the mass properties of all bodies; those that were cut share theirs with their halves."""
    whole = {
        path: body_mass(body, colliders_of[path]) for path, body in scene.bodies.items() if path not in scene.halves
    }
    parts = Counter(scene.halves.values())
    found = []
    for path in scene.bodies:
        body = scene.halves.get(path, path)
        each, share = whole[body], 1.0 / (1 + parts[body])
        found.append(replace(each, mass=share * each.mass, inertia=share * each.inertia) if parts[body] else each)
    return found


def distance_joints(scene: Scene) -> list[Joint]:
    """Return the distance joints of a scene that do something."""
    fixed = {STATIC} | {path for path, body in scene.bodies.items() if body.kinematic}
    return [
        joint
        for joint in scene.joints.values()
        if joint.kind == "distance" and not (joint.body0 in fixed and joint.body1 in fixed)
    ]


def build_pipeline(model: newton.Model, *, capacity: float = 1.0, extra: int = 0) -> newton.CollisionPipeline:
    """Build the collision pipeline of a model.

    Args:
        capacity: factor on the usual size of its contact buffer.
        extra: contacts that the buffer has room for besides those.
    """
    import newton

    # One configuration for every scene: each combination of options is another narrow-phase module to compile.
    of_a_kind = narrow_phase_of_one_kind() if model.device.is_cuda else narrow_phase_of_fast_hulls()
    with narrow_phase_kernels_made_once(), of_a_kind:
        pipeline = newton.CollisionPipeline(
            model,
            broad_phase="sap",
            rigid_contact_max=int(capacity * max(MIN_CONTACTS, CONTACTS_PER_BODY * model.body_count)) + extra,
            include_static_kinematic_pairs=False,
            # Reduction keeps only one of the contacts of a body just above a mesh, so that it would tip through.
            reduce_contacts=False,
            verify_buffers=False,
            deterministic=model.device.is_cuda,
        )
    sweep_pairs_alone(pipeline)
    drop_separated_pairs(pipeline)
    return pipeline


def build_solver(
    built: BuiltModel, pipeline: newton.CollisionPipeline, *, capacity: float = 1.0
) -> ContactSolver | newton.solvers.SolverSteel:
    """Build the solver of a model and its contacts; `capacity` is a factor on the usual number of constraint rows."""
    import newton
    import warp as wp

    model, joints = built.model, built.joints
    if has_contacts_alone(built):
        from usdsdg_physics.contact_solver.solver import ContactSolver

        return ContactSolver(
            model,
            coordinate=built.coordinate,
            dof=built.dof,
            contact_capacity=pipeline.rigid_contact_max,
            penetration_share=PENETRATION_SHARE,
        )
    minimum = MIN_CONSTRAINT_ROWS_CUDA if model.device.is_cuda else MIN_CONSTRAINT_ROWS
    options: dict[str, Any] = {
        "iterations": ITERATIONS_WITH_JOINTS if joints.trees else ITERATIONS,
        "velocity_iterations": VELOCITY_ITERATIONS,
        "baumgarte": PENETRATION_SHARE,
        "free_body_constraint_max": int(capacity * max(minimum, CONSTRAINT_ROWS_PER_BODY * model.body_count)),
        "warn_constraint_overflow": False,
        **_joint_options(joints, capacity),
    }
    if model.device.is_cuda and not any(tree.loops for tree in joints.trees):
        # The serial sweep would run one world's contacts on a single thread; nothing else closes loops.
        options["solve_mode"], options["articulated_contact_response"] = "colored", "propagation"
        options["deterministic"] = wp.DeterministicMode.RUN_TO_RUN
        return newton.solvers.SolverSteel(model, **options)
    solver = newton.solvers.SolverSteel(model, **options)
    sweep_by_island(solver)
    rebound_at_surfaces(solver)
    return solver


def has_contacts_alone(built: BuiltModel) -> bool:
    """Return whether a model is for our own solver: on a GPU, where Newton's would keep one of its parts busy."""
    return built.model.device.is_cuda and not built.joints.trees


def enable_surface_velocities(solver: ContactSolver | newton.solvers.SolverSteel) -> None:
    """Let Newton's solver read the surface velocities of contacts, which it does by itself for its own meshes only."""
    import newton
    import warp as wp

    if not isinstance(solver, newton.solvers.SolverSteel):
        return
    if not solver._has_contact_target_velocity:
        solver._has_contact_target_velocity = True
        solver._mf_target_velocity = wp.zeros_like(solver._mf_rhs)


def _joint_options(joints: BuiltJoints, capacity: float) -> dict[str, Any]:
    """Return the options of the solver that a model with joints needs."""
    if not joints.trees:
        return {}
    return {
        "articulation_constraint_max": int(capacity * joints.rows),
        "enable_joint_limits": True,
        # Newton has a finite number for no limit.
        "joint_limit_activation_gap": UNLIMITED,
        "enable_joint_velocity_limits": any(np.isfinite(axis.axis.max_velocity) for axis in joints.axes),
        # A drive that is folded into the mass matrix would pull harder than its maximum force.
        "drive_mode": "rows",
    }


def _add_shape(builder: newton.ModelBuilder, body: int, collider: Collider, meshes: dict[str, newton.Mesh]) -> int:
    import newton
    import warp as wp

    shape = collider.shape
    config = newton.ModelBuilder.ShapeConfig(
        density=0.0,
        mu=collider.material.friction,
        restitution=collider.material.restitution,
        gap=collider.gap,
        margin=collider.margin,
        collision_group=COLLIDES,
        has_particle_collision=False,
    )
    return builder.add_shape(
        body=body,
        type=_geometry_type(shape),
        xform=wp.transform(*shape.position, *shape.rotation),
        scale=wp.vec3(*shape.size),
        src=None if shape.solid is None else _mesh(shape.solid, meshes),
        cfg=config,
        label=collider.path,
    )


def _coefficients(scene: Scene) -> CoefficientTable | None:
    table = coefficient_table(scene)
    if table is not None and len(table.stand_ins) > MAX_STAND_INS:
        warn_once(
            f"{len(scene.bodies)} bodies have {len(table.value)} different physics materials, too many for static "
            "friction and combine modes of each pair: dynamic friction and restitution are averaged. Use fewer."
        )
        return None
    return table


def _add_stand_in(builder: newton.ModelBuilder, body_index: dict[str, int], stand_in: StandIn) -> int:
    import newton
    import warp as wp

    config = newton.ModelBuilder.ShapeConfig(
        density=0.0,
        mu=stand_in.friction,
        restitution=stand_in.restitution,
        collision_group=DISABLED,
        has_shape_collision=False,
        has_particle_collision=False,
    )
    return builder.add_shape(
        body=body_index.get(stand_in.body, -1), type=newton.GeoType.SPHERE, scale=wp.vec3(1e-3, 0.0, 0.0), cfg=config
    )


def _geometry_type(shape: Shape) -> int:
    import newton

    return {
        "box": newton.GeoType.BOX,
        "sphere": newton.GeoType.SPHERE,
        "capsule": newton.GeoType.CAPSULE,
        "cylinder": newton.GeoType.CYLINDER,
        "cone": newton.GeoType.CONE,
        "plane": newton.GeoType.PLANE,
        "hull": newton.GeoType.CONVEX_MESH,
        "mesh": newton.GeoType.MESH,
    }[shape.kind]


def _mesh(solid: Solid, meshes: dict[str, newton.Mesh]) -> newton.Mesh:
    import newton

    if solid.key not in meshes:
        meshes[solid.key] = newton.Mesh(solid.vertices, solid.triangles.ravel(), compute_inertia=False)
    return meshes[solid.key]

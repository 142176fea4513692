"""The ordered list of all that corrects what Newton finds and solves in a step: guards, then corrections."""

# Newton declares the arrays of models and states optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg_physics.corrections.bodies.free_flight import FreeFlight
from usdsdg_physics.corrections.bodies.locked_axes import LockedAxes
from usdsdg_physics.corrections.bodies.sleeping import Sleeping
from usdsdg_physics.corrections.bodies.stabilization import Stabilization
from usdsdg_physics.corrections.contacts.contact_report import ContactReport
from usdsdg_physics.corrections.contacts.far_ends import FarEnds
from usdsdg_physics.corrections.contacts.impacts import Impacts
from usdsdg_physics.corrections.friction.contact_coefficients import ContactCoefficients
from usdsdg_physics.corrections.friction.moving_surfaces import MovingSurfaces
from usdsdg_physics.corrections.joints.distance_joints import DistanceJoints
from usdsdg_physics.corrections.joints.floating_trees import FloatingTrees
from usdsdg_physics.corrections.joints.joint_forces import JointForces
from usdsdg_physics.corrections.joints.joint_loads import JointLoads
from usdsdg_physics.corrections.joints.link_damping import LinkDamping
from usdsdg_physics.corrections.joints.links import Links
from usdsdg_physics.corrections.joints.tops import Tops
from usdsdg_physics.corrections.overlaps.depenetration import Depenetration
from usdsdg_physics.corrections.overlaps.squeezes import Squeezes
from usdsdg_physics.guards.collider_seams import ColliderSeams
from usdsdg_physics.guards.mesh_seams import MeshSeams
from usdsdg_physics.guards.tunneling_guard import TunnelingGuard
from usdsdg_physics.model import build
from usdsdg_physics.model.build import BuiltModel, distance_joints
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.contact_events import reports_of

if TYPE_CHECKING:
    import newton
    import warp as wp


@dataclass(frozen=True)
class StepKind:
    """All that decides which kernels a step launches, and with which numbers."""

    dt: float  # s
    substeps: int
    moves_kinematic: bool = False
    depenetrates: bool = False
    has_sleepers: bool = False

    @property
    def substep(self) -> float:
        """Length of a substep [s]."""
        return self.dt / self.substeps


class StepCorrections:
    """All guards and corrections of one world; those that few scenes need are None in the others, and cost nothing.

    The methods launch kernels that may be recorded, so nothing in them depends on what arrays hold.
    """

    surfaces: MovingSurfaces | None = None  # made when the first surface moves

    def __init__(self, scene: Scene, built: BuiltModel, contacts: newton.Contacts) -> None:
        import warp as wp

        from usdsdg_physics.corrections.contacts.contact_arrays import contact_arrays

        model, shape_index = built.model, built.shape_index
        bodies = list(scene.bodies.values())
        self._scene, self._model, self._buffer = scene, model, contacts
        self._contacts = contact_arrays(contacts)

        def array(values: Any, dtype: type) -> wp.array:
            return wp.array(values, dtype=dtype, device=model.device)

        sleep_threshold = array([body.sleep_threshold for body in bodies], wp.float32)
        inertia_per_mass = array(built.inertia_per_mass, wp.float32)
        coordinate, dof = array(built.coordinate, wp.int32), array(built.dof, wp.int32)
        # Links follow from joint coordinates, so no correction moves them.
        dynamic = np.array([not body.kinematic for body in bodies], bool)
        free = array(dynamic & (built.dof >= 0), wp.int32)

        self.far_ends = FarEnds(model, free, self._contacts)
        self.mesh_seams = MeshSeams(model, self._contacts)
        self.collider_seams = ColliderSeams(scene, model, shape_index, self._contacts)
        self.tunneling_guard = TunnelingGuard(scene, model, shape_index, self._contacts)
        self.sleeping = Sleeping(model, self._contacts, inertia_per_mass, sleep_threshold)
        self.free_flight = FreeFlight(model, free, coordinate, dof, self._contacts)
        self.depenetration = Depenetration(scene, model, shape_index, self._contacts, free, dof)
        self.impacts = Impacts(model, free, self._contacts)
        self.squeezes = Squeezes(scene, model, shape_index, free, self._contacts, lifts=build.has_contacts_alone(built))
        self.stabilization = Stabilization(scene, model, inertia_per_mass, sleep_threshold, free, coordinate, dof)
        self.locked_axes = (
            LockedAxes(scene, model, coordinate, dof)
            if any(body.locked_position or body.locked_rotation for body in bodies)
            else None
        )
        self.coefficients = self._coefficients_of(built)
        self.distances = self._distances_of(scene, built, free)
        self.links = self._links_of(built)
        self.floating_trees = (
            FloatingTrees(
                model,
                scene,
                built.joints.trees,
                body_index=built.body_index,
                bases=built.joints.bases,
                touched=self.free_flight.touched,
            )
            if built.joints.trees
            else None
        )
        joints = built.joints
        self.tops = (
            Tops(
                model,
                scene,
                joints.trees,
                body_index=built.body_index,
                joint_of=joints.joint_of,
                touched=self.free_flight.touched,
            )
            if joints.trees
            else None
        )
        self.link_damping = LinkDamping(model, bodies) if joints.trees else None
        self.loads = (
            JointLoads(model, [row[1:] for row in joints.breakable], joints.rubbing)
            if joints.breakable or joints.rubbing
            else None
        )
        self.joint_forces = JointForces.of(built, scene)
        reported = [shape_index[path] for path in reports_of(scene)]
        self.report = ContactReport(model, self._contacts, reported) if reported else None

    @property
    def observables(self) -> set[str]:
        """What the solver has to tell of its steps."""
        breaks = self.distances is not None and self.distances.breakable
        forces = {"contact_f"} if self.report is not None or breaks else set()
        bears = self.loads is not None or self.joint_forces is not None
        return forces | ({"body_parent_f"} if bears else set())

    def add_surfaces(self) -> None:
        """Let surfaces move from now on."""
        self.surfaces = MovingSurfaces(
            self._scene, self._model, self._buffer, self._contacts, self.stabilization.rest_time
        )

    def begin(self, state: newton.State) -> None:
        """Begin a step."""
        self.free_flight.begin(state)
        if self.distances is not None:
            self.distances.begin(state)
        if self.locked_axes is not None:
            self.locked_axes.begin(state)

    def add_contacts(self, state: newton.State) -> None:
        """Add to the contacts that the pipeline just found."""
        if self.far_ends:
            self.far_ends.add_contacts(state)

    def before_solver(self, kind: StepKind, substep: int, state: newton.State) -> None:
        """Correct the contacts that were just found, and the velocities, before the solver's step."""
        h, visited = kind.substep, self._buffer.rigid_contact_max  # that of `VisitedContacts`
        self.free_flight.note_contacts(visited)
        if self.mesh_seams:
            self.mesh_seams.turn_contacts(state, visited)
        if self.collider_seams:
            self.collider_seams.turn_contacts(state, visited)
        self.tunneling_guard.redirect_contacts(state, visited)
        if kind.depenetrates:
            self.depenetration.raise_velocities(state)
        if kind.has_sleepers:
            self.sleeping.wake_touched(state, h)
        if self.report is not None:
            self.report.note_contacts(state, substep)
        self.squeezes.redirect_contacts(state, h, visited)
        if self.surfaces is not None:
            self.surfaces.update_contacts(state)
        if self.coefficients is not None:
            self.coefficients.apply(state, self._surface_velocity, h)
        if self.links is not None:
            self.links.keep_awake(state)
        self.impacts.center_contacts(state, self._surface_velocity, h, visited)
        if self.distances is not None:
            self.distances.add_contacts(state, self._surface_velocity, h)
        if self.link_damping is not None:
            self.link_damping.add(state, h, limits=substep == 0)

    def after_solver(
        self, kind: StepKind, substep: int, before: newton.State, after: newton.State, observed: Any
    ) -> None:
        """Correct what the solver's step made of a state; `observed` has what `observables` names."""
        h = kind.substep
        if self.report is not None:
            self.report.note_forces(observed.contact_f, substep, h)
        if self.distances is not None and self.distances.breakable:
            self.distances.note_forces(observed.contact_f)
        self.free_flight.turn(before, after, h)
        if self.links is not None:
            self.links.revert_nonfinite(before, after)
        if self.floating_trees:
            self.floating_trees.keep_momentum(before, after, h)
        if self.tops:
            self.tops.turn(before, after, h)
        if self.link_damping is not None:
            self.link_damping.remove(before)
        if self.loads is not None:
            self.loads.apply(before, observed.body_parent_f)
        if self.joint_forces is not None:
            self.joint_forces.apply(before, observed.body_parent_f, substep=substep, substeps=kind.substeps)
        if self.locked_axes is not None:
            self.locked_axes.apply(before, after)
        squeezes = self.squeezes
        self.stabilization.apply(
            before, after, h, asleep=self.sleeping.asleep, squeezed=squeezes.squeezed, neighbors=squeezes.neighbors
        )
        if kind.depenetrates:
            self.depenetration.clamp_velocities(before, after, h)

    def finish(self, kind: StepKind, state: newton.State, other: newton.State) -> None:
        """Finish a step that ends in `state`; `other` is what its substeps took turns with."""
        if self.distances is not None:
            self.distances.finish((state, other))
        if kind.substeps > 1:
            self.free_flight.finish(state, kind.dt)

    @property
    def _surface_velocity(self) -> wp.array | None:
        return self.surfaces.velocity if self.surfaces is not None else None

    def _coefficients_of(self, built: BuiltModel) -> ContactCoefficients | None:
        if built.coefficients is None:
            return None
        return ContactCoefficients(
            built.coefficients,
            self._model,
            self._contacts,
            body_index=built.body_index,
            shape_index=built.shape_index,
            stand_in_index=built.stand_in_index,
        )

    def _distances_of(self, scene: Scene, built: BuiltModel, free: wp.array) -> DistanceJoints | None:
        joints = distance_joints(scene)
        if not joints:
            return None
        return DistanceJoints(
            joints,
            self._model,
            self._contacts,
            body_index=built.body_index,
            shapes=built.smooth_shapes,
            free=free,
            touched=self.free_flight.touched,
            rest_time=self.stabilization.rest_time,
        )

    def _links_of(self, built: BuiltModel) -> Links | None:
        if not built.joints.trees:
            return None
        tree = np.array([built.joints.links.get(path, -1) for path in built.body_index], np.int32)
        ranges = np.array(built.joints.ranges, np.int32)
        rest_time, nonfinite = self.stabilization.rest_time, self.stabilization.nonfinite_steps
        return Links(self._model, self._contacts, tree, ranges, rest_time, nonfinite)

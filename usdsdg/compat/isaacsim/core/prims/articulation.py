"""`Articulation`: several robots, whose joints follow what is set."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.prims.articulation_bodies import ArticulationBodies
from usdsdg.compat.isaacsim.core.prims.articulation_switches import ArticulationSwitches
from usdsdg.compat.isaacsim.core.utils.types import JointsState
from usdsdg.compat.wrappers import bodies, poses
from usdsdg.compat.wrappers.arrays import chosen, grid, pose_rows, rows
from usdsdg.compat.wrappers.joints.rows import WHY
from usdsdg.compat.wrappers.unsupported import RefusedNames
from usdsdg.session import body_velocities

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Indices, Values


class Articulation(ArticulationSwitches, ArticulationBodies):
    """Robots: poses, links and joints. Tendons raise `Unsupported`.

    While physics plays, poses and velocities are those of the bases. Quaternions are (w, x, y, z).
    """

    __getattr__ = RefusedNames("Articulation", ("get_", "set_", "apply_", "num_fixed"), WHY)

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str = "articulation_prim_view",
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        visibilities: Values | None = None,
        reset_xform_properties: bool = True,
        enable_residual_reports: bool = False,
    ) -> None:
        """Wrap robots; see `XFormPrim`. Residuals of a solver are not reported."""
        super().__init__(
            prim_paths_expr, name, positions, translations, orientations, scales, visibilities, reset_xform_properties
        )
        self._default_base: list[np.ndarray | None] = [None, None]
        self._default_joints: JointsState | None = None

    def is_physics_handle_valid(self) -> bool:
        """Whether physics simulates."""
        return bodies.is_simulating()

    def initialize(self, physics_sim_view: object = None) -> None:
        """Take the targets of the drives as default state of the joints, and the present gains as the usual ones."""
        self._note_defaults()

    def post_reset(self) -> None:
        """Place robots and joints as their default states say, and give drives the usual gains.

        By default joints go to the targets that their drives have at first, as in Isaac Sim.
        """
        defaults = self._note_defaults()
        if bodies.is_simulating():
            self.set_world_poses(self._default_base[0], self._default_base[1])
        else:
            super().post_reset()
        where, which = range(self.count), range(self.num_dof)
        self._joints.set_positions(where, which, np.asarray(defaults.positions))
        self._joints.set_velocities(where, which, np.asarray(defaults.velocities))
        if np.any(defaults.efforts):  # pyright: ignore[reportArgumentType,reportCallIssue]
            self._joints.set_efforts(where, which, np.asarray(defaults.efforts))
        self._drives.restore_gains()

    # --- poses and velocities of the bases ---
    def get_world_poses(
        self, indices: Indices = None, clone: bool = True, usd: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return positions (N, 3) and orientations (N, 4) in the world."""
        if not bodies.is_simulating():
            return super().get_world_poses(indices)
        positions, orientations = self._out(*poses.world_poses(self._bases(indices)))
        return positions, orientations

    def set_world_poses(
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        indices: Indices = None,
        usd: bool = True,
    ) -> None:
        """Place robots in the world; what is not given stays."""
        if not bodies.is_simulating():
            super().set_world_poses(positions, orientations, indices)
        elif positions is not None or orientations is not None:
            prims = self._bases(indices)
            poses.set_world_poses(prims, *pose_rows(positions, orientations, len(prims)), strict=False)
            bodies.place_links()

    def get_local_poses(self, indices: Indices = None) -> tuple[np.ndarray, np.ndarray]:
        """Return translations (N, 3) and orientations (N, 4) relative to the parents of the robots' prims."""
        if not bodies.is_simulating():
            return super().get_local_poses(indices)
        world = poses.world_poses(self._bases(indices))
        translations, orientations = poses.local_from_world(self._chosen(indices), *world)
        translations, orientations = self._out(translations.astype(np.float32), orientations.astype(np.float32))
        return translations, orientations

    def set_local_poses(
        self, translations: Values | None = None, orientations: Values | None = None, indices: Indices = None
    ) -> None:
        """Place robots relative to the parents of their prims; what is not given stays."""
        if not bodies.is_simulating():
            super().set_local_poses(translations, orientations, indices)
            return
        prims = self._chosen(indices)
        given = pose_rows(translations, orientations, len(prims))
        poses.move_to_local(self._bases(indices), prims, *given)
        bodies.place_links()

    def get_velocities(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return (N, 6): linear [stage units/s], then angular velocities [rad/s] in the world."""
        return self._out(np.hstack(body_velocities.velocities(self._bases(indices))))[0]

    def get_linear_velocities(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return (N, 3) [stage units/s]."""
        return self._out(body_velocities.velocities(self._bases(indices))[0])[0]

    def get_angular_velocities(self, indices: Indices = None, clone: bool = True) -> np.ndarray:
        """Return (N, 3) [rad/s]."""
        return self._out(body_velocities.velocities(self._bases(indices))[1])[0]

    def set_velocities(self, velocities: Values | None = None, indices: Indices = None) -> None:
        """Set (N, 6): linear [stage units/s], then angular velocities [rad/s]; links move along."""
        if velocities is not None:
            prims = self._bases(indices)
            both = rows(velocities, 6, len(prims))
            bodies.set_velocities(prims, both[:, :3], both[:, 3:])

    def set_linear_velocities(self, velocities: Values | None = None, indices: Indices = None) -> None:
        """Set (N, 3) [stage units/s]."""
        if velocities is not None:
            prims = self._bases(indices)
            bodies.set_velocities(prims, rows(velocities, 3, len(prims)), None)

    def set_angular_velocities(self, velocities: Values | None = None, indices: Indices = None) -> None:
        """Set (N, 3) [rad/s]."""
        if velocities is not None:
            prims = self._bases(indices)
            bodies.set_velocities(prims, None, rows(velocities, 3, len(prims)))

    # --- default and present states ---
    def set_default_state(
        self, positions: Values | None = None, orientations: Values | None = None, indices: Indices = None
    ) -> None:
        """Set the poses in the world that `post_reset` restores; what is not given stays."""
        super().set_default_state(positions, orientations, indices)
        self._note_defaults()
        where = chosen(indices, self.count)
        for number, values in enumerate((positions, orientations)):
            table = self._default_base[number]
            if values is not None and table is not None:
                table[where] = rows(values, table.shape[1], len(where))

    def set_joints_default_state(
        self, positions: Values | None = None, velocities: Values | None = None, efforts: Values | None = None
    ) -> None:
        """Set the positions, velocities and efforts (N, D) that `post_reset` gives joints; what is not given stays."""
        defaults = self._note_defaults()
        shape = self.count, self.num_dof
        for name, values in (("positions", positions), ("velocities", velocities), ("efforts", efforts)):
            if values is not None:
                setattr(defaults, name, np.array(grid(values, shape), np.float32))

    def get_joints_default_state(self) -> JointsState:
        """Return the state (N, D) that `post_reset` gives joints."""
        state = self._note_defaults()
        return JointsState(*(None if each is None else self._out(each)[0] for each in vars(state).values()))

    def get_joints_state(self) -> JointsState:
        """Return positions and velocities (N, D)."""
        return JointsState(self.get_joint_positions(), self.get_joint_velocities(), None)

    def _note_defaults(self) -> JointsState:
        if self._default_joints is None:
            self._drives.usual_gains()
            targets, velocities = self._drives.targets(), self._drives.velocity_targets()
            self._default_joints = JointsState(targets, velocities, np.zeros_like(targets))
            self._default_base = list(poses.world_poses(self._bases(None)))
        return self._default_joints

    def _bases(self, indices: Indices) -> list[Usd.Prim]:
        return self._links.bases(chosen(indices, self.count))

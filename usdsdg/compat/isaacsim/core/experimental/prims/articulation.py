"""`Articulation`: robots, whose joints follow what is set."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdPhysics

from usdsdg.compat.isaacsim.core.experimental.prims.articulation_links import ArticulationLinks
from usdsdg.compat.isaacsim.core.experimental.prims.articulation_settings import ArticulationSettings
from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import _pose_rows
from usdsdg.compat.wrappers import articulation_roots, bodies, poses
from usdsdg.compat.wrappers.arrays import chosen, grid, rows_or_none
from usdsdg.compat.wrappers.joints.rows import WHY
from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.compat.wrappers.unsupported import RefusedNames
from usdsdg.session import body_velocities

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

_STILL = (0.0, 0.0, 0.0)


class Articulation(ArticulationSettings, ArticulationLinks):
    """Robots: poses, links and joints. Tendons raise `Unsupported`.

    While physics plays, poses and velocities are those of the bases. Quaternions are (w, x, y, z).
    """

    __getattr__ = RefusedNames("Articulation", ("get_", "set_", "apply_", "num_fixed"), WHY)

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        resolve_paths: bool = True,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = False,
        enable_residual_reports: bool = False,
    ) -> None:
        """Wrap robots; see `XformPrim`. Residuals of a solver are not reported."""
        super().__init__(
            paths, resolve_paths=resolve_paths, positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip

    @staticmethod
    def fetch_articulation_root_api_prim_paths(paths: str | Sequence[str]) -> list[str | None]:
        """Return the path of the first prim with the ArticulationRootAPI at or below each prim; None without one."""
        existing, _ = ArticulationLinks.resolve_paths(paths)
        roots = [articulation_roots.root_of(prim_of(path)) for path in existing]
        return [str(root.GetPath()) if root.HasAPI(UsdPhysics.ArticulationRootAPI) else None for root in roots]

    def is_physics_tensor_entity_valid(self) -> bool:
        """Whether physics simulates."""
        return bodies.is_simulating()

    is_physics_tensor_entity_initialized = is_physics_tensor_entity_valid

    # --- poses and velocities of the bases ---
    def get_world_poses(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return positions (N, 3) and orientations (N, 4) in the world."""
        if not bodies.is_simulating():
            return super().get_world_poses(indices=indices)
        positions, orientations = poses.world_poses(self._bases(indices))
        return self._warp(positions), self._warp(orientations)

    def set_world_poses(
        self, positions: Values | None = None, orientations: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Place robots in the world; what is not given stays.

        Raises:
            AssertionError: neither is given.
        """
        if not bodies.is_simulating():
            super().set_world_poses(positions, orientations, indices=indices)
            return
        prims = self._bases(indices)
        poses.set_world_poses(prims, *_pose_rows(positions, orientations, len(prims)), strict=False)
        bodies.place_links()

    def get_local_poses(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return translations (N, 3) and orientations (N, 4) relative to the parents of the robots' prims."""
        if not bodies.is_simulating():
            return super().get_local_poses(indices=indices)
        world = poses.world_poses(self._bases(indices))
        translations, orientations = poses.local_from_world(self._chosen(indices), *world)
        return self._warp(translations.astype(np.float32)), self._warp(orientations.astype(np.float32))

    def set_local_poses(
        self, translations: Values | None = None, orientations: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Place robots relative to the parents of their prims; what is not given stays.

        Raises:
            AssertionError: neither is given.
        """
        if not bodies.is_simulating():
            super().set_local_poses(translations, orientations, indices=indices)
            return
        prims, bases = self._chosen(indices), self._bases(indices)
        given = _pose_rows(translations, orientations, len(prims))
        poses.move_to_local(bases, prims, *given)
        bodies.place_links()

    def get_velocities(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return linear (N, 3) [stage units/s] and angular velocities (N, 3) [rad/s] in the world."""
        linear, angular = body_velocities.velocities(self._bases(indices))
        return self._warp(linear), self._warp(angular)

    def set_velocities(
        self,
        linear_velocities: Values | None = None,
        angular_velocities: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set linear [stage units/s] or angular velocities [rad/s]; links move along, and what is not given stays.

        Raises:
            AssertionError: neither is given.
        """
        if linear_velocities is None and angular_velocities is None:
            raise AssertionError("give linear_velocities or angular_velocities")
        prims = self._bases(indices)
        both = (rows_or_none(each, 3, len(prims)) for each in (linear_velocities, angular_velocities))
        bodies.set_velocities(prims, *both)

    # --- default state ---
    def set_default_state(
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        linear_velocities: Values | None = None,
        angular_velocities: Values | None = None,
        dof_positions: Values | None = None,
        dof_velocities: Values | None = None,
        dof_efforts: Values | None = None,
        *,
        indices: Indices = None,
        dof_indices: Indices = None,
    ) -> None:
        """Remember states for `reset_to_default_state`; what is never set of a kind that is set is 0."""
        if positions is not None or orientations is not None:
            super().set_default_state(positions, orientations, indices=indices)
        self._set_default("linear_velocities", linear_velocities, _STILL, indices)
        self._set_default("angular_velocities", angular_velocities, _STILL, indices)
        where, columns = chosen(indices, len(self)), chosen(dof_indices, self.num_dofs)
        given = (("dof_positions", dof_positions), ("dof_velocities", dof_velocities), ("dof_efforts", dof_efforts))
        for name, values in given:
            if values is not None:
                table = self._defaults.setdefault(name, np.zeros((len(self), self.num_dofs), np.float32))
                table[np.ix_(where, columns)] = grid(values, (len(where), len(columns)))

    def get_default_state(self, *, indices: Indices = None, dof_indices: Indices = None) -> tuple[wp.array | None, ...]:
        """Return default positions, orientations, linear and angular velocities, and positions, velocities and efforts
        of joints; None where none have been set."""
        velocities = (self._default(name, indices) for name in ("linear_velocities", "angular_velocities"))
        tables = [self._defaults.get(name) for name in ("dof_positions", "dof_velocities", "dof_efforts")]
        joints = (None if table is None else self._part(table, indices, dof_indices) for table in tables)
        return (*super().get_default_state(indices=indices), *velocities, *joints)

    def reset_to_default_state(self, *, warn_on_non_default_state: bool = False) -> None:
        """Set states as `set_default_state` says; drives get the positions and velocities of joints as targets.

        Raises:
            PhysicsError: there are default efforts, and physics does not play.
        """
        super().reset_to_default_state(warn_on_non_default_state=warn_on_non_default_state)
        linear, angular = self._defaults.get("linear_velocities"), self._defaults.get("angular_velocities")
        if linear is not None or angular is not None:
            self.set_velocities(linear, angular)
        if (positions := self._defaults.get("dof_positions")) is not None:
            self.set_dof_positions(positions)
            self.set_dof_position_targets(positions)
        if (velocities := self._defaults.get("dof_velocities")) is not None:
            self.set_dof_velocities(velocities)
            self.set_dof_velocity_targets(velocities)
        if (efforts := self._defaults.get("dof_efforts")) is not None:
            self.set_dof_efforts(efforts)

    def _bases(self, indices: Indices) -> list[Usd.Prim]:
        return self._links.bases(chosen(indices, len(self)))

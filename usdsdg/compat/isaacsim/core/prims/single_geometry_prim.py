"""`SingleGeometryPrim`: one collider."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdGeom

from usdsdg.compat.isaacsim.core.prims.geometry_prim import GeometryPrim
from usdsdg.compat.isaacsim.core.prims.single_xform_prim import SingleXFormPrim

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.api.materials.physics_material import PhysicsMaterial

_MOST_CONTACTS = 1000


class SingleGeometryPrim(SingleXFormPrim):
    """One gprim as a collider."""

    def __init__(
        self,
        prim_path: str,
        name: str = "geometry_prim",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        reset_xform_properties: bool = True,
        collision: bool = False,
        track_contact_forces: bool = False,
        prepare_contact_sensor: bool = False,
        disable_stablization: bool = True,
        contact_filter_prim_paths_expr: Sequence[str] | None = None,
    ) -> None:
        """Wrap a prim, see `SingleXFormPrim`.

        Args:
            collision: Make it a collider.
            track_contact_forces: Whether `get_net_contact_forces` returns a force; so it does with filters.
            prepare_contact_sensor: Let the prim, if its contacts are tracked, and filters, report their contacts.
            disable_stablization: Without effect: contact forces are those that the solver applied.
            contact_filter_prim_paths_expr: Prims whose contacts are reported one by one.
        """
        # Named, since a dynamic object is a SingleGeometryPrim too, which has been initialized before.
        SingleXFormPrim.__init__(
            self, prim_path, name, position, translation, orientation, scale, visible, reset_xform_properties
        )
        self._collider = GeometryPrim(
            prim_path, name, reset_xform_properties=False, collisions=[collision],
            track_contact_forces=track_contact_forces, prepare_contact_sensors=prepare_contact_sensor,
            contact_filter_prim_paths_expr=contact_filter_prim_paths_expr, max_contact_count=_MOST_CONTACTS,
        )  # fmt: skip

    @property
    def geom(self) -> UsdGeom.Gprim:
        """Return the prim as its schema."""
        return self._collider.geoms[0]

    def set_collision_enabled(self, enabled: bool) -> None:
        """Turn collisions on or off; turned on, the prim becomes a collider."""
        self._collider.enable_collision() if enabled else self._collider.disable_collision()

    def get_collision_enabled(self) -> bool:
        return bool(self._collider.is_collision_enabled()[0])

    def set_collision_approximation(self, approximation_type: str) -> None:
        """Set how a mesh collides: "none", "convexHull", "boundingCube", "convexDecomposition", "sdf", ..."""
        self._collider.set_collision_approximations([approximation_type])

    def get_collision_approximation(self) -> str:
        return self._collider.get_collision_approximations()[0]

    def set_contact_offset(self, offset: float) -> None:
        self._collider.set_contact_offsets(offset)

    def get_contact_offset(self) -> float:
        return float(self._collider.get_contact_offsets()[0])

    def set_rest_offset(self, offset: float) -> None:
        self._collider.set_rest_offsets(offset)

    def get_rest_offset(self) -> float:
        return float(self._collider.get_rest_offsets()[0])

    def set_torsional_patch_radius(self, radius: float) -> None:
        self._collider.set_torsional_patch_radii(radius)

    def get_torsional_patch_radius(self) -> float:
        return float(self._collider.get_torsional_patch_radii()[0])

    def set_min_torsional_patch_radius(self, radius: float) -> None:
        self._collider.set_min_torsional_patch_radii(radius)

    def get_min_torsional_patch_radius(self) -> float:
        return float(self._collider.get_min_torsional_patch_radii()[0])

    def apply_physics_material(self, physics_material: PhysicsMaterial, weaker_than_descendants: bool = False) -> None:
        self._collider.apply_physics_materials(physics_material, weaker_than_descendants)

    def get_applied_physics_material(self) -> PhysicsMaterial | None:
        return self._collider.get_applied_physics_materials()[0]

    # --- contacts ---
    def get_net_contact_forces(self, dt: float = 1.0) -> np.ndarray | None:
        """Return the contact force (3,) with anything, an impulse for dt=1: see `GeometryPrim`."""
        return _of_one(self._collider.get_net_contact_forces(dt=dt))

    def get_contact_force_matrix(self, dt: float = 1.0) -> np.ndarray | None:
        """Return the contact forces (filters, 3) with each filter: see `GeometryPrim`."""
        return _of_one(self._collider.get_contact_force_matrix(dt=dt))

    def get_contact_force_data(self, dt: float = 1.0) -> tuple[np.ndarray, ...] | None:
        """Return the contact points with filters, the last two arrays (filters,): see `GeometryPrim`."""
        return _of_pairs(self._collider.get_contact_force_data(dt=dt))

    def get_friction_data(self, dt: float = 1.0) -> tuple[np.ndarray, ...] | None:
        """Return the friction in contacts with filters, the last two arrays (filters,): see `GeometryPrim`."""
        return _of_pairs(self._collider.get_friction_data(dt=dt))


def _of_one(found: np.ndarray | None) -> np.ndarray | None:
    return None if found is None else found[0]


def _of_pairs(found: tuple[np.ndarray, ...] | None) -> tuple[np.ndarray, ...] | None:
    """Return arrays of which the last two have a row per prim, with that of the only prim."""
    return None if found is None else (*found[:-2], found[-2][0], found[-1][0])

"""`GeometryPrim`: several colliders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdGeom

from usdsdg.compat.isaacsim.core.experimental.prims.geom_prim import GeomPrim
from usdsdg.compat.isaacsim.core.prims.contact_view import ContactTracker
from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.wrappers import bindings
from usdsdg.compat.wrappers.arrays import chosen, column

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.api.materials.physics_material import PhysicsMaterial
    from usdsdg.compat.wrappers.arrays import Indices, Values


class GeometryPrim(ContactTracker, XFormPrim):
    """Gprims as colliders. Contact forces are those of `RigidContactView`."""

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str = "geometry_prim_view",
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        visibilities: Values | None = None,
        reset_xform_properties: bool = True,
        collisions: Values | None = None,
        track_contact_forces: bool = False,
        prepare_contact_sensors: bool = False,
        disable_stablization: bool = True,
        contact_filter_prim_paths_expr: Sequence[str] | None = None,
        max_contact_count: int = 0,
    ) -> None:
        """Wrap prims, see `XFormPrim`.

        Args:
            collisions: Which prims become colliders (N,).
            track_contact_forces: Whether `get_net_contact_forces` returns forces; so it does with filters.
            prepare_contact_sensors: Let prims whose contacts are tracked, and filters, report their contacts.
            disable_stablization: Without effect: contact forces are those that the solver applied.
            contact_filter_prim_paths_expr: Prims whose contacts are reported one by one, see `RigidContactView`.
            max_contact_count: How many contact points are returned at most.
        """
        super().__init__(
            prim_paths_expr, name, positions, translations, orientations, scales, visibilities, reset_xform_properties
        )
        self._colliders = GeomPrim(self.prim_paths, resolve_paths=False)
        self._materials: dict[str, PhysicsMaterial] = {}  # that were applied here, by path
        for index, collides in enumerate(column(collisions, self.count) if collisions is not None else ()):
            if collides:
                self._colliders.apply_collision_apis(indices=index)
        self._track_contacts(
            prim_paths_expr, name, contact_filter_prim_paths_expr, track=track_contact_forces,
            prepare=prepare_contact_sensors, max_count=max_contact_count,
        )  # fmt: skip

    @property
    def geoms(self) -> list[UsdGeom.Gprim]:
        """Return each prim as its schema."""
        return self._colliders.geoms

    # --- colliders ---
    def apply_collision_apis(self, indices: Indices = None) -> None:
        self._colliders.apply_collision_apis(indices=indices)

    def enable_collision(self, indices: Indices = None) -> None:
        self._colliders.set_enabled_collisions(True, indices=indices)

    def disable_collision(self, indices: Indices = None) -> None:
        self._colliders.set_enabled_collisions(False, indices=indices)

    def is_collision_enabled(self, indices: Indices = None) -> np.ndarray:
        """Return which prims collide (N,)."""
        return self._out(self._colliders.get_enabled_collisions(indices=indices).numpy()[:, 0])[0]

    def set_collision_approximations(self, approximation_types: Sequence[str], indices: Indices = None) -> None:
        """Set how meshes collide: "none", "convexHull", "boundingCube", "convexDecomposition", "sdf", ..."""
        self._colliders.set_collision_approximations(approximation_types, indices=indices)

    def get_collision_approximations(self, indices: Indices = None) -> list[str]:
        return self._colliders.get_collision_approximations(indices=indices)

    def set_contact_offsets(self, offsets: Values, indices: Indices = None) -> None:
        self._colliders.set_offsets(contact_offsets=offsets, indices=indices)

    def get_contact_offsets(self, indices: Indices = None) -> np.ndarray:
        """Return (N,) [stage units]; -inf where PhysX chooses."""
        return self._out(self._colliders.get_offsets(indices=indices)[0].numpy()[:, 0])[0]

    def set_rest_offsets(self, offsets: Values, indices: Indices = None) -> None:
        self._colliders.set_offsets(rest_offsets=offsets, indices=indices)

    def get_rest_offsets(self, indices: Indices = None) -> np.ndarray:
        """Return (N,) [stage units]; -inf where PhysX chooses."""
        return self._out(self._colliders.get_offsets(indices=indices)[1].numpy()[:, 0])[0]

    def set_torsional_patch_radii(self, radii: Values, indices: Indices = None) -> None:
        self._colliders.set_torsional_patch_radii(radii, indices=indices)

    def get_torsional_patch_radii(self, indices: Indices = None) -> np.ndarray:
        """Return (N,) [stage units]."""
        return self._out(self._colliders.get_torsional_patch_radii(indices=indices).numpy()[:, 0])[0]

    def set_min_torsional_patch_radii(self, radii: Values, indices: Indices = None) -> None:
        self._colliders.set_torsional_patch_radii(radii, indices=indices, minimum=True)

    def get_min_torsional_patch_radii(self, indices: Indices = None) -> np.ndarray:
        """Return (N,) [stage units]."""
        return self._out(self._colliders.get_torsional_patch_radii(indices=indices, minimum=True).numpy()[:, 0])[0]

    # --- materials ---
    def apply_physics_materials(
        self,
        physics_materials: PhysicsMaterial | Sequence[PhysicsMaterial],
        weaker_than_descendants: bool | Sequence[bool] | None = None,
        indices: Indices = None,
    ) -> None:
        """Bind materials for physics; one for all, or one for each."""
        where = chosen(indices, self.count)
        several = isinstance(physics_materials, (list, tuple))
        weaker = column(False if weaker_than_descendants is None else weaker_than_descendants, len(where))
        for row, index in enumerate(where):
            material: PhysicsMaterial = physics_materials[row] if several else physics_materials  # pyright: ignore
            bindings.bind_one(self._prims[index], material.material, weaker=bool(weaker[row]), purpose="physics")
            self._materials[material.prim_path] = material

    def get_applied_physics_materials(self, indices: Indices = None) -> list[PhysicsMaterial | None]:
        """Return the materials bound for physics to the prims themselves; None for prims without one.

        A material that was applied here is the object that it was applied as.
        """
        wrap = bindings.wrapper_class("api.materials:PhysicsMaterial")
        paths = [bindings.bound(prim, purpose="physics") for prim in self._chosen(indices)]
        return [self._materials.get(path) or wrap(path) if path else None for path in paths]

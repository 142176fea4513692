"""`GeomPrim`: colliders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pxr import Usd, UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import XformPrim
from usdsdg.compat.wrappers import bindings, bodies
from usdsdg.compat.wrappers.arrays import column, names
from usdsdg.stage.schemas import physx

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.isaacsim.core.experimental.materials.physics_material import PhysicsMaterial
    from usdsdg.compat.wrappers.arrays import Indices, Values

_SHAPES = (UsdGeom.Capsule, UsdGeom.Cone, UsdGeom.Cube, UsdGeom.Cylinder, UsdGeom.Sphere, UsdGeom.Mesh)


class GeomPrim(XformPrim):
    """Gprims as colliders. Prims of other types may be wrapped too, and a schema is applied to them as to gprims."""

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
        apply_collision_apis: bool = False,
    ) -> None:
        """Wrap prims; see `XformPrim`. `apply_collision_apis` makes them colliders."""
        super().__init__(
            paths, resolve_paths=resolve_paths, positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if apply_collision_apis:
            self.apply_collision_apis()

    @property
    def geoms(self) -> list[UsdGeom.Gprim]:
        """Return each prim as its schema."""
        return [_geom(prim) for prim in self.prims]

    def apply_collision_apis(self, *, indices: Indices = None) -> None:
        """Make the prims colliders."""
        for prim in self._chosen(indices):
            for api in (UsdPhysics.CollisionAPI, UsdPhysics.MeshCollisionAPI, physx.PhysxCollisionAPI):
                api.Apply(prim)

    def set_collision_approximations(self, approximations: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set how meshes collide: "none", "convexHull", "boundingCube", "convexDecomposition", "sdf", ..."""
        prims = self._chosen(indices)
        bodies.write(prims, UsdPhysics.MeshCollisionAPI, "Approximation", names(approximations, len(prims)))

    def get_collision_approximations(self, *, indices: Indices = None) -> list[str]:
        """Return how meshes collide; the schema is applied where it is missing."""
        apis = self.ensure_api(self._chosen(indices), UsdPhysics.MeshCollisionAPI)
        return [str(api.GetApproximationAttr().Get()) for api in apis]

    def set_enabled_collisions(self, enabled: Values, *, indices: Indices = None) -> None:
        """Turn collisions on or off; turned on, a prim becomes a collider."""
        prims = self._chosen(indices)
        for prim, wanted in zip(prims, column(enabled, len(prims)), strict=True):
            if wanted:
                for api in (UsdPhysics.MeshCollisionAPI, physx.PhysxCollisionAPI):
                    api.Apply(prim)
            if wanted or prim.HasAPI(UsdPhysics.CollisionAPI):
                bodies.write([prim], UsdPhysics.CollisionAPI, "CollisionEnabled", [bool(wanted)])

    def get_enabled_collisions(self, *, indices: Indices = None) -> wp.array:
        """Return which prims collide (N, 1)."""
        api = UsdPhysics.CollisionAPI
        return self._warp(bodies.read(self._chosen(indices), api, api.GetCollisionEnabledAttr, False))

    def set_offsets(
        self, contact_offsets: Values | None = None, rest_offsets: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Author the contact and rest offsets of PhysX [stage units].

        Raises:
            AssertionError: neither is given.
        """
        if contact_offsets is None and rest_offsets is None:
            raise AssertionError("give contact_offsets or rest_offsets")
        prims = self._chosen(indices)
        for name, values in (("ContactOffset", contact_offsets), ("RestOffset", rest_offsets)):
            if values is not None:
                bodies.write(prims, physx.PhysxCollisionAPI, name, column(values, len(prims)))

    def get_offsets(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return contact and rest offsets (N, 1); -inf where PhysX chooses."""
        prims, api = self._chosen(indices), physx.PhysxCollisionAPI
        offsets = (
            bodies.read(prims, api, lambda each: each.GetContactOffsetAttr(), float("-inf")),
            bodies.read(prims, api, lambda each: each.GetRestOffsetAttr(), float("-inf")),
        )
        return self._warp(offsets[0]), self._warp(offsets[1])

    def set_torsional_patch_radii(self, radii: Values, *, indices: Indices = None, minimum: bool = False) -> None:
        """Author PhysX's radii of torsional friction [stage units]."""
        prims = self._chosen(indices)
        name = "MinTorsionalPatchRadius" if minimum else "TorsionalPatchRadius"
        bodies.write(prims, physx.PhysxCollisionAPI, name, column(radii, len(prims)))

    def get_torsional_patch_radii(self, *, indices: Indices = None, minimum: bool = False) -> wp.array:
        """Return PhysX's radii of torsional friction (N, 1) [stage units]."""
        name = "GetMinTorsionalPatchRadiusAttr" if minimum else "GetTorsionalPatchRadiusAttr"
        api = physx.PhysxCollisionAPI
        return self._warp(bodies.read(self._chosen(indices), api, lambda each: getattr(each, name)(), 0.0))

    def apply_physics_materials(
        self,
        materials: PhysicsMaterial | Sequence[PhysicsMaterial],
        *,
        weaker_than_descendants: Values | None = None,
        indices: Indices = None,
    ) -> None:
        """Bind the first prim of each material for physics; one for all, or one for each."""
        prims = self._chosen(indices)
        weaker = False if weaker_than_descendants is None else weaker_than_descendants
        bindings.bind(prims, materials, column(weaker, len(prims)), purpose="physics")

    def get_applied_physics_materials(self, *, indices: Indices = None) -> list[PhysicsMaterial | None]:
        """Return wrappers of the materials bound for physics to the prims themselves; None for prims without one."""
        fetch = bindings.wrapper_class("experimental.materials:PhysicsMaterial").fetch_instances
        paths = [bindings.bound(prim, purpose="physics") for prim in self._chosen(indices)]
        return [fetch(path)[0] if path else None for path in paths]


def _geom(prim: Usd.Prim) -> UsdGeom.Gprim:
    return next((shape(prim) for shape in _SHAPES if prim.IsA(shape)), UsdGeom.Gprim(prim))

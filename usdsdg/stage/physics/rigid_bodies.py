"""Apply the schemas of colliders and rigid bodies."""

from collections.abc import Iterator

from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.stage.schemas import physx


def gprims_below(root: Usd.Prim) -> Iterator[Usd.Prim]:
    """Yield the gprims at and below a prim; those inside instances are left out."""
    return (prim for prim in Usd.PrimRange(root) if prim.IsA(UsdGeom.Gprim))


def apply_collision_schemas(gprim: Usd.Prim, *, sdf: bool = False) -> None:
    """Make a gprim a collider, with PhysX's attributes, and with those of MeshCollisionAPI on a mesh.

    Args:
        sdf: apply PhysxSDFMeshCollisionAPI too.
    """
    UsdPhysics.CollisionAPI.Apply(gprim)
    physx.PhysxCollisionAPI.Apply(gprim)
    if sdf:
        physx.PhysxSDFMeshCollisionAPI.Apply(gprim)
    if gprim.IsA(UsdGeom.Mesh):
        UsdPhysics.MeshCollisionAPI.Apply(gprim)


def set_approximation(gprim: Usd.Prim, approximation: str) -> None:
    """Author how a collider's mesh is approximated; a gprim that is no mesh has no approximation and stays as it is."""
    if gprim.IsA(UsdGeom.Mesh):
        UsdPhysics.MeshCollisionAPI(gprim).CreateApproximationAttr(approximation)


def apply_rigid_body_schemas(prim: Usd.Prim) -> UsdPhysics.RigidBodyAPI:
    """Make a prim a rigid body, with PhysX's attributes."""
    body = UsdPhysics.RigidBodyAPI.Apply(prim)
    physx.PhysxRigidBodyAPI.Apply(prim)
    return body


def set_simulation_owner(prim: Usd.Prim, scene: Sdf.Path | None) -> None:
    """Author which PhysicsScene simulates a rigid body or collider; None leaves it as it is."""
    if scene is not None:
        prim.CreateRelationship("physics:simulationOwner", custom=False).SetTargets([scene])

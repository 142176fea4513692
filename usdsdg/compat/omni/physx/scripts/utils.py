"""`omni.physx.scripts.utils`: rigid bodies, colliders, joints, materials and filters on a stage.

The functions that take a `custom_execute_fn` author themselves what it would author; it is not called.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.compat.omni.physx.scripts.joints import MAX_FLOAT, create_unused_path, createJoint, createJoints
from usdsdg.errors import warn_once
from usdsdg.stage.schemas import physx
from usdsdg.stage.schemas.codeless import Schema

__all__ = [
    "MAX_FLOAT", "MESH_APPROXIMATIONS", "addCollisionGroup", "addPairFilter", "addPhysicsScene", "addPlaneCollider",
    "addRigidBodyMaterial", "ancestorHasAPI", "createJoint", "createJoints", "create_unused_path", "descendantHasAPI",
    "ensureMaterialOnPath", "getUnitScaleFactor", "get_basis", "hasAPI", "hasSchema", "isDefined", "removeCollider",
    "removeColliderSubtree", "removePairFilter", "removePhysics", "removeRigidBody", "removeRigidBodySubtree",
    "removeStaticCollider", "setCollider", "setColliderSubtree", "setPhysics", "setRigidBody", "setStaticCollider",
]  # fmt: skip

Execute = Callable[..., object] | None

# What is applied with each approximation of a mesh besides MeshCollisionAPI.
MESH_APPROXIMATIONS: dict[str, type[Schema] | None] = {
    "none": physx.PhysxTriangleMeshCollisionAPI,
    "convexHull": physx.PhysxConvexHullCollisionAPI,
    "convexDecomposition": physx.PhysxConvexDecompositionCollisionAPI,
    "meshSimplification": physx.PhysxTriangleMeshSimplificationCollisionAPI,
    "convexMeshSimplification": physx.PhysxTriangleMeshSimplificationCollisionAPI,
    "boundingCube": None,
    "boundingSphere": None,
    "sphereFill": physx.PhysxSphereFillCollisionAPI,
    "sdf": physx.PhysxSDFMeshCollisionAPI,
}


# --- rigid bodies and colliders ---
def setPhysics(prim: Usd.Prim, kinematic: bool, custom_execute_fn: Execute = None) -> None:
    """Make a prim a rigid body, without colliders; one that is a rigid body stays as it is."""
    if prim.HasAPI(UsdPhysics.RigidBodyAPI):
        warn_once(f"{prim.GetPath()} is a rigid body already, so setPhysics leaves it as it is")
        return
    body = UsdPhysics.RigidBodyAPI.Apply(prim)
    physx.PhysxRigidBodyAPI.Apply(prim)
    body.CreateRigidBodyEnabledAttr(True)
    body.CreateKinematicEnabledAttr(kinematic)


def setCollider(prim: Usd.Prim, approximationShape: str = "none", custom_execute_fn: Execute = None) -> None:
    """Make a prim a collider.

    Args:
        approximationShape: How a mesh collides, see `MESH_APPROXIMATIONS`; a mesh of a rigid body cannot collide with
            its triangles ("none") and has its convex hull then.
    """
    if prim.GetAttribute("omni:no_collision"):
        return
    is_mesh = prim.IsA(UsdGeom.Mesh)
    if is_mesh and approximationShape == "none" and ancestorHasAPI(UsdPhysics.RigidBodyAPI, prim):
        warn_once(f"{prim.GetPath()} belongs to a rigid body, so its convex hull collides, not its triangles")
        approximationShape = "convexHull"
    UsdPhysics.CollisionAPI.Apply(prim).CreateCollisionEnabledAttr(True)
    physx.PhysxCollisionAPI.Apply(prim)
    if is_mesh or prim.IsInstanceable():
        if approximationShape not in MESH_APPROXIMATIONS:
            known = ", ".join(MESH_APPROXIMATIONS)
            warn_once(f"{prim.GetPath()}: {approximationShape!r} is none of {known}, so its convex hull collides")
            approximationShape = "convexHull"
        api = MESH_APPROXIMATIONS[approximationShape]
        if api is not None:
            api.Apply(prim)
        UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(approximationShape)


def setColliderSubtree(prim: Usd.Prim, approximationShape: str = "none", execute_command_fn: Execute = None) -> None:
    """Make all geometry and instances at and below a prim colliders; see `setCollider`."""
    below = iter(Usd.PrimRange(prim))
    for each in below:
        if each.GetMetadata("hide_in_stage_window"):
            below.PruneChildren()
        elif each.IsA(UsdGeom.Gprim) or each.IsInstanceable():
            setCollider(each, approximationShape)


def setRigidBody(prim: Usd.Prim, approximationShape: str, kinematic: bool, custom_execute_fn: Execute = None) -> None:
    """Make a prim a rigid body, and all geometry at and below it colliders; see `setCollider`."""
    setPhysics(prim, kinematic)
    if prim.IsA(UsdGeom.Xformable):
        setColliderSubtree(prim, approximationShape)
    else:
        setCollider(prim, approximationShape)


def setStaticCollider(prim: Usd.Prim, approximationShape: str = "none", custom_execute_fn: Execute = None) -> None:
    """Make all geometry at and below a prim colliders; see `setCollider`."""
    setColliderSubtree(prim, approximationShape)


def removePhysics(prim: Usd.Prim, custom_execute_fn: Execute = None) -> None:
    """Let a prim be no rigid body; its colliders stay."""
    prim.RemoveAPI(UsdPhysics.RigidBodyAPI)
    prim.RemoveAPI(physx.PhysxRigidBodyAPI)


def removeCollider(prim: Usd.Prim, custom_execute_fn: Execute = None) -> None:
    """Let a prim be no collider."""
    prim.RemoveAPI(UsdPhysics.CollisionAPI)
    prim.RemoveAPI(physx.PhysxCollisionAPI)
    if prim.IsA(UsdGeom.Mesh) or prim.IsInstanceable():
        prim.RemoveAPI(UsdPhysics.MeshCollisionAPI)
        for api in dict.fromkeys(MESH_APPROXIMATIONS.values()):
            if api is not None:
                prim.RemoveAPI(api)


def removeColliderSubtree(prim: Usd.Prim, custom_execute_fn: Execute = None) -> None:
    """Let no geometry at and below a prim be a collider."""
    for each in Usd.PrimRange(prim):
        if each.IsA(UsdGeom.Gprim) or (each.IsInstanceable() and each.HasAPI(UsdPhysics.CollisionAPI)):
            removeCollider(each)


removeStaticCollider = removeColliderSubtree


def removeRigidBodySubtree(prim: Usd.Prim, custom_execute_fn: Execute = None) -> None:
    """Let a prim be no rigid body, and no geometry at and below it a collider."""
    removePhysics(prim)
    removeColliderSubtree(prim)


removeRigidBody = removeRigidBodySubtree


# --- scenes, materials, filters ---
def addPhysicsScene(stage: Usd.Stage, path: str | Sdf.Path) -> list[str | Sdf.Path]:
    """Define a PhysicsScene; return its path, or nothing, with a warning, if a prim has the path."""
    if isDefined(stage, path):
        return []
    UsdPhysics.Scene.Define(stage, path)
    return [path]


def ensureMaterialOnPath(stage: Usd.Stage, path: str | Sdf.Path) -> bool:
    """Define a material unless there is one; return False, with a warning, where another prim has the path."""
    prim = stage.GetPrimAtPath(str(path))
    if prim and not prim.IsA(UsdShade.Material):
        warn_once(f"{path} is a {prim.GetTypeName() or 'prim without a type'}, so no material is made there")
        return False
    if not prim:
        UsdShade.Material.Define(stage, path)
    return True


def addRigidBodyMaterial(
    stage: Usd.Stage,
    path: str | Sdf.Path,
    density: float | None = None,
    staticFriction: float | None = None,
    dynamicFriction: float | None = None,
    restitution: float | None = None,
) -> bool:
    """Define a material for physics, or add to one; return False where another prim has the path."""
    if not ensureMaterialOnPath(stage, path):
        return False
    material = UsdPhysics.MaterialAPI.Apply(stage.GetPrimAtPath(str(path)))
    for create, value in (
        (material.CreateStaticFrictionAttr, staticFriction),
        (material.CreateDynamicFrictionAttr, dynamicFriction),
        (material.CreateRestitutionAttr, restitution),
        (material.CreateDensityAttr, density),
    ):
        if value is not None:
            create().Set(value)
    return True


def addCollisionGroup(stage: Usd.Stage, path: str | Sdf.Path) -> None:
    """Define a collision group that filters none."""
    UsdPhysics.CollisionGroup.Define(stage, Sdf.Path(str(path))).CreateFilteredGroupsRel()


def addPlaneCollider(stage: Usd.Stage, prim_path: str | Sdf.Path, upAxis: str) -> None:
    """Define an unbounded plane that collides and is not seen."""
    plane = UsdGeom.Plane.Define(stage, prim_path)
    plane.CreateAxisAttr(upAxis)
    plane.CreatePurposeAttr(UsdGeom.Tokens.guide)
    setCollider(plane.GetPrim())


def addPairFilter(stage: Usd.Stage, paths: Sequence[str | Sdf.Path], custom_execute_fn: Execute = None) -> None:
    """Let prims not collide with each other."""
    for path in paths:
        pairs = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath(str(path))).CreateFilteredPairsRel()
        for other in paths:
            if str(other) != str(path):
                pairs.AddTarget(Sdf.Path(str(other)))


def removePairFilter(stage: Usd.Stage, paths: Iterable[str | Sdf.Path], custom_execute_fn: Execute = None) -> None:
    """Let prims collide with all others."""
    for path in paths:
        stage.GetPrimAtPath(str(path)).RemoveAPI(UsdPhysics.FilteredPairsAPI)


# --- questions ---
def isDefined(stage: Usd.Stage, path: str | Sdf.Path) -> bool:
    """Whether a prim has a path; warn if so."""
    found = bool(stage.GetPrimAtPath(str(path)))
    if found:
        warn_once(f"there is a prim at {path} already")
    return found


def hasSchema(prim: Usd.Prim, schemaName: str) -> bool:
    """Whether a schema, named as in "PhysicsRigidBodyAPI", is applied."""
    return schemaName in prim.GetAppliedSchemas()


def hasAPI(name: str, prim: Usd.Prim) -> bool:
    """Whether a schema is applied; see `hasSchema`."""
    return hasSchema(prim, name)


def descendantHasAPI(name: type, prim: Usd.Prim) -> bool:
    """Whether a schema is applied to a prim or one below it."""
    return any(each.HasAPI(name) for each in Usd.PrimRange(prim))


def ancestorHasAPI(name: type, prim: Usd.Prim) -> bool:
    """Whether a schema is applied to a prim or one above it."""
    while prim and not prim.IsPseudoRoot():
        if prim.HasAPI(name):
            return True
        prim = prim.GetParent()
    return False


def getUnitScaleFactor(stage: Usd.Stage) -> float:
    """Return how many stage units a meter is."""
    return 1.0 / UsdGeom.GetStageMetersPerUnit(stage)


def get_basis(up_axis: str) -> tuple[Gf.Vec3d, Gf.Vec3d, Gf.Vec3d]:
    """Return the directions up, forward and right of a stage whose up axis is "Y" or "Z"."""
    if up_axis == "Y":
        return Gf.Vec3d(0, 1, 0), Gf.Vec3d(0, 0, -1), Gf.Vec3d(1, 0, 0)
    return Gf.Vec3d(0, 0, 1), Gf.Vec3d(-1, 0, 0), Gf.Vec3d(0, 1, 0)

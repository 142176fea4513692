"""Stages for the physics tests, authored with pxr alone."""

from __future__ import annotations

import os
import warnings

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg import errors
from usdsdg_physics import NewtonEngine
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache

# Device of the physics tests, for example cuda:0.
DEVICE = os.environ.get("USDSDG_TEST_DEVICE", "cpu")


def new_stage(*, up: str = "Z", meters_per_unit: float = 1.0) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, meters_per_unit)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    scene = UsdPhysics.Scene.Define(stage, "/PhysicsScene").GetPrim()
    scene.CreateAttribute("physxScene:timeStepsPerSecond", Sdf.ValueTypeNames.UInt).Set(60)
    return stage


def add(
    stage: Usd.Stage,
    path: str,
    kind: str = "Cube",
    *,
    at=(0.0, 0.0, 0.0),
    rotate=None,
    scale=(0.1, 0.1, 0.1),
    body: bool = True,
    gravity: bool = True,
    angular_damping: float = 0.0,
    material: UsdShade.Material | None = None,
) -> Usd.Prim:
    """A gprim with a collider, and a rigid body unless `body` is False."""
    prim = stage.DefinePrim(path, kind)
    xformable = UsdGeom.Xformable(prim)
    xformable.AddTranslateOp().Set(Gf.Vec3d(*at))
    if rotate is not None:
        xformable.AddRotateXYZOp().Set(Gf.Vec3f(*rotate))
    xformable.AddScaleOp().Set(Gf.Vec3f(*scale))
    collide(prim)
    if body:
        make_body(prim, gravity=gravity, angular_damping=angular_damping)
    if material is not None:
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
    return prim


def collide(prim: Usd.Prim, *, approximation: str = "convexHull") -> None:
    UsdPhysics.CollisionAPI.Apply(prim)
    if prim.IsA(UsdGeom.Mesh):
        UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(approximation)


def make_body(prim: Usd.Prim, *, gravity: bool = True, angular_damping: float = 0.0) -> None:
    UsdPhysics.RigidBodyAPI.Apply(prim)
    prim.CreateAttribute("physxRigidBody:disableGravity", Sdf.ValueTypeNames.Bool).Set(not gravity)
    prim.CreateAttribute("physxRigidBody:angularDamping", Sdf.ValueTypeNames.Float).Set(angular_damping)


def physics_material(stage: Usd.Stage, path: str, *, friction: float = 0.5, restitution: float = 0.0, density=None):
    material = UsdShade.Material.Define(stage, path)
    api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    api.CreateStaticFrictionAttr(friction)
    api.CreateDynamicFrictionAttr(friction)
    api.CreateRestitutionAttr(restitution)
    if density is not None:
        api.CreateDensityAttr(density)
    return material


def mesh(stage: Usd.Stage, path: str, points: np.ndarray, triangles: np.ndarray) -> UsdGeom.Mesh:
    prim = UsdGeom.Mesh.Define(stage, path)
    prim.CreatePointsAttr([Gf.Vec3f(*map(float, point)) for point in points])
    prim.CreateFaceVertexCountsAttr([3] * len(triangles))
    prim.CreateFaceVertexIndicesAttr([int(index) for index in np.ravel(triangles)])
    return prim


def playing(stage: Usd.Stage) -> NewtonEngine:
    engine = NewtonEngine(stage, device=DEVICE)
    engine.play()
    return engine


def position(prim: Usd.Prim) -> np.ndarray:
    """World position of a prim [stage units]."""
    matrix = UsdGeom.XformCache().GetLocalToWorldTransform(prim)
    return np.array(matrix.ExtractTranslation())


def fallen(steps: int, *, rate: float = 60.0) -> float:
    """Distance [m] that a body falls from rest in so many steps, by its velocity at the end of each."""
    return 9.81 / rate**2 * steps * (steps + 1) / 2


def velocity(prim: Usd.Prim) -> np.ndarray:
    return np.array(prim.GetAttribute("physics:velocity").Get())


def set_value(prim: Usd.Prim, name: str, value: object) -> None:
    prim.GetAttribute(name).Set(value)


def warnings_of(stage: Usd.Stage) -> list[str]:
    """Return the warnings that reading the physics of a stage gives."""
    errors.forget_warnings()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parse(stage, HullCache())
    errors.forget_warnings()
    return [str(each.message) for each in caught]

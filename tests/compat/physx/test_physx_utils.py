"""`omni.physx.scripts.utils`: rigid bodies, colliders, joints and filters, read back with pxr."""

import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics, UsdShade

from usdsdg.compat.omni.physx.scripts import utils
from usdsdg.errors import UsdsdgWarning
from usdsdg.stage.schemas import physx


def mesh(stage, path):
    made = UsdGeom.Mesh.Define(stage, path)
    made.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    made.CreateFaceVertexCountsAttr([3] * 4)
    made.CreateFaceVertexIndicesAttr([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3])
    return made.GetPrim()


def test_a_rigid_body_has_colliders_on_all_geometry_below(stage):
    body = UsdGeom.Xform.Define(stage, "/body").GetPrim()
    shape, ball = mesh(stage, "/body/mesh"), UsdGeom.Sphere.Define(stage, "/body/part/ball").GetPrim()
    utils.setRigidBody(body, "convexDecomposition", False)
    api = UsdPhysics.RigidBodyAPI(body)
    assert (api.GetRigidBodyEnabledAttr().Get(), api.GetKinematicEnabledAttr().Get()) == (True, False)
    assert body.HasAPI(physx.PhysxRigidBodyAPI)
    assert [prim.HasAPI(UsdPhysics.CollisionAPI) for prim in (body, shape, ball)] == [False, True, True]
    assert UsdPhysics.MeshCollisionAPI(shape).GetApproximationAttr().Get() == "convexDecomposition"
    assert shape.HasAPI(physx.PhysxConvexDecompositionCollisionAPI)
    assert not ball.HasAPI(UsdPhysics.MeshCollisionAPI)
    assert utils.hasSchema(body, "PhysicsRigidBodyAPI")
    assert utils.hasAPI("PhysicsCollisionAPI", shape)
    assert utils.ancestorHasAPI(UsdPhysics.RigidBodyAPI, ball)
    assert utils.descendantHasAPI(UsdPhysics.CollisionAPI, body)
    with pytest.warns(UsdsdgWarning, match="/body is a rigid body already"):
        utils.setPhysics(body, True)
    utils.removeRigidBody(body)
    assert not body.GetAppliedSchemas()
    assert not shape.GetAppliedSchemas()
    assert not utils.descendantHasAPI(UsdPhysics.CollisionAPI, body)


def test_static_meshes_collide_with_their_triangles_and_those_of_bodies_cannot(stage):
    static = mesh(stage, "/static")
    utils.setStaticCollider(static)
    assert UsdPhysics.MeshCollisionAPI(static).GetApproximationAttr().Get() == "none"
    assert static.HasAPI(physx.PhysxTriangleMeshCollisionAPI)
    utils.removeStaticCollider(static)
    assert not static.GetAppliedSchemas()
    moving = mesh(stage, "/moving")
    with pytest.warns(UsdsdgWarning, match="/moving belongs to a rigid body"):
        utils.setRigidBody(moving, "none", True)
    assert UsdPhysics.MeshCollisionAPI(moving).GetApproximationAttr().Get() == "convexHull"
    with pytest.warns(UsdsdgWarning, match="'cloud' is none of none, convexHull"):
        utils.setCollider(mesh(stage, "/other"), "cloud")
    kept = mesh(stage, "/kept")
    kept.CreateAttribute("omni:no_collision", Sdf.ValueTypeNames.Bool).Set(True)
    utils.setCollider(kept)
    assert not kept.HasAPI(UsdPhysics.CollisionAPI)


@pytest.mark.parametrize("kind", ["Fixed", "Revolute", "Prismatic", "Spherical", "Distance", "D6", "Gear"])
def test_joints_connect_prims_where_they_are(stage, kind):
    first, second = (UsdGeom.Xform.Define(stage, f"/{name}") for name in ("first", "second"))
    first.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    first.AddScaleOp().Set(Gf.Vec3f(2))
    second.AddTranslateOp().Set(Gf.Vec3d(1, 4, 0))
    second.AddOrientOp().Set(Gf.Quatf(0, 0, 0, 1))
    prim = utils.createJoint(stage, kind, first.GetPrim(), second.GetPrim())
    assert str(prim.GetPath()) == f"/second/{kind}Joint"
    joint = UsdPhysics.Joint(prim)
    assert [str(rel.GetTargets()[0]) for rel in (joint.GetBody0Rel(), joint.GetBody1Rel())] == ["/first", "/second"]
    # In the space of the first prim, which scales by 2.
    assert Gf.IsClose(joint.GetLocalPos0Attr().Get(), Gf.Vec3f(0, 2, 0), 1e-6)
    assert joint.GetLocalPos1Attr().Get() == (0, 0, 0)
    assert Gf.IsClose(joint.GetLocalRot0Attr().Get().GetImaginary(), Gf.Vec3f(0, 0, 1), 1e-6)
    if kind in ("Revolute", "Prismatic", "Spherical"):
        assert prim.GetAttribute("physics:axis").Get() == "X"
    if kind == "D6":
        limit = UsdPhysics.LimitAPI(prim, "rotY")
        assert limit.GetLowAttr().Get() > limit.GetHighAttr().Get()  # locked


def test_one_prim_is_joined_to_the_world_or_to_its_parent(stage):
    UsdGeom.Xform.Define(stage, "/parent")
    child = UsdGeom.Xform.Define(stage, "/parent/child")
    child.AddTranslateOp().Set(Gf.Vec3d(0, 0, 3))
    to_world = UsdPhysics.Joint(utils.createJoint(stage, "Fixed", child.GetPrim(), None))
    assert not to_world.GetBody0Rel().GetTargets()
    assert to_world.GetLocalPos0Attr().Get() == (0, 0, 3)
    joints = utils.createJoints(stage, "Fixed", ["/parent/child", "/parent"], join_to_parent=True)
    assert [str(each.GetPath()) for each in joints] == ["/parent/child/FixedJoint0", "/parent/FixedJoint"]
    assert [len(UsdPhysics.Joint(each).GetBody0Rel().GetTargets()) for each in joints] == [1, 0]


def test_scenes_materials_planes_and_filters(stage):
    assert utils.addPhysicsScene(stage, "/scene") == ["/scene"]
    with pytest.warns(UsdsdgWarning, match="prim at /scene already"):
        assert utils.addPhysicsScene(stage, "/scene") == []
    assert utils.addRigidBodyMaterial(stage, "/ice", staticFriction=0.1, density=900.0)
    material = UsdPhysics.MaterialAPI(stage.GetPrimAtPath("/ice"))
    assert stage.GetPrimAtPath("/ice").IsA(UsdShade.Material)
    assert (material.GetStaticFrictionAttr().Get(), material.GetDensityAttr().Get()) == pytest.approx((0.1, 900.0))
    with pytest.warns(UsdsdgWarning, match="no material is made"):
        assert not utils.addRigidBodyMaterial(stage, "/scene")
    utils.addPlaneCollider(stage, "/plane", "Y")
    assert UsdGeom.Plane(stage.GetPrimAtPath("/plane")).GetAxisAttr().Get() == "Y"
    utils.addCollisionGroup(stage, "/group")
    assert stage.GetPrimAtPath("/group").IsA(UsdPhysics.CollisionGroup)
    for path in ("/a", "/b"):
        UsdGeom.Cube.Define(stage, path)
    utils.addPairFilter(stage, ["/a", "/b"])
    pairs = UsdPhysics.FilteredPairsAPI(stage.GetPrimAtPath("/a")).GetFilteredPairsRel().GetTargets()
    assert pairs == ["/b"]
    utils.removePairFilter(stage, ["/a", "/b"])
    assert not stage.GetPrimAtPath("/a").HasAPI(UsdPhysics.FilteredPairsAPI)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    assert utils.getUnitScaleFactor(stage) == pytest.approx(100.0)
    assert utils.get_basis("Y")[0] == (0, 1, 0)

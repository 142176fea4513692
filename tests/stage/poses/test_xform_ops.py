"""Poses of prims whose translate op is not the first: positions are those of the parent's space."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from usdsdg.errors import BadPrim
from usdsdg.stage.poses.pose_batch import author_poses
from usdsdg.stage.poses.xform_ops import author_pose, author_world_position, local_translation


def turned_orbit(stage, scale=(2, 2, 2)):
    """A prim that is moved, then scaled, then turned about its parent, as rigs of turntables are."""
    parent = UsdGeom.Xform.Define(stage, "/Rig")
    parent.AddTranslateOp().Set(Gf.Vec3d(10, 0, 0))
    prim = UsdGeom.Xform.Define(stage, "/Rig/Arm")
    prim.AddRotateZOp().Set(90.0)
    prim.AddScaleOp().Set(Gf.Vec3f(*scale))
    prim.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    return prim.GetPrim()


def origin(prim):
    """The place of the prim in its parent's space, as USD computes it."""
    return np.array(UsdGeom.Xformable(prim).GetLocalTransformation().ExtractTranslation())


def test_a_position_is_in_the_space_of_the_parent():
    stage = Usd.Stage.CreateInMemory()
    prim = turned_orbit(stage)
    np.testing.assert_allclose(local_translation(prim), origin(prim), atol=1e-12)
    author_pose(prim, translate=(1, 2, 3))
    np.testing.assert_allclose(origin(prim), (1, 2, 3), atol=1e-12)
    np.testing.assert_allclose(local_translation(prim), (1, 2, 3), atol=1e-12)
    assert [op.GetOpName() for op in UsdGeom.Xformable(prim).GetOrderedXformOps()] == [
        "xformOp:rotateZ",
        "xformOp:scale",
        "xformOp:translate",
    ]


def test_positions_of_many_prims_are_the_same():
    stage = Usd.Stage.CreateInMemory()
    prims = [turned_orbit(stage), UsdGeom.Xform.Define(stage, "/Plain").GetPrim()]
    author_poses(prims, translate=np.array([[1.0, 2, 3], [4, 5, 6]]))
    np.testing.assert_allclose([origin(prim) for prim in prims], [[1, 2, 3], [4, 5, 6]], atol=1e-12)


def test_a_point_of_the_world_is_reached():
    stage = Usd.Stage.CreateInMemory()
    prim = turned_orbit(stage)
    author_world_position(prim, (3, 4, 5))
    place = UsdGeom.XformCache().GetLocalToWorldTransform(prim).ExtractTranslation()
    np.testing.assert_allclose(place, (3, 4, 5), atol=1e-12)


def test_a_prim_that_is_scaled_to_zero_after_its_translation_cannot_be_placed():
    stage = Usd.Stage.CreateInMemory()
    prim = turned_orbit(stage, scale=(0, 1, 1))
    with pytest.raises(BadPrim, match="/Rig/Arm cannot be placed"):
        author_pose(prim, translate=(1, 2, 3))

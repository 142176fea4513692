"""Places in the world of prims below ancestors that are scaled; UsdGeom computes where they are."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from usdsdg.compat.wrappers.poses import set_world_poses
from usdsdg.errors import DegenerateFrame
from usdsdg.stage.poses.relative_poses import relative_to_parents
from usdsdg.stage.poses.world_poses import author_world_pose
from usdsdg.stage.poses.xform_ops import author_world_position

PLACE, UPRIGHT = (3.0, 4.0, 5.0), (0.0, 0.0, 0.0, 1.0)


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


def below_scaled(stage, scale):
    """A prim below one that is scaled and turned: where an axis vanishes, its determinant is not exactly 0."""
    parent = UsdGeom.Xform.Define(stage, "/Scaled")
    parent.AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40))
    parent.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*scale))
    return UsdGeom.Xform.Define(stage, "/Scaled/Part").GetPrim()


def by_pose(prim):
    author_world_pose(prim, PLACE, UPRIGHT)


def by_position(prim):
    author_world_position(prim, PLACE)


def by_wrapper(prim):
    set_world_poses([prim], np.array([PLACE]), np.array([(1.0, 0.0, 0.0, 0.0)]), strict=False)


def by_frame(prim):
    moved, _, _ = relative_to_parents([prim], [prim.GetStage().GetPseudoRoot()], np.array([PLACE]), None, None)
    UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(*moved[0].tolist()))


@pytest.mark.parametrize("place", [by_pose, by_position, by_wrapper, by_frame])
@pytest.mark.parametrize("scale", [1.0, 5e-5, 1e-8])
def test_a_prim_below_a_small_ancestor_is_placed(stage, place, scale):
    prim = below_scaled(stage, (scale,) * 3)
    place(prim)
    found = UsdGeom.XformCache().GetLocalToWorldTransform(prim).ExtractTranslation()
    np.testing.assert_allclose(found, PLACE, rtol=1e-6)  # the experimental wrappers have float32


@pytest.mark.parametrize("place", [by_pose, by_position, by_wrapper, by_frame])
def test_a_prim_below_a_flat_ancestor_is_told_of(stage, place):
    with pytest.raises(DegenerateFrame, match=r"^/Scaled/Part cannot be placed: an ancestor is scaled to zero"):
        place(below_scaled(stage, (1.0, 0.0, 1.0)))


def test_the_prim_that_cannot_be_placed_is_named(stage):
    flat = below_scaled(stage, (0.0, 1.0, 1.0))
    first = UsdGeom.Xform.Define(stage, "/First").GetPrim()
    with pytest.raises(DegenerateFrame, match=r"^/Scaled/Part"):
        set_world_poses([first, flat], np.zeros((2, 3)), np.array([(1.0, 0, 0, 0)] * 2), strict=False)

"""Matrices of prims that the renderer has read are those that USD composes."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg_render.renderer import WarpRenderer


def scene(rng):
    """Return a stage of nested prims with all kinds of ops, one of which is instanced twice."""
    stage = Usd.Stage.CreateInMemory()
    stage.CreateClassPrim("/Model")
    UsdGeom.Cube.Define(stage, "/Model/arm/box").AddRotateZYXOp().Set(Gf.Vec3f(*rng.uniform(-180, 180, 3)))
    for name in ("a", "a/b", "a/b/c", "d"):
        place(UsdGeom.Cube.Define(stage, f"/World/{name}"), rng)
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/a/b/c")).SetResetXformStack(True)
    for name in ("first", "second"):
        copy = UsdGeom.Xform.Define(stage, f"/World/a/{name}")
        copy.GetPrim().GetReferences().AddInternalReference("/Model")
        copy.GetPrim().SetInstanceable(True)
        place(copy, rng)
    UsdGeom.Camera.Define(stage, "/World/camera")
    return stage


def place(xform, rng):
    xform.AddTranslateOp().Set(Gf.Vec3d(*rng.uniform(-9, 9, 3)))
    xform.AddOrientOp().Set(Gf.Quatf(*rng.normal(size=4)).GetNormalized())
    xform.AddScaleOp().Set(Gf.Vec3f(*rng.uniform(0.5, 2, 3)))


@pytest.mark.parametrize("seed", range(3))
def test_places_are_those_of_usd_after_each_sync(seed):
    rng = np.random.default_rng(seed)
    stage = scene(rng)
    renderer = WarpRenderer(stage, device="cpu")
    everything = [each.GetPath() for each in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())][1:]
    paths = [path for path in everything if not path.HasPrefix("/Model")]
    for number in range(3):
        renderer.sync()
        rows, matrices = renderer.places([*paths, Sdf.Path("/World/none")])
        assert rows.tolist() == list(range(len(paths)))
        cache = UsdGeom.XformCache()
        expected = [np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path))) for path in paths]
        np.testing.assert_allclose(matrices, expected, rtol=1e-12, atol=1e-12)
        stage.GetAttributeAtPath("/World/a.xformOp:translate").Set(Gf.Vec3d(number, 2, 3))
        stage.GetAttributeAtPath("/World/a/second.xformOp:scale").Set(Gf.Vec3f(1, 2, 3))


def test_places_of_animated_prims_are_those_at_the_time():
    stage = scene(np.random.default_rng(0))
    spin = stage.GetAttributeAtPath("/World/a.xformOp:translate")
    spin.Set(Gf.Vec3d(0), 0)
    spin.Set(Gf.Vec3d(8, 0, 0), 8)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(8)
    renderer = WarpRenderer(stage, device="cpu")
    for time in (0, 3, 8):
        renderer.sync(Usd.TimeCode(time))
        _, (matrix,) = renderer.places([Sdf.Path("/World/a/b")])
        cache = UsdGeom.XformCache(Usd.TimeCode(time))
        expected = np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath("/World/a/b")))
        np.testing.assert_allclose(matrix, expected, rtol=1e-12, atol=1e-12)


def test_prims_that_were_hidden_at_the_first_sync_have_no_place():
    stage = scene(np.random.default_rng(0))
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/d")).MakeInvisible()
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    rows, matrices = renderer.places([Sdf.Path("/World/d"), Sdf.Path("/World/a")])
    assert rows.tolist() == [1]
    assert matrices.shape == (1, 4, 4)

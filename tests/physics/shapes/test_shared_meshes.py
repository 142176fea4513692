"""Prims with the same points and faces share triangles and hulls; no others do, whatever differs between them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
import warp as wp
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.physics.scenes import collide, make_body, mesh, new_stage, playing, position
from usdsdg import errors
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes import convex_hulls, mesh_triangles
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.scene.records import Collider, Shape
from usdsdg_physics.world.compile_kernels import prepare_newton

BOX = trimesh.creation.box(extents=(0.4, 0.3, 0.2))
# A wedge and a lower box of which faces may be left out: four-sided faces, and a point that no face names.
POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0.5), (1, 1, 0.5), (0, 1, 1), (0.5, 0.5, 2)]
COUNTS = [4, 4, 4, 4, 4, 4]
INDICES = [0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7]


def _add(stage: Usd.Stage, path: str, approximation: str) -> UsdGeom.Mesh:
    made = UsdGeom.Mesh.Define(stage, path)
    made.CreatePointsAttr(POINTS)
    made.CreateFaceVertexCountsAttr(COUNTS)
    made.CreateFaceVertexIndicesAttr(INDICES)
    collide(made.GetPrim(), approximation=approximation)
    return made


def _move_point(made: UsdGeom.Mesh) -> None:
    made.GetPointsAttr().Set([*POINTS[:4], (0, 0, 1.5), *POINTS[5:]])


def _sample_points(made: UsdGeom.Mesh) -> None:
    made.GetPointsAttr().Clear()
    made.GetPointsAttr().Set(POINTS, 0.0)
    made.GetPointsAttr().Set([(x, y, 3 * z) for x, y, z in POINTS], 10.0)


def _name_subset(made: UsdGeom.Mesh, family: str) -> None:
    UsdGeom.Subset.CreateGeomSubset(made, "part", "face", [1], family, "")


VARIATIONS = {
    "nothing": lambda made: None,
    "scale": lambda made: made.AddScaleOp().Set(Gf.Vec3f(1, 2, 3)),
    "mirrored": lambda made: made.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1)),
    "sheared": lambda made: made.AddTransformOp().Set(Gf.Matrix4d(1, 0.5, 0, 0, 0, 1, 0, 0, 0, 0.25, 1, 0, 0, 0, 0, 1)),
    "orientation": lambda made: made.CreateOrientationAttr("leftHanded"),
    "subdivision": lambda made: made.CreateSubdivisionSchemeAttr("none"),
    "hole": lambda made: made.CreateHoleIndicesAttr([1]),
    "other hole": lambda made: made.CreateHoleIndicesAttr([2]),
    "holes": lambda made: made.CreateHoleIndicesAttr([0, 1, 2, 3, 4, 5]),
    "counts": lambda made: made.GetFaceVertexCountsAttr().Set([4, 4, 4, 4, 3, 5]),
    "fewer faces": lambda made: made.GetFaceVertexCountsAttr().Set(COUNTS[:4]),
    "indices": lambda made: made.GetFaceVertexIndicesAttr().Set([8, *INDICES[1:]]),
    "point": _move_point,
    "fewer points": lambda made: made.GetPointsAttr().Set(POINTS[:8]),
    "point that is not finite": lambda made: made.GetPointsAttr().Set([(np.nan, 0, 0), *POINTS[1:]]),
    "samples": _sample_points,
    "subset": lambda made: _name_subset(made, "materialBind"),
    "invisible faces": lambda made: _name_subset(made, "invisible"),
    "guide": lambda made: made.CreatePurposeAttr("guide"),
}
# No face names the last point.
SAME_SOLID = {"nothing", "fewer points", "scale", "mirrored", "subdivision", "subset", "invisible faces", "guide"}


def _colliders(stage: Usd.Stage, hulls: HullCache, time: float = 10.0) -> dict[str, Collider]:
    errors.forget_warnings()
    return parse(stage, hulls, time=Usd.TimeCode(time)).colliders


def _numbers(shape: Shape) -> tuple[object, ...]:
    solid = shape.solid
    arrays = () if solid is None else (solid.vertices, solid.triangles, solid.centroid, solid.covariance)
    size = () if solid is None else (solid.key, solid.volume, *((array.dtype, array.tobytes()) for array in arrays))
    return shape.kind, shape.size, shape.position, shape.rotation, size


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("approximation", ["none", "convexHull", "boundingCube", "boundingSphere"])
@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("variation", VARIATIONS)
def test_a_mesh_collides_as_it_does_alone(variation, first, approximation, monkeypatch):
    """Beside one from which it differs in one thing, read before or after it, as in a process that knows neither."""

    def author(*names: str) -> Usd.Stage:
        stage = new_stage()
        for name in names:
            made = _add(stage, f"/World/{name}", approximation)
            if name == "varied":
                VARIATIONS[variation](made)
        return stage

    found = _colliders(author(*(("varied", "base") if first else ("base", "varied"))), HullCache())
    for name in ("base", "varied"):
        monkeypatch.setattr(convex_hulls, "_known", {})
        alone = _colliders(author(name), HullCache())
        path = f"/World/{name}"
        assert (path in found) == (path in alone)
        if path in alone:
            assert _numbers(found[path].shape) == _numbers(alone[path].shape)
    if approximation == "none" and "/World/varied" in found:
        same = found["/World/base"].shape.solid is found["/World/varied"].shape.solid
        assert same == (variation in SAME_SOLID)


def test_samples_are_read_at_the_time_of_each_play():
    stage, hulls = new_stage(), HullCache()
    _sample_points(_add(stage, "/World/base", "convexHull"))
    with pytest.warns(errors.UsdsdgWarning, match="does not follow time samples and splines of points"):
        heights = [
            np.ptp(_colliders(stage, hulls, time)["/World/base"].shape.solid.vertices[:, 2])
            for time in (0.0, 10.0, 0.0)
        ]
    assert heights == [1.0, 3.0, 1.0]
    errors.forget_warnings()


def test_many_references_are_cut_into_triangles_once(monkeypatch):
    calls, made = [], mesh_triangles.face_triangles
    monkeypatch.setattr(mesh_triangles, "face_triangles", lambda *arrays: calls.append(1) or made(*arrays))
    stage, hulls = new_stage(), HullCache()
    mesh(stage, "/Asset/mesh", BOX.vertices, BOX.faces)
    for index in range(5):
        prim = stage.DefinePrim(f"/World/box_{index}", "Xform")
        prim.GetReferences().AddInternalReference("/Asset")
        collide(stage.GetPrimAtPath(f"/World/box_{index}/mesh"))
    found = _colliders(stage, hulls)
    assert len(found) == 5
    assert len({id(collider.shape.solid) for collider in found.values()}) == 1
    assert len(calls) == 1
    _colliders(stage, hulls)
    assert len(calls) == 1


def test_what_is_wrong_with_a_mesh_is_said_of_each_prim_that_has_it(recwarn):
    stage, hulls = new_stage(), HullCache()
    for name in ("a", "b"):
        made = _add(stage, f"/World/{name}", "none")
        made.GetFaceVertexIndicesAttr().Set([77, *INDICES[1:]])
        made.GetPointsAttr().Set([*POINTS[:8], (np.inf, 0, 0)])
    _colliders(stage, hulls)
    said = [str(each.message) for each in recwarn if issubclass(each.category, errors.UsdsdgWarning)]
    for name in ("a", "b"):
        for words in ("1 of its faces does not collide, with points outside 0..8", "1 of its points is not finite"):
            assert any(text.startswith(f"/World/{name}: {words}") for text in said)
    errors.forget_warnings()


def test_a_flat_mesh_is_named_again_on_the_next_stage():
    for name in ("first", "second"):
        with pytest.warns(errors.UsdsdgWarning, match=f"/World/{name} is flat"):
            hull = HullCache().hull(np.array(POINTS[:4], np.float32), prim_path=f"/World/{name}")
        assert hull.volume > 0
    errors.forget_warnings()


def test_an_edit_of_one_prim_while_physics_plays_leaves_the_other_as_it_is():
    stage = new_stage()
    floor = mesh(stage, "/World/floor", np.array([(-9, -9, 0), (9, -9, 0), (0, 9, 0)]), np.array([[0, 1, 2]]))
    collide(floor.GetPrim(), approximation="none")
    prims = []
    for index in range(2):
        made = mesh(stage, f"/World/box_{index}", BOX.vertices, BOX.faces)
        made.AddTranslateOp().Set(Gf.Vec3d(2 * index, 0, 0.11))
        collide(made.GetPrim())
        make_body(made.GetPrim())
        prims.append(made)
    engine = playing(stage)
    engine.advance(0.5)
    taller = BOX.vertices * (1, 1, 3)
    prims[0].GetPointsAttr().Set(taller.astype(np.float32))
    prims[0].GetPrim().GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 0.31))
    engine.advance(0.5)
    assert position(prims[0].GetPrim())[2] == pytest.approx(0.3, abs=2e-3)
    assert position(prims[1].GetPrim())[2] == pytest.approx(0.1, abs=2e-3)
    prims[0].GetPointsAttr().Set(BOX.vertices.astype(np.float32))
    engine.advance(1.0)
    assert position(prims[0].GetPrim())[2] == pytest.approx(0.1, abs=2e-3)
    assert position(prims[1].GetPrim())[2] == pytest.approx(0.1, abs=2e-3)


def test_only_so_much_is_kept(monkeypatch):
    monkeypatch.setattr(mesh_triangles, "MOST_BYTES", 1000)
    stage, hulls = new_stage(), HullCache()
    for index in range(20):
        made = _add(stage, f"/World/m{index}", "none")
        made.GetPointsAttr().Set([*POINTS[:8], (0.5, 0.5, index)])
        made.GetFaceVertexIndicesAttr().Set([*INDICES[:-1], 8])
    found = _colliders(stage, hulls)
    assert [float(found[f"/World/m{i}"].shape.solid.vertices[-1, 2]) for i in range(20)] == list(range(20))
    kept = list(hulls.triangles._known.values())
    assert 0 < sum(each.points.nbytes + each.triangles.nbytes for each in kept) <= 1000


def test_shared_arrays_cannot_be_written():
    stage, hulls = new_stage(), HullCache()
    read = hulls.triangles.read(_add(stage, "/World/base", "none").GetPrim())
    for array in (read.points, read.triangles):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_arrays_do_not_change_with_the_stage():
    """Where no face can be used, the points are those of the prim, which it may have in memory."""
    stage, hulls = new_stage(), HullCache()
    made = _add(stage, "/World/base", "convexHull")
    made.GetFaceVertexCountsAttr().Set([])
    with pytest.warns(errors.UsdsdgWarning, match="of which the rest is not used"):
        read = hulls.triangles.read(made.GetPrim())
    _move_point(made)
    stage.GetRootLayer().Clear()
    assert np.array_equal(read.points, np.array(POINTS, np.float32))
    errors.forget_warnings()


def test_kernels_are_not_read_again_for_the_next_world():
    prepare_newton()
    module = wp.get_module("newton._src.sim.articulation")
    module.get_module_hash()
    before = dict(module.hashers)
    assert before
    prepare_newton()
    assert module.hashers == before
    assert wp.get_module_options(module)["enable_backward"] is False


def test_types_of_arrays_are_part_of_the_key():
    zeros = (np.zeros(4, np.int32), np.zeros(4, np.float32), np.zeros((2, 2), np.int32))
    keys = {mesh_triangles._digest(array) for array in zeros}
    assert len(keys) == 3
    assert mesh_triangles._digest(zeros[0], zeros[1]) != mesh_triangles._digest(zeros[1], zeros[0])


def test_a_static_mesh_and_a_body_of_one_asset_differ():
    stage = new_stage()
    for name in ("static", "body"):
        made = _add(stage, f"/World/{name}", "none")
        if name == "body":
            UsdPhysics.RigidBodyAPI.Apply(made.GetPrim())
            made.GetPrim().CreateAttribute("physxRigidBody:disableGravity", Sdf.ValueTypeNames.Bool).Set(True)
    found = _colliders(stage, HullCache())
    assert found["/World/static"].shape.kind == "mesh"
    assert found["/World/body"].shape.kind == "hull"

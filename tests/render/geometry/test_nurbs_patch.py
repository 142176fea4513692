"""NurbsPatch: surfaces with closed forms, what is painted on them, parts of them, and what cannot be drawn."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg_render.sync.extract import SceneExtractor

HALF = np.sqrt(0.5)
# A quarter of a unit circle from +x to +y, exactly.
ARC, ARC_WEIGHTS, ARC_KNOTS = np.array([(1, 0), (1, 1), (0, 1)], float), np.array([1, HALF, 1]), [0, 0, 0, 1, 1, 1]


def patch(points, *, u_knots, v_knots, u_order, v_order, weights=None, **values):
    """A stage with one patch, of points (V, U, 3)."""
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.NurbsPatch.Define(stage, "/Patch")
    rows, columns = points.shape[:2]
    prim.CreateUVertexCountAttr(columns)
    prim.CreateVVertexCountAttr(rows)
    prim.CreateUOrderAttr(u_order)
    prim.CreateVOrderAttr(v_order)
    prim.CreateUKnotsAttr(u_knots)
    prim.CreateVKnotsAttr(v_knots)
    prim.CreatePointsAttr([Gf.Vec3f(*point) for point in points.reshape(-1, 3).tolist()])
    if weights is not None:
        prim.CreatePointWeightsAttr(weights.ravel().tolist())
    for name, value in values.items():
        prim.GetPrim().GetAttribute(name).Set(value)
    return stage, prim


def prototype_of(stage, time=None):
    extractor = SceneExtractor(stage)
    extractor.update(time)
    [prototype] = extractor.scene.prototypes
    return prototype


def plane(**values):
    """The square [0, 3] x [0, 2] in z = 0, u along x in three spans and v along y in two."""
    points = np.array([[(x, y, 0) for x in range(4)] for y in range(3)], float)
    return patch(points, u_knots=[0, 0, 1, 2, 3, 3], v_knots=[0, 0, 1, 2, 2], u_order=2, v_order=2, **values)


@pytest.fixture
def octant():
    """An eighth of the unit sphere that ends in a pole."""
    points = np.array([[(x * r, y * r, z) for x, y in ARC] for r, z in ARC])
    return patch(
        points, u_knots=ARC_KNOTS, v_knots=ARC_KNOTS, u_order=3, v_order=3, weights=np.outer(ARC_WEIGHTS, ARC_WEIGHTS)
    )


def test_points_and_normals_of_a_rational_sphere_are_exact(octant):
    stage, _ = octant
    found = prototype_of(stage)
    np.testing.assert_allclose(np.linalg.norm(found.points, axis=1), 1.0, atol=1e-6)
    corners = found.points[found.triangles]
    is_pole = np.isclose(corners[..., 2], 1.0)  # where the normal is that of the face
    np.testing.assert_allclose(found.normals[~is_pole], corners[~is_pole], atol=1e-5)
    assert (np.einsum("tci,tci->tc", found.normals, corners)[is_pole] > 0.99).all()


def test_a_flat_patch_has_two_triangles_a_span_and_its_parameters_as_texture_coordinates():
    stage, _ = plane()
    found = prototype_of(stage)
    assert len(found.triangles) == 2 * 3 * 2
    np.testing.assert_allclose(found.normals, np.broadcast_to([0, 0, 1], found.normals.shape))
    np.testing.assert_allclose(found.uvs, found.points[found.triangles][..., :2] / [3, 2], atol=1e-6)


def test_a_left_handed_patch_faces_the_other_way():
    stage, prim = plane()
    prim.CreateOrientationAttr("leftHanded")
    found = prototype_of(stage)
    a, b, c = found.points[found.triangles].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] < 0).all()
    assert (found.normals[..., 2] == -1).all()


def test_surfaces_have_edges_where_knots_say_so():
    points = np.array([[(0, y, 1), (1, y, 0), (2, y, 1)] for y in (0, 1)], float)
    stage, _ = patch(points, u_knots=[0, 0, 1, 2, 2], v_knots=[0, 0, 1, 1], u_order=2, v_order=2)
    found = prototype_of(stage)
    left = found.points[found.triangles].mean(axis=1)[:, 0] < 1
    np.testing.assert_allclose(
        found.normals[left], np.broadcast_to([HALF, 0, HALF], found.normals[left].shape), atol=1e-6
    )
    np.testing.assert_allclose(found.normals[~left][..., 0], -HALF, atol=1e-6)


def test_only_the_range_is_drawn():
    stage, prim = plane()
    prim.CreateURangeAttr(Gf.Vec2d(0.5, 2.25))
    found = prototype_of(stage)
    np.testing.assert_allclose([found.points.min(0), found.points.max(0)], [(0.5, 0, 0), (2.25, 2, 0)])
    prim.CreateURangeAttr(Gf.Vec2d(5, 4))
    with pytest.warns(UserWarning, match=r"/Patch: uRange \(5.0, 4.0\) names no part.*0 to 3"):
        assert prototype_of(stage).points[:, 0].max() == 3


def test_texture_coordinates_of_control_points_are_drawn_on_the_surface(octant):
    stage, prim = octant
    values = [Gf.Vec2f(point[0], point[2]) for point in prim.GetPointsAttr().Get()]
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex").Set(values)
    found = prototype_of(stage)
    np.testing.assert_allclose(found.uvs, found.points[found.triangles][..., [0, 2]], atol=1e-6)


def test_colors_of_control_points_are_drawn_and_those_of_other_kinds_are_their_mean():
    stage, prim = plane()
    colors = np.array([(x / 3, y / 2, 0) for y in range(3) for x in range(4)])
    prim.CreateDisplayColorPrimvar("vertex").Set([Gf.Vec3f(*color) for color in colors.tolist()])
    found = prototype_of(stage)
    assert found.colors is not None
    np.testing.assert_allclose(found.colors[..., :2], found.points[found.triangles][..., :2] / [3, 2], atol=1e-6)
    prim.CreateDisplayColorPrimvar("uniform").Set([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 0, 1)])
    with pytest.warns(UserWarning, match="/Patch: primvars of a NurbsPatch that are uniform are not supported"):
        prototype_of(stage)


def test_a_moving_patch_is_drawn_at_its_time():
    stage, prim = plane()
    points = np.array(prim.GetPointsAttr().Get())
    prim.GetPointsAttr().Clear()
    for time in (0, 10):
        prim.GetPointsAttr().Set([Gf.Vec3f(*p) for p in np.add(points, (0, 0, time)).tolist()], time)
    assert (prototype_of(stage, Usd.TimeCode(5)).points[:, 2] == 5).all()


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"uVertexCount": 5}, "it has 12 points, and uVertexCount times vVertexCount is 15"),
        ({"uKnots": [0, 0, 1, 2, 3]}, "uOrder 2, uVertexCount 4 and uKnots, of which it has 5"),
        ({"vKnots": [0, 0, 2, 1, 2]}, "vOrder 2, vVertexCount 3 and vKnots"),
        ({"vOrder": 1}, "vOrder 1"),
    ],
)
def test_what_gives_no_surface_is_named(values, said):
    stage, _ = plane(**values)
    extractor = SceneExtractor(stage)
    with pytest.warns(UserWarning, match=f"/Patch: {said}.*not drawn"):
        extractor.update()
    assert not extractor.scene.instances.paths


def test_points_that_are_not_finite_are_named():
    stage, prim = plane()
    prim.CreatePointsAttr([Gf.Vec3f(float("nan"))] * 12)
    with pytest.warns(UserWarning, match="/Patch: a point is NaN or infinite, so it is not drawn"):
        SceneExtractor(stage).update()


def test_trim_curves_and_bad_weights_are_named(recwarn):
    stage, prim = plane()
    prim.CreateTrimCurveCountsAttr([1])
    prim.CreatePointWeightsAttr([1.0, -1.0])
    assert len(prototype_of(stage).triangles) == 12
    said = " ".join(str(each.message) for each in recwarn)
    assert "/Patch: its trim curves are not supported" in said
    assert "/Patch: pointWeights are not one above 0 for each point" in said

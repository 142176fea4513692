"""Meshes that ask for refinement: when, how fine, with what on them."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, Vt

from tests.render.geometry.test_meshes import CUBE_FACES, CUBE_POINTS, area_vectors, make_mesh, prototype_of

# Where the middle of a cube's face ends: (16 f + 4 * sum of neighbors + sum of the opposite corners) / 36 after one
# level, whose face points lie at 1, edge points at 3/4 and vertices at 5/9.
FACE_LIMIT = (16 + 4 * 4 * 3 / 4 + 4 * 5 / 9) / 36
CENTERED = np.array(CUBE_POINTS, float) * 2.0 - 1.0


def ask(mesh, level, enabled=True):
    prim = mesh.GetPrim()
    prim.CreateAttribute("refinementEnableOverride", Sdf.ValueTypeNames.Bool).Set(enabled)
    prim.CreateAttribute("refinementLevel", Sdf.ValueTypeNames.Int).Set(level)


def make_cube(scheme="catmullClark", level=None):
    stage, mesh = make_mesh(CENTERED, [4] * 6, CUBE_FACES, scheme)
    if level is not None:
        ask(mesh, level)
    return stage, mesh


def open_grid(n=5):
    points = [(x, y, 0) for y in range(n) for x in range(n)]
    corner = [y * n + x for y in range(n - 1) for x in range(n - 1)]
    faces = [k for c in corner for k in (c, c + 1, c + n + 1, c + n)]
    stage, mesh = make_mesh(points, [4] * len(corner), faces, "catmullClark")
    ask(mesh, 2)
    return stage, mesh


def add_uvs(mesh, values, interpolation, indices=None):
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
    st.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(values, np.float32)))
    if indices is not None:
        st.SetIndices(list(map(int, indices)))


@pytest.mark.parametrize(
    ("level", "enabled", "faces"), [(None, None, 6), (2, False, 6), (0, True, 6), (1, True, 24), (3, True, 384)]
)
def test_the_override_says_whether_and_how_fine(level, enabled, faces):
    _, mesh = make_cube()
    if level is not None:
        ask(mesh, level, enabled)
    assert len(prototype_of(mesh).triangles) == 2 * faces


def test_polygons_are_never_refined():
    _, mesh = make_cube("none", level=3)
    assert len(prototype_of(mesh).triangles) == 12


def test_a_refined_cube_lies_on_its_limit_surface_with_normals_outward():
    _, mesh = make_cube(level=3)
    prototype = prototype_of(mesh)
    assert np.abs(prototype.points).max() == pytest.approx(FACE_LIMIT, abs=1e-6)
    outward = np.einsum("tci,tci->tc", prototype.normals, prototype.points[prototype.triangles])
    assert (outward > 0).all()
    assert np.einsum("ti,tci->tc", area_vectors(prototype), prototype.normals).min() > 0
    assert np.bincount(prototype.triangle_faces).tolist() == [128] * 6


def test_left_handed_surfaces_turn_their_normals():
    _, mesh = make_cube(level=2)
    mesh.CreateOrientationAttr("leftHanded")
    prototype = prototype_of(mesh)
    assert (np.einsum("tci,tci->tc", prototype.normals, prototype.points[prototype.triangles]) < 0).all()
    assert np.einsum("ti,tci->tc", area_vectors(prototype), prototype.normals).min() > 0


def test_authored_normals_do_not_count_for_refined_surfaces():
    _, mesh = make_cube(level=1)
    mesh.CreateNormalsAttr([Gf.Vec3f(0, 0, 1)] * 8)
    assert np.unique(prototype_of(mesh).normals, axis=0).shape[0] > 3


def test_creases_ask_for_refinement_and_hold_the_shape():
    _, mesh = make_cube()
    mesh.CreateCreaseIndicesAttr([4, 5, 7, 6, 4, 0, 1, 3, 2, 0])
    mesh.CreateCreaseLengthsAttr([5, 5])
    mesh.CreateCreaseSharpnessesAttr([10.0, 10.0])
    prototype = prototype_of(mesh)
    assert len(prototype.triangles) > 12 * 16
    # Between two sharp rims the sides become the cylinder-like B-spline of the square; its top and bottom are flat.
    top = prototype.triangle_faces == 4
    assert np.allclose(prototype.points[prototype.triangles[top]][..., 2], 1.0)
    np.testing.assert_allclose(prototype.normals[top], np.broadcast_to([0, 0, 1], (top.sum(), 3, 3)), atol=1e-6)
    sides = (prototype.triangle_faces != 4) & (prototype.triangle_faces != 5)
    assert np.abs(prototype.normals[sides][..., 2]).max() < 1e-6


def test_creases_may_have_one_value_an_edge():
    shapes = []
    for sharpness in ([10.0], [10.0, 10.0, 10.0, 10.0], [0.0, 0.0, 0.0, 0.0]):
        _, mesh = make_cube(level=2)
        mesh.CreateCreaseIndicesAttr([4, 5, 7, 6, 4])
        mesh.CreateCreaseLengthsAttr([5])
        mesh.CreateCreaseSharpnessesAttr(sharpness)
        shapes.append(prototype_of(mesh).points)
    np.testing.assert_array_equal(shapes[0], shapes[1])
    assert np.abs(shapes[0] - shapes[2]).max() > 0.1


def test_sharp_corners_stay_where_they_are():
    _, mesh = make_cube()
    mesh.CreateCornerIndicesAttr([7])
    mesh.CreateCornerSharpnessesAttr([10.0])
    prototype = prototype_of(mesh)
    assert prototype.points.max() == 1.0
    assert prototype.points.min() > -0.85


def test_broken_creases_are_named_and_left_out():
    _, mesh = make_cube(level=1)
    mesh.CreateCreaseIndicesAttr([4, 5, 99])
    mesh.CreateCreaseLengthsAttr([3])
    mesh.CreateCreaseSharpnessesAttr([10.0])
    mesh.CreateCornerIndicesAttr([99])
    mesh.CreateCornerSharpnessesAttr([10.0])
    with pytest.warns(UserWarning, match="/Mesh") as caught:
        prototype = prototype_of(mesh)
    assert ["creases" in str(w.message) for w in caught].count(True) == 1
    assert ["cornerIndices" in str(w.message) for w in caught].count(True) == 1
    np.testing.assert_allclose(np.abs(prototype.points).max(), FACE_LIMIT, atol=1e-6)


@pytest.mark.parametrize(
    ("boundary", "corner", "area"),
    [("edgeAndCorner", (0, 0), None), ("edgeOnly", (1 / 6, 1 / 6), None), ("none", (1, 1), 4.0)],
)
def test_boundaries_follow_their_interpolation(boundary, corner, area):
    _, mesh = open_grid()
    mesh.CreateInterpolateBoundaryAttr(boundary)
    prototype = prototype_of(mesh)
    drawn = prototype.points[prototype.triangles].reshape(-1, 3)
    nearest = drawn[np.argmin(drawn[:, 0] + drawn[:, 1])]
    np.testing.assert_allclose(nearest[:2], corner, atol=1e-6)
    if area is not None:  # faces on the boundary are not drawn
        assert area_vectors(prototype)[:, 2].sum() == pytest.approx(area)


def test_holes_are_left_out_but_shape_their_neighbors():
    _, mesh = make_cube(level=2)
    whole = prototype_of(mesh)
    mesh.CreateHoleIndicesAttr([4])
    holed = prototype_of(mesh)
    assert set(holed.triangle_faces) == {0, 1, 2, 3, 5}
    drawn = whole.triangle_faces != 4
    np.testing.assert_array_equal(holed.points[holed.triangles], whole.points[whole.triangles[drawn]])


def test_subsets_follow_the_faces():
    _, mesh = make_cube(level=2)
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, "top", "face", [4], "materialBind").GetPrim()
    prototype = prototype_of(mesh, subsets=[subset])
    np.testing.assert_array_equal(prototype.triangle_slots == 0, prototype.triangle_faces == 4)


@pytest.mark.parametrize("interpolation", ["vertex", "varying", "faceVarying"])
@pytest.mark.parametrize("rule", ["all", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries"])
def test_flat_texture_coordinates_stay_flat(interpolation, rule):
    """On a regular sheet they are affine in the position; linear rules keep that of the unrefined sheet."""
    _, mesh = open_grid()
    mesh.CreateFaceVaryingLinearInterpolationAttr(rule)
    points = np.asarray(mesh.GetPointsAttr().Get())[:, :2]
    values = points @ np.array([[0.25, 0.1], [0.0, 0.5]])
    if interpolation == "faceVarying":
        add_uvs(mesh, values, interpolation, mesh.GetFaceVertexIndicesAttr().Get())
    else:
        add_uvs(mesh, values, interpolation)
    prototype = prototype_of(mesh)
    at = prototype.points[prototype.triangles][..., :2]
    expected = at @ np.array([[0.25, 0.1], [0.0, 0.5]])
    inner = ((at >= 1.0) & (at <= 3.0)).all(axis=(1, 2))
    compared = inner if interpolation != "vertex" else np.ones(len(at), bool)
    np.testing.assert_allclose(prototype.uvs[compared], expected[compared], atol=1e-6)


@pytest.mark.parametrize("interpolation", ["vertex", "varying", "faceVarying"])
@pytest.mark.parametrize("bad", [-1, 99])
def test_indices_of_texture_coordinates_that_name_none_are_told(interpolation, bad):
    _, mesh = open_grid()
    indices = [0] * (len(mesh.GetFaceVertexIndicesAttr().Get()) if interpolation == "faceVarying" else 25)
    add_uvs(mesh, [(0, 0), (1, 0)], interpolation, [*indices[:-1], bad])
    with pytest.warns(UserWarning, match=f"the {interpolation} texture coordinates .* too few for the mesh"):
        assert not prototype_of(mesh).uvs.any()


def test_texture_seams_stay_seams():
    """Every face of the cube is the whole image: no corner between two faces mixes their coordinates."""
    _, mesh = make_cube(level=2)
    mesh.CreateFaceVaryingLinearInterpolationAttr("cornersPlus1")
    add_uvs(mesh, [(0, 0), (1, 0), (1, 1), (0, 1)], "faceVarying", [0, 1, 2, 3] * 6)
    prototype = prototype_of(mesh)
    for face in range(6):
        uvs = prototype.uvs[prototype.triangle_faces == face].reshape(-1, 2)
        np.testing.assert_allclose([uvs.min(0), uvs.max(0)], [[0, 0], [1, 1]], atol=1e-6)
        area = prototype.uvs[prototype.triangle_faces == face]
        covered = np.linalg.det(area[:, 1:] - area[:, :1]).sum() / 2
        assert covered == pytest.approx(1.0, abs=1e-5), "the image covers the face once"


def test_uniform_and_constant_texture_coordinates_are_kept():
    _, mesh = make_cube(level=2)
    add_uvs(mesh, [(k, 0) for k in range(6)], "uniform")
    prototype = prototype_of(mesh)
    np.testing.assert_allclose(prototype.uvs[..., 0], np.repeat(prototype.triangle_faces[:, None], 3, 1))
    add_uvs(mesh, [(0.5, 0.25)], "constant")
    assert (prototype_of(mesh).uvs == [0.5, 0.25]).all()


def test_too_few_texture_coordinates_are_named_on_refined_surfaces_too():
    _, mesh = make_cube(level=1)
    add_uvs(mesh, [(0, 0)] * 3, "faceVarying")
    with pytest.warns(UserWarning, match="/Mesh.*too few"):
        assert (prototype_of(mesh).uvs == 0).all()


def test_loop_wants_triangles():
    _, mesh = make_cube("loop", level=2)
    with pytest.warns(UserWarning, match="/Mesh.*loop.*triangles"):
        assert len(prototype_of(mesh).triangles) == 12
    _, mesh = make_mesh([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], [3] * 4,
                        [0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2], "loop")  # fmt: skip
    ask(mesh, 2)
    prototype = prototype_of(mesh)
    assert np.bincount(prototype.triangle_faces).tolist() == [16] * 4
    assert (np.einsum("tci,tci->tc", prototype.normals, prototype.points[prototype.triangles]) > 0).all()


def test_bilinear_surfaces_keep_their_shape():
    _, mesh = make_cube("bilinear", level=2)
    prototype = prototype_of(mesh)
    assert len(prototype.triangles) == 6 * 16 * 2
    assert np.linalg.norm(area_vectors(prototype), axis=1).sum() == pytest.approx(24.0)
    assert (np.abs(prototype.normals).max(-1) == 1.0).all()


def test_levels_that_would_fill_memory_are_lowered_by_name(monkeypatch):
    monkeypatch.setattr("usdsdg_render.geometry.subdivision.surface.MAX_FACES", 1000)
    _, mesh = make_cube(level=20)
    with pytest.warns(UserWarning, match="/Mesh.*refinementLevel 20.*1,000 faces; 3 is used"):
        assert len(prototype_of(mesh).triangles) == 2 * 384


def test_broken_faces_are_dropped_before_refinement():
    points = [tuple(p) for p in CENTERED] + [(float("nan"), 0, 0)]
    _, mesh = make_mesh(points, [4] * 6 + [3, 2], [*CUBE_FACES, 0, 1, 8, 0, 1], "catmullClark")
    ask(mesh, 2)
    with pytest.warns(UserWarning, match="/Mesh"):
        prototype = prototype_of(mesh)
    assert np.isfinite(prototype.points).all()
    assert set(prototype.triangle_faces) == set(range(6))


def test_rules_that_are_not_ours_are_named():
    _, mesh = open_grid()
    mesh.CreateTriangleSubdivisionRuleAttr("smooth")
    mesh.CreateFaceVaryingLinearInterpolationAttr("cornersPlus2")
    add_uvs(mesh, np.zeros((64, 2)), "faceVarying")
    with pytest.warns(UserWarning, match="/Mesh") as caught:
        prototype_of(mesh)
    said = [str(warning.message) for warning in caught]
    assert ["triangleSubdivisionRule" in each for each in said].count(True) == 1
    assert ["cornersPlus2" in each for each in said].count(True) == 1

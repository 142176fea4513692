"""Meshes to prototypes: triangulation, orientation, primvars, broken data."""

import math

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdsdg.stage.geometry.triangulate import clip_ears
from usdsdg_render.geometry.mesh_source import read_mesh
from usdsdg_render.geometry.meshes import build_prototype

DEFAULT = Usd.TimeCode.Default()
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
CUBE_POINTS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
CUBE_FACES = [0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6, 4, 5, 7, 6, 2, 3, 1, 0]


def make_mesh(points, counts, indices, scheme="none"):
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
    mesh.CreateFaceVertexCountsAttr(list(map(int, counts)))
    mesh.CreateFaceVertexIndicesAttr(list(map(int, indices)))
    mesh.CreateSubdivisionSchemeAttr(scheme)
    return stage, mesh


def prototype_of(mesh, **options):
    source = read_mesh(mesh.GetPrim(), DEFAULT, **options)
    return None if source is None else build_prototype(str(mesh.GetPath()), source)


def area_vectors(prototype):
    a, b, c = prototype.points[prototype.triangles].astype(np.float64).transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2.0


def shoelace(polygon):
    x, y = np.asarray(polygon, float)[:, :2].T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


def star(points, inner, rng=None):
    angle = np.arange(2 * points) * math.pi / points
    radius = np.where(np.arange(2 * points) % 2, inner, 1.0)
    if rng is not None:
        radius = radius * rng.uniform(0.6, 1.0, len(radius))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(len(angle))], axis=1)


def contains_no_outside(polygon, prototype):
    """Every triangle's center lies in the polygon, by counting crossings."""
    centers = prototype.points[prototype.triangles].mean(axis=1)[:, :2]
    inside = np.zeros(len(centers), bool)
    for (x0, y0), (x1, y1) in zip(polygon[:, :2], np.roll(polygon[:, :2], -1, axis=0)):
        crosses = (y0 > centers[:, 1]) != (y1 > centers[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (centers[:, 0] < (x1 - x0) * (centers[:, 1] - y0) / (y1 - y0) + x0)
    return inside.all()


@pytest.mark.parametrize("corners", [3, 4, 5, 12])
def test_convex_polygons_keep_their_area(corners):
    angle = np.arange(corners) * 2 * math.pi / corners
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    _, mesh = make_mesh(points, [corners], range(corners))
    prototype = prototype_of(mesh)
    assert len(prototype.triangles) == corners - 2
    np.testing.assert_allclose(area_vectors(prototype).sum(axis=0), [0, 0, shoelace(points)], atol=1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_concave_polygons_are_filled_without_overlap(seed):
    rng = np.random.default_rng(seed)
    polygon = np.roll(star(3 + seed % 5, 0.35, rng), seed, axis=0)
    _, mesh = make_mesh(polygon, [len(polygon)], range(len(polygon)))
    prototype = prototype_of(mesh)
    areas = area_vectors(prototype)[:, 2]
    assert (areas > 0).all(), "a triangle is turned over"
    np.testing.assert_allclose(areas.sum(), shoelace(polygon), rtol=1e-5)
    assert contains_no_outside(polygon, prototype)


@pytest.mark.parametrize("reflex", range(4))
def test_arrowhead_quads_split_inside_whichever_corner_is_reflex(reflex):
    quad = np.roll(np.array([(0.0, 0.2, 0), (1, -1, 0), (0, 1, 0), (-1, -1, 0)]), reflex, axis=0)
    _, mesh = make_mesh(quad, [4], range(4))
    areas = area_vectors(prototype_of(mesh))[:, 2]
    assert (areas > 0).all()
    np.testing.assert_allclose(areas.sum(), shoelace(quad), rtol=1e-6)


def test_concave_faces_stand_in_any_plane_among_convex_ones():
    arrow = np.array([(0.0, 0.2, 0), (1, -1, 0), (0.5, 0.9, 0), (0, 1, 0), (-1, -1, 0)])
    rotation = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(1, 2, 3), 70)))
    points = np.concatenate([np.array(SQUARE, float), arrow @ rotation + 5.0, np.array(SQUARE, float) + 9.0])
    _, mesh = make_mesh(points, [4, 5, 4], range(13))
    prototype = prototype_of(mesh)
    assert prototype.triangle_faces.tolist() == [0, 0, 1, 1, 1, 2, 2]
    areas = np.linalg.norm(area_vectors(prototype), axis=1)
    np.testing.assert_allclose(areas[2:5].sum(), shoelace(arrow), rtol=1e-5)
    np.testing.assert_allclose(areas[[0, 1, 5, 6]], 0.5, rtol=1e-5)


def test_polygons_that_cross_themselves_end_in_triangles_all_the_same():
    bow_tie = np.array([(0.0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0), (-1, 0.5, 0)])
    assert clip_ears(bow_tie).shape == (3, 3)


def test_a_cube_is_closed_faces_out_and_left_handed_means_the_other_way():
    _, mesh = make_mesh(CUBE_POINTS, [4] * 6, CUBE_FACES)
    right = prototype_of(mesh)
    mesh.CreateOrientationAttr("leftHanded")
    left = prototype_of(mesh)
    for prototype, sign in ((right, 1.0), (left, -1.0)):
        vectors = area_vectors(prototype)
        volume = np.einsum("ij,ij->", prototype.points[prototype.triangles[:, 0]], vectors) / 3
        assert volume == pytest.approx(sign)
        facing = np.einsum("tci,ti->tc", prototype.normals, vectors)
        assert (facing > 0).all(), "computed normals follow the winding"


def test_authored_normals_stay_with_left_handed_meshes():
    _, mesh = make_mesh(SQUARE, [4], [3, 2, 1, 0])
    mesh.CreateOrientationAttr("leftHanded")
    mesh.CreateNormalsAttr([Gf.Vec3f(0, 0, 1)] * 4)
    prototype = prototype_of(mesh)
    assert (area_vectors(prototype)[:, 2] > 0).all()
    assert (prototype.normals == [0, 0, 1]).all()


def test_holes_are_not_drawn():
    _, mesh = make_mesh(CUBE_POINTS, [4] * 6, CUBE_FACES)
    mesh.CreateHoleIndicesAttr([4, 99])
    assert set(prototype_of(mesh).triangle_faces) == {0, 1, 2, 3, 5}


# Two triangles that share an edge, so that vertex, face and corner differ.
FOLD = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize(
    ("interpolation", "where"),
    [
        ("constant", [[0, 0, 0], [0, 0, 0]]),
        ("uniform", [[0, 0, 0], [1, 1, 1]]),
        ("vertex", [[0, 1, 2], [0, 2, 3]]),
        ("varying", [[0, 1, 2], [0, 2, 3]]),
        ("faceVarying", [[0, 1, 2], [3, 4, 5]]),
    ],
)
def test_every_interpolation_of_uvs_and_normals(interpolation, where, indexed):
    _, mesh = make_mesh(FOLD, [3, 3], [0, 1, 2, 0, 2, 3])
    rng = np.random.default_rng(1)
    uvs = rng.random((6, 2)).astype(np.float32)
    normals = rng.normal(size=(6, 3)).astype(np.float32)
    order = np.array([3, 1, 5, 0, 2, 4]) if indexed else np.arange(6)
    api = UsdGeom.PrimvarsAPI(mesh)
    st = api.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
    st.Set(Vt.Vec2fArray.FromNumpy(uvs))
    n = api.CreatePrimvar("normals", Sdf.ValueTypeNames.Normal3fArray, interpolation)
    n.Set(Vt.Vec3fArray.FromNumpy(normals))
    if indexed:
        st.SetIndices(order.tolist())
        n.SetIndices(order.tolist())
    prototype = prototype_of(mesh)
    np.testing.assert_array_equal(prototype.uvs, uvs[order][where])
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(prototype.normals, unit[order][where], atol=1e-6)


def test_face_varying_values_follow_the_corners_of_polygons():
    """Positions as UVs: whatever the triangulation, a corner's UV is its own point."""
    polygon = star(4, 0.4)
    points = np.concatenate([polygon, polygon + np.array([5.0, 0, 0])])
    _, mesh = make_mesh(points, [8, 8], range(16))
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    st.Set(Vt.Vec2fArray.FromNumpy(points[:, :2].astype(np.float32)))
    prototype = prototype_of(mesh)
    np.testing.assert_array_equal(prototype.uvs, prototype.points[prototype.triangles][..., :2])


def test_the_primvar_wins_over_the_normals_attribute():
    _, mesh = make_mesh(SQUARE, [4], range(4))
    mesh.CreateNormalsAttr([Gf.Vec3f(1, 0, 0)] * 4)
    assert (prototype_of(mesh).normals == [1, 0, 0]).all()
    normals = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("normals", Sdf.ValueTypeNames.Normal3fArray, "constant")
    normals.Set([Gf.Vec3f(0, 2, 0)])
    assert (prototype_of(mesh).normals == [0, 1, 0]).all()


def test_without_normals_polygons_are_flat_and_subdivision_surfaces_smooth():
    _, mesh = make_mesh(CUBE_POINTS, [4] * 6, CUBE_FACES)
    flat = prototype_of(mesh).normals
    assert (np.abs(flat).max(axis=-1) == 1.0).all()
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    smooth = prototype_of(mesh)
    # All faces of a cube are equal, so area-weighted normals point along the diagonals, except for how many
    # triangles of a face meet at the corner.
    outward = smooth.points[smooth.triangles] - 0.5
    assert (np.einsum("tci,tci->tc", smooth.normals, outward) > 0.7 * math.sqrt(0.75)).all()
    assert np.abs(smooth.normals).max() < 0.9
    for point in range(8):  # one normal a point
        at_point = smooth.normals[smooth.triangles == point]
        np.testing.assert_allclose(at_point, np.broadcast_to(at_point[0], at_point.shape), atol=1e-6)


def test_the_uv_set_is_the_one_the_material_asks_for():
    _, mesh = make_mesh(SQUARE, [4], range(4))
    api = UsdGeom.PrimvarsAPI(mesh)
    for name, value in (("UVMap", 0.25), ("other", 0.75)):
        api.CreatePrimvar(name, Sdf.ValueTypeNames.TexCoord2fArray, "constant").Set([Gf.Vec2f(value)])
    assert (prototype_of(mesh, uv_name="other").uvs == 0.75).all()
    assert (prototype_of(mesh, uv_name="st").uvs == 0.25).all()
    api.RemovePrimvar("UVMap")
    assert (prototype_of(mesh).uvs == 0.75).all(), "any texCoord2f is better than none"


def test_uvs_of_an_ancestor_are_inherited_where_they_are_constant():
    stage = Usd.Stage.CreateInMemory()
    group = UsdGeom.Xform.Define(stage, "/Group")
    st = UsdGeom.PrimvarsAPI(group).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "constant")
    st.Set([Gf.Vec2f(0.875, 0.125)])
    mesh = UsdGeom.Mesh.Define(stage, "/Group/Mesh")
    mesh.CreatePointsAttr(SQUARE)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr(range(4))
    inherited = UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance("st").Get()[0]
    assert (prototype_of(mesh).uvs == inherited).all()
    st.SetInterpolation("vertex")
    assert (prototype_of(mesh).uvs == 0).all(), "USD hands down constant primvars alone"
    UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("map1", Sdf.ValueTypeNames.TexCoord2fArray, "constant").Set([Gf.Vec2f(0.5)])
    st.SetInterpolation("constant")
    assert (prototype_of(mesh).uvs == 0.5).all(), "the mesh's own set wins"


@pytest.mark.parametrize("kind", ["TexCoord3fArray", "Float3Array", "Vector3fArray", "Double3Array"])
def test_uvs_of_three_numbers_are_read(kind):
    _, mesh = make_mesh(SQUARE, [4], range(4))
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", getattr(Sdf.ValueTypeNames, kind), "vertex")
    st.Set([Gf.Vec3f(u, v, 9) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))])
    assert {tuple(uv) for uv in prototype_of(mesh).uvs.reshape(-1, 2).tolist()} == {(0, 0), (1, 0), (1, 1), (0, 1)}


def test_subsets_give_slots_and_the_rest_comes_last():
    _, mesh = make_mesh(CUBE_POINTS, [4] * 6, CUBE_FACES)
    subsets = [
        UsdGeom.Subset.CreateGeomSubset(mesh, name, "face", faces, "materialBind").GetPrim()
        for name, faces in (("a", [4]), ("b", [0, 5]))
    ]
    prototype = prototype_of(mesh, subsets=subsets)
    expected = {4: 0, 0: 1, 5: 1, 1: 2, 2: 2, 3: 2}
    assert prototype.triangle_slots.tolist() == [expected[face] for face in prototype.triangle_faces]


@pytest.mark.parametrize(
    ("points", "counts", "indices", "kept", "said"),
    [
        (
            FOLD,
            [3, 2, 3],
            [0, 1, 2, 0, 1, 0, 2, 3],
            [0, 2],
            "1 face has fewer than three vertices .first: face 1. and is dropped",
        ),
        (FOLD, [2, 2, 3], [0, 1, 2, 0, 0, 2, 3], [2], "2 faces have fewer than three vertices .* and are dropped"),
        (FOLD, [3, 3, 3], [0, 1, 2, 0, 2, 3], [0, 1], "1 face lies beyond the end"),
        (FOLD, [3], [0, 1, 2, 0, 2, 3], [0], "sum to 3"),
        (FOLD, [3, 3], [0, 1, 7, 0, 2, 3], [1], "1 face names points outside 0..3"),
        (FOLD, [3, 3], [0, 1, -1, 0, 2, 3], [1], "points outside"),
        ([*FOLD[:3], (math.nan, 0, 0)], [3, 3], [0, 1, 2, 0, 2, 3], [0], "1 face has a NaN or infinite point"),
        ([*FOLD[:3], (math.inf, 0, 0)], [3, 3], [0, 1, 2, 0, 2, 3], [0], "1 face has a NaN or infinite point"),
        (FOLD, [3, 3], [0, 1, 1, 0, 2, 3], [1], "no area"),
    ],
)
def test_broken_faces_are_dropped_by_name_and_the_rest_stays(points, counts, indices, kept, said):
    _, mesh = make_mesh(points, counts, indices)
    with pytest.warns(UserWarning, match=f"/Mesh.*{said}"):
        prototype = prototype_of(mesh)
    assert prototype.triangle_faces.tolist() == kept
    assert np.isfinite(prototype.points).all()
    assert np.isfinite(prototype.normals).all()
    assert (area_vectors(prototype)[:, 2] > 0).all()


@pytest.mark.parametrize(
    ("points", "counts", "indices"),
    [([], [], []), (FOLD, [], []), ([], [3], [0, 1, 2]), (FOLD, [3], [0, 0, 0]), (FOLD, [3], [7, 8, 9])],
)
def test_meshes_without_a_surface_are_named(points, counts, indices):
    _, mesh = make_mesh(points, counts, indices)
    with pytest.warns(UserWarning, match="/Mesh"):
        assert prototype_of(mesh) is None


def test_too_few_primvar_values_are_named_and_replaced():
    _, mesh = make_mesh(SQUARE, [4], range(4))
    mesh.CreateNormalsAttr([Gf.Vec3f(0, 1, 0)] * 2)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(1)] * 3)
    with pytest.warns(UserWarning, match="too few") as caught:
        prototype = prototype_of(mesh)
    assert len(caught) == 2
    assert (prototype.normals == [0, 0, 1]).all()
    assert (prototype.uvs == 0).all()


def test_nan_normals_fall_back_to_the_face_and_nan_uvs_to_zero():
    _, mesh = make_mesh(SQUARE, [4], range(4))
    mesh.CreateNormalsAttr([Gf.Vec3f(math.nan, 0, 0), Gf.Vec3f(0, 0, 0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(1, 0, 0)])
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "constant")
    st.Set([Gf.Vec2f(math.nan, 0.5)])
    with pytest.warns(UserWarning, match="texture coordinates"):
        prototype = prototype_of(mesh)
    expected = {0: [0, 0, 1], 1: [0, 0, 1], 2: [1, 0, 0], 3: [1, 0, 0]}
    for vertex, normal in zip(prototype.triangles.ravel(), prototype.normals.reshape(-1, 3)):
        assert normal.tolist() == expected[int(vertex)]
    assert (prototype.uvs == [0, 0.5]).all()


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_slivers_are_drawn_as_long_as_they_have_a_width(size, recwarn):
    """A needle a hundred thousand times longer than wide is still a part of its surface, and a line is none."""
    widths = 10.0 ** -np.arange(6)
    points = [corner for w in widths for corner in ((0, 0, 0), (size, 0, 0), (0.5 * size, w * size, 0))]
    _, mesh = make_mesh(points, [3] * len(widths), range(3 * len(widths)))
    np.testing.assert_allclose(area_vectors(prototype_of(mesh))[:, 2], widths * size**2 / 2, rtol=1e-5)
    assert not recwarn.list
    _, lines = make_mesh([*points[:3], *points[:2], (0.5 * size, 1e-9 * size, 0)], [3, 3], range(6))
    with pytest.warns(UserWarning, match="1 face has no area"):
        assert prototype_of(lines).triangle_faces.tolist() == [0]


def test_collinear_vertices_of_a_polygon_are_no_fault(recwarn):
    points = [(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    _, mesh = make_mesh(points, [5], range(5))
    assert area_vectors(prototype_of(mesh))[:, 2].sum() == pytest.approx(1.0)
    assert not recwarn.list

"""Triangle, body and volume tests of scattering, compared with slow references and analytic results."""

import numpy as np
import pytest
import trimesh
from pxr import Gf, UsdGeom, Vt

from usdsdg.errors import GraphError
from usdsdg.scatter.bounds import Bounds
from usdsdg.scatter.collisions import collide, triangles_cross, winding
from usdsdg.scatter.solid import Solids
from usdsdg.scatter.surface import Surface
from usdsdg.scatter.volume import Box, Volume, inside
from usdsdg.session import stage_context
from usdsdg.stage.geometry.triangles import TriangleInstance, Triangles, triangles_below

EVERYWHERE = Bounds.given(None, None)


def placed(mesh, matrix=None):
    triangles = Triangles(np.array(mesh.vertices, np.float64), np.array(mesh.faces))
    return TriangleInstance("/mesh", triangles, np.eye(4) if matrix is None else matrix)


def solid(mesh, matrix=None):
    return Solids().around(np.zeros(3), [placed(mesh, matrix)])


def slow_triangles_cross(a, b):
    """Two triangles intersect if an edge of one passes through the other."""

    def passes(triangle, start, end):
        normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        above, below = normal @ (start - triangle[0]), normal @ (end - triangle[0])
        if above * below >= 0:
            return False
        point = start + (end - start) * above / (above - below)
        sides = [normal @ np.cross(triangle[(i + 1) % 3] - triangle[i], point - triangle[i]) for i in range(3)]
        return min(sides) > 0

    return any(passes(one, other[i], other[(i + 1) % 3]) for one, other in ((a, b), (b, a)) for i in range(3))


def test_triangles_cross_where_an_edge_passes_through():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 2000, 3, 3))
    expected = [slow_triangles_cross(*pair) for pair in zip(a, b)]
    assert 0.1 < np.mean(expected) < 0.9
    assert triangles_cross(a, b).tolist() == expected


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_coplanar_triangles_and_shared_edges_are_no_intersections(scale):
    one = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    for offset in ((0.1, 0.1, 0), (2, 0, 0), (0, 0, 0.1), (-1, 0, 0), (0.6, 0.6, 0)):
        assert not triangles_cross(one[None] * scale, (one + offset)[None] * scale)[0], offset
    rotated = one[:, [0, 2, 1]]
    assert not triangles_cross(one[None] * scale, rotated[None] * scale)[0]
    shift = np.array([0.1, 0.1, -0.1])
    assert triangles_cross(one[None] * scale, (rotated + shift)[None] * scale)[0]


def test_boxes_in_contact_do_not_collide_and_overlapping_ones_do():
    box = solid(trimesh.creation.box())
    for axis in range(3):
        step = np.eye(3)[axis]
        assert not collide(box, box, step * 1.0001)
        assert not collide(box, box, step)
        assert collide(box, box, step * 0.999)
        assert collide(box, box, step * 0.8)
    assert collide(box, box, np.zeros(3))


def test_a_body_inside_another_collides_but_not_one_inside_a_room():
    big, small = trimesh.creation.box((4, 4, 4)), trimesh.creation.icosphere(radius=0.5)
    for offset, expected in (((0, 0, 0), True), ((1.4, 0, 0), True), ((2.6, 0, 0), False)):
        assert collide(solid(big), solid(small), np.array(offset, float)) is expected
        assert collide(solid(small), solid(big), np.array(offset, float)) is expected
    room = big.copy()
    room.invert()
    assert not collide(solid(room), solid(small), np.zeros(3))
    assert collide(solid(room), solid(small), np.array([1.6, 0, 0]))


def test_a_body_in_the_concave_corner_of_an_l_shape_does_not_collide():
    arm = trimesh.util.concatenate(
        [trimesh.creation.box((4, 1, 1)), trimesh.creation.box((1, 1, 4)).apply_translation((-1.5, 0, 1.5))]
    )
    ball = solid(trimesh.creation.icosphere(radius=0.9))
    # Within the convex hull of the L, and of its bounding box.
    assert not collide(solid(arm), ball, np.array([0.5, 0.0, 1.5]))
    assert collide(solid(arm), ball, np.array([-0.5, 0.0, 1.5]))


def test_spheres_collide_if_their_distance_is_below_the_sum_of_radii():
    rng = np.random.default_rng(0)
    sphere = trimesh.creation.icosphere(subdivisions=3)
    body = solid(sphere)
    inner = np.linalg.norm(sphere.triangles_center, axis=1).min()
    for distance in (1.9 * inner, 2.001):
        for direction in rng.normal(size=(20, 3)):
            offset = direction / np.linalg.norm(direction) * distance
            assert collide(body, body, offset) == (distance < 2)


def test_the_matrix_of_a_mirrored_and_stretched_body_is_applied():
    matrix = np.diag([-3.0, 1.0, 1.0, 1.0])
    flat, ball = solid(trimesh.creation.icosphere(), matrix), solid(trimesh.creation.icosphere(radius=0.1))
    assert collide(flat, ball, np.array([2.8, 0, 0]))
    assert collide(flat, ball, np.array([0.0, 0, 0]))
    assert not collide(flat, ball, np.array([0, 1.2, 0]))


def test_winding_numbers_from_solid_angles_and_from_ray_intersections_agree():
    rng = np.random.default_rng(3)
    mesh = trimesh.creation.torus(1.0, 0.4, major_sections=16, minor_sections=8)
    points = rng.uniform((-1.4, -1.4, -0.4), (1.4, 1.4, 0.4), (400, 3))
    expected = np.abs(winding(points, mesh.triangles)) > 0.5
    assert 0.1 < expected.mean() < 0.9
    assert (inside(points, mesh.triangles) == expected).all()
    assert (inside(points, mesh.triangles[:, ::-1]) == expected).all()
    np.testing.assert_allclose(winding(points, mesh.triangles), expected, atol=1e-9)


def test_points_on_a_surface_are_uniform_by_area():
    # One face four times as large as the other.
    quad = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]], float)
    corners = np.concatenate([quad, quad * 2 + (10, 0, 5)])
    points = Surface(corners, EVERYWHERE, offset=0.5).points(np.random.default_rng(0).random((20000, 3)))
    on_large = points[:, 0] > 5
    assert on_large.mean() == pytest.approx(0.8, abs=0.01)
    assert set(points[on_large, 2].round(9)) == {5.5}
    assert set(points[~on_large, 2].round(9)) == {0.5}
    small = points[~on_large, :2]
    np.testing.assert_allclose(small.mean(0), 0.5, atol=0.02)
    np.testing.assert_allclose(small.var(0), 1 / 12, atol=0.004)


def test_clipping_a_surface_keeps_area_and_orientation():
    sphere = trimesh.creation.icosphere(subdivisions=4)
    bounds = Bounds.given((-0.5, None, 0.0), (None, 0.3, None))
    clipped = bounds.clip(sphere.triangles)
    assert bounds.contains(clipped.mean(1)).all()
    normals = np.cross(clipped[:, 1] - clipped[:, 0], clipped[:, 2] - clipped[:, 0])
    assert ((normals * clipped.mean(1)).sum(1) >= -1e-12).all()
    samples = trimesh.sample.sample_surface(sphere, 200_000, seed=1)[0]
    area = np.linalg.norm(normals, axis=1).sum() / 2
    assert area == pytest.approx(sphere.area * bounds.contains(samples).mean(), rel=0.01)


def test_points_in_a_volume_are_inside_and_uniform():
    mesh = trimesh.creation.torus(1.0, 0.4, major_sections=32, minor_sections=16)
    volume = Volume([mesh.triangles], EVERYWHERE)
    points = volume.points(np.random.default_rng(0).random((30000, 4)))
    points = points[~np.isnan(points).any(1)]
    assert len(points) > 15000
    assert (np.abs(winding(points[:500], mesh.triangles)) > 0.5).all()
    np.testing.assert_allclose(points.mean(0), 0, atol=0.02)
    # A solid torus: E[z²] = r²/4, E[x² + y²] = R² + 3r²/4.
    assert (points[:, 2] ** 2).mean() == pytest.approx(0.04, rel=0.05)
    assert (points[:, :2] ** 2).sum(1).mean() == pytest.approx(1.12, rel=0.02)


def test_a_plate_thinner_than_a_voxel_is_sampled():
    plate = trimesh.creation.box((10, 10, 0.01)).apply_translation((0, 0, 3))
    points = Volume([plate.triangles], EVERYWHERE).points(np.random.default_rng(0).random((20000, 4)))
    points = points[~np.isnan(points).any(1)]
    assert len(points) > 100
    assert (np.abs(points[:, 2] - 3) <= 0.005).all()


@pytest.mark.parametrize(("prevent_overlap", "fraction"), [(True, 1 / 3), (False, 1 / 2)])
def test_the_density_in_overlapping_volumes_is_uniform_or_multiplied(prevent_overlap, fraction):
    boxes = [trimesh.creation.box((2, 1, 1)).apply_translation((x, 0, 0)).triangles for x in (0, 1)]
    volume = Volume(boxes, EVERYWHERE, prevent_overlap=prevent_overlap)
    points = volume.points(np.random.default_rng(0).random((40000, 4)))
    points = points[~np.isnan(points).any(1)]
    assert ((points[:, 0] > 0) & (points[:, 0] < 1)).mean() == pytest.approx(fraction, abs=0.015)


def test_excluded_volumes_and_bounds_are_respected():
    block, hole = trimesh.creation.box((2, 2, 2)), trimesh.creation.icosphere(radius=0.8)
    bounds = Bounds.given((None, 0.1, None), (None, None, 0.5))
    for region in (
        Volume([block.triangles], bounds, excluded=[hole.triangles]),
        Box(Bounds.given((-1, 0.1, -1), (1, 1, 0.5)), [hole.triangles]),
    ):
        points = region.points(np.random.default_rng(0).random((20000, 4)))
        points = points[~np.isnan(points).any(1)]
        assert len(points) > 5000
        assert not inside(points, hole.triangles).any()
        assert bounds.contains(points).all()


def test_volumes_that_cannot_be_sampled_raise_errors():
    block = trimesh.creation.box((2, 2, 2)).triangles
    with pytest.raises(GraphError, match="all six numbers"):
        Box(Bounds.given((0, 0, 0), (1, None, 1)))
    with pytest.raises(GraphError, match="no volume lies within"):
        Volume([block], Bounds.given((5, 5, 5), None))
    with pytest.raises(GraphError, match="nothing is left"):
        Volume([block], EVERYWHERE, excluded=[trimesh.creation.box((3, 3, 3)).triangles])
    with pytest.raises(GraphError, match="larger voxel_size"):
        Volume([block], EVERYWHERE, voxel_size=1e-4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (((1, 2), None), r"min_samp is \(1, 2\); expected three numbers"),
        ((None, (0, "x", 1)), "max_samp is"),
        (((0, 0, 2), (1, 1, 1)), "is above max_samp"),
    ],
)
def test_invalid_bounds_raise_errors(given, message):
    with pytest.raises(GraphError, match=message):
        Bounds.given(*given)


VOLUMES = {
    "Cube": ({"size": 2.0}, 8.0),
    "Sphere": ({"radius": 1.5}, 4 / 3 * np.pi * 1.5**3),
    "Cylinder": ({"radius": 0.5, "height": 3.0}, np.pi * 0.25 * 3),
    "Cone": ({"radius": 0.5, "height": 3.0}, np.pi * 0.25),
    "Capsule": ({"radius": 0.5, "height": 2.0}, np.pi * 0.25 * 2 + 4 / 3 * np.pi * 0.125),
}


@pytest.mark.parametrize("kind", VOLUMES)
@pytest.mark.parametrize("axis", ["X", "Z"])
def test_usd_shapes_have_their_analytic_volume_and_extent(kind, axis):
    stage = stage_context.new_stage()
    sizes, volume = VOLUMES[kind]
    prim = stage.DefinePrim("/World/shape", kind)
    for name, value in sizes.items():
        prim.GetAttribute(name).Set(value)
    if prim.HasAttribute("axis"):
        prim.GetAttribute("axis").Set(axis)
    points, faces = triangles_below([prim])[0].in_world()
    mesh = trimesh.Trimesh(points, faces)
    # Circles are polygons of 48 sides.
    assert mesh.volume == pytest.approx(volume, rel=0.01)
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), 0)
    np.testing.assert_allclose([points.min(0), points.max(0)], extent, atol=1e-6)


def test_meshes_are_triangulated_without_holes_and_oriented_outwards():
    stage = stage_context.new_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/World/mesh")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)])
    mesh.CreateFaceVertexCountsAttr([4, 3, 2])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 1, 4, 2, 0, 1])
    mesh.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
    found = triangles_below([mesh.GetPrim()])[0].in_world()
    # Mirrored by the transform, and still facing up.
    normals = np.cross(*np.moveaxis(found.corners()[:, 1:] - found.corners()[:, :1], 1, 0))
    assert normals[:, 2].tolist() == [1, 1, 1]
    mesh.CreateHoleIndicesAttr([0])
    assert len(triangles_below([mesh.GetPrim()])[0].triangles.faces) == 1
    mesh.CreateOrientationAttr("leftHanded")
    found = triangles_below([mesh.GetPrim()])[0].in_world()
    assert np.cross(*(found.corners()[0, 1:] - found.corners()[0, 0]))[2] < 0


def test_triangles_of_instances_and_point_instances_are_found():
    stage = stage_context.new_stage()
    crate = stage.DefinePrim("/World/crate", "Xform")
    UsdGeom.Cube.Define(stage, "/World/crate/box").AddTranslateOp().Set(Gf.Vec3d(0, 0, 1))
    copy = UsdGeom.Xform.Define(stage, "/World/copy")
    copy.GetPrim().GetReferences().AddInternalReference(crate.GetPath())
    copy.GetPrim().SetInstanceable(True)
    copy.AddTranslateOp().Set(Gf.Vec3d(5, 0, 0))
    assert [p.in_world().points.mean(0).round(6).tolist() for p in triangles_below([copy.GetPrim()])] == [[5, 0, 1]]
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    instancer.CreatePrototypesRel().SetTargets([crate.GetPath()])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr(Vt.Vec3fArray([(1, 0, 0), (0, 9, 0)]))
    instancer.AddTranslateOp().Set(Gf.Vec3d(0, 0, 2))
    found = [p.in_world().points.mean(0).round(6).tolist() for p in triangles_below([instancer.GetPrim()])]
    assert found == [[1, 0, 3], [0, 9, 3]]

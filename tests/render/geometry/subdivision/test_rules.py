"""Subdivision rules against B-splines, closed forms, trimesh and themselves."""

import numpy as np
import pytest
import trimesh
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from usdsdg_render.geometry.subdivision.rules import (
    INFINITE,
    ControlMesh,
    boundary_corners,
    child_counts,
    face_varying_normals,
    limit_values,
    refine,
)

CUBE_POINTS = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
CUBE_FACES = np.array([0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6, 4, 5, 7, 6, 2, 3, 1, 0])


def control_mesh(points, counts, indices, *, crease=0.0):
    points, indices = np.asarray(points, float), np.asarray(indices)
    return ControlMesh(points, np.zeros(len(points)), np.asarray(counts), indices, np.full(len(indices), crease))


def cube(crease=0.0):
    return control_mesh(CUBE_POINTS, [4] * 6, CUBE_FACES, crease=crease)


def grid(n, rng):
    """n x n vertices over [0, n - 1]^2 with random heights."""
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="xy")
    points = np.stack([x, y, rng.normal(size=(n, n))], axis=-1).reshape(-1, 3)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    return control_mesh(
        points, [4] * len(corner), np.stack([corner, corner + 1, corner + n + 1, corner + n], -1).ravel()
    )


def ball():
    mesh = trimesh.creation.icosphere(1)
    mesh.vertices *= (1.0, 0.7, 1.6)
    return mesh, control_mesh(mesh.vertices, [3] * len(mesh.faces), mesh.faces.ravel())


def spline(values, at):
    """A uniform cubic B-spline with these control values at integers, evaluated at `at`."""
    return BSpline(np.arange(-2.0, len(values) + 2.0), np.asarray(values, float), 3)(at)


def test_the_corners_of_a_cube_end_where_the_closed_form_says():
    # Valence 3: (9 v + 4 * sum of neighbors + sum of the opposite corners) / 24, which is half the cube's.
    for levels in (1, 2, 4):
        surface = refine(cube(), levels, loop=False)
        np.testing.assert_allclose(limit_values(surface, loop=False)[:8], CUBE_POINTS / 2, atol=1e-12)


def test_inside_a_regular_grid_the_surface_is_the_tensor_b_spline():
    n, levels = 7, 3
    control = grid(n, np.random.default_rng(0))
    surface = refine(control, levels, loop=False)
    ends = limit_values(surface, loop=False)
    inside = np.all((ends[:, :2] >= 2.0) & (ends[:, :2] <= n - 3.0), axis=1)
    heights = control.values[:, 2].reshape(n, n)
    expected = [spline([spline(row, x) for row in heights], y) for x, y, _ in ends[inside]]
    assert inside.sum() == 17 * 17
    np.testing.assert_allclose(ends[inside, 2], expected, atol=1e-12)


def test_a_boundary_is_the_b_spline_of_its_vertices_and_pinned_corners_stay():
    n = 9
    control = grid(n, np.random.default_rng(1))
    control = control._replace(corner_sharpness=np.where(boundary_corners(control), INFINITE, 0.0))
    ends = limit_values(refine(control, 3, loop=False), loop=False)
    np.testing.assert_allclose(ends[[0, n - 1]], control.values[[0, n - 1]])
    edge = (np.abs(ends[:, 1]) < 1e-12) & (ends[:, 0] >= 2.0) & (ends[:, 0] <= n - 3.0)
    assert edge.sum() == 33
    np.testing.assert_allclose(ends[edge, 2], spline(control.values[:n, 2], ends[edge, 0]), atol=1e-12)


def test_loop_refines_as_trimesh_does():
    mesh, control = ball()
    points, triangles = trimesh.remesh.subdivide_loop(mesh.vertices, mesh.faces, iterations=2)
    surface = refine(control, 2, loop=True)
    assert len(surface.values) == len(points)
    assert len(surface.counts) == len(triangles)
    assert cKDTree(points).query(surface.values)[0].max() < 1e-12
    volume = trimesh.Trimesh(surface.values, surface.indices.reshape(-1, 3), process=False).volume
    assert volume == pytest.approx(trimesh.Trimesh(points, triangles).volume)


@pytest.mark.parametrize("loop", [False, True])
def test_the_limit_is_where_many_levels_lead(loop):
    control = ball()[1] if loop else cube()
    coarse = refine(control, 1, loop=loop)
    fine = refine(control, 7, loop=loop)
    kept = len(coarse.values)
    np.testing.assert_allclose(limit_values(coarse, loop=loop), fine.values[:kept], atol=1e-4)
    np.testing.assert_allclose(limit_values(coarse, loop=loop), limit_values(fine, loop=loop)[:kept], atol=1e-12)


@pytest.mark.parametrize("loop", [False, True])
def test_what_is_sharp_everywhere_keeps_its_shape(loop):
    control = ball()[1] if loop else cube()
    sharp = control._replace(
        corner_sharpness=np.full(len(control.values), INFINITE),
        crease_sharpness=np.full(len(control.indices), INFINITE),
    )
    surface = refine(sharp, 3, loop=loop)
    ends = limit_values(surface, loop=loop)
    before = trimesh.Trimesh(control.values, _triangles(control), process=False)
    after = trimesh.Trimesh(ends, _triangles(surface), process=False)
    assert after.volume == pytest.approx(before.volume)
    assert after.area == pytest.approx(before.area)


def _triangles(surface):
    face = surface.indices.reshape(len(surface.counts), -1)
    return face if face.shape[1] == 3 else np.concatenate([face[:, :3], face[:, [0, 2, 3]]])


def test_sharpness_one_is_sharp_for_one_level():
    rim = np.zeros(24)
    rim[16:20] = 1.0  # around the top
    control = cube()._replace(crease_sharpness=_both_sides(rim))
    once = refine(control, 1, loop=False)
    forever = refine(control._replace(crease_sharpness=control.crease_sharpness * INFINITE), 1, loop=False)
    np.testing.assert_allclose(once.values, forever.values, atol=1e-12)
    assert (once.crease_sharpness == 0).all()
    assert forever.crease_sharpness.max() == INFINITE


def test_fractions_of_sharpness_lie_between_the_whole_ones():
    heights = []
    for sharpness in (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, INFINITE):
        rim = np.zeros(24)
        rim[16:20] = sharpness
        surface = refine(cube()._replace(crease_sharpness=_both_sides(rim)), 4, loop=False)
        heights.append(limit_values(surface, loop=False)[4, 2])
    assert (np.diff(heights) > 0).all()
    # The crease of the top face is the B-spline of its square, at its corners: (1 + 4 + 1) / 6 of them.
    assert heights[-1] == pytest.approx(1.0)
    # Between no and one level of sharpness the first level is blended linearly.
    np.testing.assert_allclose(heights[2], (heights[0] + heights[4]) / 2, atol=1e-12)


def _both_sides(creases):
    """The same sharpness for the half-edges on the other side of the cube's edges."""
    following = np.arange(24) + 1 - 4 * (np.arange(24) % 4 == 3)
    edges = {frozenset((CUBE_FACES[k], CUBE_FACES[following[k]])): creases[k] for k in range(24) if creases[k]}
    return np.array([edges.get(frozenset((CUBE_FACES[k], CUBE_FACES[following[k]])), 0.0) for k in range(24)])


def test_three_sharp_edges_hold_their_corner():
    sharp = np.zeros(24)
    for k in range(24):
        if 7 in (CUBE_FACES[k], CUBE_FACES[k + 1 - 4 * (k % 4 == 3)]):
            sharp[k] = INFINITE
    surface = refine(cube()._replace(crease_sharpness=sharp), 3, loop=False)
    np.testing.assert_allclose(limit_values(surface, loop=False)[7], [1, 1, 1])


def test_faces_of_any_size_give_quads_in_the_order_of_their_parents():
    pyramid = control_mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 1)], [4, 3, 3, 3, 3],
                   [3, 2, 1, 0, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4])  # fmt: skip
    surface = refine(pyramid, 2, loop=False)
    assert child_counts(pyramid.counts, 2, loop=False).tolist() == [16, 12, 12, 12, 12]
    assert len(surface.counts) == 64
    middle = surface.values[surface.indices].reshape(64, 4, 3).mean(1)
    assert middle[:16, 2].max() < middle[16:, 2].min(), "the base stays below the sides"


def test_normals_are_smooth_but_part_at_sharp_edges():
    smooth = refine(cube(), 4, loop=False)
    smooth = smooth._replace(values=limit_values(smooth, loop=False))
    normals = face_varying_normals(smooth)
    for vertex in (0, 9, 30):
        around = normals[smooth.indices == vertex]
        np.testing.assert_allclose(around, np.broadcast_to(around[0], around.shape), atol=1e-12)
    assert (np.einsum("ni,ni->n", normals, smooth.values[smooth.indices]) > 0).all(), "they point outward"
    rim = np.zeros(24)
    rim[16:20] = INFINITE
    creased = refine(cube()._replace(crease_sharpness=_both_sides(rim)), 3, loop=False)
    creased = creased._replace(values=limit_values(creased, loop=False))
    around = face_varying_normals(creased)[creased.indices == 4]
    assert len(np.unique(np.round(around, 9), axis=0)) == 2, "one normal above the rim, one below"
    np.testing.assert_allclose(around[:, 2].max(), 1.0, atol=1e-6)

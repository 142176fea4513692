"""Sweeps against closed forms, and against overlap queries along the way."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.physics.queries.test_queries import SIZES, _placed, _scene
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.queries.scene_queries import SceneQueries
from usdsdg_physics.scene.records import Shape

NO_BODIES = np.zeros((0, 7))
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def _sweep(shape, kind, size, origin, direction, distance=10.0, rotation=UPRIGHT, **options):
    queries = SceneQueries(_scene([shape]))
    return queries.sweep(NO_BODIES, kind, size, origin, rotation, direction, distance, **options)


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.69])
def test_a_sphere_meets_a_sphere_where_their_centers_are_two_radii_apart(offset):
    (hit,) = _sweep(Shape("sphere", (0.5, 0, 0), (0, 0, 5)), "sphere", (0.2, 0, 0), (offset, 0, 0), (0, 0, 1))
    height = np.sqrt(0.7**2 - offset**2)
    assert hit.distance == pytest.approx(5 - height, abs=1e-9)
    normal = np.array([offset, 0, -height]) / 0.7
    assert hit.normal == pytest.approx(normal, abs=1e-5)
    assert hit.position == pytest.approx(np.array([0, 0, 5]) + 0.5 * normal, abs=1e-5)
    assert not _sweep(Shape("sphere", (0.5, 0, 0), (0, 0, 5)), "sphere", (0.2, 0, 0), (0.71, 0, 0), (0, 0, 1))


def test_a_sphere_meets_the_edge_of_a_box_as_a_cylinder_around_it():
    (hit,) = _sweep(Shape("box", (1, 1, 1), (0, 0, 5)), "sphere", (0.5, 0, 0), (1.3, 0, 0), (0, 0, 1))
    assert hit.distance == pytest.approx(4 - 0.4, abs=1e-9)
    assert hit.position == pytest.approx((1, 0, 4), abs=1e-5)
    assert hit.normal == pytest.approx((0.6, 0, -0.8), abs=1e-5)


def test_a_box_on_its_corner_meets_a_box_with_the_corner():
    turned = (Rotation.align_vectors([[0, 0, 1]], [[1, 1, 1]])[0]).as_quat()
    (hit,) = _sweep(Shape("box", (2, 2, 1), (0, 0, 5)), "box", (0.5, 0.5, 0.5), (0.2, 0.1, 0), (0, 0, 1), 9.0, turned)
    assert hit.distance == pytest.approx(4 - np.sqrt(0.75), abs=1e-9)
    assert hit.position == pytest.approx((0.2, 0.1, 4), abs=1e-6)
    assert hit.normal == pytest.approx((0, 0, -1), abs=1e-6)


def test_a_rotation_of_any_length_turns_the_box_that_is_swept():
    """A quarter turn about Y: the long side of the box points down."""
    (hit,) = _sweep(
        Shape("box", (1, 1, 1)), "box", (1.0, 0.1, 0.1), (0, 0, 8), (0, 0, -1), rotation=(0.0, 2.0, 0.0, 2.0)
    )
    assert hit.distance == pytest.approx(8 - 1 - 1, abs=1e-9)
    assert hit.normal == pytest.approx((0, 0, 1), abs=1e-6)


def test_a_box_moves_obliquely_onto_a_plane():
    direction = np.array([3.0, 0.0, -4.0])
    (hit,) = _sweep(Shape("plane", (0, 0, 0)), "box", (0.5, 0.5, 0.5), (0, 0, 2.5), direction)
    assert hit.distance == pytest.approx(2.0 / 0.8, abs=1e-12)
    assert hit.normal == (0, 0, 1)
    assert not _sweep(Shape("plane", (0, 0, 0)), "box", (0.5, 0.5, 0.5), (0, 0, 2.5), -direction)


@pytest.mark.parametrize(("up", "both_sides", "hits"), [(-1, False, 1), (1, False, 0), (1, True, 1)])
def test_triangles_that_face_along_the_motion_count_with_both_sides(up, both_sides, hits):
    shape = Shape("mesh", (1, 1, 1), (0, 0, 0), solid=HullCache().mesh(SQUARE, TRIANGLES))
    found = _sweep(shape, "sphere", (0.25, 0, 0), (0.5, -0.2, 3.0 * -up), (0, 0, up), both_sides=both_sides)
    assert len(found) == hits
    for hit in found:
        assert hit.distance == pytest.approx(2.75, abs=1e-9)
        assert hit.normal == pytest.approx((0, 0, -up), abs=1e-9)
        assert hit.face == 0


def test_what_overlaps_at_the_start_has_distance_zero():
    (hit,) = _sweep(Shape("box", (1, 1, 1)), "sphere", (0.5, 0, 0), (0, 0, 1.2), (1, 0, 0))
    assert (hit.distance, hit.normal, hit.position) == (0.0, (-1, 0, 0), (0, 0, 1.2))


def test_hits_are_nearest_first_and_then_in_path_order():
    shapes = [Shape("sphere", (0.5, 0, 0), (x, 0, z)) for x, z in ((0, 5), (0.2, 3), (-0.2, 3))]
    hits = SceneQueries(_scene(shapes)).sweep(NO_BODIES, "box", (1, 1, 0.1), (0, 0, 0), UPRIGHT, (0, 0, 1), 9.0)
    assert [hit.collision for hit in hits] == ["/s001", "/s002", "/s000"]
    hits = SceneQueries(_scene(shapes)).raycast(NO_BODIES, (0, 0, 0), (0, 0, 1), 9.0)
    assert [hit.collision for hit in hits] == ["/s001", "/s002", "/s000"]


@pytest.mark.parametrize("kind", ["box", "sphere"])
def test_a_moving_shape_overlaps_from_the_first_contact_on_and_not_before(kind):
    rng = np.random.default_rng(3)
    points = rng.normal(size=(20, 3)).astype(np.float32)
    shapes = [_placed(name, rng) for name in SIZES for _ in range(6)]
    shapes += [_placed("hull", rng, HullCache().hull(points, prim_path="/h"), (0.2, 0.3, -0.2)) for _ in range(6)]
    queries, size = SceneQueries(_scene(shapes)), (0.15, 0.1, 0.2) if kind == "box" else (0.15, 0.0, 0.0)
    rotation = Rotation.random(random_state=rng).as_quat()
    for _ in range(6):
        target = rng.uniform(-0.6, 0.6, 3)
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        origin = target - 4 * direction
        hits = {h.collision: h for h in queries.sweep(NO_BODIES, kind, size, origin, rotation, direction, 8.0)}

        def overlapping(t, origin=origin, direction=direction):
            at = origin + t * direction
            if kind == "box":
                return {o.collision for o in queries.overlap_box(NO_BODIES, size, at, rotation)}
            return {o.collision for o in queries.overlap_sphere(NO_BODIES, size[0], at)}

        swept = set()
        for t in np.linspace(0.0, 8.0, 161):
            now = overlapping(t)
            swept |= now
            assert all(hits[name].distance <= t for name in now)
        assert swept <= set(hits)
        for name, hit in hits.items():
            assert name not in overlapping(hit.distance - 1e-6)
            # A graze of a rounded shape deepens with the square of the distance.
            assert name in overlapping(hit.distance + 2e-3) or name not in swept
            assert np.dot(hit.normal, direction) < 0

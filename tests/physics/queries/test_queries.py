"""Overlap and raycast against oracles that share no code with them."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, playing, set_value
from usdsdg import errors
from usdsdg_physics import NewtonEngine, Overlap
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.queries.scene_queries import SceneQueries
from usdsdg_physics.scene.records import STATIC, Collider, Material, Scene, Shape

SIZES = {
    "box": (0.3, 0.2, 0.4),
    "sphere": (0.4, 0.0, 0.0),
    "capsule": (0.2, 0.3, 0.0),
    "cylinder": (0.3, 0.25, 0.0),
    "cone": (0.35, 0.3, 0.0),
}


def _scene(shapes: list[Shape]) -> Scene:
    colliders = {f"/s{i:03d}": Collider(f"/s{i:03d}", STATIC, shape, Material()) for i, shape in enumerate(shapes)}
    return Scene(bodies={}, colliders=colliders, gravity=(0, 0, -9.81), scene_path="")


def _placed(kind: str, rng: np.random.Generator, solid=None, size=None) -> Shape:
    size = SIZES[kind] if size is None else size
    return Shape(kind, size, tuple(rng.uniform(-1, 1, 3)), tuple(Rotation.random(random_state=rng).as_quat()), solid)


def _nearest(shape: Shape, p: np.ndarray) -> np.ndarray:
    """Points of the solid nearest to p (N, 3), in the shape's frame."""
    radius, half, _ = shape.size
    if shape.kind == "box":
        return np.clip(p, -np.array(shape.size), shape.size)
    if shape.kind in ("sphere", "capsule"):
        axis = np.zeros_like(p)
        axis[:, 2] = np.clip(p[:, 2], -half, half)
        away = p - axis
        return axis + away * np.minimum(1, radius / np.maximum(np.linalg.norm(away, axis=1), 1e-300))[:, None]
    flat = np.linalg.norm(p[:, :2], axis=1)
    toward = p[:, :2] / np.maximum(flat, 1e-300)[:, None]
    if shape.kind == "cylinder":
        r, z = np.minimum(flat, radius), np.clip(p[:, 2], -half, half)
    else:
        r, z = _nearest_in_triangle(flat, p[:, 2], radius, half)
    return np.concatenate([toward * r[:, None], z[:, None]], axis=1)


def _nearest_in_triangle(r, z, radius, half):
    """The half section of a cone: corners (0, -half), (radius, -half), (0, half), with r >= 0."""
    inside = (z >= -half) & (r <= radius * (half - z) / (2 * half))
    best_r, best_z, best = r.copy(), z.copy(), np.where(inside, 0.0, np.inf)
    for (r0, z0), (r1, z1) in (((0, -half), (radius, -half)), ((radius, -half), (0, half))):
        t = np.clip(((r - r0) * (r1 - r0) + (z - z0) * (z1 - z0)) / ((r1 - r0) ** 2 + (z1 - z0) ** 2), 0, 1)
        at_r, at_z = r0 + t * (r1 - r0), z0 + t * (z1 - z0)
        distance = np.hypot(at_r - r, at_z - z)
        closer = distance < best
        best_r, best_z, best = (
            np.where(closer, at_r, best_r),
            np.where(closer, at_z, best_z),
            np.where(closer, distance, best),
        )
    return best_r, best_z


def _distances(shapes: list[Shape], query: Shape) -> np.ndarray:
    """Distance of every shape to the query, by alternating projections onto the two convex sets."""
    rotation, offset = Rotation.from_quat(query.rotation), np.array(query.position)
    distances = []
    for shape in shapes:
        own, at = Rotation.from_quat(shape.rotation), np.array(shape.position)
        p = at[None, :]
        for _ in range(3000):
            q = rotation.apply(_nearest(query, rotation.inv().apply(p - offset))) + offset
            last, p = p, own.apply(_nearest(shape, own.inv().apply(q - at))) + at
            if np.abs(p - last).max() < 1e-12:
                break
        distances.append(float(np.linalg.norm(p - q)))
    return np.array(distances)


@pytest.mark.parametrize("query_kind", ["box", "sphere"])
def test_overlap_of_primitives_matches_their_distance(query_kind):
    """Pairs nearer than 1 mm are left out: there the projections have not converged."""
    rng = np.random.default_rng(5)
    shapes = [_placed(kind, rng) for kind in SIZES for _ in range(30)]
    query = _placed(query_kind, rng, size=(0.5, 0.3, 0.2) if query_kind == "box" else (0.5, 0.0, 0.0))
    queries = SceneQueries(_scene(shapes))
    none = np.zeros((0, 7))
    if query_kind == "box":
        hits = queries.overlap_box(none, query.size, query.position, query.rotation)
    else:
        hits = queries.overlap_sphere(none, query.size[0], query.position)
    found = np.zeros(len(shapes), bool)
    found[[int(hit.collision[2:]) for hit in hits]] = True
    distances = _distances(shapes, query)
    clear = (distances > 1e-3) | (distances < 1e-6)
    assert clear.sum() > 0.9 * len(shapes)
    assert (found == (distances < 1e-6))[clear].all()
    assert 10 < found.sum() < len(shapes) - 10


def test_overlap_of_hulls_matches_linear_programming():
    """A box and a hull meet exactly when a convex combination of the hull's vertices lies in the box."""
    rng = np.random.default_rng(6)
    cache = HullCache()
    shapes = [
        _placed("hull", rng, cache.hull(rng.normal(size=(40, 3)) * rng.uniform(0.1, 0.3, 3)), (1.0, 1.5, -0.7))
        for _ in range(60)
    ]
    half, at, turn = np.array([0.5, 0.3, 0.2]), np.array([0.1, 0.0, -0.1]), Rotation.random(random_state=rng)
    hits = SceneQueries(_scene(shapes)).overlap_box(np.zeros((0, 7)), half, at, turn.as_quat())
    found = {int(hit.collision[2:]) for hit in hits}
    for row, shape in enumerate(shapes):
        points = Rotation.from_quat(shape.rotation).apply(shape.solid.vertices * shape.size) + shape.position
        local = turn.inv().apply(points - at)
        feasible = linprog(
            np.zeros(len(local)),
            A_ub=np.concatenate([local.T, -local.T]),
            b_ub=np.concatenate([half, half]),
            A_eq=np.ones((1, len(local))),
            b_eq=[1.0],
        ).success
        assert feasible == (row in found), row
    assert 10 < len(found) < 50


def test_rays_stop_where_small_spheres_begin_to_touch():
    """A tiny sphere touches a shape at the hit and nothing before it; a missing ray meets nothing all the way."""
    rng = np.random.default_rng(7)
    cache = HullCache()
    shapes = [_placed(kind, rng) for kind in SIZES for _ in range(2)]
    shapes += [_placed("hull", rng, cache.hull(rng.normal(size=(30, 3)) * 0.2), (1, 1.5, -0.7)) for _ in range(3)]
    queries, none = SceneQueries(_scene(shapes)), np.zeros((0, 7))
    hits = 0
    for _ in range(60):
        origin = rng.normal(size=3)
        origin *= 3 / np.linalg.norm(origin)
        direction = rng.uniform(-0.8, 0.8, 3) - origin
        direction /= np.linalg.norm(direction)
        hit = next(iter(queries.raycast(none, origin, direction, 6.0)), None)
        reach = hit.distance if hit else 6.0
        for fraction in np.linspace(0, 0.999, 40):
            assert not queries.overlap_sphere(none, 1e-5, origin + fraction * (reach - 1e-3) * direction)
        if hit:
            hits += 1
            touching = queries.overlap_sphere(none, 1e-6, hit.position)
            assert Overlap(hit.rigid_body, hit.collision) in touching
            assert np.dot(hit.normal, direction) < 0
            assert np.linalg.norm(hit.normal) == pytest.approx(1)
            outside = np.array(hit.position) + 1e-3 * np.array(hit.normal)
            assert hit.collision not in {o.collision for o in queries.overlap_sphere(none, 5e-4, outside)}
    assert 15 < hits < 60


@pytest.mark.parametrize("slope", [0.0, 0.02])
def test_rays_to_the_apex_of_a_cone_hit_it_there_with_a_normal(slope):
    """Wherever the cone is, rounding lets none into it, and the normal looks against the ray."""
    rng = np.random.default_rng(3)
    for number in range(300):
        radius, half = rng.uniform(0.3, 1.0, 2)  # rays are steeper than its side
        turn = Rotation.random(random_state=rng) if number else Rotation.identity()
        at = rng.uniform(-3, 3, 3) if number else np.zeros(3)
        cone = Shape("cone", (radius, half, 0.0), tuple(at), tuple(turn.as_quat()))
        down = np.array([*rng.normal(size=2) * slope, -1.0])
        down = turn.apply(down / np.linalg.norm(down))
        apex = turn.apply((0, 0, half)) + at
        hit = SceneQueries(_scene([cone])).raycast(np.zeros((0, 7)), apex - 2.0 * down, down, 9.0)[0]
        assert hit.distance == pytest.approx(2.0, abs=1e-6)
        assert np.linalg.norm(hit.normal) == pytest.approx(1.0)
        assert np.dot(hit.normal, down) < 0.0


def test_no_ray_passes_between_the_two_triangles_of_a_square():
    """The middle of a square lies on the edge that its triangles share."""
    rng = np.random.default_rng(4)
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    solid = HullCache().mesh(points, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    for _ in range(300):
        square = _placed("mesh", rng, solid, tuple(rng.uniform(0.5, 2.0, 3)))
        turn = Rotation.from_quat(square.rotation)
        down = turn.apply((*rng.uniform(-0.3, 0.3, 2), -1.0))
        on_diagonal = turn.apply(rng.uniform(-0.9, 0.9) * np.array([1.0, 1.0, 0.0]) * square.size) + square.position
        (hit,) = SceneQueries(_scene([square])).raycast(np.zeros((0, 7)), on_diagonal - 3.0 * down, down, 9.0)
        assert hit.position == pytest.approx(on_diagonal, abs=1e-6)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda e: e.raycast_all((0, 0, 5), (0, 0, 0), 9.0), "raycast finds nothing, .* a direction"),
        (lambda e: e.raycast_all((0, 0, float("nan")), (0, 0, -1), 9.0), "raycast finds nothing, .* not finite"),
        (lambda e: e.sweep_sphere(-0.1, (0, 0, 5), (0, 0, -1), 9.0), "sweep_sphere finds nothing, .* a radius"),
        (lambda e: e.sweep_box((1, 1, 1), (0, 0, 5), (0, 0, 0, 0), (0, 0, -1), 9), "sweep_box finds nothing"),
        (lambda e: e.overlap_box((1, 1, 1), (0, 0, 0), (0, 0, 0, 0)), "overlap_box finds nothing, .* a rotation"),
        (lambda e: e.overlap_sphere(-5.0, (0, 0, 0)), "overlap_sphere finds nothing, .* below zero"),
    ],
)
def test_queries_with_numbers_that_nothing_has_find_nothing_and_are_named(ask, words):
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match=words):
        assert ask(NewtonEngine(_stage())) == []
    errors.forget_warnings()


def test_ray_from_inside_hits_at_once():
    shape = Shape("cylinder", SIZES["cylinder"])
    (hit,) = SceneQueries(_scene([shape])).raycast(np.zeros((0, 7)), (0, 0, 0), (0, 0, 1), 9.0)
    assert hit is not None
    assert hit.distance == 0.0


def _stage() -> Usd.Stage:
    stage = new_stage()
    add(stage, "/World/floor", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)
    add(stage, "/World/b", at=(1, 0, 0.1), gravity=False)
    add(stage, "/World/a", at=(-1, 0, 0.1), gravity=False)
    part = UsdGeom.Xform.Define(stage, "/World/compound")
    part.AddTranslateOp().Set(Gf.Vec3d(0, 2, 0.1))
    add(stage, "/World/compound/part", body=False)
    make_body(part.GetPrim(), gravity=False)
    return stage


def test_hits_come_in_path_order_with_their_bodies():
    """A static collider is its own rigid_body, as in PhysX, where scripts tell it from others by that path."""
    engine = playing(_stage())
    engine.advance(1 / 60)
    assert engine.overlap_box((5, 5, 0.3), (0, 0, 0)) == [
        Overlap("/World/a", "/World/a"),
        Overlap("/World/b", "/World/b"),
        Overlap("/World/compound", "/World/compound/part"),
        Overlap("/World/floor", "/World/floor"),
    ]
    assert engine.overlap_sphere(0.2, (1, 0, 0.35)) == [Overlap("/World/b", "/World/b")]


def test_switched_off_colliders_are_not_found():
    stage = _stage()
    engine = playing(stage)
    engine.advance(1 / 60)
    set_value(stage.GetPrimAtPath("/World/b"), "physics:collisionEnabled", False)
    engine.advance(1 / 60)
    assert engine.overlap_sphere(0.2, (1, 0, 0.35)) == []
    assert engine.raycast((1, 0, 5), (0, 0, -1), 10).collision == "/World/floor"


def test_queries_follow_bodies_and_static_colliders():
    stage = _stage()
    engine = playing(stage)
    set_value(stage.GetPrimAtPath("/World/b"), "physics:velocity", Gf.Vec3f(0, 0, 2))
    set_value(stage.GetPrimAtPath("/World/floor"), "xformOp:translate", Gf.Vec3d(0, 0, -1.5))
    engine.advance(1.0)
    hit = engine.raycast((1, 0, 5), (0, 0, -2), 10)
    assert hit.collision == "/World/b"
    assert hit.distance == pytest.approx(5 - 2.2, abs=1e-4)
    assert engine.raycast((3, 3, 5), (0, 0, -1), 10).distance == pytest.approx(6, abs=1e-5)
    assert engine.raycast((3, 3, 5), (0, 0, -1), 5.9) is None


def test_queries_are_in_stage_units():
    stage = new_stage(meters_per_unit=0.01)
    add(stage, "/World/box", at=(0, 0, 100), scale=(10, 10, 10), gravity=False)
    engine = playing(stage)
    engine.advance(1 / 60)
    hit = engine.raycast((0, 0, 300), (0, 0, -1), 1000)
    assert hit.distance == pytest.approx(190, abs=1e-3)
    assert hit.position == pytest.approx((0, 0, 110), abs=1e-3)
    assert engine.overlap_sphere(5, (0, 0, 114.9))
    assert not engine.overlap_sphere(5, (0, 0, 115.1))


def test_queries_of_a_stopped_stage_see_what_is_authored():
    stage = _stage()
    engine = playing(stage)
    engine.stop()
    set_value(stage.GetPrimAtPath("/World/b"), "xformOp:translate", Gf.Vec3d(3, 0, 1))
    assert engine.overlap_sphere(0.5, (3, 0, 1)) == [Overlap("/World/b", "/World/b")]


def test_static_mesh_and_plane():
    """A mesh without approximation keeps its hollow; a plane fills everything below it."""
    stage = new_stage()
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, -1]], float)
    funnel = mesh(stage, "/World/funnel", corners, [[0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]])
    funnel.AddTranslateOp().Set(Gf.Vec3d(0, 0, 1))
    collide(funnel.GetPrim(), approximation="none")
    plane = UsdGeom.Plane.Define(stage, "/World/plane")
    plane.AddTranslateOp().Set(Gf.Vec3d(0, 0, -2))
    collide(plane.GetPrim())
    engine = playing(stage)
    engine.advance(1 / 60)
    assert engine.overlap_sphere(0.2, (0, 0, 0.8)) == []
    assert engine.overlap_sphere(0.2, (0, 0, 0.1)) == [Overlap("/World/funnel", "/World/funnel")]
    assert engine.overlap_box((0.1, 0.1, 0.1), (5, 5, -2.05)) == [Overlap("/World/plane", "/World/plane")]
    assert engine.overlap_box((0.1, 0.1, 0.1), (5, 5, -1.85)) == []
    assert engine.raycast((0, 0, 5), (0, 0, -1), 10).distance == pytest.approx(5)
    assert engine.raycast((9, 0, 5), (0, 0, -1), 10).distance == pytest.approx(7)


def test_queries_without_bodies_follow_what_is_moved_while_playing():
    stage = new_stage()
    wall = add(stage, "/World/wall", at=(5, 0, 0), body=False)
    engine = playing(stage)
    engine.advance(1 / 60)
    assert engine.raycast((0, 0, 0), (1, 0, 0), 100).distance == pytest.approx(4.9, abs=1e-4)
    for distance in (7, 9):
        set_value(wall, "xformOp:translate", (distance, 0, 0))
        engine.advance(1 / 60)
        assert engine.raycast((0, 0, 0), (1, 0, 0), 100).distance == pytest.approx(distance - 0.1, abs=1e-4)
    add(stage, "/World/late", at=(0, 9, 0))
    engine.advance(1 / 60)
    assert engine.rigid_bodies == ("/World/late",)

"""Triangle meshes collide on kinematic bodies as on static colliders; on others they become convex hulls, by name."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics
from scipy.spatial import ConvexHull

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, playing, position, set_value, velocity
from usdsdg import errors
from usdsdg.stage.schemas import physx
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
HALF = 0.1  # m, of a box in the bowl
# The height of that box, level on its four lower corners, which touch z = r² at r² = 2 HALF².
IN_BOWL = 2 * HALF**2 + HALF


def _bowl(rings=24, sectors=24):
    """Points and triangles of z = r² up to r = 1, faces up."""
    points, faces = [], []
    for ring in range(rings + 1):
        radius = ring / rings
        angles = 2 * np.pi * np.arange(sectors) / sectors
        points += [(radius * np.cos(a), radius * np.sin(a), radius**2) for a in angles]
    for ring in range(rings):
        for i in range(sectors):
            a, b = ring * sectors + i, ring * sectors + (i + 1) % sectors
            faces += [[a, a + sectors, b + sectors], [a, b + sectors, b]]
    return np.array(points), np.array(faces)


def _box_mesh(half, *, lid=True):
    """Points and outward triangles of a box, or of one without its upper faces."""
    hull = ConvexHull(CORNERS)
    faces = hull.simplices.copy()
    a, b, c = (CORNERS[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return CORNERS * half, faces if lid else faces[hull.equations[:, 2] < 0.5]


def _collider(stage, path, points, faces, *, at=(0, 0, 0), body=None, approximation="none"):
    """A mesh with a collider; `body` is None, "kinematic" or "dynamic"."""
    prim = mesh(stage, path, points, faces).GetPrim()
    UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(*at))
    collide(prim, approximation=approximation)
    if body:
        make_body(prim)
        UsdPhysics.RigidBodyAPI(prim).CreateKinematicEnabledAttr(body == "kinematic")
    return prim


def _kinds(stage):
    return {path: collider.shape.kind for path, collider in parse(stage, HullCache()).colliders.items()}


@pytest.mark.parametrize("approximation", ["none", "sdf", "meshSimplification"])
def test_a_box_falls_into_a_kinematic_bowl(approximation, recwarn):
    stage = new_stage()
    _collider(stage, "/World/bowl", *_bowl(), body="kinematic", approximation=approximation)
    box = add(stage, "/World/box", at=(0, 0, 1.0), scale=(HALF,) * 3)
    playing(stage).advance(3.0)
    # The bowl's facets are up to 2 mm above the paraboloid.
    assert position(box)[2] == pytest.approx(IN_BOWL, abs=4e-3)
    assert not [warning for warning in recwarn if issubclass(warning.category, errors.UsdsdgWarning)]


def test_a_kinematic_tray_carries_what_is_in_it():
    """It is lifted by 0.5 m and carried 0.8 m aside, at up to 1.5 m/s."""
    stage = new_stage()
    points, faces = _box_mesh((0.3, 0.3, 0.1), lid=False)
    # Triangles collide from the side that they face: inward, as those of a container.
    tray = _collider(stage, "/World/tray", points, faces[:, ::-1], body="kinematic")
    box = add(stage, "/World/box", at=(0, 0, 0.0))
    engine = playing(stage)
    engine.advance(0.5)
    assert position(box)[2] == pytest.approx(0.0, abs=1e-3)
    for step in range(1, 81):
        part = (1 - np.cos(np.pi * step / 80)) / 2
        set_value(tray, "xformOp:translate", Gf.Vec3d(0.8 * part, 0, 0.5 * part))
        engine.advance(1 / 60)
    engine.advance(0.5)
    assert position(box)[2] == pytest.approx(0.5, abs=2e-3)
    assert abs(position(box)[0] - 0.8) < 0.2


def test_a_fast_kinematic_mesh_passes_through_nothing_small():
    """It moves by more than a ball and its contact offset in each substep away from meshes."""
    stage = new_stage()
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    plate = _collider(stage, "/World/plate", square, np.array([[0, 1, 2], [0, 2, 3]]), body="kinematic")
    ball = add(stage, "/World/ball", "Sphere", at=(0.2, 0.1, 0.56), scale=(0.01,) * 3, gravity=False)
    engine = playing(stage)
    speed = 12.0
    for step in range(1, 31):
        set_value(plate, "xformOp:translate", Gf.Vec3d(0, 0, speed * step / 60))
        engine.advance(1 / 60)
    assert position(ball)[2] > position(plate)[2]
    assert velocity(ball)[2] == pytest.approx(speed, rel=0.05)


def test_the_shape_follows_kinematic_enabled_while_playing():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    bowl = _collider(stage, "/World/bowl", *_bowl(), body="kinematic")
    box = add(stage, "/World/box", at=(0, 0, 0.3))
    engine = playing(stage)
    engine.advance(1.0)
    assert engine._session.scene.colliders["/World/bowl"].shape.kind == "mesh"
    assert position(box)[2] == pytest.approx(IN_BOWL, abs=4e-3)
    set_value(box, "xformOp:translate", Gf.Vec3d(0, 0, 1.2))
    set_value(bowl, "physics:kinematicEnabled", False)
    with pytest.warns(errors.UsdsdgWarning, match="convex hulls.*/World/bowl"):
        engine.advance(0.5)
    assert engine._session.scene.colliders["/World/bowl"].shape.kind == "hull"
    assert position(box)[2] > 1.0
    errors.forget_warnings()
    set_value(bowl, "physics:kinematicEnabled", True)
    engine.advance(1.0)
    assert position(box)[2] < 0.5


def test_queries_see_the_triangles_where_the_body_is():
    stage = new_stage()
    bowl = _collider(stage, "/World/bowl", *_bowl(), body="kinematic")
    engine = playing(stage)
    set_value(bowl, "xformOp:translate", Gf.Vec3d(5, 0, 2))
    engine.advance(1 / 60)
    hit = engine.raycast((5.01, 0.01, 9), (0, 0, -1), 20)
    assert hit.rigid_body == "/World/bowl"
    assert hit.position[2] == pytest.approx(2, abs=2e-3)
    assert engine.overlap_box((0.1, 0.1, 0.1), (5, 0, 2.5)) == []
    assert [found.collision for found in engine.overlap_box((0.1, 0.1, 0.1), (5, 0, 2.05))] == ["/World/bowl"]
    assert engine.raycast((0.01, 0.01, 9), (0, 0, -1), 20) is None


def test_instances_of_a_kinematic_prototype_keep_their_triangles():
    stage = new_stage()
    _collider(stage, "/World/bowls/bowl", *_bowl(), body="kinematic")
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/bowls")
    instancer.CreatePrototypesRel().SetTargets(["/World/bowls/bowl"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(0), Gf.Vec3f(3, 0, 0)])
    box = add(stage, "/World/box", at=(3, 0, 0.6), scale=(HALF,) * 3)
    playing(stage).advance(2.0)
    assert position(box)[2] == pytest.approx(IN_BOWL, abs=4e-3)


def test_a_closed_kinematic_mesh_has_the_mass_of_its_volume():
    """Also one whose faces look inward; what is not closed has no volume, and the 1 kg of a body without shapes."""
    stage = new_stage()
    half = (0.1, 0.2, 0.3)
    points, faces = _box_mesh(half)
    points += np.array([0, 0, 1])
    _collider(stage, "/World/closed", points, faces, body="kinematic")
    _collider(stage, "/World/inward", points, faces[:, ::-1], body="kinematic")
    _collider(stage, "/World/open", *_box_mesh(half, lid=False), body="kinematic")
    box = add(stage, "/World/box", scale=half)
    found = playing(stage).mass_properties(["/World/closed", "/World/inward", "/World/open", str(box.GetPath())])
    assert found.mass == pytest.approx([48, 48, 1, 48], rel=1e-5)
    assert np.asarray(found.center)[:2] == pytest.approx(np.array([[0, 0, 1]] * 2), abs=1e-5)
    inertia = np.asarray(found.inertia)
    assert inertia[0] == pytest.approx(inertia[3], rel=1e-4, abs=1e-5)
    assert inertia[1] == pytest.approx(inertia[3], rel=1e-4, abs=1e-5)


def test_meshes_whose_hollows_are_filled_are_named_in_one_warning(recwarn):
    errors.forget_warnings()
    stage = new_stage()
    cups = [f"/World/cup{i}" for i in range(7)]
    for i, path in enumerate(cups):
        _collider(stage, path, *_box_mesh(0.1, lid=False), at=(i, 0, 0), body="dynamic")
    trigger = _collider(stage, "/World/trigger", *_bowl(), at=(0, 5, 0))
    physx.PhysxTriggerAPI.Apply(trigger)
    # Convex already, meant to be a hull, or not solid at all.
    _collider(stage, "/World/block", *_box_mesh(0.1), at=(0, 1, 0), body="dynamic")
    _collider(stage, "/World/hull", *_bowl(), at=(0, 2, 0), body="dynamic", approximation="convexHull")
    _collider(stage, "/World/static", *_bowl(), at=(0, 8, 0))
    _collider(stage, "/World/kinematic", *_bowl(), at=(0, 9, 0), body="kinematic")
    kinds = _kinds(stage)
    assert {path for path, kind in kinds.items() if kind == "mesh"} == {"/World/static", "/World/kinematic"}
    messages = [str(warning.message) for warning in recwarn]
    assert len(messages) == 1
    assert f"{', '.join(cups[:5])} and 3 more" in messages[0]
    assert "'convexDecomposition'" in messages[0]
    assert "'convexHull'" in messages[0]
    errors.forget_warnings()


def test_a_round_convex_mesh_of_many_points_is_not_named(recwarn):
    """Its hull has 64 of the 500 points, and another volume."""
    points = np.random.default_rng(0).normal(size=(500, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    hull = ConvexHull(points)
    faces = hull.simplices.copy()
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    stage = new_stage()
    _collider(stage, "/World/ball", points, faces, body="dynamic")
    assert _kinds(stage) == {"/World/ball": "hull"}
    assert not recwarn.list


def test_a_plane_on_a_kinematic_body_is_left_out_by_name():
    errors.forget_warnings()
    stage = new_stage()
    plane = add(stage, "/World/plane", "Plane", scale=(1, 1, 1))
    UsdPhysics.RigidBodyAPI(plane).CreateKinematicEnabledAttr(True)
    with pytest.warns(errors.UsdsdgWarning, match="/World/plane is a Plane under a rigid body"):
        assert _kinds(stage) == {}
    errors.forget_warnings()

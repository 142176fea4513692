"""What is added, removed or changed while a scene plays is read alone, and gives what the whole stage gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.physics.scenes import add, make_body, mesh, new_stage, physics_material, playing, position, set_value
from usdsdg_physics import play
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache

STEP = 1 / 60
_SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]], float), np.array([[0, 1, 2], [0, 2, 3], [3, 1, 0]])


def _scene() -> Usd.Stage:
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -1), scale=(5, 5, 0.1), body=False)
    material = physics_material(stage, "/Looks/rubber", friction=0.9)
    add(stage, "/World/a/box", rotate=(10, 20, 30), material=material)
    add(stage, "/World/b", at=(1, 0, 0), rotate=(0, 45, 0))
    add(stage, "/World/b/inner", "Sphere", at=(0, 0, 3), body=False)
    add(stage, "/World/c", at=(2, 0, 0))
    add(stage, "/World/kinematic", at=(-2, 0, 0)).CreateAttribute(
        "physics:kinematicEnabled", Sdf.ValueTypeNames.Bool
    ).Set(True)
    return stage


def _between(stage: Usd.Stage) -> None:
    add(stage, "/World/a/late", at=(0, 2, 0))
    UsdGeom.Xform.Define(stage, "/World/first")
    stage.GetPrimAtPath("/World").SetChildrenReorder(["first", "a"])


def _mesh_body(stage: Usd.Stage) -> None:
    prim = mesh(stage, "/World/c/mesh", *_SQUARE).GetPrim()
    UsdPhysics.CollisionAPI.Apply(prim)


def _nested(stage: Usd.Stage) -> None:
    make_body(stage.GetPrimAtPath("/World/b/inner"))


def _removed(stage: Usd.Stage) -> None:
    stage.RemovePrim("/World/b")
    stage.GetPrimAtPath("/World/c").SetActive(False)


def _moved_at_once(stage: Usd.Stage) -> None:
    add(stage, "/World/late", at=(0, 2, 0))
    set_value(stage.GetPrimAtPath("/World/b"), "xformOp:translate", Gf.Vec3d(1, 1, 1))
    set_value(stage.GetPrimAtPath("/World/kinematic"), "xformOp:translate", Gf.Vec3d(-2, 1, 1))
    set_value(stage.GetPrimAtPath("/World/c"), "physxRigidBody:disableGravity", True)
    set_value(stage.GetPrimAtPath("/World/ground"), "xformOp:translate", Gf.Vec3d(0, 0, -2))


def _nowhere(stage: Usd.Stage) -> None:
    add(stage, "/World/late", at=(0, 2, 0))
    set_value(stage.GetPrimAtPath("/World/kinematic"), "xformOp:translate", Gf.Vec3d(np.nan, 1, 1))


def _no_bodies(stage: Usd.Stage) -> None:
    for path in ("/World/a", "/World/b", "/World/c", "/World/kinematic"):
        stage.RemovePrim(path)
    set_value(stage.GetPrimAtPath("/World/ground"), "xformOp:translate", Gf.Vec3d(0, 0, -2))


def _no_body_any_more(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath("/World/b").RemoveAPI(UsdPhysics.RigidBodyAPI)


def _renamed(stage: Usd.Stage) -> None:
    edit = Sdf.BatchNamespaceEdit()
    edit.Add("/World/b", "/World/kinematic/b")
    assert stage.GetRootLayer().Apply(edit)


def _joint(stage: Usd.Stage) -> None:
    joint = UsdPhysics.FixedJoint.Define(stage, "/World/joint")
    joint.CreateBody1Rel().SetTargets(["/World/c"])
    joint.CreateLocalPos0Attr(Gf.Vec3f(*position(stage.GetPrimAtPath("/World/c"))))


def _gravity(stage: Usd.Stage) -> None:
    UsdPhysics.Scene.Get(stage, "/PhysicsScene").CreateGravityMagnitudeAttr(1.0)
    add(stage, "/World/late", at=(0, 2, 0))


def _size(stage: Usd.Stage) -> None:
    add(stage, "/World/late", at=(0, 2, 0))
    UsdGeom.Cube(stage.GetPrimAtPath("/World/c")).CreateSizeAttr(1.0)


@pytest.mark.parametrize(
    ("edit", "alone"),
    [
        (_between, True),
        (_mesh_body, True),
        (_nested, True),
        (_removed, True),
        (_moved_at_once, True),
        (_no_body_any_more, True),
        (_renamed, True),
        (_gravity, True),
        (_no_bodies, False),
        (_nowhere, False),
        (_joint, False),
        (_size, False),
    ],
)
def test_a_part_gives_what_the_whole_stage_gives(monkeypatch, edit: Callable[[Usd.Stage], None], alone: bool):
    stage = _scene()
    engine = playing(stage)
    for _ in range(3):
        engine.advance(STEP)
    whole = []
    monkeypatch.setattr(play, "parse", lambda *args, **options: whole.append(1) or parse(*args, **options))
    edit(stage)
    session = engine._session
    assert session is not None
    world = session.current_world()
    found, expected = session.scene, parse(stage, HullCache())
    assert bool(whole) != alone
    assert list(found.bodies) == list(expected.bodies) == list(world.body_index)
    assert list(found.colliders) == list(expected.colliders)
    assert world.gravity == pytest.approx(expected.gravity)
    for path, body in expected.bodies.items():
        mine = found.bodies[path]
        at, signs = world.poses()[world.body_index[path]], np.ones(7)
        signs[3:] = np.sign(np.dot(at[3:], body.pose[3:]))  # a quaternion and its negative turn alike
        if not body.kinematic:  # those are on their way
            assert signs * at == pytest.approx(body.pose, abs=1e-6)
        assert np.array(mine.body_from_prim) == pytest.approx(np.array(body.body_from_prim), abs=1e-6)
        changing = {name: getattr(body, name) for name in ("pose", "velocity", "angular_velocity", "body_from_prim")}
        assert replace(mine, **changing) == body
    for path, collider in expected.colliders.items():
        mine = found.colliders[path]
        assert mine.shape.size == pytest.approx(collider.shape.size, rel=1e-6)
        assert mine.shape.position == pytest.approx(collider.shape.position, abs=1e-6)
        assert replace(mine, shape=collider.shape) == collider
    engine.advance(STEP)
    engine.stop()


def test_bodies_keep_their_bits_when_another_is_added():
    ends = []
    for adds in (False, True):
        stage = new_stage()
        prim = add(stage, "/World/box", rotate=(10, 20, 30), gravity=False)
        set_value(prim, "physics:velocity", Gf.Vec3f(0.1, 0.2, 0.3))
        set_value(prim, "physics:angularVelocity", Gf.Vec3f(100, 20, 30))
        engine = playing(stage)
        for step in range(20):
            if adds and step == 10:
                add(stage, "/World/late", at=(0, 9, 0))
            engine.advance(STEP)
        session = engine._session
        assert session is not None
        world = session.current_world()
        row = world.body_index["/World/box"]
        ends.append(np.concatenate([world.poses()[row], world.velocities()[row]]))
        engine.stop()
    assert ends[0].tobytes() == ends[1].tobytes()

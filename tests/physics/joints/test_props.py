"""Articulated props and robots as Isaac Sim's assets have them: they stand in the pose in which they are authored."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.mechanisms import drive, joint, limit, rotation
from tests.physics.scenes import add, new_stage, playing, position

STEP = 1.0 / 60.0


def ground(stage) -> None:
    add(stage, "/World/ground", at=(0, 0, -0.5), scale=(5, 5, 0.5), body=False)


def box(stage, path: str, at, half, mass: float) -> str:
    UsdPhysics.MassAPI.Apply(add(stage, path, at=at, scale=half)).CreateMassAttr(mass)
    return path


def rub(made, name: str, effort: float) -> None:
    made.GetPrim().AddAppliedSchema(f"PhysxJointAxisAPI:{name}")
    attribute = f"physxJointAxis:{name}:staticFrictionEffort"
    made.GetPrim().CreateAttribute(attribute, Sdf.ValueTypeNames.Float).Set(effort)


def cupboard(stage) -> list[str]:
    """A cupboard that stands on the ground by itself, with three drawers on slides and two doors on two hinges each.

    Its walls are colliders of one body, as such assets have them; the parts have a clearance of 2 mm.
    """
    top = "/World/cupboard"
    xform = UsdGeom.Xform.Define(stage, top)
    xform.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0))
    prim = xform.GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(prim)
    UsdPhysics.ArticulationRootAPI.Apply(prim)
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(30.0)
    walls = {
        "left": ((0, -0.39, 0.5), (0.3, 0.01, 0.5)), "right": ((0, 0.39, 0.5), (0.3, 0.01, 0.5)),
        "back": ((-0.29, 0, 0.5), (0.01, 0.38, 0.5)), "bottom": ((0, 0, 0.01), (0.28, 0.38, 0.01)),
        "shelf": ((0, 0, 0.55), (0.28, 0.38, 0.01)), "lid": ((0, 0, 0.99), (0.3, 0.38, 0.01)),
    }  # fmt: skip
    for name, (at, half) in walls.items():
        add(stage, f"{top}/{name}", at=at, scale=half, body=False)
    found = [top]
    for number in range(3):
        z = 0.66 + 0.14 * number
        drawer = box(stage, f"/World/drawer_{number}", (0.01, 0, z), (0.28, 0.375, 0.06), 3.0)
        slide = joint(stage, f"/World/slide_{number}", UsdPhysics.PrismaticJoint, top, drawer, (0.01, 0, z))
        limit(slide, 0.0, 0.45)
        rub(slide, "linear", 5.0)
        found.append(drawer)
    for name, side in (("left", -1), ("right", 1)):
        door = box(stage, f"/World/door_{name}", (0.312, side * 0.196, 0.28), (0.01, 0.19, 0.24), 4.0)
        for place, z in (("low", 0.1), ("high", 0.46)):
            hinge = joint(
                stage, f"/World/hinge_{name}_{place}", UsdPhysics.RevoluteJoint, top, door,
                (0.312, side * 0.386, z), axis="Z",
            )  # fmt: skip
            limit(hinge, *((-100.0, 0.0) if side < 0 else (0.0, 100.0)))
        found.append(door)
    return found


def poses(stage, paths: list[str]) -> list[tuple[np.ndarray, np.ndarray]]:
    prims = [stage.GetPrimAtPath(path) for path in paths]
    return [(position(prim), rotation(prim)) for prim in prims]


def assert_stand(before, after) -> None:
    """Within 1 mm and 0.5 degrees."""
    for (at, turned), (now, turned_now) in zip(before, after):
        assert np.linalg.norm(now - at) < 1e-3
        assert np.degrees(np.arccos(np.clip((np.trace(turned_now @ turned.T) - 1) / 2, -1, 1))) < 0.5


def test_a_cupboard_with_drawers_and_doors_stands_for_ten_seconds(recwarn):
    stage = new_stage()
    ground(stage)
    paths = cupboard(stage)
    before = poses(stage, paths)
    engine = playing(stage)
    for _ in range(600):
        engine.step(STEP)
    assert_stand(before, poses(stage, paths))
    assert not recwarn


def test_a_drawer_of_it_opens_under_more_than_its_friction():
    stage = new_stage()
    ground(stage)
    cupboard(stage)
    engine = playing(stage)
    found = []
    for _ in range(60):
        engine.apply_joint_efforts(["/World/slide_0", "/World/slide_1"], [4.0, 8.0])
        engine.step(STEP)
        found.append(engine.joint_positions(["/World/slide_0", "/World/slide_1"]))
    # Until the end of the slide shakes the cupboard, 3 N on 3 kg move it by half of the time squared.
    assert found[47] == pytest.approx([0.0, 0.5 * 0.8**2], abs=5e-3)
    assert found[59][1] == pytest.approx(0.45, abs=2e-3)


# Franka's panda: frames of its links from link to link (x, y, z and rotation about x), mass of each link.
LINKS = (
    ((0, 0, 0.333), 0, 4.97), ((0, 0, 0), -90, 0.65), ((0, -0.316, 0), 90, 3.23), ((0.0825, 0, 0), 90, 3.59),
    ((-0.0825, 0.384, 0), -90, 1.23), ((0, 0, 0), 90, 1.67), ((0.088, 0, 0), 90, 0.74),
)  # fmt: skip
READY = (0.0, -45.0, 0.0, -135.0, 0.0, 90.0, 45.0)
LIMITS = ((-166, 166), (-101, 101), (-166, 166), (-176, -4), (-166, 166), (-1, 215), (-166, 166))


def panda(stage) -> tuple[list[str], list[str]]:
    """An arm with the kinematics, masses, limits and drives of the asset, in its ready pose, with two fingers."""
    base = box(stage, "/World/base", (0, 0, 0.07), (0.1, 0.07, 0.07), 3.0)
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(base))
    stage.GetPrimAtPath(base).CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(
        False
    )
    joint(stage, "/World/root", UsdPhysics.FixedJoint, "", base, (0, 0, 0))
    bodies, joints = [base], []
    # Row-vector matrices: of the link's frame in the world with the joint at zero, then at its angle.
    frame, parent_at = Gf.Matrix4d(1), Gf.Matrix4d(1)
    for number, ((x, y, z), turn, mass) in enumerate(LINKS):
        offset = Gf.Matrix4d().SetRotate(Gf.Rotation((1, 0, 0), turn))
        offset.SetTranslateOnly((x, y, z))
        origin = offset * frame
        frame = Gf.Matrix4d().SetRotate(Gf.Rotation((0, 0, 1), READY[number])) * origin
        path = link(stage, f"/World/link_{number}", frame, (0, 0, -0.05), (0.05, 0.05, 0.08), mass)
        made = frame_joint(
            stage, f"/World/joint_{number}", UsdPhysics.RevoluteJoint, bodies[-1], path, parent_at, origin
        )
        limit(made, *LIMITS[number])
        strong = number < 4
        drive(made, "angular", stiffness=400.0, damping=80.0, target=READY[number], max_force=87.0 if strong else 12.0)
        bodies.append(path)
        joints.append(f"/World/joint_{number}")
        parent_at = frame
    hand = Gf.Matrix4d().SetRotate(Gf.Rotation((0, 0, 1), -45))
    hand.SetTranslateOnly((0, 0, 0.107))
    hand = hand * frame
    path = link(stage, "/World/hand", hand, (0, 0, 0.03), (0.03, 0.1, 0.03), 0.73)
    frame_joint(stage, "/World/hand_joint", UsdPhysics.FixedJoint, bodies[-1], path, parent_at, hand)
    bodies.append(path)
    for name, side in (("left", 1), ("right", -1)):
        origin = Gf.Matrix4d().SetTranslate((0, 0, 0.0584)) * hand
        at = Gf.Matrix4d().SetTranslate((0, side * 0.02, 0)) * origin
        finger = link(stage, f"/World/finger_{name}", at, (0, side * 0.008, 0.03), (0.01, 0.006, 0.025), 0.1)
        made = frame_joint(
            stage, f"/World/finger_joint_{name}", UsdPhysics.PrismaticJoint, path, finger, hand, origin, axis="Y"
        )
        limit(made, *((0.0, 0.04) if side > 0 else (-0.04, 0.0)))
        drive(made, "linear", stiffness=6000.0, damping=1000.0, target=side * 0.02, max_force=180.0)
        bodies.append(finger)
    return bodies, joints


def link(stage, path: str, frame: Gf.Matrix4d, center, half, mass: float) -> str:
    """A body at a frame, with a box of its own around a center."""
    xform = UsdGeom.Xform.Define(stage, path)
    xform.AddTransformOp().Set(frame)
    UsdPhysics.RigidBodyAPI.Apply(xform.GetPrim())
    UsdPhysics.MassAPI.Apply(xform.GetPrim()).CreateMassAttr(mass)
    add(stage, f"{path}/shape", at=center, scale=half, body=False)
    return path


def frame_joint(stage, path: str, kind: type, body0: str, body1: str, at0, origin, *, axis: str = "Z"):
    """A joint whose frame is at `origin` in body 0, which is at `at0` in the world, and at the frame of body 1."""
    made = kind.Define(stage, path)
    made.CreateBody0Rel().SetTargets([Sdf.Path(body0)])
    made.CreateBody1Rel().SetTargets([Sdf.Path(body1)])
    if body0 == "/World/base":
        at0 = Gf.Matrix4d().SetTranslate((0, 0, 0.07))
    local = origin * at0.GetInverse()
    scale = (0.1, 0.07, 0.07) if body0 == "/World/base" else (1, 1, 1)
    made.CreateLocalPos0Attr(Gf.Vec3f(*(c / s for c, s in zip(local.ExtractTranslation(), scale))))
    made.CreateLocalRot0Attr(Gf.Quatf(local.ExtractRotationQuat()))
    if kind is not UsdPhysics.FixedJoint:
        made.CreateAxisAttr(axis)
    return made


def test_a_panda_stands_in_its_ready_pose_for_ten_seconds(recwarn):
    stage = new_stage()
    ground(stage)
    paths, joints = panda(stage)
    before = poses(stage, paths)
    engine = playing(stage)
    assert np.degrees(engine.joint_positions(joints)) == pytest.approx(np.array(READY), abs=1e-3)
    for _ in range(600):
        engine.step(STEP)
    assert_stand(before, poses(stage, paths))
    # 400 N m per degree carry at most 40 N m with 0.1 degrees.
    assert np.degrees(engine.joint_positions(joints)) == pytest.approx(np.array(READY), abs=0.15)
    assert not recwarn

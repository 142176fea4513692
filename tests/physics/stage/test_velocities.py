"""Velocities that steps do not write to the stage: the same motion, read from the simulation."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.physics.scenes import DEVICE, add, collide, new_stage, physics_material, position, set_value, velocity
from usdsdg.errors import PhysicsError
from usdsdg_physics import NewtonEngine

STEP = 1 / 60


def _play(stage: Usd.Stage, *, written: bool) -> NewtonEngine:
    engine = NewtonEngine(stage, device=DEVICE, writes_velocities=lambda: written)
    engine.play()
    return engine


def _thrown() -> tuple[Usd.Stage, Usd.Prim]:
    """A box that flies and spins, and one that stays where it is."""
    stage = new_stage(meters_per_unit=0.01)
    prim = add(stage, "/World/box", at=(0, 0, 500), scale=(10, 10, 10))
    set_value(prim, "physics:velocity", Gf.Vec3f(100, 0, 50))
    set_value(prim, "physics:angularVelocity", Gf.Vec3f(0, 90, 180))
    still = add(stage, "/World/still", at=(500, 0, 0), scale=(10, 10, 10), gravity=False)
    UsdPhysics.MassAPI.Apply(still).CreateMassAttr(1.0)
    return stage, prim


def _both(edit, steps: int = 12) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The matrix, the position and the velocities of the thrown box, when an edit was made half way, both ways."""
    found = []
    for written in (True, False):
        stage, prim = _thrown()
        engine = _play(stage, written=written)
        engine.advance(steps / 2 * STEP)
        edit(stage, prim)
        engine.advance(steps / 2 * STEP)
        matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
        found.append((matrix, position(prim), engine.velocities(["/World/box"])[0]))
        if written:
            angular = np.radians(prim.GetAttribute("physics:angularVelocity").Get())
            assert found[0][2] == pytest.approx([*velocity(prim), *angular], rel=1e-5, abs=1e-4)
    return found


def _set_mass(stage: Usd.Stage, prim: Usd.Prim) -> None:
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(3.0)


def _add_collider(stage: Usd.Stage, prim: Usd.Prim) -> None:
    child = UsdGeom.Sphere.Define(stage, "/World/box/part").GetPrim()
    collide(child)


def _add_body(stage: Usd.Stage, prim: Usd.Prim) -> None:
    add(stage, "/World/other", at=(0, 900, 0), scale=(10, 10, 10))


def _add_body_and_set_mass(stage: Usd.Stage, prim: Usd.Prim) -> None:
    _add_body(stage, prim)
    set_value(stage.GetPrimAtPath("/World/still"), "physxRigidBody:disableGravity", True)
    UsdPhysics.MassAPI(stage.GetPrimAtPath("/World/still")).GetMassAttr().Set(2.0)


@pytest.mark.parametrize(
    "edit",
    [
        lambda stage, prim: None,
        lambda stage, prim: set_value(prim, "physics:velocity", Gf.Vec3f(0, 70, 0)),
        lambda stage, prim: set_value(prim, "physics:angularVelocity", Gf.Vec3f(0, 70, 0)),
        lambda stage, prim: set_value(prim, "xformOp:translate", Gf.Vec3d(0, 0, 900)),
        _set_mass,
        _add_collider,
        _add_body,
        _add_body_and_set_mass,
        lambda stage, prim: physics_material(stage, "/World/material"),
        lambda stage, prim: set_value(prim, "physxRigidBody:angularDamping", 0.5),
    ],
    ids=["nothing", "linear", "angular", "pose", "mass", "collider", "body", "body and mass", "material", "damping"],
)
def test_motion_is_the_same_whether_velocities_are_written_or_not(edit):
    (matrix, place, moving), (other_matrix, other_place, other_moving) = _both(edit)
    assert other_matrix == pytest.approx(matrix, abs=2e-4)
    assert other_place == pytest.approx(place, abs=2e-3)
    assert other_moving == pytest.approx(moving, rel=1e-4, abs=1e-3)
    assert np.abs(moving[3:]).max() > 0.5  # it still spins


def test_a_velocity_and_a_mass_that_are_set_together():
    """What is set counts, what is not goes on, when the world has to be built again."""

    def edit(stage: Usd.Stage, prim: Usd.Prim) -> None:
        set_value(prim, "physics:velocity", Gf.Vec3f(0, 70, 0))
        _set_mass(stage, prim)

    (matrix, _, moving), (other_matrix, _, other_moving) = _both(edit)
    assert other_matrix == pytest.approx(matrix, abs=2e-4)
    assert other_moving == pytest.approx(moving, rel=1e-4, abs=1e-3)
    assert moving[1] == pytest.approx(70.0, rel=1e-4)


def test_a_kinematic_body_that_becomes_dynamic_begins_with_the_velocity_on_the_stage():
    stage, prim = _thrown()
    UsdPhysics.RigidBodyAPI(prim).CreateKinematicEnabledAttr(True)
    engine = _play(stage, written=False)
    engine.advance(3 * STEP)
    UsdPhysics.RigidBodyAPI(prim).GetKinematicEnabledAttr().Set(False)
    engine.advance(STEP)
    assert engine.velocities(["/World/box"])[0, :3] == pytest.approx([100, 0, 50 - 981 * STEP], rel=1e-3, abs=1e-3)


def test_nothing_of_the_simulation_is_on_the_stage_but_poses():
    stage, prim = _thrown()
    authored = stage.GetRootLayer().ExportToString()
    engine = _play(stage, written=False)
    engine.advance(6 * STEP)
    assert velocity(prim).tolist() == [100, 0, 50]
    assert engine.velocities(["/World/box"])[0, :3] == pytest.approx([100, 0, 50 - 981 * 0.1], rel=1e-3, abs=1e-3)
    set_value(prim, "physics:velocity", Gf.Vec3f(1, 2, 3))
    engine.advance(STEP)
    engine.stop()
    assert stage.GetRootLayer().ExportToString() == authored


def test_velocities_of_instances_are_left_alone_too():
    stage = new_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    add(stage, "/World/many/prototypes/box", scale=(0.1, 0.1, 0.1))
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path("/World/many/prototypes/box")])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([(0, 0, 5), (3, 0, 5)])
    instancer.CreateVelocitiesAttr([(1, 0, 0), (0, 1, 0)])
    engine = _play(stage, written=False)
    engine.advance(3 * STEP)
    assert [tuple(each) for each in instancer.GetVelocitiesAttr().Get()] == [(1, 0, 0), (0, 1, 0)]
    assert instancer.GetPositionsAttr().Get()[0][0] == pytest.approx(3 * STEP, rel=1e-4)


def test_a_path_that_is_no_body_is_an_error():
    stage, _ = _thrown()
    with pytest.raises(PhysicsError, match="/World/none is not a simulated rigid body"):
        _play(stage, written=False).velocities(["/World/none"])

"""Pushes of single bodies by `omni.physx`: momentum is force · time, and a push off the center turns."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from usdsdg.app.app import get_app
from usdsdg.compat import carb
from usdsdg.compat import physics_schema_tools as PhysicsSchemaTools
from usdsdg.compat.omni.physx import get_physx_interface, get_physx_simulation_interface
from usdsdg.errors import ArgumentError, PhysicsError
from usdsdg.session import body_velocities, engines
from usdsdg.session.timeline import get_timeline

BOX, DT = "/World/box", 1 / 60


@pytest.fixture
def box(stage):
    """A cube of 1 m and 2 kg without gravity, whose inertia is 2/6 kg m²."""
    UsdPhysics.Scene.Define(stage, "/scene").CreateGravityMagnitudeAttr(0.0)
    cube = UsdGeom.Cube.Define(stage, BOX)
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    UsdPhysics.MassAPI.Apply(cube.GetPrim()).CreateMassAttr(2.0)
    get_timeline().play()
    get_app().update()
    return cube.GetPrim()


def velocities(prim):
    linear, angular = body_velocities.velocities([prim])
    return linear[0], angular[0]


def test_a_force_at_a_position_pushes_and_turns(box):
    body = PhysicsSchemaTools.sdfPathToInt(box.GetPath())
    simulation = get_physx_simulation_interface()
    simulation.apply_force_at_pos(0, body, carb.Float3(6, 0, 0), carb.Float3(1, 2.5, 3))
    get_app().update()
    linear, angular = velocities(box)
    assert linear == pytest.approx([6 / 2 * DT, 0, 0], rel=1e-3)
    assert angular == pytest.approx([0, 0, -6 * 0.5 / (2 / 6) * DT], rel=1e-2)
    get_app().update()  # it acted for one step
    assert velocities(box)[0] == pytest.approx(linear, rel=1e-3)


def test_an_impulse_is_what_it_changes_the_momentum_by(box):
    get_physx_interface().apply_force_at_pos(BOX, Gf.Vec3f(0, 3, 0), Gf.Vec3f(1, 2, 3), "Impulse")
    get_app().update()
    assert velocities(box)[0] == pytest.approx([0, 1.5, 0], rel=1e-3)


def test_a_torque_turns(box):
    body = PhysicsSchemaTools.sdfPathToInt(box.GetPath())
    get_physx_simulation_interface().apply_torque(0, body, (0, 0, 2))
    get_app().update()
    linear, angular = velocities(box)
    assert linear == pytest.approx(np.zeros(3), abs=1e-6)
    assert angular == pytest.approx([0, 0, 2 / (2 / 6) * DT], rel=1e-2)


def test_other_modes_and_bodies_are_refused(box):
    with pytest.raises(ArgumentError, match="'Force' or an 'Impulse', not 'Acceleration'"):
        get_physx_interface().apply_force_at_pos(BOX, (1, 0, 0), (0, 0, 0), "Acceleration")
    with pytest.raises(PhysicsError, match="/World/none"):
        get_physx_interface().apply_force_at_pos("/World/none", (1, 0, 0), (0, 0, 0))


def test_a_body_sleeps_and_wakes(box):
    body = PhysicsSchemaTools.sdfPathToInt(box.GetPath())
    simulation = get_physx_simulation_interface()
    UsdPhysics.RigidBodyAPI(box).GetVelocityAttr().Set(Gf.Vec3f(1, 0, 0))
    get_app().update()
    simulation.put_to_sleep(0, body)
    assert velocities(box)[0] == pytest.approx(np.zeros(3))
    simulation.wake_up(0, body)


def test_where_a_body_is(box):
    found = get_physx_interface().get_rigidbody_transformation(BOX)
    assert found["ret_val"]
    assert tuple(found["position"]) == pytest.approx((1, 2, 3))
    assert tuple(found["rotation"]) == pytest.approx((0, 0, 0, 1))
    assert get_physx_interface().get_rigidbody_transformation("/World/none") == {"ret_val": False}


def test_a_stage_is_attached_and_detached(box):
    get_timeline().stop()
    simulation = get_physx_simulation_interface()
    assert simulation.attach_stage(simulation.get_attached_stage())
    simulation.simulate(DT, 0.0)
    simulation.detach_stage()
    assert not engines.physics().is_playing

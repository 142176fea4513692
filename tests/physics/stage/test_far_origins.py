"""Bodies collide where their shapes are, however far off their origins, as of assets modeled in place in a room."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, playing, position, set_value
from tests.sampled_cases import crossed

HALF = 0.1


def _body(stage, path, at, origin, kind="Cube", *, half=HALF, velocity=(0, 0, 0), spin=(0, 0, 0), gravity=True):
    """A shape in the world at a point, below a body whose origin is elsewhere; return the shape."""
    body = UsdGeom.Xform.Define(stage, path)
    body.AddTranslateOp().Set(Gf.Vec3d(*map(float, origin)))
    make_body(body.GetPrim(), gravity=gravity)
    api = UsdPhysics.RigidBodyAPI(body)
    api.CreateVelocityAttr(Gf.Vec3f(*velocity))
    api.CreateAngularVelocityAttr(Gf.Vec3f(*spin))
    return add(stage, f"{path}/shape", kind, at=np.subtract(at, origin), scale=(half,) * 3, body=False)


@pytest.mark.parametrize(
    ("origin", "put_while_playing"), crossed([(0.2, 0, 0), (0.2, 0, -3), (4, 0, 0.5)], [False, True])
)
def test_what_lies_on_a_table_stays_there_wherever_its_origin_is(origin, put_while_playing):
    stage = new_stage()
    add(stage, "/World/table", at=(0, 0, 0.5), scale=(1, 1, 0.25), body=False)
    shape = _body(stage, "/World/cup", (0.2, 0, 0.75 + HALF), origin)
    engine = playing(stage)
    if put_while_playing:
        set_value(shape.GetParent(), "xformOp:translate", Gf.Vec3d(*np.add(origin, (0, 0, 2))))
        engine.advance(0.1)
        set_value(shape.GetParent(), "xformOp:translate", Gf.Vec3d(*origin))
        set_value(shape.GetParent(), "physics:velocity", Gf.Vec3f(0))
    engine.advance(1.0)
    assert position(shape) == pytest.approx([0.2, 0, 0.75 + HALF], abs=1e-3)


@pytest.mark.parametrize("origin", [(0, 0, 0.03), (0, 0, -3), (4, 0, -3)])
def test_what_begins_across_a_thin_floor_comes_out_on_the_side_of_its_middle(origin):
    stage = new_stage()
    add(stage, "/World/floor", at=(0, 0, -0.01), scale=(3, 3, 0.01), body=False)
    shape = _body(stage, "/World/box", (0, 0, 0.03), origin)
    playing(stage).advance(1.0)
    assert position(shape)[2] == pytest.approx(HALF, abs=1e-3)


@pytest.mark.parametrize(("radius", "speed", "off"), [(0.02, 10.0, 3.0), (0.1, 45.0, 3.0), (0.1, 45.0, 0.0)])
def test_fast_balls_do_not_fall_through_a_mesh(radius, speed, off):
    stage = new_stage()
    corners = np.array([[x, y, 0] for x in (-8, 8) for y in (-8, 8)], float)
    collide(mesh(stage, "/World/ground", corners, np.array([(0, 2, 1), (1, 2, 3)])).GetPrim(), approximation="none")
    balls = []
    for number in range(12):  # which arrive at another time of a step each
        at = np.array([number - 6, 0.3, 1.5 + number / 12 * speed / 60])
        origin, path = np.add(at, (0, 0, off)), f"/World/ball{number}"
        balls.append(_body(stage, path, at, origin, "Sphere", half=radius, velocity=(0, 0, -speed)))
    playing(stage).advance(1.0)
    assert [position(ball)[2] for ball in balls] == pytest.approx(np.full(12, radius), abs=1e-3)


@pytest.mark.parametrize("spin", [10, -10])
def test_a_body_that_turns_slowly_beside_a_sleeping_one_does_not_wake_it(spin):
    stage = new_stage()
    add(stage, "/World/sleeper", gravity=False)
    beside = (2 * HALF + 0.015, 0, 0)
    # About its center of mass, at 10 degrees a second, no point of it moves a millimeter toward the other in a step.
    _body(stage, "/World/turning", beside, (0, 20, 0), spin=(0, 0, spin), gravity=False)
    engine = playing(stage)
    engine.put_to_sleep(["/World/sleeper"])
    engine.advance(0.1)
    assert engine._session.world.asleep() == ["/World/sleeper"]

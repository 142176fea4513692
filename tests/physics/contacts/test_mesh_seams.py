"""Round things roll over the seams of triangles as over one face, and still meet what stands above a mesh."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics, UsdShade

from tests.physics.scenes import add, collide, mesh, new_stage, physics_material, playing, position, velocity
from tests.sampled_cases import crossed

RADIUS, SPEED = 0.05, 1.0


def strips(stage, count, *, height=lambda x: 0.0 * x):
    """A floor of 7 by 2 m in strips of two triangles."""
    side = np.linspace(-1, 6, count + 1)
    points = np.array([(x, y, height(x)) for x in side for y in (-1, 1)])
    triangles = [t for a in range(0, 2 * count, 2) for t in ((a, a + 2, a + 1), (a + 1, a + 2, a + 3))]
    floor = mesh(stage, "/World/floor", points, np.array(triangles)).GetPrim()
    collide(floor, approximation="none")
    return floor


def roll(stage, kind, *, turned=None):
    material = physics_material(stage, "/World/rubber", friction=0.8)
    scale = 2 * RADIUS if kind == "Capsule" else RADIUS  # of a radius of 0.5 or 1
    ball = add(stage, "/World/ball", kind, at=(0, 0.1, RADIUS), scale=(scale,) * 3, rotate=turned, material=material)
    UsdPhysics.RigidBodyAPI(ball).CreateVelocityAttr(Gf.Vec3f(SPEED, 0, 0))
    spin = Gf.Vec3f(0, float(np.degrees(SPEED / RADIUS)), 0)
    UsdPhysics.RigidBodyAPI(ball).CreateAngularVelocityAttr(spin)
    return ball


@pytest.mark.parametrize(("kind", "strip_count"), crossed(["Sphere", "Capsule"], [1, 70]))
def test_a_ball_rolls_on_over_the_seams_of_a_flat_mesh(kind, strip_count):
    """It lost 71 % of its speed over 70 strips, since the edge of the next triangle was in its way."""
    stage = new_stage()
    strips(stage, strip_count)
    ball = roll(stage, kind, turned=(90, 0, 0) if kind == "Capsule" else None)
    playing(stage).advance(4.0)
    assert velocity(ball) == pytest.approx([SPEED, 0, 0], abs=0.02)
    assert position(ball) == pytest.approx([4 * SPEED, 0.1, RADIUS], abs=0.05)


@pytest.mark.parametrize("strip_count", [1, 7, 70])
@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_cylinder_rolls_on_over_the_seams_of_a_flat_mesh(strip_count, slip):
    """It hopped at the diagonals and was turned aside: what was ahead of where it touched held it up as it came down.

    One that slides at first rolls as one on a single face: with I = m r² / 2, two thirds of its speed are left.
    """
    radius, speed = 0.1, 3.0
    stage = new_stage()
    material = physics_material(stage, "/World/rubber", friction=0.3)
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World")).Bind(material, materialPurpose="physics")
    strips(stage, strip_count)
    roller = add(stage, "/World/roller", "Cylinder", at=(-0.5, 0.1, radius), rotate=(90, 0, 0), scale=(radius,) * 3)
    UsdPhysics.RigidBodyAPI(roller).CreateVelocityAttr(Gf.Vec3f(speed, 0, 0))
    spin = np.degrees((1.0 - slip) * speed / radius)
    UsdPhysics.RigidBodyAPI(roller).CreateAngularVelocityAttr(Gf.Vec3f(0, float(spin), 0))
    engine, left = playing(stage), speed * (1.0 - slip / 3.0)
    heights = []
    for _ in range(100):
        engine.step(1 / 60)
        heights.append(position(roller)[2])
    assert max(heights) < radius + 2e-4
    assert velocity(roller) == pytest.approx([left, 0, 0], abs=0.04 * speed)


def test_a_cone_rolls_on_a_flat_mesh_as_on_a_box():
    """It rolls about its apex, all the time over other seams. Within 5 % of the speed: it hops at none, but brakes."""
    ends = []
    for kind in ("box", "mesh"):
        stage = new_stage()
        material = physics_material(stage, "/World/rubber", friction=0.8)
        UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World")).Bind(material, materialPurpose="physics")
        if kind == "box":
            add(stage, "/World/floor", at=(2.5, 0, -1), scale=(3.5, 1, 1), body=False)
        else:
            strips(stage, 70)
        cone = add(stage, "/World/cone", "Cone", at=(2, 0, 0.0475), rotate=(108.435, 0, 0), scale=(0.1, 0.1, 0.15))
        engine = playing(stage)
        engine.advance(0.5)
        cone.GetAttribute("physics:velocity").Set(Gf.Vec3f(1, 0, 0))
        engine.advance(1.0)
        ends.append(velocity(cone))
    assert np.linalg.norm(ends[0]) > 0.4
    assert ends[1] == pytest.approx(ends[0], abs=0.05 * float(np.linalg.norm(ends[0])))


def test_a_cylinder_stops_at_a_curb_of_a_mesh():
    """The curb is higher than its axis, and stands on seams."""
    stage = new_stage()
    strips(stage, 70, height=lambda x: np.where(x > 2.01, 0.3, 0.0))
    roller = add(stage, "/World/roller", "Cylinder", at=(0, 0.1, 0.1), rotate=(90, 0, 0), scale=(0.1,) * 3)
    UsdPhysics.RigidBodyAPI(roller).CreateVelocityAttr(Gf.Vec3f(1, 0, 0))
    UsdPhysics.RigidBodyAPI(roller).CreateAngularVelocityAttr(Gf.Vec3f(0, float(np.degrees(10.0)), 0))
    engine = playing(stage)
    for _ in range(180):
        engine.step(1 / 60)
        assert position(roller)[0] < 2.0
        assert position(roller)[2] > 0.0995


def test_a_ball_rolls_over_a_mesh_that_is_moved_and_scaled():
    stage = new_stage()
    floor = UsdGeom.Xformable(strips(stage, 70).GetPrim())
    floor.AddTranslateOp().Set(Gf.Vec3d(0, 0.3, 0))
    floor.AddScaleOp().Set(Gf.Vec3f(2.0, 2.0, 2.0))
    ball = roll(stage, "Sphere")
    playing(stage).advance(4.0)
    assert velocity(ball) == pytest.approx([SPEED, 0, 0], abs=0.02)


def test_a_ball_stops_at_a_wall_and_on_a_ridge_of_a_mesh():
    stage = new_stage()
    strips(stage, 70, height=lambda x: np.where(np.abs(x - 2.0) < 0.04, 0.06, 0.0))
    ball = roll(stage, "Sphere")
    playing(stage).advance(3.0)
    assert position(ball)[0] < 2.0  # the ridge is higher than its center
    stage = new_stage()
    strips(stage, 70, height=lambda x: -0.2 * np.abs(x - 2.0))
    ball = add(stage, "/World/ball", "Sphere", at=(2.3, 0.1, 0.1), scale=(RADIUS,) * 3)
    playing(stage).advance(0.5)
    # On the falling side it rests along the normal of that.
    x, _, z = position(ball)
    assert (z + 0.2 * (x - 2.0)) / np.hypot(1.0, 0.2) == pytest.approx(RADIUS, abs=1e-3)

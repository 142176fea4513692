"""Bodies slide and roll over tiles that lie level as over one floor, and still meet what stands out of it."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdPhysics, UsdShade

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, physics_material, playing, position, velocity
from tests.sampled_cases import crossed

HALF, SPEED, STEPS = 0.1, 2.0, 90
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
SIDES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
SIDES += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


def tile(stage, path, low, high, *, top=0.0, kind="box"):
    """A part of a floor, 2 m wide, that ends at `top`."""
    center, half = np.array([(low + high) / 2, 0, top - 0.1]), np.array([(high - low) / 2, 1.0, 0.1])
    if kind in ("box", "kinematic"):
        prim = add(stage, path, at=center.tolist(), scale=half.tolist(), body=False)
        if kind == "kinematic":
            UsdPhysics.RigidBodyAPI.Apply(prim).CreateKinematicEnabledAttr(True)
        return prim
    made = mesh(stage, path, center + CORNERS * half, np.array(SIDES)).GetPrim()
    collide(made, approximation=kind)
    return made


def slide(stage, shape, *, at=(-0.2, 0.0, HALF), speed=SPEED):
    prim = add(stage, "/World/thing", shape, at=at, scale=(HALF,) * 3)
    UsdPhysics.RigidBodyAPI(prim).CreateVelocityAttr(Gf.Vec3f(speed, 0, 0))
    engine = playing(stage)
    for _ in range(STEPS):
        engine.step(1 / 60)
    return position(prim)


@pytest.mark.parametrize(
    ("kind", "shape"), crossed(["box", "kinematic", "convexHull", "none"], ["Cube", "Sphere", "Cylinder"])
)
def test_tiles_are_as_one_floor(shape, kind):
    """What slides went no farther than the first seam."""
    whole = new_stage()
    tile(whole, "/World/floor", -0.5, 3.5)
    tiled = new_stage()
    for number in range(8):
        tile(tiled, f"/World/tile_{number}", -0.5 + number / 2, number / 2, kind=kind)
    expected = slide(whole, shape)
    if shape != "Sphere":  # v² / 2 μ g, that of a step more or less
        assert expected[0] + 0.2 == pytest.approx(SPEED**2 / (2 * 0.5 * 9.81), abs=SPEED / 60)
    assert slide(tiled, shape) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize(("tilt", "origin"), crossed([2, 8], [1.0, 0.0, -1.0]))
def test_a_tilted_mesh_slides_on_over_strips_wherever_its_origin_is(origin, tilt):
    """It lands on an edge, and stopped at the first seam where its origin was at its bottom or farther below."""
    stage, friction, speed, seconds = new_stage(), 0.05, 4.0, 1.0
    material = physics_material(stage, "/World/ice", friction=friction)
    side = np.linspace(-1, 8, 60)
    points = np.array([(x, y, 0.0) for x in side for y in (-3, 3)])
    triangles = [t for a in range(0, 118, 2) for t in ((a, a + 2, a + 1), (a + 1, a + 2, a + 3))]
    floor = mesh(stage, "/World/floor", points, np.array(triangles)).GetPrim()
    collide(floor, approximation="none")
    sine, cosine = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    corners = CORNERS * (HALF, 0.8 * HALF, HALF / 2) @ np.array([(cosine, 0, sine), (0, 1, 0), (-sine, 0, cosine)])
    corners[:, 2] -= corners[:, 2].min()
    thing = mesh(stage, "/World/thing", corners - (0, 0, origin), np.array(SIDES))
    thing.AddTranslateOp().Set(Gf.Vec3d(0, 0.03, origin))
    collide(thing.GetPrim())
    make_body(thing.GetPrim())
    for prim in (floor, thing.GetPrim()):
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
    UsdPhysics.RigidBodyAPI(thing).CreateVelocityAttr(Gf.Vec3f(speed, 0, 0))
    engine = playing(stage)
    for _ in range(60):
        engine.step(seconds / 60)
    # It loses some of its speed where it lands.
    assert 0.9 < position(thing.GetPrim())[0] / (speed * seconds - friction * 9.81 * seconds**2 / 2) < 1.01


@pytest.mark.parametrize("shape", ["Cube", "Cylinder"])
def test_a_mesh_of_strips_is_as_one_face(shape):
    stage = new_stage()
    side = np.linspace(-1, 6, 71)
    points = np.array([(x, y, 0.0) for x in side for y in (-1, 1)])
    triangles = [t for a in range(0, 140, 2) for t in ((a, a + 2, a + 1), (a + 1, a + 2, a + 3))]
    collide(mesh(stage, "/World/floor", points, np.array(triangles)).GetPrim(), approximation="none")
    x, y, z = slide(stage, shape)
    assert x + 0.2 == pytest.approx(SPEED**2 / (2 * 0.5 * 9.81), abs=SPEED / 60)
    assert (y, z) == pytest.approx((0.0, HALF), abs=1e-3)


@pytest.mark.parametrize(("kind", "height"), crossed(["box", "convexHull", "none"], [0.002, 0.3]))
def test_what_stands_out_of_the_floor_stops(kind, height):
    """A step, which continues no floor, and a wall on the floor, whose foot lies in the floor's face."""
    stage = new_stage()
    tile(stage, "/World/floor", -0.5, 0.0, kind=kind)
    tile(stage, "/World/step", 0.0, 2.0, top=height, kind=kind)
    assert slide(stage, "Cube")[0] == pytest.approx(-HALF, abs=0.01)
    stage = new_stage()
    tile(stage, "/World/floor", -0.5, 3.5, kind=kind)
    tile(stage, "/World/wall", 0.1, 0.3, top=0.2, kind=kind)
    assert slide(stage, "Cube", speed=4.0)[0] == pytest.approx(0.0, abs=0.01)


def test_a_wall_and_the_floor_are_one_mesh():
    stage = new_stage()
    points = np.array([(-1, -1, 0), (0.3, -1, 0), (0.3, -1, 1), (-1, 1, 0), (0.3, 1, 0), (0.3, 1, 1)], float)
    triangles = np.array([(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)])
    collide(mesh(stage, "/World/room", points, triangles).GetPrim(), approximation="none")
    x, _, z = slide(stage, "Cube", speed=4.0)
    assert (x, z) == pytest.approx((0.2, HALF), abs=0.01)


def test_belts_pass_things_on_to_each_other():
    """The second one is twice as fast."""
    stage = new_stage()
    for number, speed in enumerate((0.5, 1.0)):
        belt = tile(stage, f"/World/belt_{number}", 2 * number - 1, 2 * number + 1, kind="kinematic")
        belt.AddAppliedSchema("PhysxSurfaceVelocityAPI")
        name = "physxSurfaceVelocity:surfaceVelocity"
        belt.CreateAttribute(name, Sdf.ValueTypeNames.Vector3f).Set(Gf.Vec3f(speed, 0, 0))
    box = add(stage, "/World/box", at=(-0.5, 0, HALF), scale=(HALF,) * 3)
    engine = playing(stage)
    for _ in range(60 * 4):
        engine.step(1 / 60)
    assert velocity(box) == pytest.approx([1.0, 0, 0], abs=0.02)
    assert position(box)[0] > 1.2

"""What hits an edge or a post with its end alone turns about that; what falls on a floor lies down.

The oracle is the impulse of an impact without restitution: it stops the point that is hit, at the distance a from the
center of mass, J = m v / (1 + m a² / I), and leaves v - J / m and J a / I.
"""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics, UsdShade

from tests.physics.scenes import add, collide, mesh, new_stage, physics_material, playing, set_value, velocity

LENGTH, THICKNESS, G = 1.0, 0.04, 9.81
INERTIA = (LENGTH**2 + THICKNESS**2) / 12  # of a kilogram


def _after_impact(speed: float, arm: float) -> tuple[float, float]:
    """The speed that is left, and the spin [rad/s]."""
    impulse = speed / (1 + arm**2 / INERTIA)
    return speed - impulse, impulse * arm / INERTIA


def _rod(stage, at, *, along: int = 0, **options):
    scale = np.full(3, THICKNESS / 2)
    scale[along] = LENGTH / 2
    rod = add(stage, "/World/rod", at=at, scale=tuple(scale.tolist()), **options)
    UsdPhysics.MassAPI.Apply(rod).CreateMassAttr(1.0)
    return rod


def _spin(prim) -> np.ndarray:
    return np.radians(np.array(prim.GetAttribute("physics:angularVelocity").Get()))


def _step_until_hit(engine, rod, speed_limit: float = 0.5) -> float:
    """Step until the rod turns; return the seconds of this."""
    for step in range(1, 600):
        engine.step(1 / 240)
        if np.linalg.norm(_spin(rod)) > speed_limit:
            return step / 240
    raise AssertionError("nothing turned the rod")


def _table(stage, kind: str) -> None:
    """A table of 2 m, 1 m and 1 m whose top is at z = 0 and that ends at x = 0."""
    if kind == "box":
        add(stage, "/World/table", at=(-1, 0, -0.5), scale=(1, 1, 0.5), body=False)
        return
    if kind == "kinematic":
        table = add(stage, "/World/table", at=(-1, 0, -0.5), scale=(1, 1, 0.5))
        UsdPhysics.RigidBodyAPI(table).CreateKinematicEnabledAttr(True)
        return
    corners = np.array([(x, y, z) for x in (-2.0, 0.0) for y in (-1.0, 1.0) for z in (-1.0, 0.0)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([(q[0], q[i], q[i + 1]) for q in faces for i in (1, 2)])
    prim = mesh(stage, "/World/table", corners, triangles).GetPrim()
    UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(1, 2, 1))
    collide(prim, approximation="convexHull" if kind == "hull" else "none")


@pytest.mark.parametrize("kind", ["box", "kinematic", "hull", "mesh"])
@pytest.mark.parametrize("overhang", [0.1, 0.3])
def test_a_rod_that_hits_the_edge_of_a_table_goes_on_falling(kind, overhang):
    """It turns about the edge without rolling; it stopped in the air. Within 3 %: gravity acts during the step."""
    stage = new_stage()
    _table(stage, kind)
    arm = LENGTH / 2 - overhang
    rod = _rod(stage, (arm, 0, 0.5))
    engine = playing(stage)
    seconds = _step_until_hit(engine, rod)
    left, spin = _after_impact(G * seconds, arm)
    assert velocity(rod)[2] == pytest.approx(-left, rel=0.03)
    assert _spin(rod) == pytest.approx([0, spin, 0], abs=0.03 * spin)


def test_a_rod_that_hits_a_post_turns_about_it():
    """Without gravity it is as fast and turns as fast for ever; a post beside it is no wall."""
    stage = new_stage()
    smooth = physics_material(stage, "/World/smooth", friction=0.0)
    add(stage, "/World/post", "Cylinder", at=(0.5, 0.35, 0), scale=(0.05, 0.05, 1), body=False, material=smooth)
    rod = _rod(stage, (0, 0, 0), along=1, gravity=False, material=smooth)
    set_value(rod, "physics:velocity", Gf.Vec3f(3, 0, 0))
    engine = playing(stage)
    _step_until_hit(engine, rod)
    left, spin = _after_impact(3.0, 0.35)
    assert velocity(rod) == pytest.approx([left, 0, 0], abs=0.02 * left)
    assert _spin(rod) == pytest.approx([0, 0, spin], abs=0.02 * spin)


def _heights_after_impact(engine, body):
    """Return the heights of a body at steps of two seconds, from the first one after which it does not fall on."""
    heights = []
    for _ in range(120):
        engine.step(1 / 60)
        heights.append(UsdGeom.XformCache().GetLocalToWorldTransform(body).ExtractTranslation()[2])
    return heights[int(np.flatnonzero(np.diff(heights) >= 0.0)[0]) :]


@pytest.mark.parametrize("tile", [0.25, 4.0])
def test_a_cube_that_falls_on_its_corner_lies_down_also_beside_a_seam(tile):
    """What is below the center of mass may be another tile than the one that the corner hits."""
    stage = new_stage()
    for row in range(-2, 3):
        for column in range(-2, 3):
            at = (tile * row, tile * column, -0.1)
            add(stage, f"/World/tile{row + 2}{column + 2}", at=at, scale=(tile / 2, tile / 2, 0.1), body=False)
    half = 0.05
    cube = add(stage, "/World/cube", at=(0.14, 0, 1.0), rotate=(35, 40, 10), scale=(half,) * 3)
    engine = playing(stage)
    heights = _heights_after_impact(engine, cube)
    assert max(heights) < 2.0 * half


@pytest.mark.parametrize("kind", ["box", "hull", "mesh"])
@pytest.mark.parametrize("arm", [0.02, 0.05, 0.08])
def test_a_cube_that_falls_beside_a_table_turns_about_its_edge(kind, arm):
    """Without friction, which would act on its spin; it stopped in the air, its center beyond the edge."""
    half = 0.1
    stage = new_stage()
    smooth = physics_material(stage, "/World/smooth", friction=0.0)
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World")).Bind(smooth, materialPurpose="physics")
    _table(stage, kind)
    cube = add(stage, "/World/cube", at=(arm, 0, 0.5 + half), scale=(half,) * 3)
    engine = playing(stage)
    seconds = _step_until_hit(engine, cube)
    impulse = G * seconds / (1 + arm**2 / (half**2 * 2 / 3))
    assert velocity(cube)[2] == pytest.approx(impulse - G * seconds, abs=0.03 * G * seconds)
    assert _spin(cube) == pytest.approx([0, impulse * arm / (half**2 * 2 / 3), 0], rel=0.03, abs=0.05)


@pytest.mark.parametrize("tilt", [0.0, 15.0, 25.0])
def test_a_cube_that_falls_between_slats_lies_on_both(tilt):
    """Nothing is below its center, but it does not turn about the slat that it hits first, and hop."""
    half, pitch = 0.1, 0.15
    stage = new_stage()
    for row in range(-4, 5):
        add(stage, f"/World/slat{row + 4}", at=((row + 0.5) * pitch, 0, -0.02), scale=(0.04, 1, 0.02), body=False)
    cube = add(stage, "/World/cube", at=(0.01, 0, 1.0), rotate=(0, tilt, 0), scale=(half,) * 3)
    engine = playing(stage)
    heights = _heights_after_impact(engine, cube)
    assert max(heights) < 1.5 * half
    assert heights[-1] == pytest.approx(half, abs=2e-3)

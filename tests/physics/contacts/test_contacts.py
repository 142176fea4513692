"""Every kind of shape lies on every kind of floor where its geometry says."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, playing, position

# A wedge with its centroid off the middle, so that mirroring it shows.
WEDGE = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [2, 1, 0], [0, 0, 1], [0, 1, 1]], float) - (0.7, 0.5, 0.35)
WEDGE_FACES = [[0, 2, 1], [1, 2, 3], [0, 1, 4], [2, 5, 3], [4, 1, 5], [5, 1, 3], [0, 4, 2], [2, 4, 5]]


def _cube_floor(stage):
    add(stage, "/World/floor", at=(0, 0, -0.5), scale=(9, 9, 0.5), body=False)


def _plane_floor(stage):
    collide(UsdGeom.Plane.Define(stage, "/World/floor").GetPrim())


def _mesh_floor(stage):
    corners = np.array([[x, y, 0] for x in (-9, 9) for y in (-9, 9)], float)
    floor = mesh(stage, "/World/floor", corners, [[0, 2, 1], [1, 2, 3]])
    collide(floor.GetPrim(), approximation="none")


def _hull_floor(stage):
    corners = np.array([[x, y, z] for x in (-9, 9) for y in (-9, 9) for z in (-1, 0)], float)
    collide(mesh(stage, "/World/floor", corners, [[0, 1, 2], [5, 6, 7], [3, 4, 0]]).GetPrim())


@pytest.mark.parametrize("floor", [_cube_floor, _plane_floor, _mesh_floor, _hull_floor])
def test_shapes_rest_on_floors(floor):
    """Resting heights within 2 mm: sphere and upright solids at their half height, the lying capsule at its radius."""
    stage = new_stage()
    floor(stage)
    expected = {}
    for i, (kind, turn, height) in enumerate(
        [
            ("Cube", (0, 0, 0), 0.2),
            ("Sphere", (0, 0, 0), 0.2),
            ("Capsule", (90, 0, 0), 0.1),
            ("Cylinder", (0, 0, 0), 0.2),
            ("Cone", (0, 0, 0), 0.2),
        ]
    ):
        prim = add(stage, f"/World/{kind}", kind, at=(2 * i - 4, 0, height + 0.02), rotate=turn, scale=(0.2, 0.2, 0.2))
        expected[prim] = height
    for i, mirror in enumerate((1, -1)):
        prim = mesh(stage, f"/World/wedge_{i}", WEDGE, WEDGE_FACES)
        prim.AddTranslateOp().Set(Gf.Vec3d(2 * i, 3, 0.2))
        prim.AddScaleOp().Set(Gf.Vec3f(0.5 * mirror, 0.5, 0.5))
        collide(prim.GetPrim())
        make_body(prim.GetPrim())
        expected[prim.GetPrim()] = 0.35 * 0.5
    playing(stage).advance(2.0)
    for prim, height in expected.items():
        assert position(prim)[2] == pytest.approx(height, abs=2e-3), prim.GetPath()


def test_mirrored_wedge_leans_the_other_way():
    """On a narrow pillar below its middle, the wedge tips toward its heavy side, which mirroring swaps."""
    ends = []
    for mirror in (1, -1):
        stage = new_stage()
        add(stage, "/World/pillar", at=(0, 0, -0.5), scale=(0.05, 0.5, 0.5), body=False)
        prim = mesh(stage, "/World/wedge", WEDGE + np.array([-0.3, 0, 0.35]), WEDGE_FACES)
        prim.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0))
        prim.AddScaleOp().Set(Gf.Vec3f(mirror, 1, 1))
        collide(prim.GetPrim())
        make_body(prim.GetPrim())
        playing(stage).advance(0.5)
        spin = prim.GetPrim().GetAttribute("physics:angularVelocity").Get()
        ends.append(spin[1])
    assert ends[0] < -5
    assert ends[1] > 5


def test_y_up_plane():
    stage = new_stage(up="Y")
    plane = UsdGeom.Plane.Define(stage, "/World/floor")
    plane.CreateAxisAttr("Y")
    collide(plane.GetPrim())
    prim = add(stage, "/World/box", at=(0, 0.3, 0))
    playing(stage).advance(1.0)
    assert position(prim) == pytest.approx([0, 0.1, 0], abs=2e-3)


def test_compound_body_rests_on_its_lowest_part():
    stage = new_stage()
    _cube_floor(stage)
    body = UsdGeom.Xform.Define(stage, "/World/table")
    body.AddTranslateOp().Set(Gf.Vec3d(0, 0, 1.05))
    add(stage, "/World/table/top", at=(0, 0, 0), scale=(0.5, 0.5, 0.05), body=False)
    for i, (x, y) in enumerate([(-1, -1), (-1, 1), (1, -1), (1, 1)]):
        add(stage, f"/World/table/leg_{i}", at=(0.4 * x, 0.4 * y, -0.55), scale=(0.05, 0.05, 0.45), body=False)
    make_body(body.GetPrim())
    playing(stage).advance(1.0)
    assert position(body.GetPrim()) == pytest.approx([0, 0, 1.0], abs=2e-3)


def test_rest_offset_keeps_a_distance():
    stage = new_stage()
    _cube_floor(stage)
    prim = add(stage, "/World/box", at=(0, 0, 0.3))
    prim.CreateAttribute("physxCollision:restOffset", Sdf.ValueTypeNames.Float).Set(0.02)
    prim.CreateAttribute("physxCollision:contactOffset", Sdf.ValueTypeNames.Float).Set(0.05)
    playing(stage).advance(1.0)
    assert position(prim)[2] == pytest.approx(0.12, abs=2e-3)


def test_heavy_box_on_a_light_one():
    """Thirtyfold mass above a light body neither crushes it nor sends it off; the solver's limit is near a hundred."""
    stage = new_stage()
    _cube_floor(stage)
    light, heavy = add(stage, "/World/light", at=(0, 0, 0.1)), add(stage, "/World/heavy", at=(0, 0, 0.31))
    UsdPhysics.MassAPI.Apply(light).CreateMassAttr(0.1)
    UsdPhysics.MassAPI.Apply(heavy).CreateMassAttr(3.0)
    playing(stage).advance(2.0)
    assert position(light)[2] == pytest.approx(0.1, abs=0.01)
    assert position(heavy)[2] == pytest.approx(0.3, abs=0.02)


def test_thin_body_does_not_fall_through_a_sheet():
    """A floor of two triangles, tilted discs of 2 cm at 4 m/s: an ordinary substep would take them 3 cm down."""
    stage = new_stage()
    _mesh_floor(stage)
    discs = []
    for i in range(12):
        at, turn = (i - 6, 0.3 * i, 0.2 + 0.013 * i), (3 * (i % 4), 2 * (i % 4), 40 * i)
        discs.append(add(stage, f"/World/disc_{i}", "Cylinder", at=at, rotate=turn, scale=(0.1, 0.1, 0.01)))
        discs[-1].GetAttribute("physics:velocity").Set(Gf.Vec3f(0, 0, -4))
    playing(stage).advance(1.0)
    assert [position(prim)[2] for prim in discs] == pytest.approx([0.01] * 12, abs=3e-3)

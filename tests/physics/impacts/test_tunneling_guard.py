"""No body is pushed through a wall, even where the minimum penetration depth leads through it."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf

from tests.physics.scenes import add, collide, make_body, mesh, new_stage, playing, position

# A box from its origin at the bottom up, as asset libraries model them.
STANDING = np.array([[x, y, z] for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (0.0, 0.8)], float)
STANDING_FACES = [[0, 1, 2], [1, 3, 2], [4, 6, 5], [5, 6, 7], [0, 4, 1], [1, 4, 5], [2, 3, 6], [3, 7, 6]]
STANDING_FACES += [[0, 2, 4], [2, 6, 4], [1, 5, 3], [3, 5, 7]]


def _standing(stage, path, at, *, gravity=False):
    prim = mesh(stage, path, STANDING, STANDING_FACES)
    prim.AddTranslateOp().Set(Gf.Vec3d(*at))
    collide(prim.GetPrim())
    make_body(prim.GetPrim(), gravity=gravity)
    return prim.GetPrim()


def _room(stage):
    """Floor and walls that only touch at the seams, around 4 x 4 meters from z = 0 up."""
    add(stage, "/World/floor", at=(0, 0, -0.25), scale=(2, 2, 0.25), body=False)
    for i, (x, y) in enumerate(((2.25, 0), (-2.25, 0), (0, 2.25), (0, -2.25))):
        scale = (0.25, 2.5, 2) if x else (2.5, 0.25, 2)
        add(stage, f"/World/wall_{i}", at=(x, y, 2), scale=scale, body=False)


@pytest.mark.parametrize(("height", "side"), [(-0.1, "above"), (-0.6, "below")])
def test_a_body_across_a_slab_goes_to_the_side_of_its_origin(height, side):
    """Placed with its middle in or beyond a slab from z = -0.5 to 0; the shortest way out is the other one."""
    stage = new_stage()
    add(stage, "/World/slab", at=(0, 0, -0.25), scale=(3, 3, 0.25), body=False)
    prim = _standing(stage, "/World/asset", (0, 0, 0))
    # Upside down, the box hangs from its origin; the right way up it reaches from below through the slab.
    if side == "above":
        prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 0.05))
        prim.CreateAttribute("xformOp:rotateXYZ", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(180, 0, 0))
        prim.GetAttribute("xformOpOrder").Set(["xformOp:translate", "xformOp:rotateXYZ"])
    else:
        prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, -0.55))
    playing(stage).advance(3.0)
    z = position(prim)[2]
    assert (z > 0.75) if side == "above" else (z < -1.25)


def test_a_plate_that_falls_along_a_wall_stays_on_the_floor():
    """At 10 m/s it comes 8 cm deep into the floor in one substep, and only 1.2 cm from the seam with the wall."""
    stage = new_stage()
    _room(stage)
    plate = add(stage, "/World/plate", at=(1.989, 1.5, 0.6), scale=(0.006, 0.1, 0.14))
    plate.CreateAttribute("physics:velocity", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(1, 0, -10))
    playing(stage).advance(1.5)
    assert position(plate)[2] > 0.13


def test_a_body_slides_over_an_edge_and_falls_down_beside_it():
    stage = new_stage()
    add(stage, "/World/table", at=(0, 0, -0.5), scale=(0.5, 0.5, 0.5), body=False)
    block = add(stage, "/World/block", at=(0.2, 0, 0.1), scale=(0.1, 0.1, 0.1))
    block.CreateAttribute("physics:velocity", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(4, 0, 0))
    playing(stage).advance(1.2)
    x, _, z = position(block)
    assert x > 0.6
    assert z < -1.5

"""3D boxes of prims that do not carry their gprims along follow what places these; corners in NumPy are the oracle."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from tests.annotators.ray_caster import add_cube, new_stage, place
from usdsdg.annotators import LabeledPrimReader
from usdsdg.stage.semantics.labels import add_labels

CORNERS = np.array(list(np.ndindex(2, 2, 2))) - 0.5


def turned(prim):
    place(prim, translate=(1, 2, 3), rotate=(10, 20, 30), scale=(2, 1, 1))


def matrix(prim) -> np.ndarray:
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))


def bounds_of(cube_to_world: np.ndarray, owner_to_world: np.ndarray, size: float) -> list[np.ndarray]:
    relative = cube_to_world @ np.linalg.inv(owner_to_world)
    corners = size * CORNERS @ relative[:3, :3] + relative[3, :3]
    return [corners.min(axis=0), corners.max(axis=0)]


@pytest.mark.parametrize("moved", ["/World", "/World/Owner", "/World/Owner/Group", "/World/Owner/Group/Cube", "size"])
def test_a_gprim_that_does_not_move_with_its_owner(moved):
    stage = new_stage()
    owner = UsdGeom.Xform.Define(stage, "/World/Owner")
    add_labels(owner.GetPrim(), {"class": ["thing"]})
    group = UsdGeom.Xform.Define(stage, "/World/Owner/Group")
    group.SetResetXformStack(True)
    cube = add_cube(stage, "/World/Owner/Group/Cube", translate=(0, 5, 0))
    reader, gprims = LabeledPrimReader(stage), ("/World/Owner/Group/Cube",)
    reader.read(gprims)
    if moved == "size":
        UsdGeom.Cube(cube).GetSizeAttr().Set(3.0)
    else:
        turned(stage.GetPrimAtPath(moved))
        group.SetResetXformStack(True)
    expected = bounds_of(matrix(cube), matrix(owner.GetPrim()), 3.0 if moved == "size" else 1.0)
    np.testing.assert_allclose(reader.read(gprims).bounds[0], expected, atol=1e-9)


@pytest.mark.parametrize("moved", ["/Library/Tree/Trunk", "/Library/Tree", "/World/Forest/Points", "size", "positions"])
def test_a_prototype_that_is_not_below_its_owner(moved):
    stage = new_stage()
    forest = UsdGeom.Xform.Define(stage, "/World/Forest").GetPrim()
    add_labels(forest, {"class": ["forest"]})
    tree = UsdGeom.Xform.Define(stage, "/Library/Tree").GetPrim()
    trunk = add_cube(stage, "/Library/Tree/Trunk", translate=(0, 0, 1))
    points = UsdGeom.PointInstancer.Define(stage, "/World/Forest/Points")
    points.CreatePrototypesRel().SetTargets([tree.GetPath()])
    points.CreateProtoIndicesAttr([0])
    points.CreatePositionsAttr([Gf.Vec3f(5, 0, 0)])
    reader, gprims = LabeledPrimReader(stage), ("/Library/Tree/Trunk[0]",)
    reader.read(gprims)
    if moved == "size":
        UsdGeom.Cube(trunk).GetSizeAttr().Set(3.0)
    elif moved == "positions":
        points.GetPositionsAttr().Set([Gf.Vec3f(0, 7, 0)])
    else:
        turned(stage.GetPrimAtPath(moved))
    point = np.eye(4)
    point[3, :3] = points.GetPositionsAttr().Get()[0]
    trunk_to_world = matrix(trunk) @ point @ matrix(points.GetPrim())
    expected = bounds_of(trunk_to_world, matrix(forest), 3.0 if moved == "size" else 1.0)
    np.testing.assert_allclose(reader.read(gprims).bounds[0], expected, atol=1e-6)

"""Matrices of prims that are more than a turn, a scale, a shear and a move."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from usdsdg.errors import UsdsdgWarning
from usdsdg_render.sync.extract import SceneExtractor


def cube(stage, path, matrix):
    prim = UsdGeom.Cube.Define(stage, path)
    prim.AddTransformOp().Set(Gf.Matrix4d(*map(float, np.ravel(matrix))))
    return prim


@pytest.mark.parametrize("column", [(0.5, 0, 0, 1), (0, 0, 0, 2)])
def test_projections_are_named_and_drawn_without(column):
    stage, matrix = Usd.Stage.CreateInMemory(), np.eye(4)
    matrix[:, 3] = column
    UsdGeom.Xform.Define(stage, "/World").AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    cube(stage, "/World/cube", matrix)
    extractor = SceneExtractor(stage)
    with pytest.warns(UsdsdgWarning, match="/World/cube: its transform is a projection"):
        extractor.update()
    moved = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]]
    assert extractor.scene.instances.local_to_world[0].tolist() == moved


def test_matrices_of_32_bits_are_not_named(recwarn):
    stage = Usd.Stage.CreateInMemory()
    matrix = np.array([[0.1, 0.3, 0, 1e-9], [0, 1e3, 0, 0], [0, 0, 1e-3, 0], [7, 8, 9, 1 + 1e-7]])
    cube(stage, "/World/cube", matrix)
    SceneExtractor(stage).update()
    assert not recwarn.list

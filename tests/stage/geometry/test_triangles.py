"""Triangles in prototypes of point instancers, against where they are drawn."""

import numpy as np
from pxr import Gf, Usd, UsdGeom

from usdsdg.stage.geometry.triangles import triangles_below
from usdsdg_render.sync.extract import SceneExtractor


def test_points_also_move_what_resets_the_transform_stack_in_their_prototype():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/World").AddTranslateOp().Set(Gf.Vec3d(0, 0, 7))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    instancer.AddTranslateOp().Set(Gf.Vec3d(0, 0, 2))
    for path, place in (("prototypes", (0, 5, 0)), ("prototypes/crate", (0, 0, 3))):
        UsdGeom.Xform.Define(stage, f"/World/many/{path}").AddTranslateOp().Set(Gf.Vec3d(*place))
    box = UsdGeom.Cube.Define(stage, "/World/many/prototypes/crate/box")
    box.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    UsdGeom.Cube.Define(stage, "/World/many/prototypes/crate/lid").AddTranslateOp().Set(Gf.Vec3d(2, 0, 0))
    box.SetResetXformStack(True)
    instancer.CreatePrototypesRel().SetTargets([box.GetPath().GetParentPath()])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([(10, 0, 0), (20, 0, 0)])

    extractor = SceneExtractor(stage)
    extractor.update()
    found = [each.to_world for each in triangles_below([instancer.GetPrim()])]

    np.testing.assert_allclose(found, extractor.scene.instances.local_to_world)
    np.testing.assert_allclose([each[3, :3] for each in found], [(11, 0, 9), (12, 0, 12), (21, 0, 9), (22, 0, 12)])

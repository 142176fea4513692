"""Prims with keypoints are read as they are at the time of the frame."""

from pxr import Usd, UsdGeom

from usdsdg.annotators.point_instances import PointFrames
from usdsdg.annotators.prims.keypoint_prims import KeypointReader
from usdsdg.stage.keypoints import set_keypoints


def test_what_nothing_is_drawn_of_has_keypoints_while_it_is_shown():
    stage = Usd.Stage.CreateInMemory()
    marks = UsdGeom.Xform.Define(stage, "/Marks")
    set_keypoints(marks.GetPrim(), {"corner": (1, 2, 3)})
    visibility = UsdGeom.Imageable(marks).CreateVisibilityAttr()
    visibility.Set("invisible", 0)
    visibility.Set("inherited", 10)
    reader = KeypointReader(stage)

    def read(time):
        prims = reader.read([], [], PointFrames(stage, UsdGeom.XformCache(time)), time)
        return [(prim.name, prim.positions.tolist()) for prim in prims]

    assert read(Usd.TimeCode(5)) == []
    assert read(Usd.TimeCode(10)) == [("/Marks", [[1, 2, 3]])]
    visibility.Set("invisible", 10)
    assert read(Usd.TimeCode(10)) == []

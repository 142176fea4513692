"""Prims with keypoints are read as they are at the time of the frame."""

from pxr import Usd, UsdGeom

from usdsdg.annotators.labeled_prims import LabeledPrimReader
from usdsdg.annotators.point_instances import PointFrames
from usdsdg.annotators.prims.keypoint_prims import KeypointReader
from usdsdg.stage.keypoints import set_keypoints
from usdsdg_render.renderer import WarpRenderer


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


def seen(stage: Usd.Stage) -> list[str]:
    """The prims whose keypoints are in a frame of the stage as it is."""
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    labeled = LabeledPrimReader(stage).read(renderer.gprims)
    return [prim.name for prim in labeled.read_keypoints()]


def test_a_prototype_below_its_instancer_has_those_of_its_points_only():
    """Where no point draws it, its keypoints were listed at the place of the prototype, where nothing is."""
    stage = Usd.Stage.CreateInMemory()
    points = UsdGeom.PointInstancer.Define(stage, "/Trees")
    points.CreatePrototypesRel().SetTargets(["/Trees/Oak", "/Trees/Fir"])
    points.CreatePositionsAttr([(5, 0, 0), (6, 0, 0)])
    points.CreateProtoIndicesAttr([0, 1])
    for name in ("Oak", "Fir"):
        UsdGeom.Cube.Define(stage, f"/Trees/{name}/Trunk")
        set_keypoints(stage.GetPrimAtPath(f"/Trees/{name}/Trunk"), {"top": (0, 0, 1)})
    set_keypoints(points.GetPrim(), {"center": (0, 0, 0)})
    assert seen(stage) == ["/Trees", "/Trees/Oak/Trunk[0]", "/Trees/Fir/Trunk[1]"]
    points.GetProtoIndicesAttr().Set([1, 1])
    assert seen(stage) == ["/Trees", "/Trees/Fir/Trunk[0]", "/Trees/Fir/Trunk[1]"]
    points.CreateInvisibleIdsAttr([0, 1])
    assert seen(stage) == ["/Trees"]


def test_an_instance_in_a_class_has_those_of_points_only():
    """Its prims do not say of themselves that they are in a class."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Cube.Define(stage, "/Asset/Trunk")
    set_keypoints(stage.GetPrimAtPath("/Asset/Trunk"), {"top": (0, 0, 1)})
    stage.CreateClassPrim("/Library")
    oak = stage.DefinePrim("/Library/Oak", "Xform")
    oak.GetReferences().AddInternalReference("/Asset")
    oak.SetInstanceable(True)
    points = UsdGeom.PointInstancer.Define(stage, "/Trees")
    points.CreatePrototypesRel().SetTargets(["/Library/Oak"])
    points.CreatePositionsAttr([(5, 0, 0)])
    points.CreateProtoIndicesAttr([0])
    assert seen(stage) == ["/Asset/Trunk", "/Library/Oak/Trunk[0]"]
    points.MakeInvisible()
    assert seen(stage) == ["/Asset/Trunk"]

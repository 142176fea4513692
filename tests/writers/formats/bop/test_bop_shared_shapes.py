"""Models of objects whose triangles stand elsewhere: in an asset that instances share, or a prototype of points."""

import json

import pytest
from pxr import Gf, Usd, UsdGeom

import usdsdg as rep
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.semantics.labels import add_labels

pytestmark = pytest.mark.filterwarnings("ignore:BopWriter. objects of the class:usdsdg.errors.UsdsdgWarning")


@pytest.fixture
def stage(stage):
    """Meters, with a camera 10 m above the origin, and a sail of 0.4 m by 0.4 m in `/Library`, which is not drawn."""
    stage = current_stage()
    stage.SetMetadata("metersPerUnit", 1.0)
    stage.CreateClassPrim("/Library")
    UsdGeom.Xform.Define(stage, "/Library/Boat").AddScaleOp().Set(Gf.Vec3f(1, 1, 1))
    sail = UsdGeom.Mesh.Define(stage, "/Library/Boat/Sail")
    sail.CreatePointsAttr([(-0.2, -0.2, 0), (0.2, -0.2, 0), (0, 0.2, 0)])
    sail.CreateFaceVertexCountsAttr([3])
    sail.CreateFaceVertexIndicesAttr([0, 1, 2])
    sail.CreateSubdivisionSchemeAttr("none")
    sail.AddTranslateOp().Set((0, 0, 0))
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.AddTranslateOp().Set((0, 0, 10))
    camera.CreateClippingRangeAttr((0.1, 100))
    return stage


def add_instance(stage: Usd.Stage) -> None:
    """A labeled prim in an instance: a proxy, whose triangles are those of the instance's prototype."""
    add_labels(stage.GetPrimAtPath("/Library/Boat/Sail"), {"class": ["sail"]})
    copy = stage.DefinePrim("/World/Copy", "Xform")
    copy.GetReferences().AddInternalReference("/Library/Boat")
    copy.SetInstanceable(True)


def add_nested_instance(stage: Usd.Stage) -> None:
    """A labeled prim above an instance in an instance."""
    inner = stage.DefinePrim("/Library/Fleet/Inner", "Xform")
    inner.GetReferences().AddInternalReference("/Library/Boat")
    inner.SetInstanceable(True)
    copy = stage.DefinePrim("/World/Copy", "Xform")
    copy.GetReferences().AddInternalReference("/Library/Fleet")
    copy.SetInstanceable(True)
    add_labels(copy, {"class": ["sail"]})


def add_points(stage: Usd.Stage) -> None:
    """A labeled prim above an instancer of one point, whose prototype is elsewhere."""
    add_labels(UsdGeom.Xform.Define(stage, "/World/Harbor").GetPrim(), {"class": ["sail"]})
    points = UsdGeom.PointInstancer.Define(stage, "/World/Harbor/Points")
    points.CreatePrototypesRel().SetTargets(["/Library/Boat"])
    points.CreatePositionsAttr([(0, 0, 0)])
    points.CreateProtoIndicesAttr([0])


def reshape(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath("/Library/Boat/Sail").GetAttribute("points").Set([(-0.4, -0.2, 0), (0.4, -0.2, 0), (0, 0.2, 0)])


def add_a_part(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath("/Library/Boat/Sail").GetAttribute("points").Set([(-0.4, -0.2, 0), (0.4, -0.2, 0), (0, 0.2, 0)])
    cube = UsdGeom.Cube.Define(stage, "/Library/Boat/Mast")
    cube.CreateSizeAttr(0.1)


def scale_the_prototype(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath("/Library/Boat").GetAttribute("xformOp:scale").Set(Gf.Vec3f(2, 1, 1))


def widths(folder, edit, stage: Usd.Stage) -> list[int]:
    """Return the width [mm] of the model of the only object, before and after an edit."""
    writer = rep.writers.get("BopWriter")
    writer.initialize(output_dir=str(folder))
    writer.attach(rep.create.render_product("/Camera", (96, 72)))
    rep.orchestrator.step(delta_time=0.0)
    edit(stage)
    rep.orchestrator.step(delta_time=0.0)
    writer.detach()
    rep.orchestrator.wait_until_complete()
    infos = json.loads((folder / "models/models_info.json").read_text())
    poses = json.loads((folder / "train_pbr/000000/scene_gt.json").read_text())
    return [round(infos[str(pose["obj_id"])]["size_x"]) for frame in ("0", "1") for pose in poses[frame]]


@pytest.mark.parametrize(
    ("add", "edit"),
    [
        (add_instance, reshape),
        (add_nested_instance, reshape),
        (add_nested_instance, add_a_part),
        (add_points, reshape),
        (add_points, add_a_part),
        (add_points, scale_the_prototype),
    ],
)
def test_what_is_edited_where_it_stands_is_edited_where_it_is_drawn(stage, tmp_path, add, edit):
    add(stage)
    assert widths(tmp_path, edit, stage) == [400, 800]


def test_a_point_instancer_that_gets_another_prototype_has_another_model(stage, tmp_path):
    add_points(stage)
    UsdGeom.Cube.Define(stage, "/Library/Buoy").CreateSizeAttr(0.3)
    points = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Harbor/Points"))
    edited = widths(tmp_path, lambda _: points.GetPrototypesRel().SetTargets(["/Library/Buoy"]), stage)
    assert edited == [400, 300]


def test_models_that_stay_are_the_same(stage, tmp_path):
    add_points(stage)
    other = UsdGeom.Xform.Define(stage, "/World/Other").AddTranslateOp()
    other.Set((0, 0, 0))
    forget_warnings()
    with pytest.warns(UsdsdgWarning) as warned:
        assert widths(tmp_path, lambda _: other.Set((1, 2, 3)), stage) == [400, 400]
    assert not [each for each in warned if "differ in shape" in str(each.message)]

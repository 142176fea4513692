"""Which triangles are in a model: those that the masks of its object show, and no others."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.annotators.prims.labeled_survey import LabeledSurvey
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.writers.formats.bop.bop_models import model_of
from usdsdg_render.renderer import WarpRenderer


def cube(stage: Usd.Stage, path: str, x: float) -> Usd.Prim:
    """A cube of one unit around (x, 0, 0)."""
    shape = UsdGeom.Cube.Define(stage, path)
    shape.CreateSizeAttr(1.0)
    shape.AddTranslateOp().Set(Gf.Vec3d(x, 0, 0))
    return shape.GetPrim()


@pytest.fixture
def car():
    stage = Usd.Stage.CreateInMemory()
    add_labels(UsdGeom.Xform.Define(stage, "/Car").GetPrim(), {"class": ["car"]})
    cube(stage, "/Car/Body", 0.0)
    return stage


def reach(stage: Usd.Stage, predicate: str | None = "class:*") -> tuple[float, float]:
    """Where the model of the car begins and ends along x."""
    model = model_of(LabeledSurvey(stage, predicate), "/Car", np.eye(3))
    assert model is not None
    return float(model.points[:, 0].min()), float(model.points[:, 0].max())


@pytest.mark.parametrize(("predicate", "end"), [("class:*", 5.5), ("class:*;part:*", 0.5), (None, 0.5)])
def test_a_part_is_of_the_whole_unless_its_labels_pass_the_filter(car, predicate, end):
    add_labels(cube(car, "/Car/Wheel", 5.0), {"part": ["wheel"]})
    assert reach(car, predicate) == (-0.5, end)


@pytest.mark.parametrize("purpose", ["proxy", "guide", "render"])
def test_parts_that_are_not_drawn_for_their_purpose_are_left_out(car, purpose):
    UsdGeom.Imageable(cube(car, "/Car/Part", 5.0)).CreatePurposeAttr(purpose)
    assert reach(car) == (-0.5, 5.5 if purpose == "render" else 0.5)


@pytest.mark.parametrize(
    ("of_points", "of_library", "of_wheel", "end"),
    [
        ("", "", "", 5.5),
        ("guide", "", "", 0.5),
        ("proxy", "", "render", 0.5),
        ("", "guide", "", 5.5),  # the purpose of what a prototype is in says nothing about what draws it
        ("render", "proxy", "", 5.5),
        ("", "", "guide", 0.5),
    ],
)
def test_points_are_in_a_model_where_pictures_show_them(car, of_points, of_library, of_wheel, end):
    UsdGeom.Scope.Define(car, "/Library")
    cube(car, "/Library/Wheel", 0.0)
    points = UsdGeom.PointInstancer.Define(car, "/Car/Points")
    points.CreatePrototypesRel().SetTargets(["/Library/Wheel"])
    points.CreatePositionsAttr([(5, 0, 0)])
    points.CreateProtoIndicesAttr([0])
    for path, purpose in (("/Car/Points", of_points), ("/Library", of_library), ("/Library/Wheel", of_wheel)):
        if purpose:
            UsdGeom.Imageable(car.GetPrimAtPath(path)).CreatePurposeAttr(purpose)
    renderer = WarpRenderer(car, device="cpu")
    renderer.sync()
    drawn = [path for path in renderer.gprims if path.startswith("/Library/Wheel[")]
    assert bool(drawn) == (end > 1)
    assert reach(car) == (-0.5, end)


def test_a_labeled_prototype_has_a_model_whatever_it_is_in():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Scope.Define(stage, "/Library").CreatePurposeAttr("guide")
    add_labels(cube(stage, "/Library/Wheel", 0.0), {"class": ["wheel"]})
    points = UsdGeom.PointInstancer.Define(stage, "/Points")
    points.CreatePrototypesRel().SetTargets(["/Library/Wheel"])
    points.CreatePositionsAttr([(5, 0, 0)])
    points.CreateProtoIndicesAttr([0])
    assert model_of(LabeledSurvey(stage, "class:*"), "/Library/Wheel[0]", np.eye(3)) is not None


def test_hidden_parts_are_left_out(car):
    UsdGeom.Xform.Define(car, "/Car/Collision").MakeInvisible()
    cube(car, "/Car/Collision/Part", 5.0)
    assert reach(car) == (-0.5, 0.5)


@pytest.mark.parametrize("scale", [(1.0, 2.0, 3.0), (-1.0, 1.0, 1.0), (1.0, -2.0, 0.5), (-1.0, -1.0, -1.0)])
@pytest.mark.parametrize("stretch", [(1.0, 1.0, 1.0), (-2.0, 1.0, 1.0)])
def test_triangles_turn_outward_also_where_something_is_mirrored(scale, stretch):
    stage = Usd.Stage.CreateInMemory()
    add_labels(UsdGeom.Xform.Define(stage, "/Car").GetPrim(), {"class": ["car"]})
    UsdGeom.Xformable(cube(stage, "/Car/Body", 5.0)).AddScaleOp().Set(Gf.Vec3f(scale))
    model = model_of(LabeledSurvey(stage, "class:*"), "/Car", np.diag(stretch))
    assert model is not None
    a, b, c = np.moveaxis(model.points[model.triangles].astype(np.float64), 1, 0)
    volume = (a * np.cross(b, c)).sum() / 6  # by the divergence theorem, positive where normals lead out of the body
    assert volume == pytest.approx(abs(np.prod(scale) * np.prod(stretch)), rel=1e-6)


def test_points_that_no_face_uses_are_left_out(car):
    mesh = UsdGeom.Mesh.Define(car, "/Car/Roof")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0), (50, 0, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    assert reach(car) == (-0.5, 1.0)


@pytest.mark.parametrize("axis", "XYZ")
def test_planes_are_as_wide_and_long_as_their_axis_says(car, axis):
    plane = UsdGeom.Plane.Define(car, "/Plane")
    add_labels(plane.GetPrim(), {"class": ["plane"]})
    plane.CreateAxisAttr(axis)
    plane.CreateWidthAttr(6.0)
    plane.CreateLengthAttr(4.0)
    model = model_of(LabeledSurvey(car, "class:*"), "/Plane", np.eye(3))
    assert model is not None
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(plane), Usd.TimeCode.Default())
    np.testing.assert_array_equal([model.points.min(axis=0), model.points.max(axis=0)], extent)
    a, b, c = np.moveaxis(model.points[model.triangles], 1, 0)
    assert (np.cross(b - a, c - a)["XYZ".index(axis) == np.arange(3)[None].repeat(len(a), 0)] > 0).all()


@pytest.mark.parametrize("home", ["class", "over", "hidden"])
def test_prototypes_that_are_not_drawn_by_themselves_have_models(home):
    """A library of prototypes, instanced by an instancer that the second point of another one draws."""
    stage = Usd.Stage.CreateInMemory()
    library = UsdGeom.Scope.Define(stage, "/Library")
    UsdGeom.Xform.Define(stage, "/Library/Mug")
    add_labels(stage.GetPrimAtPath("/Library/Mug"), {"class": ["mug"]})
    cube(stage, "/Library/Mug/Body", 2.0)
    for path, prototype, ids in (("/Library/Row", "/Library/Mug", [3, 4]), ("/Rows", "/Library/Row", [8, 9])):
        row = UsdGeom.PointInstancer.Define(stage, path)
        row.CreatePrototypesRel().SetTargets([prototype])
        row.CreateProtoIndicesAttr([0, 0])
        row.CreatePositionsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(0, 1, 0)])
        row.CreateIdsAttr(ids)
    if home == "hidden":
        library.MakeInvisible()
    else:
        library.GetPrim().SetSpecifier({"class": Sdf.SpecifierClass, "over": Sdf.SpecifierOver}[home])
    survey = LabeledSurvey(stage, "class:*")
    assert [each.name for each in survey.read()] == ["/Library/Mug[3][8]", "/Library/Mug[4][8]"]
    model = model_of(survey, "/Library/Mug[4][9]", np.eye(3))
    assert model is not None
    np.testing.assert_array_equal(model.points[:, 0].max(), 2.5)
    UsdGeom.Imageable(stage.GetPrimAtPath("/Library/Mug")).MakeInvisible()
    assert list(survey.read()) == []


def test_scales_that_have_samples_only_are_those_with_which_the_stage_begins():
    """As exporters of animations write them: the default time has none of their values."""
    stage = Usd.Stage.CreateInMemory()
    stage.SetStartTimeCode(3)
    car = UsdGeom.Xform.Define(stage, "/Car")
    add_labels(car.GetPrim(), {"class": ["car"]})
    grown = car.AddScaleOp()
    for time, scale in ((1, 9.0), (3, 2.0), (5, 4.0)):
        grown.Set(Gf.Vec3f(scale), time)
    body = UsdGeom.Cube.Define(stage, "/Car/Body")
    body.CreateSizeAttr().Set(10.0, 3)
    body.AddTranslateOp().Set(Gf.Vec3d(7, 0, 0), 3)
    survey = LabeledSurvey(stage, "class:*")
    (surveyed,) = survey.read()
    np.testing.assert_array_equal(surveyed.local_to_world, np.diag([2, 2, 2, 1]))
    model = model_of(survey, "/Car", surveyed.local_to_world[:3, :3])
    assert model is not None
    np.testing.assert_array_equal((model.points[:, 0].min(), model.points[:, 0].max()), (4, 24))


def row_of_mugs(places: list[tuple[float, float, float]] | None, time: Usd.TimeCode) -> Usd.Stage:
    """Two points of an instancer, with positions at one time."""
    stage = Usd.Stage.CreateInMemory()
    row = UsdGeom.PointInstancer.Define(stage, "/Row")
    add_labels(cube(stage, "/Row/Mug", 0.0), {"class": ["mug"]})
    row.CreatePrototypesRel().SetTargets(["/Row/Mug"])
    row.CreateProtoIndicesAttr([0, 0])
    if places is not None:
        row.CreatePositionsAttr().Set(places, time)
    return stage


def test_points_that_move_have_models():
    survey = LabeledSurvey(row_of_mugs([(1, 2, 3), (4, 5, 6)], Usd.TimeCode(1)), "class:*")
    found = {each.name: each.local_to_world[3, :3].tolist() for each in survey.read()}
    assert found == {"/Row/Mug[0]": [1, 2, 3], "/Row/Mug[1]": [4, 5, 6]}
    assert model_of(survey, "/Row/Mug[1]", np.eye(3)) is not None


@pytest.mark.parametrize("places", [None, [(1, 2, 3)]])
def test_points_without_positions_which_are_not_drawn_are_left_out(places):
    assert list(LabeledSurvey(row_of_mugs(places, Usd.TimeCode.Default()), "class:*").read()) == []


@pytest.mark.parametrize("refined", [False, True])
def test_faces_that_pictures_refine_are_named(car, refined, recwarn):
    shell = UsdGeom.Mesh.Define(car, "/Car/Shell")
    shell.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    shell.CreateFaceVertexCountsAttr([3])
    shell.CreateFaceVertexIndicesAttr([0, 1, 2])
    if refined:
        shell.CreateCornerIndicesAttr([0])
        shell.CreateCornerSharpnessesAttr([10.0])
    assert model_of(LabeledSurvey(car, "class:*"), "/Car", np.eye(3)) is not None
    assert any("/Car/Shell: pictures refine its faces" in str(each.message) for each in recwarn) == refined

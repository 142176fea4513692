"""GeomSubsets in masks: with the setting, faces have the labels of their subset; without it, those of the mesh."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

import usdsdg as rep
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.semantics.labels import add_labels

SETTING = "/syntheticdata/sensors/perSubsetSegmentation"


@pytest.fixture
def product(stage):
    """A strip of three unit squares seen from above, 30 x 10 pixels: two subsets, and a face of none."""
    mesh = UsdGeom.Mesh.Define(stage, "/World/strip")
    points = [(x, y, 0) for y in (0, 1) for x in (0, 1, 2, 3)]
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr([4, 4, 4])
    mesh.CreateFaceVertexIndicesAttr([k + d for k in range(3) for d in (0, 1, 5, 4)])
    add_labels(mesh.GetPrim(), {"class": ["strip"]})
    for name, faces in (("left", [0]), ("middle", [1])):
        subset = UsdGeom.Subset.Define(stage, f"/World/strip/{name}")
        subset.CreateElementTypeAttr("face")
        subset.CreateIndicesAttr(faces)
    add_labels(stage.GetPrimAtPath("/World/strip/left"), {"class": ["left"]})
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(1.5, 0.5, 10))
    camera.CreateProjectionAttr("orthographic")
    camera.CreateHorizontalApertureAttr(30.0)
    return rep.create.render_product("/World/Camera", (30, 10))


def captured(name, product, **params):
    annotator = rep.annotators.get(name, init_params=params)
    annotator.attach(product)
    rep.orchestrator.step()
    got = annotator.get_data()
    return got["data"], got["info"]["idToLabels"]


def labels_along(data, table):
    return [table[str(number)] for number in data[5, [5, 15, 25]]]


def test_subsets_are_part_of_their_mesh_by_default(product):
    data, table = captured("semantic_segmentation", product)
    assert labels_along(data, table) == [{"class": "strip"}] * 3


def test_faces_have_the_labels_of_their_subset(product):
    get_settings().set(SETTING, True)
    data, table = captured("semantic_segmentation", product)
    assert labels_along(data, table) == [{"class": "strip,left"}, {"class": "strip"}, {"class": "strip"}]
    assert (data[:, :10] == data[5, 5]).all()
    assert (data[:, 10:] == data[5, 15]).all()


def test_a_mesh_of_which_all_faces_are_in_labeled_subsets_is_not_said_to_be_empty(product, stage, recwarn):
    get_settings().set(SETTING, True)
    UsdGeom.Subset(stage.GetPrimAtPath("/World/strip/middle")).GetIndicesAttr().Set([1, 2])
    add_labels(stage.GetPrimAtPath("/World/strip/middle"), {"class": ["middle"]})
    for name in ("bounding_box_3d", "bounding_box_3d_360"):
        rows, _ = captured(name, product)
        assert len(rows) == 2
    assert not [each for each in recwarn if "finite bounds" in str(each.message)]


def test_subsets_are_gprims_of_their_own(product):
    get_settings().set(SETTING, True)
    data, table = captured("instance_id_segmentation", product)
    assert labels_along(data, table) == ["/World/strip/left", "/World/strip/middle", "/World/strip"]
    _, instances = captured("instance_segmentation", product)
    assert set(instances.values()) - {"BACKGROUND", "UNLABELLED"} == {"/World/strip/left", "/World/strip"}


def test_point_clouds_have_the_labels_of_subsets(product):
    get_settings().set(SETTING, True)
    annotator = rep.annotators.get("pointcloud")
    annotator.attach(product)
    rep.orchestrator.step()
    points = annotator.get_data()
    left = points["data"][:, 0] < 1
    assert len(set(points["info"]["pointInstance"][left])) == 1
    assert len(np.unique(points["info"]["pointInstance"])) == 2


@pytest.mark.parametrize("of", ["the mesh", "a subset", "another subset"])
def test_boxes_of_subsets_follow_time_samples(of, product, stage):
    get_settings().set(SETTING, True)
    if of == "the mesh":
        points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/strip")).GetPointsAttr()
        before = points.Get()
        points.Set(before, 0)
        points.Set([point * 2 for point in before], 60)
        expected = (0, 0, 2, 2)
    else:
        path = "/World/strip/left" if of == "a subset" else "/World/strip/middle"
        indices = UsdGeom.Subset(stage.GetPrimAtPath(path)).GetIndicesAttr()
        indices.Set([0] if of == "a subset" else [1], 0)
        indices.Set([0, 2], 60)
        expected = (0, 0, 3, 1)
        if of == "another subset":
            UsdGeom.Subset(stage.GetPrimAtPath("/World/strip/left")).GetIndicesAttr().Set([0, 1])
            expected = (1, 0, 2, 1)  # the faces of the last subset are no more its own
    annotator = rep.annotators.get("bounding_box_3d")
    annotator.attach(product)
    for second in (0.0, 1.0):
        get_timeline().set_current_time(second)
        rep.orchestrator.step(delta_time=0.0)
    got = annotator.get_data()
    row = got["data"][got["info"]["primPaths"].index("/World/strip/left")]
    assert tuple(row[name] for name in ("x_min", "y_min", "x_max", "y_max")) == expected


def test_a_box_of_a_subset_follows_another_that_goes(product, stage):
    get_settings().set(SETTING, True)
    UsdGeom.Subset(stage.GetPrimAtPath("/World/strip/left")).GetIndicesAttr().Set([0, 1])
    annotator = rep.annotators.get("bounding_box_3d")
    annotator.attach(product)
    for is_active, width in ((True, 1), (False, 2)):
        stage.GetPrimAtPath("/World/strip/middle").SetActive(is_active)
        rep.orchestrator.step()
        got = annotator.get_data()
        assert got["data"][got["info"]["primPaths"].index("/World/strip/left")]["x_max"] == width

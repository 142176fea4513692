"""Point instancers that share prototypes: each point has its own name, id, labels, pose and motion."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

import usdsdg as rep
from usdsdg.stage.semantics.labels import add_labels

PIXELS_PER_UNIT = 8
SIZE = (96, 64)
# Of each instancer: id -> x, y. "A" has no point 5, and its point 4 is a ball.
BOXES = {"A": {0: (-4, 2), 1: (-2, 2)}, "B": {0: (1, -2), 1: (3, -2), 4: (5, -2), 5: (-1, -2)}}
BALL = (4, 2)


def instancer(stage, path, label, points, kinds):
    found = UsdGeom.PointInstancer.Define(stage, path)
    found.CreatePrototypesRel().SetTargets(["/Library/Box", "/Library/Ball"])
    found.CreateIdsAttr(list(points))
    found.CreateProtoIndicesAttr(kinds)
    found.CreatePositionsAttr([Gf.Vec3f(x, y, 0) for x, y in points.values()])
    add_labels(found.GetPrim().GetParent(), {"class": [label]})
    return found


@pytest.fixture
def annotators(stage):
    """A row of boxes of A and one of B, seen from above in parallel rays; their labels are on the boxes and above."""
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.CreateClassPrim("/Library")
    box = UsdGeom.Cube.Define(stage, "/Library/Box")
    box.CreateSizeAttr(1.0)
    add_labels(box.GetPrim(), {"class": ["box"]})
    UsdGeom.Sphere.Define(stage, "/Library/Ball").CreateRadiusAttr(0.5)
    for name in "AB":
        UsdGeom.Xform.Define(stage, f"/World/{name}")
    instancer(stage, "/World/A/Points", "first", {**BOXES["A"], 4: BALL}, [0, 0, 1])
    instancer(stage, "/World/B/Points", "second", BOXES["B"], [0, 0, 0, 0])
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.CreateProjectionAttr("orthographic")
    camera.CreateHorizontalApertureAttr(10.0 * SIZE[0] / PIXELS_PER_UNIT)
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 10))
    product = rep.create.render_product("/Camera", SIZE)
    names = ["instance_segmentation", "instance_id_segmentation", "bounding_box_3d", "motion_vectors"]
    return {name: rep.annotators.get(name).attach(product) for name in names}


def at(image, point):
    """The value of the pixel that shows a point of the plane z = 0."""
    x, y = point
    return image[int(SIZE[1] / 2 - PIXELS_PER_UNIT * y), int(SIZE[0] / 2 + PIXELS_PER_UNIT * x)]


def objects(annotators, drawn="AB"):
    """Return (instancer, id) -> (id in the segmentation, path, labels), and check that boxes agree."""
    rep.orchestrator.step(delta_time=0.0)
    masks, boxes = annotators["instance_segmentation"].get_data(), annotators["bounding_box_3d"].get_data()
    place_of = {number: tuple(row["transform"][3, :2]) for number, row in zip(boxes["info"]["bboxIds"], boxes["data"])}
    found = {}
    for name in drawn:
        for point, place in BOXES[name].items():
            number = int(at(masks["data"], place))
            tables = (masks["info"][table][str(number)] for table in ("idToLabels", "idToSemantics"))
            found[name, point] = (number, *tables)
            np.testing.assert_allclose(place_of[number], place, atol=1e-6)
    return found


def test_each_point_is_an_object_with_the_labels_of_what_its_instancer_is_in(annotators):
    found = objects(annotators)
    assert (
        len({number for number, _, _ in found.values()}) == len({path for _, path, _ in found.values()}) == len(found)
    )
    for (name, _), (_, path, labels) in found.items():
        assert path.startswith("/Library/Box[")
        assert labels == {"class": {"A": "first,box", "B": "second,box"}[name]}
    assert at(annotators["instance_segmentation"].get_data()["data"], BALL) not in [each[0] for each in found.values()]


def test_an_instancer_keeps_its_ids_while_another_one_is_hidden(annotators, stage):
    before = objects(annotators)
    first = UsdGeom.Imageable(stage.GetPrimAtPath("/World/A"))
    first.MakeInvisible()
    assert objects(annotators, "B") == {key: value for key, value in before.items() if key[0] == "B"}
    first.MakeVisible()
    assert objects(annotators) == before


def test_points_of_one_instancer_move_and_those_of_the_other_do_not(annotators, stage):
    objects(annotators)
    UsdGeom.Imageable(stage.GetPrimAtPath("/Library/Ball")).MakeInvisible()  # other gprims are drawn than before
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/B")).AddTranslateOp().Set(Gf.Vec3d(0.25, -0.125, 0))
    rep.orchestrator.step(delta_time=0.0)
    motion = annotators["motion_vectors"].get_data()
    for name, expected in (("A", (0, 0)), ("B", (-2, -1))):  # +x moved left, +y moved up
        for place in BOXES[name].values():
            np.testing.assert_allclose(at(motion, place)[:2], expected, atol=1e-4)


def test_ids_and_motion_of_points_go_on_while_another_instancer_comes_and_goes(annotators, stage):
    move = UsdGeom.Xformable(stage.GetPrimAtPath("/World/A")).AddTranslateOp()
    found = []
    for frame, drawn in enumerate(("AB", "A", "AB", "A")):
        if drawn == "A":
            stage.RemovePrim("/World/B")
        elif frame:
            UsdGeom.Xform.Define(stage, "/World/B")
            instancer(stage, "/World/B/Points", "second", BOXES["B"], [0, 0, 0, 0])
        move.Set(Gf.Vec3d(0.125 * frame, 0, 0))
        rep.orchestrator.step(delta_time=0.0)
        images = [annotators[f"{kind}_segmentation"].get_data()["data"] for kind in ("instance", "instance_id")]
        found.append([int(at(image, place)) for image in images for place in BOXES["A"].values()])
        for place in BOXES["A"].values():
            expected = (-1, 0) if frame else (0, 0)
            np.testing.assert_allclose(at(annotators["motion_vectors"].get_data(), place)[:2], expected, atol=1e-4)
    assert found == [found[0]] * len(found)

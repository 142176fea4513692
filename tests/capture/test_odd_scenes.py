"""Scenes with values that are wrong, or that images do not follow: what is said of them, and that the rest is exact."""

import numpy as np
import pytest

import usdsdg as rep
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.poses.transforms import up_axis
from usdsdg_physics.parse.scene import read_gravity
from usdsdg_physics.parse.units import Units

CAMERA = """def Camera "Cam" {
    float focalLength = 50
    float horizontalAperture = 20
    double3 xformOp:translate = (0, 0, 10)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    %s
}
"""
CUBE = """def Cube "%s" (prepend apiSchemas = ["SemanticsLabelsAPI:class"]) {
    token[] semantics:labels:class = ["box"]
    double size = 1
    %s
}
"""


def placed(x, order='["xformOp:translate"]'):
    return f"double3 xformOp:translate = ({x}, 0, 0)\n    uniform token[] xformOpOrder = {order}"


@pytest.fixture
def attach(tmp_path):
    """A function that opens a stage with this text and attaches annotators to its camera."""

    def attach(text, *names, head=""):
        file = tmp_path / "stage.usda"
        file.write_text(f"#usda 1.0\n(\n{head}\n)\n{text}")
        rep.open_stage(str(file))
        product = rep.create.render_product("/Cam", (32, 32))
        annotators = [rep.annotators.get(name) for name in names]
        for annotator in annotators:
            annotator.attach(product)
        return annotators

    return attach


def step():
    rep.orchestrator.step(delta_time=0.0)


@pytest.mark.parametrize("head", ["", "startTimeCode = 0\nendTimeCode = 24\ntimeCodesPerSecond = 24"])
def test_a_prim_with_an_unknown_xform_op_is_named_and_stays_out_of_every_frame(attach, head):
    broken = CUBE % ("Broken", placed(1, '["xformOp:translate", "xformOp:nope"]'))
    boxes, depth = attach(
        CAMERA % "" + broken + CUBE % ("Good", placed(-1)), "bounding_box_3d", "distance_to_camera", head=head
    )
    with pytest.warns(UsdsdgWarning, match="/Broken: its xformOps cannot be read: Invalid xform opType token 'nope'"):
        step()
    for time in (0.0, 0.0, 0.5):
        assert boxes.get_data()["info"]["primPaths"] == ["/Good"]
        assert not np.isfinite(depth.get_data()[:, 16:]).any()
        get_timeline().set_current_time(time)
        step()


def test_points_with_equal_ids_are_objects_of_their_own(attach):
    points = """def PointInstancer "P" {
    rel prototypes = [</P/A>]
    int[] protoIndices = [0, 0, 0]
    int64[] ids = [5, 5, 6]
    point3f[] positions = [(-1, 0, 0), (1, 0, 0), (0, 1.2, 0)]
    %s
}
"""
    boxes, masks = attach(CAMERA % "" + points % (CUBE % ("A", "")), "bounding_box_3d", "instance_segmentation")
    with pytest.warns(UsdsdgWarning, match="/P: some of its ids are equal"):
        step()
    data = boxes.get_data()
    assert data["info"]["primPaths"] == ["/P/A[0]", "/P/A[1]", "/P/A[2]"]
    np.testing.assert_allclose(data["data"]["transform"][:, 3, :2], [[-1, 0], [1, 0], [0, 1.2]])
    assert len(np.unique(masks.get_data()["data"])) == 4, "three objects before the background"


def test_clipping_planes_are_named(attach):
    attach(CAMERA % "float4[] clippingPlanes = [(1, 0, 0, 0)]" + CUBE % ("A", ""), "distance_to_camera")
    with pytest.warns(UsdsdgWarning, match="/Cam: clippingPlanes cut nothing off"):
        step()


def test_the_exposure_of_a_camera_is_named_where_there_is_a_color_image(attach, recwarn):
    light = 'def DomeLight "Dome" {\n}\n'
    attach(CAMERA % "float exposure = 3" + light + CUBE % ("A", ""), "distance_to_camera")
    step()
    assert not [each for each in recwarn if "exposure" in str(each.message)]
    attach(CAMERA % "float exposure:iso = 800" + light + CUBE % ("A", ""), "rgb")
    with pytest.warns(UsdsdgWarning, match="/Cam: color images do not follow exposure:iso: .*/rtx/post/tonemap"):
        step()


@pytest.mark.parametrize(
    ("words", "said", "boxes_of"),
    [
        ('uniform token purpose = "renders"', "/Odd: purpose 'renders' is none of default, render, proxy, guide", []),
        ('uniform token orientation = "lefthanded"', "/Odd: orientation 'lefthanded' is none of rightHanded", ["/Odd"]),
        ('uniform token subdivisionScheme = "catmull"', "/Odd: subdivisionScheme 'catmull' is none of", ["/Odd"]),
    ],
)
def test_a_word_that_usd_does_not_know_is_named(attach, words, said, boxes_of):
    plate = f"""def Mesh "Odd" (prepend apiSchemas = ["SemanticsLabelsAPI:class"]) {{
        token[] semantics:labels:class = ["plate"]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
        {words}
    }}\n"""
    (boxes,) = attach(CAMERA % "" + plate, "bounding_box_3d")
    with pytest.warns(UsdsdgWarning, match=said):
        step()
    assert boxes.get_data()["info"]["primPaths"] == boxes_of


def test_a_projection_that_usd_does_not_know_is_perspective_and_named(attach):
    (depth,) = attach(CAMERA % 'token projection = "orthografic"' + CUBE % ("Cube", ""), "distance_to_camera")
    with pytest.warns(UsdsdgWarning, match="/Cam: projection 'orthografic' is neither perspective nor orthographic"):
        step()
    assert depth.get_data()[16, 16] == pytest.approx(0.095, rel=1e-3)  # of centimeters


@pytest.mark.parametrize(("authored", "used"), [("z", "Z"), ("X", "Y"), ("", "Y"), ("up", "Y")])
def test_an_up_axis_that_is_none_is_named(attach, authored, used):
    """Python's "XYZ".index raised for "z", and took the first axis for the empty word."""
    attach(CAMERA % "" + CUBE % ("Cube", ""), "rgb", head=f'upAxis = "{authored}"')
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match=f"upAxis '{authored}' is neither 'Y' nor 'Z'; '{used}' is used"):
        assert up_axis(current_stage()) == used
    gravity = read_gravity(current_stage(), None, Units(meters=1.0, kilograms=1.0))
    assert gravity == ((0.0, 0.0, -9.81) if used == "Z" else (0.0, -9.81, 0.0))


@pytest.mark.parametrize("value", ["0", "-2", "nan", "inf"])
def test_a_unit_of_mass_that_is_none_is_named(attach, value):
    attach(CAMERA % "" + CUBE % ("Cube", ""), "rgb", head=f"kilogramsPerUnit = {value}")
    with pytest.warns(UsdsdgWarning, match="kilogramsPerUnit .* is not a mass; 1 is used"):
        assert Units.of(current_stage()).kilograms == 1.0

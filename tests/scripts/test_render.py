"""`usdsdg render` on ordinary stages: without camera, without light, in any unit."""

import hashlib
import json

import numpy as np
import pytest
from PIL import Image

from tests.scripts.conftest import usdsdg

STAGE = """#usda 1.0
(
    metersPerUnit = {unit}
    upAxis = "{up}"
)
def Xform "Things"
{{
    def Cube "Cube"
    {{
        double size = {size}
    }}
    {more}
}}
"""
SMALL = ("--width=64", "--height=48", "--spp=8")


def write(folder, *, unit=1.0, up="Z", size=1.0, more=""):
    (folder / "scene.usda").write_text(STAGE.format(unit=unit, up=up, size=size, more=more))


@pytest.mark.parametrize(("unit", "up", "size"), [(1.0, "Z", 1e-4), (0.01, "Y", 100.0), (1.0, "Y", 1e6)])
def test_a_stage_without_camera_and_light_is_shown_whole_and_lit(tmp_path, unit, up, size):
    write(tmp_path, unit=unit, up=up, size=size)
    before = hashlib.sha256((tmp_path / "scene.usda").read_bytes()).hexdigest()
    done = usdsdg("render", "scene.usda", "out", *SMALL, cwd=tmp_path)
    assert "no camera: this image shows everything" in done.stderr
    assert "no light: a plain sky and a sun" in done.stderr
    assert hashlib.sha256((tmp_path / "scene.usda").read_bytes()).hexdigest() == before

    depth = np.load(tmp_path / "out" / "distance_to_image_plane_0000.npy")
    rows, columns = np.nonzero(np.isfinite(depth))
    # The whole cube is visible, away from the border, and large.
    assert 0 < rows.min() < rows.max() < 47
    assert 0 < columns.min() < columns.max() < 63
    assert len(rows) > 0.1 * depth.size
    # The gray cube is neither black nor overexposed, and its sides differ.
    image = np.array(Image.open(tmp_path / "out" / "rgb_0000.png"))[rows, columns, :3].mean(axis=1)
    assert image.min() > 40
    assert image.max() < 250
    assert np.ptp(np.percentile(image, [10, 90])) > 30


def test_a_camera_and_a_light_of_the_stage_are_used_as_they_are(tmp_path):
    more = """
    def Camera "Eye"
    {
        float2 clippingRange = (0.01, 100)
        double3 xformOp:translate = (0, 0, 6)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def DomeLight "Sky"
    {
    }
    """
    write(tmp_path, more=more)
    done = usdsdg("render", "scene.usda", "out", *SMALL, cwd=tmp_path)
    assert "the stage has no" not in done.stderr
    params = json.loads((tmp_path / "out" / "camera_params_0000.json").read_text())
    assert np.array(params["cameraViewTransform"]).reshape(4, 4)[3, 2] == -6


def test_a_wrong_camera_is_an_error_that_lists_the_cameras_of_the_stage(tmp_path):
    write(tmp_path, more='def Camera "Eye" {}\n    def Xform "Box" {}')
    for path, problem in (("/Things/Box", "is a Xform without a camera in it"), ("/Nope", "is not on the stage")):
        done = usdsdg("render", "scene.usda", "out", f"--camera={path}", *SMALL, cwd=tmp_path, expect=1)
        assert f"{path} {problem}; cameras on the stage: /Things/Eye" in done.stderr


@pytest.mark.parametrize(
    ("option", "message"), [("--time=nan", "--time nan is not a time code"), ("--camera=", "is not on")]
)
def test_invalid_options_are_refused(tmp_path, option, message):
    write(tmp_path)
    done = usdsdg("render", "scene.usda", "out", option, *SMALL, cwd=tmp_path, expect=1)
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_an_image_that_is_too_large_is_refused(tmp_path):
    write(tmp_path)
    done = usdsdg("render", "scene.usda", "out", "--width=100000", "--height=100000", cwd=tmp_path, expect=1)
    assert "error: render_product: an image of 100000 x 100000 pixels cannot be made" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("out/*.png"))


def test_a_closed_hall_seen_from_outside_is_black_with_a_warning(tmp_path):
    lamp = 'def SphereLight "Lamp" {\nfloat inputs:intensity = 5000\n}\n'
    write(tmp_path, size=10.0, more=lamp)
    stderr = usdsdg("render", "scene.usda", "out", *SMALL, cwd=tmp_path).stderr
    assert np.array(Image.open(tmp_path / "out" / "rgb_0000.png"))[..., :3].max() == 0
    assert "the image is black: no light reaches what /" in stderr
    write(tmp_path, size=10.0, more=lamp + 'def DomeLight "Sky" {\nfloat inputs:intensity = 500\n}\n')
    assert "black" not in usdsdg("render", "scene.usda", "out", *SMALL, cwd=tmp_path).stderr


def test_lights_that_are_too_dim_for_the_exposure_are_named(tmp_path):
    write(tmp_path, more='def DomeLight "Sky" {\n}\n')  # with USD's intensity of 1
    stderr = usdsdg("render", "scene.usda", "out", *SMALL, cwd=tmp_path).stderr
    assert np.array(Image.open(tmp_path / "out" / "rgb_0000.png"))[..., :3].max() <= 2
    assert "its brightest pixel has 1 nits, and white is 1,500" in stderr
    assert "inputs:intensity or inputs:exposure of /Things/Sky;" in stderr
    assert "no light reaches" not in stderr

"""DataVisualizationWriter: boxes where the annotators say that they are, on the wanted background."""

import numpy as np
import pytest
from PIL import Image

from tests.annotators.ray_caster import add_cube, known, make_frame, new_stage
from tests.annotators.scenes import add_camera, mask_of
from usdsdg import annotators, writers
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings

PRODUCT = "/Render/HydraTextures/rp1"
GREEN, RED = (0, 128, 0, 255), (255, 0, 0, 255)


def seen_from(*eye):
    stage = new_stage()
    add_cube(stage, "/World/Cube", "cube", rotate=(10, 20, 30))
    add_camera(stage, "/World/Eye", eye, (0, 0, 0))
    return make_frame(stage, (64, 48), camera="/World/Eye")


@pytest.fixture(scope="module")
def cube():
    return seen_from(-2, -2, 4)


def write(folder, frame, **options):
    """Return the pictures by file name."""
    writer = writers.get("DataVisualizationWriter", init_params={"output_dir": str(folder), **options})
    writer.attach(known(PRODUCT))
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.backend.wait_until_done()
    return {path.name: np.array(Image.open(path)) for path in folder.rglob("*.png")}


def extent(mask):
    rows, columns = np.nonzero(mask)
    return [columns.min(), rows.min(), columns.max(), rows.max()]


def test_rectangles_are_drawn_on_the_inclusive_edge_pixels(cube, tmp_path):
    pictures = write(tmp_path, cube, bounding_box_2d_tight=True, bounding_box_2d_tight_params={"outline": "red"})
    picture = pictures["bounding_box_2d_tight_fast_0000.png"]
    assert picture.shape == (48, 64, 4)
    red = (picture == RED).all(axis=2)
    assert (picture[~red] == 0).all()  # transparent
    left, top, right, bottom = extent(mask_of(cube, "/World/Cube"))
    assert extent(red) == [left, top, right, bottom]
    assert red.sum() == 2 * (right - left) + 2 * (bottom - top)


def test_edges_of_3d_boxes_enclose_the_cube(cube, tmp_path):
    picture = write(tmp_path, cube, bounding_box_3d=True)["bounding_box_3d_fast_0000.png"]
    drawn = (picture == GREEN).all(axis=2)
    # A cube fills its own box, so its mask and the lines end at the same pixels, up to rounding.
    assert np.abs(np.subtract(extent(drawn), extent(mask_of(cube, "/World/Cube")))).max() <= 1
    assert 60 < drawn.sum() < 600


def test_edges_behind_the_camera_are_left_out(tmp_path):
    picture = write(tmp_path, seen_from(0.1, 0.1, 0.2), bounding_box_3d=True)["bounding_box_3d_fast_0000.png"]
    assert np.isfinite(picture).all()
    assert picture.shape == (48, 64, 4)


def test_backgrounds_are_pictures_of_the_same_frame(cube, tmp_path):
    pictures = write(
        tmp_path,
        cube,
        bounding_box_2d_loose=True,
        bounding_box_2d_loose_params={"background": "rgb", "outline": [1, 2, 3], "width": 2},
        bounding_box_3d=True,
        bounding_box_3d_params={"background": "normals", "fill": "#010203"},
        frame_padding=2,
    )
    assert sorted(pictures) == ["bounding_box_2d_loose_fast_00.png", "bounding_box_3d_fast_00.png"]
    rgb, normals = pictures["bounding_box_2d_loose_fast_00.png"], pictures["bounding_box_3d_fast_00.png"]
    inside = mask_of(cube, "/World/Cube") & (rgb[..., :3] != (1, 2, 3)).any(axis=2)
    assert (rgb[inside] == np.asarray(cube.aovs["LdrColor"])[inside]).all()
    inside = mask_of(cube, "/World/Cube") & (normals[..., :3] != (1, 2, 3)).any(axis=2)
    expected = (np.asarray(cube.aovs["normals"])[inside][:, :3] * 0.5 + 0.5) * 255
    assert np.abs(normals[inside][:, :3] - expected).max() <= 1


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"outline": "greenish"}, "outline 'greenish' is no color that Pillow knows"),
        ({"fill": (1, 2)}, r"fill \(1, 2\) is no color"),
        ({"outline": [0.5, 0, 1]}, r"outline \[0.5, 0, 1\] is no color"),
        ({"width": 1.5}, "width is 1.5; expected a whole number"),
        ({"width": -1}, "width is -1; expected"),
    ],
)
def test_styles_that_pillow_cannot_draw_are_refused_at_once(cube, tmp_path, params, message):
    with pytest.raises(WriterError, match=message):
        write(tmp_path, cube, bounding_box_2d_tight=True, bounding_box_2d_tight_params=params)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"background": "depth"}, "background 'depth' is none of rgb, normals, so the picture is transparent"),
        ({"outline": "red"}, "'outline' has no effect; known are background, fill, width"),
    ],
)
def test_parameters_without_effect_are_named_and_ignored(cube, tmp_path, params, message):
    forget_warnings()
    plain = write(tmp_path / "plain", cube, bounding_box_3d=True)
    with pytest.warns(UsdsdgWarning, match=message):
        found = write(tmp_path / "given", cube, bounding_box_3d=True, bounding_box_3d_params=params)
    for name, picture in plain.items():
        np.testing.assert_array_equal(found[name], picture)

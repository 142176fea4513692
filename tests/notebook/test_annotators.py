"""What notebooks show of annotators and render products."""

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

import usdsdg as rep
from usdsdg.annotators.colors import colors_of_ids

SIZE = (96, 64)


@pytest.fixture
def product(stage):
    rep.create.cube(semantics=[("class", "<b>crate</b>")])
    rep.create.light(light_type="Dome", intensity=1000)
    return rep.create.render_product(rep.create.camera(position=(0, -4, 0), look_at=(0, 0, 0)), SIZE)


def attached(product, name):
    annotator = rep.annotators.get(name)
    annotator.attach(product)
    return annotator


def decoded(png: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(png)))


def image_in(html: str) -> np.ndarray:
    data = re.search(r"data:image/png;base64,([^\"]+)", html)
    assert data is not None
    return decoded(base64.b64decode(data[1]))


def test_color_is_the_picture_itself(product):
    rgb = attached(product, "rgb")
    rep.orchestrator.step()
    assert np.array_equal(decoded(rgb._repr_png_()), rgb.get_data()[..., :3])
    assert np.array_equal(image_in(rgb._repr_html_()), rgb.get_data()[..., :3])


@pytest.mark.parametrize("name", ["instance_segmentation", "semantic_segmentation"])
def test_masks_have_the_colors_of_their_ids(product, name):
    masks = attached(product, name)
    rep.orchestrator.step()
    ids = masks.get_data()["data"]
    assert len(np.unique(ids)) == 2
    assert np.array_equal(decoded(masks._repr_png_()), colors_of_ids(ids.ravel()).reshape(*ids.shape, 4)[..., :3])


def test_depth_is_colored_and_its_scale_is_told(product):
    depth = attached(product, "distance_to_camera")
    rep.orchestrator.step()
    shown = image_in(depth._repr_html_())
    assert (shown[~np.isfinite(depth.get_data())] == 0).all()
    assert (shown[np.isfinite(depth.get_data())] > 0).any(axis=1).all()
    assert "red 3.50 m" in depth._repr_html_()


def test_boxes_are_drawn_over_the_color_of_the_same_product(product):
    boxes, rgb = attached(product, "bounding_box_2d_tight"), attached(product, "rgb")
    rep.orchestrator.step()
    before, drawn = rgb.get_data()[..., :3].astype(int), decoded(boxes._repr_png_()).astype(int)
    changed = np.abs(drawn - before).max(axis=2) > 8
    assert changed.any()
    assert not changed[:, :3].any()
    box = boxes.get_data()["data"][0]
    assert changed[(box["y_min"] + box["y_max"]) // 2, box["x_min"] - 1 : box["x_min"] + 2].any()


def test_tables_have_labels_and_prims_and_escape_them(product):
    boxes = attached(product, "bounding_box_3d")
    rep.orchestrator.step()
    html = boxes._repr_html_()
    assert "&lt;b&gt;crate&lt;/b&gt;" in html
    assert "<b>crate" not in html
    assert "/Replicator/Cube" in html
    assert boxes._repr_png_() is None  # edges are projected by a camera, and none is attached


def test_solids_are_drawn_where_the_camera_is_held_too(product):
    boxes, camera = attached(product, "bounding_box_3d"), attached(product, "camera_params")
    rep.orchestrator.step()
    assert decoded(boxes._repr_png_()).std() > 1
    assert "cameraFocalLength" in camera._repr_html_()


def test_points_are_a_table(product):
    points = attached(product, "pointcloud")
    rep.orchestrator.step()
    assert points._repr_png_() is None
    assert "and " in points._repr_html_()


def test_nothing_is_computed_to_show_an_annotator(product):
    rgb = attached(product, "rgb")
    assert rgb._repr_png_() is None
    assert "nothing yet" in rgb._repr_html_()
    assert "not attached" in rep.annotators.get("normals")._repr_html_()


@pytest.mark.filterwarnings("ignore:PtMultiMatte")
def test_every_annotator_has_html_before_and_after_a_frame(product):
    # These need a second camera and an attribute.
    names = set(rep.annotators.get_registered_annotators()) - {
        "cross_correspondence",
        "CrossCorrespondence",
        "Attribute",
    }
    annotators = {name: attached(product, name) for name in names}
    assert all("nothing yet" in each._repr_html_() for each in annotators.values())
    rep.orchestrator.step()
    for name, each in annotators.items():
        html = each._repr_html_()
        assert name in html
        assert "nothing yet" not in html
        assert html.count("<div") == html.count("</div>")
        assert ("<img" in html) == (each._repr_png_() is not None)


def test_a_render_product_shows_what_its_annotators_hold(product):
    assert "640" not in product._repr_html_()
    assert "no annotator holds a picture" in product._repr_html_()
    assert product._repr_png_() is None
    rgb = attached(product, "rgb")
    attached(product, "camera_params")
    rep.orchestrator.step()
    assert f"{SIZE[0]} x {SIZE[1]}" in product._repr_html_()
    assert np.array_equal(decoded(product._repr_png_()), rgb.get_data()[..., :3])

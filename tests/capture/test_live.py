"""Annotators between captures: what the application shows after its latest update, rendered when it is read."""

import numpy as np
import pytest
from pxr import UsdGeom

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.capture import capture
from usdsdg.compat.omni.syntheticdata.synthetic_data import SyntheticData
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.semantics.labels import add_labels


@pytest.fixture
def cube(stage):
    UsdGeom.Cube.Define(stage, "/World/cube").CreateSizeAttr(1.0)
    return UsdGeom.Xformable(stage.GetPrimAtPath("/World/cube")).AddTranslateOp()


@pytest.fixture
def product(cube):
    return rep.create.render_product(rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0)), (9, 9))


def depth_of(product):
    annotator = rep.annotators.get("distance_to_image_plane")
    annotator.attach(product)
    return annotator


def test_an_annotator_has_no_data_before_the_first_update(product):
    assert depth_of(product).get_data().size == 0


def test_an_update_of_a_stopped_timeline_shows_the_stage(product):
    depth = depth_of(product)
    get_app().update()
    assert depth.get_data()[4, 4] == pytest.approx(4.5)


def test_an_edit_shows_after_the_next_update_only(product, cube):
    depth = depth_of(product)
    rep.orchestrator.step()
    cube.Set((0, 0, 1))
    assert depth.get_data()[4, 4] == pytest.approx(4.5)
    get_app().update()
    assert depth.get_data()[4, 4] == pytest.approx(3.5)


def test_nothing_is_rendered_again_where_nothing_has_changed(product, monkeypatch):
    depth = depth_of(product)
    rep.orchestrator.step()
    get_app().update()
    monkeypatch.setattr(capture.Capture, "show", lambda *_, **__: pytest.fail("rendered again"))
    assert depth.get_data()[4, 4] == pytest.approx(4.5)


def test_the_time_of_a_playing_timeline_is_that_of_the_image(product):
    rep.orchestrator.set_capture_on_play(False)
    time = rep.annotators.get("ReferenceTime")
    time.attach(product)
    get_timeline().play()
    for _ in range(6):
        get_app().update()
    got = time.get_data()
    assert got["referenceTimeNumerator"] / got["referenceTimeDenominator"] == pytest.approx(6 / 60, abs=1e-6)


def test_reading_does_not_count_as_a_captured_frame(product):
    seen = []
    depth = depth_of(product)
    writer = rep.writers.get("BasicWriter")
    assert writer is not None
    get_app().update()
    depth.get_data()
    from usdsdg.app.frame_loop import get_orchestrator

    get_orchestrator().on_captured(lambda: seen.append(1))
    assert get_orchestrator().captures == 0
    assert not seen


def test_a_disabled_product_keeps_its_image(product, cube):
    depth = depth_of(product)
    get_app().update()
    assert depth.get_data().shape == (9, 9)
    product.set_updates_enabled(False)
    cube.Set((0, 0, 1))
    get_app().update()
    assert np.isclose(depth.get_data()[4, 4], 4.5)


def test_annotators_of_a_product_that_opts_out_do_not_capture_a_playing_timeline(product):
    from usdsdg.app.frame_loop import get_orchestrator

    product.captured_on_play = False
    depth = depth_of(product)
    get_timeline().play()
    get_app().update()
    assert get_orchestrator().captures == 0
    assert depth.get_data().shape == (9, 9)


def test_a_product_that_is_enabled_again_shows_what_has_changed_meanwhile(product, cube):
    depth = depth_of(product)
    get_app().update()
    assert depth.get_data()[4, 4] == pytest.approx(4.5)
    product.set_updates_enabled(False)
    cube.Set((0, 0, 1))
    get_app().update()
    depth.get_data()
    product.set_updates_enabled(True)
    get_app().update()
    assert depth.get_data()[4, 4] == pytest.approx(3.5)


def test_a_setting_that_decides_labels_shows_after_the_next_update(stage, product):
    add_labels(stage.GetPrimAtPath("/World/cube"), {"class": ["box"], "color": ["red"]})
    semantics = rep.annotators.get("semantic_segmentation").attach(product)
    get_app().update()
    assert {"class": "box", "color": "red"} in semantics.get_data()["info"]["idToLabels"].values()
    SyntheticData.Get().set_instance_mapping_semantic_filter("color:*")
    get_app().update()
    assert {"color": "red"} in semantics.get_data()["info"]["idToLabels"].values()


def test_ids_between_captures_are_those_of_captured_frames(stage):
    camera = rep.create.camera(position=(0, 0, 9), look_at=(0, 0, 0))
    product = rep.create.render_product(camera, (60, 40))
    names = ("instance_segmentation", "instance_id_segmentation")
    annotators = [rep.annotators.get(name).attach(product) for name in names]
    # The objects come up in another order than that of the stage.
    for name, x in (("b", -1.5), ("d", 1.5)):
        _labeled_cube(stage, f"/World/{name}", x)
    rep.orchestrator.step()
    for name, x in (("a", -0.8), ("c", 0.8)):
        _labeled_cube(stage, f"/World/{name}", x)
    stage.GetPrimAtPath("/World").SetChildrenReorder(["a", "b", "c", "d"])

    rep.orchestrator.step()
    captured = [each.get_data()["info"]["idToLabels"] for each in annotators]
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World/a")).SetTranslate((-0.7, 0, 0))
    get_app().update()
    shown = [each.get_data()["info"]["idToLabels"] for each in annotators]

    assert all(len(table) >= 5 for table in captured)
    assert shown == captured


def _labeled_cube(stage, path, x):
    prim = UsdGeom.Cube.Define(stage, path).GetPrim()
    UsdGeom.XformCommonAPI(prim).SetTranslate((x, 0, 0))
    UsdGeom.XformCommonAPI(prim).SetScale((0.2, 0.2, 0.2))
    add_labels(prim, {"class": [path[-1]]})

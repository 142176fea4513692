"""Annotators between captures: what the application shows after its latest update, rendered when it is read."""

import numpy as np
import pytest
from pxr import UsdGeom

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.capture import capture
from usdsdg.session.timeline import get_timeline


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

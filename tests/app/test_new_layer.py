"""Render products of `new_layer`, and what is attached to them, when the layer is begun again."""

import pytest

import usdsdg as rep
from tests.app.counting import Counting
from usdsdg.errors import UsdsdgWarning


def test_products_of_a_layer_that_is_begun_again_have_the_same_names_and_no_earlier_readers(stage):
    kept = rep.create.render_product(rep.create.camera(), (8, 8), name="kept")
    outside = rep.annotators.get("camera_params").attach(kept)
    writers, annotators = [], []
    for _ in range(2):
        with rep.new_layer():
            products = [rep.create.render_product(rep.create.camera(), (8, 8), name=name) for name in (None, "mine")]
        assert [each.path for each in products] == [
            "/Render/HydraTextures/Replicator", "/Render/HydraTextures/mine",
        ]  # fmt: skip
        writers.append(Counting())
        writers[-1].attach([*products, kept])
        annotators.append(rep.annotators.get("camera_params").attach(products[0]))
        rep.orchestrator.step()
    first, second = writers
    # The first writer still has the product that is not of the layer.
    assert [len(each.times) for each in writers] == [2, 1]
    assert first._render_products == (kept.path,)
    assert second._render_products == (*(each.path for each in products), kept.path)
    assert [each.is_attached for each in (*annotators, outside)] == [False, True, True]


def test_products_of_other_layers_stay(stage):
    camera = rep.create.camera()
    with rep.new_layer("Mine"):
        mine = rep.create.render_product(camera, (8, 8))
    for _ in range(2):
        with rep.new_layer():
            rep.create.cube()
    frames = Counting()
    frames.attach(mine)
    rep.orchestrator.step()
    assert len(frames.times) == 1


def test_a_writer_that_loses_its_product_before_it_got_a_frame_is_named(stage):
    with rep.new_layer():
        Counting().attach(rep.create.render_product(rep.create.camera(), (8, 8)))
    with (
        pytest.warns(UsdsdgWarning, match="got no frame of /Render/HydraTextures/Replicator"),
        rep.new_layer(),
    ):
        rep.create.cube()

"""Annotators that watch some of the render products of a writer, and writers by render product."""

import pytest

import usdsdg as rep
from usdsdg.errors import ArgumentError, WriterRegistryError


class Seen(rep.Writer):
    def __init__(self):
        self.annotators = [
            rep.annotators.get("rgb", render_product_idxs=[0]),
            rep.annotators.get("distance_to_camera", render_product_idxs=[1]),
        ]
        self.payloads = []

    def write(self, data):
        self.payloads.append(data)


@pytest.fixture
def products(stage):
    camera = rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0))
    return [rep.create.render_product(camera, (8, 8), name=name) for name in ("One", "Two")]


def test_annotators_of_a_writer_deliver_only_the_products_that_they_chose(products):
    writer = Seen()
    writer.attach(products)
    rep.orchestrator.step()
    (payload,) = writer.payloads
    assert {key for key in payload if "-" in key} == {"rgb-One", "distance_to_camera-Two"}
    writer.detach_from(products[0])
    rep.orchestrator.step()
    assert [key for key in writer.payloads[1] if key.startswith(("rgb", "distance"))] == ["distance_to_camera"]


def test_an_annotator_attaches_to_the_product_that_it_chose(products):
    annotator = rep.annotators.get("rgb", render_product_idxs=[1])
    assert annotator.attach(products).render_product == products[1].path
    assert rep.annotators.get("rgb").attach(products, render_product_idxs=[0]).render_product == products[0].path
    with pytest.raises(ArgumentError, match="there is no render product 2, of 2 counted from 0"):
        rep.annotators.get("rgb", render_product_idxs=[2]).attach(products)
    with pytest.raises(ValueError, match="no render product"):
        annotator.attach([])
    with pytest.raises(ValueError, match="device is 'invalid'"):
        annotator.get_data(device="invalid")


def test_writers_are_found_by_their_render_products(products):
    other = rep.create.render_product("/Replicator/Camera_Xform/Camera", (4, 4), name="Other")
    writer = Seen()
    writer.attach(products)
    registry = rep.WriterRegistry
    for given in (products[0], products, products[0].path, None):
        assert registry.get_attached_writers(given) == {"Seen": writer}
        assert registry.get_attached_writer("Seen", given) is writer
    assert registry.get_attached_writers(other) == {}
    with pytest.raises(WriterRegistryError, match="No writer is attached"):
        registry.get_attached_writer("Seen", [other])


def test_normals_are_png_whatever_the_format_of_pictures(products, tmp_path):
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), rgb=True, normals=True, image_output_format="jpg")
    writer.attach(products[0])
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert {"normals_0000.png", "rgb_0000.jpg"} <= {path.name for path in tmp_path.iterdir()}


def test_label_types_and_a_predicate_exclude_each_other(tmp_path):
    with pytest.raises(ValueError, match="exclude each other"):
        rep.writers.get("BasicWriter").initialize(
            output_dir=str(tmp_path), semantic_types=["class"], semantic_filter_predicate="class:*"
        )


def test_a_group_of_backends_takes_them_by_position(tmp_path):
    parts = [rep.backends.get("DiskBackend", init_params={"output_dir": str(tmp_path / name)}) for name in "ab"]
    group = rep.backends.get("BackendGroup")
    group.initialize(parts)
    group.schedule(group.write_blob, data=b"x", path="f.txt")
    group.wait_until_done()
    assert [(tmp_path / name / "f.txt").read_bytes() for name in "ab"] == [b"x", b"x"]


def test_the_registry_detaches_the_writers_of_a_product_from_all_of_theirs(products):
    first, second = products
    both, other = Plain(), Plain()
    both.attach((first, second.path))
    other.attach(second)
    rep.WriterRegistry.detach("Plain", render_products=first)
    assert (both.render_products, other.render_products) == ((), (second.path,))
    rep.WriterRegistry.detach("Plain", [first])
    assert rep.WriterRegistry.get_attached_writers() == {"Plain": other}


class Plain(rep.Writer):
    def __init__(self):
        self.annotators = ["rgb"]

    def write(self, data):
        pass

"""What every registered writer promises."""

import json

import numpy as np
import pytest
from PIL import Image

from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators, writers

# Options that make a writer write as much as it can.
OPTIONS = {
    "BasicWriter": dict.fromkeys(["rgb", "semantic_segmentation", "bounding_box_3d", "camera_params", "normals"], True),
    "PoseWriter": {"write_debug_images": True},
}
PRODUCT = "/Render/HydraTextures/rp"


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (40, 30), filters=["class:*"])


def run(name, folder, frame, count=3):
    writer = writers.get(name)
    writer.initialize(output_dir=str(folder), **OPTIONS[name])
    writer.attach(known(PRODUCT))
    try:
        for _ in range(count):
            writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        writer.on_final_frame()
        writer.backend.wait_until_done()
    finally:
        writer.detach()
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_every_writer_is_tried():
    assert set(OPTIONS) == set(writers.get_writers())


@pytest.mark.parametrize("name", OPTIONS)
def test_the_same_frames_give_the_same_bytes(name, frame, tmp_path):
    assert run(name, tmp_path / "a", frame) == run(name, tmp_path / "b", frame)


@pytest.mark.parametrize("name", OPTIONS)
def test_every_file_can_be_read(name, frame, tmp_path):
    written = run(name, tmp_path, frame)
    assert written
    for path in tmp_path.rglob("*"):
        if path.suffix == ".png":
            with Image.open(path) as image:
                assert image.size == (40, 30)
                image.load()
        elif path.suffix == ".npy":
            np.load(path)
        elif path.is_file():
            json.loads(path.read_text())


@pytest.mark.parametrize("name", OPTIONS)
def test_no_frame_overwrites_another(name, frame, tmp_path):
    sizes = [len(run(name, tmp_path / str(count), frame, count)) for count in (1, 2, 3)]
    assert sizes[2] - sizes[1] == sizes[1] - sizes[0] > 0


@pytest.mark.parametrize("name", OPTIONS)
def test_nothing_temporary_is_left(name, frame, tmp_path):
    assert not [path for path in run(name, tmp_path, frame) if path.rsplit("/", 1)[-1].startswith(".")]

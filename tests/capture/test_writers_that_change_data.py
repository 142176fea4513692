"""Writers of scripts may change what they are handed: files, annotators, other writers and later frames stay whole."""

import json

import numpy as np
import pytest
from PIL import Image

import usdsdg as rep
from usdsdg.writers.backends.io_queue import IoQueue

FRAMES = 3


@pytest.fixture
def product(stage):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "cube")])
    return rep.create.render_product(rep.create.camera(position=(4, 0, 2), look_at=(0, 0, 0)), (16, 12))


def own_writer(folder, products):
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir=str(folder), rgb=True, bounding_box_2d_tight=True)
    writer.attach(products)


class Blackens(rep.WriterRegistry.get("BasicWriter").__class__):
    """A BasicWriter that changes everything once it has stored it."""

    def write(self, data):
        super().write(data)
        for seen in data["annotators"]["rgb"].values():
            seen["data"][...] = 0
        for seen in data["annotators"]["bounding_box_2d_tight_fast"].values():
            seen["data"]["x_min"] = -1
            seen["idToLabels"].clear()


class DrawsLater(rep.Writer):
    """Schedules a picture and a growing list, then draws into the one and appends to the other."""

    def __init__(self, folder):
        self.backend = rep.backends.DiskBackend(str(folder))
        self.annotators = ["rgb"]
        self.means = []

    def write(self, data):
        number = len(self.means)
        self.backend.write_image(f"plain_{number}.png", data["rgb"])
        self.backend.schedule(rep.functional.write_json, path=f"means_{number}.json", data={"means": self.means})
        data["rgb"][...] = number
        self.means.append(number)


def pictures(folder, name):
    return [np.asarray(Image.open(folder / f"{name}_{k}.png")) for k in range(FRAMES)]


def test_what_a_subclass_of_a_writer_changes_is_its_own(product, tmp_path):
    Blackens(output_dir=str(tmp_path / "a"), rgb=True, bounding_box_2d_tight=True).attach(product)
    own_writer(tmp_path / "b", product)
    watching = rep.annotators.get("rgb", do_array_copy=False).attach(product)
    for _ in range(FRAMES):
        rep.orchestrator.step()
        assert watching.get_data().any()
    rep.orchestrator.wait_until_complete()
    for file in (tmp_path / "b").glob("*.*"):
        if file.suffix in (".png", ".npy"):
            assert (tmp_path / "a" / file.name).read_bytes() == file.read_bytes(), file.name
    for k in range(FRAMES):
        labels = json.loads((tmp_path / "b" / f"bounding_box_2d_tight_labels_{k:04d}.json").read_text())
        assert labels == {"0": {"class": "cube"}}


def test_what_is_scheduled_is_written_as_it_was(product, tmp_path, monkeypatch):
    """Also where the queue comes to it after the frame."""
    jobs = []
    monkeypatch.setattr(IoQueue, "submit", lambda queue, run, **about: jobs.append(run))
    writer = DrawsLater(tmp_path)
    writer.attach(product)
    watching = rep.annotators.get("rgb").attach(product)
    expected = []
    for _ in range(FRAMES):
        rep.orchestrator.step()
        expected.append(watching.get_data())
    for job in jobs:
        job()
    np.testing.assert_array_equal(pictures(tmp_path, "plain"), expected)
    for k in range(FRAMES):
        assert json.loads((tmp_path / f"means_{k}.json").read_text()) == {"means": list(range(k))}

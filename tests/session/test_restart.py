"""A new session in a process that has made a dataset: that one has ended, as when a process ends."""

import json
import os

import pytest

import usdsdg as rep
from tests.writers.journal.test_folders import recipe
from usdsdg.session import session
from usdsdg.session.session import current
from usdsdg.stage import assets
from usdsdg.stage.assets import anchors
from usdsdg.writers.journal import journal
from usdsdg.writers.journal.earlier_run import Mode


@pytest.fixture
def dataset(stage, tmp_path):
    """The folder of a dataset of one frame, whose writer is still attached; its run goes on."""
    current().run.begin(recipe(), Mode.NEW, None)
    camera = rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0))
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "car")])
    writer = rep.writers.get("CocoWriter")
    writer.initialize(output_dir=str(tmp_path / "out"), semantic_types=["class"])
    writer.attach(rep.create.render_product(camera, (16, 16)))
    rep.orchestrator.step(delta_time=0.0)
    yield tmp_path / "out"
    session.restart()


def test_a_new_session_ends_the_dataset_of_the_one_before(dataset):
    session.restart()
    told = journal.read(dataset / ".usdsdg/journal.jsonl")
    assert (told.frames, told.is_complete) == ({0}, True)
    (annotations,) = (each for each in dataset.rglob("*.json") if each.parent.name != ".usdsdg")
    assert len(json.loads(annotations.read_text())["images"]) == 1


def test_a_new_session_forgets_from_where_files_were_named(tmp_path, monkeypatch):
    file = tmp_path / "part.usda"
    file.write_text("#usda 1.0\n")
    monkeypatch.chdir(tmp_path)
    assets.locate("part.usda")
    assert anchors.portable(str(file)) == "<here>/part.usda"
    session.restart()
    assert anchors.portable(str(file)) == str(file)


def test_a_copy_of_the_process_leaves_the_dataset_to_the_other(dataset):
    pid = os.fork()
    if pid == 0:
        try:
            session.restart()
        finally:
            os._exit(0)
    os.waitpid(pid, 0)
    assert not journal.read(dataset / ".usdsdg/journal.jsonl").is_complete

"""Writers that are not due at every frame, or whose products are off: parts and runs that go on are the whole."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import usdsdg as rep
from tests.capture.part_runs import cut, differences, folders, run, run_again, run_parts
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.workers.plan import plan
from usdsdg.writers.journal import journal, recipe
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.parts import join_parts

FRAMES = 6


def scene():
    """Author a labeled cube that moves; return a render product."""
    cube = rep.create.cube(semantics=[("class", "cube")])
    camera = rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))
    with rep.trigger.on_frame(), cube:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
    return rep.create.render_product(camera, (32, 24))


def attach(folder: Path, product: object, **options: object) -> None:
    """Attach a writer of labels."""
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(folder), bounding_box_2d_tight=True)
    writer.attach(product, **options)


def some_frames(folder: Path) -> None:
    """Capture with a writer of all frames, one of every other, and one that is attached late."""
    product = scene()
    attach(folder / "all", product)
    attach(folder / "other", product, trigger=rep.trigger.on_frame(interval=2))
    for frame in range(FRAMES):
        get_settings().set("/usdsdg/test/frame", frame)
        if frame == 4:
            attach(folder / "late", product)
        rep.orchestrator.step()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(some_frames, folder)
    return folder


def frames(folder: Path) -> set[int]:
    return journal.read(folder / ".usdsdg/journal.jsonl").frames


@pytest.mark.parametrize(("name", "first"), [("all", 0), ("other", 0), ("late", 4)])
def test_each_recipe_tells_the_settings_at_the_first_frame_of_its_dataset(whole, name, first):
    told = recipe.read(whole / name)["settings"]
    assert told == {recipe.SEED_SETTING: 1, "/usdsdg/test/frame": first}


@pytest.mark.parametrize("portions", [("4:6", "0:1", "1:2", "2:4"), ("1/2", "0/2"), ("0:3", "3:")])
def test_parts_of_writers_that_are_not_due_at_all_frames_are_joined(whole, portions, tmp_path):
    run_parts(some_frames, tmp_path, *portions)
    assert differences(tmp_path, whole) == []
    assert frames(tmp_path / "other") == {0, 2, 4}
    assert frames(tmp_path / "late") == {4, 5}


def test_a_run_of_such_writers_goes_on(whole, tmp_path):
    run_again(some_frames, tmp_path / "again", whole, 3)
    assert differences(tmp_path / "again", whole) == []


@pytest.mark.parametrize("lacking", [1, 2])
def test_processes_go_on_with_a_run_whose_datasets_end_at_different_frames(whole, lacking, tmp_path):
    """lacking: how many frames less of one are in its journal, as where the process died between the two."""
    folder = tmp_path / "again"
    shutil.copytree(whole, folder)
    for home in folders(folder):
        cut(home, 4 - lacking if home.name == "other" else 4)
    places = [FolderPlace(home) for home in folders(folder)]
    for part in plan(places, FRAMES, 2):
        run(some_frames, folder, Portion.of_frames(part.frames), Mode.RESUME)
    for place in places:
        join_parts(place)
    assert differences(folder, whole) == []


def test_one_frame_that_no_part_has_made_is_told_in_the_singular(tmp_path):
    for text in ("0:2", "3:6"):
        run(some_frames, tmp_path, Portion.of_frames(text))
    with pytest.raises(rep.errors.DatasetError, match="frame 2 is in no part; make it with --frames"):
        join_parts(FolderPlace(tmp_path / "all"))


def test_a_frame_that_no_part_has_made_is_told(tmp_path):
    for text in ("0:2", "5:6"):
        run(some_frames, tmp_path, Portion.of_frames(text))
    with pytest.raises(rep.errors.DatasetError, match="frames 2, 3, 4 are in no part"):
        join_parts(FolderPlace(tmp_path / "all"))
    with pytest.raises(rep.errors.DatasetError, match="frame"):
        join_parts(FolderPlace(tmp_path / "late"))


def in_one_folder(folder: Path) -> None:
    """Capture with writers in one folder, of which the first one is due at every third frame."""
    product = scene()
    for kind, options in (("KittiWriter", {"trigger": rep.trigger.on_frame(interval=3)}), ("PoseWriter", {})):
        writer = rep.writers.get(kind)
        writer.initialize(output_dir=str(folder))
        writer.attach(product, **options)
    for _ in range(FRAMES):
        rep.orchestrator.step()


@pytest.mark.filterwarnings("ignore:.*is written to by several writers")
@pytest.mark.parametrize("portions", [("4:6", "1:4", "0:1"), ("1/2", "0/2")])
def test_parts_of_writers_in_one_folder_are_joined(portions, tmp_path):
    run(in_one_folder, tmp_path / "whole")
    run_parts(in_one_folder, tmp_path / "parts", *portions)
    assert differences(tmp_path / "parts", tmp_path / "whole") == []
    run_again(in_one_folder, tmp_path / "again", tmp_path / "whole", 4)
    assert differences(tmp_path / "again", tmp_path / "whole") == []


def products_off(folder: Path) -> None:
    """Capture, at times with all render products off."""
    product = scene()
    attach(folder, product)
    for frame in range(FRAMES):
        product.hydra_texture.set_updates_enabled(frame % 3 != 1)
        rep.orchestrator.step()


def test_frames_with_all_products_off_are_whole(tmp_path):
    """They never were, so that no later frame came into the journal."""
    run(products_off, tmp_path / "whole")
    found = journal.read(tmp_path / "whole/.usdsdg/journal.jsonl")
    assert found.is_complete
    assert found.frames == set(range(FRAMES))
    assert len(list((tmp_path / "whole").glob("*.npy"))) == 4
    run_parts(products_off, tmp_path / "parts", "0:2", "2:5", "5:6")
    run_again(products_off, tmp_path / "again", tmp_path / "whole", 3)
    assert differences(tmp_path / "parts", tmp_path / "whole") == []
    assert differences(tmp_path / "again", tmp_path / "whole") == []


def test_a_folder_may_be_claimed_while_journals_are_appended_to(tmp_path, monkeypatch):
    """It was "dictionary changed size during iteration" at random, where a writer's first frame came late."""
    append = DatasetFolder.append

    def claiming(self, frames):
        append(self, frames)
        current().run.claim(str(tmp_path / "third"))

    def script(folder: Path) -> None:
        product = scene()
        for name in ("first", "second"):
            attach(folder / name, product)
        rep.orchestrator.step()
        current().io_queue.wait_until_done()
        current().run.append()

    monkeypatch.setattr(DatasetFolder, "append", claiming)
    run(script, tmp_path)
    assert frames(tmp_path / "first") == frames(tmp_path / "second") == {0}


def late_class(folder: Path) -> None:
    """Capture with a class that comes up in the third frame."""
    attach(folder, scene())
    for frame in range(FRAMES):
        if frame == 2:
            rep.create.sphere(semantics=[("class", "late")], position=(0, 1, 0))
        rep.orchestrator.step()


@pytest.mark.parametrize("portions", [("2:6", "0:2"), ("0:2", "2:6"), ("1/2", "0/2")])
def test_a_class_that_comes_up_late_is_in_the_joined_table(portions, tmp_path):
    """The part that was made last had written the table of its frames alone."""
    run(late_class, tmp_path / "whole")
    run_parts(late_class, tmp_path / "parts", *portions)
    assert differences(tmp_path / "parts", tmp_path / "whole") == []
    assert '"late"' in (tmp_path / "whole/.usdsdg/classes.json").read_text()


def test_processes_that_go_on_keep_the_classes_of_the_one_before(tmp_path):
    run(late_class, tmp_path / "whole")
    shutil.copytree(tmp_path / "whole", tmp_path / "again")
    cut(tmp_path / "again", 5)
    place = FolderPlace(tmp_path / "again")
    for part in plan([place], 5, 2):
        run(late_class, tmp_path / "again", Portion.of_frames(part.frames), Mode.RESUME)
    join_parts(place)
    assert '"late"' in (tmp_path / "again/.usdsdg/classes.json").read_text()

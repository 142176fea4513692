"""The removal of an earlier run, ended at each of its operations: what goes on leaves the bytes of a run of its own."""

import errno
import json
import os
import pathlib

import pytest

from tests.cli.datasets import content
from tests.writers.journal.test_folders import recipe, run, write_frame
from usdsdg.errors import DatasetInTheWay, OutputNotWritable
from usdsdg.writers.journal import earlier_files, journal
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.places.place import REMOVING, FolderPlace
from usdsdg.writers.journal.portion import Portion

pytestmark = pytest.mark.filterwarnings("ignore:.*the files of the earlier run:UserWarning")
CHANGES = [(os, "truncate"), (os, "unlink"), (os, "replace"), (os, "rmdir"), (pathlib.Path, "unlink")]


class Ended(BaseException):
    """Ctrl-C, or a process that is killed."""


@pytest.fixture
def end_at(monkeypatch):
    """A function that lets the n-th change of the disk raise `Ended` before it is done."""
    left = [-1]

    def counted(change):
        def changed(*arguments, **named):
            left[0] -= 1
            if left[0] == 0:
                raise Ended
            return change(*arguments, **named)

        return changed

    for owner, name in CHANGES:
        monkeypatch.setattr(owner, name, counted(getattr(owner, name)))
    return lambda number: left.__setitem__(0, number)


def make(path, mode, portion=None):
    """Make the frames that are not there."""
    folder = DatasetFolder(FolderPlace(path), recipe(), mode, portion)
    first, end = (0, 4) if portion is None else (portion.first, portion.last)
    for number in range(first, end):
        if not folder.has(number):
            write_frame(folder, number)
    folder.close(complete=True)


@pytest.mark.parametrize("mode", [Mode.NEW, Mode.OVERWRITE, Mode.REPLACE])
def test_a_run_that_was_to_be_replaced_can_be_resumed_wherever_its_removal_was_ended(mode, tmp_path, end_at):
    make(tmp_path / "whole", Mode.NEW)
    whole = content(tmp_path / "whole")
    for number in range(1, 200):
        path = tmp_path / f"{number}"
        make(path, Mode.NEW)
        (path / "notes.txt").write_text("mine")
        end_at(number)
        try:
            DatasetFolder(FolderPlace(path), recipe(), mode, None).release()
            break
        except Ended:
            pass
        finally:
            end_at(-1)
        make(path, Mode.RESUME)
        assert content(path) == whole | {"notes.txt": b"mine"}, f"ended at operation {number}"
    assert 10 < number < 199


def test_a_part_that_was_to_be_replaced_can_be_resumed_wherever_its_removal_was_ended(tmp_path, end_at):
    portion = Portion(0, 3)
    make(tmp_path / "whole", Mode.NEW, portion)
    whole = content(tmp_path / "whole")
    for number in range(1, 200):
        path = tmp_path / f"{number}"
        make(path, Mode.NEW, portion)
        end_at(number)
        try:
            DatasetFolder(FolderPlace(path), recipe(), Mode.REPLACE, portion).release()
            break
        except Ended:
            pass
        finally:
            end_at(-1)
        make(path, Mode.RESUME, portion)
        assert content(path) == whole, f"ended at operation {number}"
    assert 3 < number < 199


def test_names_that_a_removal_has_left_do_not_cost_a_later_run_its_files(tmp_path):
    run(tmp_path, frames=(0, 1))
    kept = tmp_path / ".usdsdg" / REMOVING
    kept.write_text(json.dumps("0.png") + "\n")
    going_on = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.RESUME, None)
    going_on.release()
    assert going_on.has(1)
    assert (tmp_path / "0.png").exists()
    assert not kept.exists()


@pytest.mark.parametrize("text", ["", "no JSON\n", '"../outside.txt"\n', '[1]\n"0.png"\n', "\0"])
def test_a_damaged_file_of_names_removes_nothing_outside(text, tmp_path):
    (tmp_path / "outside.txt").write_text("mine")
    run(tmp_path / "out", frames=(0,))
    (tmp_path / "out/.usdsdg" / REMOVING).write_text(text)
    run(tmp_path / "out", Mode.OVERWRITE, frames=(1,))
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"1.png", ".usdsdg"}
    assert (tmp_path / "outside.txt").exists()


def test_a_full_disk_can_be_made_room_on(tmp_path, monkeypatch):
    run(tmp_path, frames=(0, 1))
    monkeypatch.setattr(earlier_files, "_keep_names", lambda *_: False)
    run(tmp_path, Mode.OVERWRITE, frames=(0,))
    assert {path.name for path in tmp_path.iterdir()} == {"0.png", ".usdsdg"}


def test_a_run_of_another_recipe_goes_on_with_a_removal_that_was_interrupted(tmp_path, end_at):
    make(tmp_path / "whole", Mode.NEW)
    whole, resumed = content(tmp_path / "whole"), set()
    for number in range(1, 200):
        path = tmp_path / f"{number}"
        run(path, frames=(0, 1), arguments=["earlier"])
        end_at(number)
        try:
            DatasetFolder(FolderPlace(path), recipe(), Mode.OVERWRITE, None).release()
            break
        except Ended:
            pass
        finally:
            end_at(-1)
        try:
            make(path, Mode.RESUME)
        except DatasetInTheWay:
            # Nothing was removed yet, so that the earlier run goes on, or stays.
            assert {"0.png", "1.png"} <= content(path).keys()
            assert max(journal.read(path / ".usdsdg/journal.jsonl").frames) == 1
        else:
            resumed.add(number)
            assert content(path) == whole, f"ended at operation {number}"
    assert len(resumed) > 5


@pytest.mark.parametrize("owner", [os, pathlib.Path])
def test_a_file_of_an_earlier_run_that_cannot_be_removed_is_named(owner, tmp_path, monkeypatch):
    run(tmp_path, frames=(0,))
    unlink = owner.unlink

    def refuse(path, **named):
        if str(path).endswith("recipe.json"):
            raise PermissionError(errno.EPERM, "Operation not permitted", str(path))
        unlink(path, **named)

    monkeypatch.setattr(owner, "unlink", refuse)
    with pytest.raises(OutputNotWritable, match=r"recipe\.json cannot be written: this user may not write there"):
        run(tmp_path, Mode.OVERWRITE, frames=(1,))
    monkeypatch.setattr(owner, "unlink", unlink)
    run(tmp_path, Mode.OVERWRITE, frames=(1,))
    assert {path.name for path in tmp_path.iterdir()} == {"1.png", ".usdsdg"}

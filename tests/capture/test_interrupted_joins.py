"""Processes of --workers that die while parts are joined, and processes without parts that find some."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import usdsdg as rep
from tests.capture.part_runs import differences, folders, run, run_parts
from usdsdg.errors import DatasetInTheWay, UsdsdgWarning
from usdsdg.session import session
from usdsdg.session.session import current
from usdsdg.workers.dataset import make_claimed
from usdsdg.writers import parts
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import Recipe

FRAMES, PORTIONS = 4, ("0:2", "2:4")


def two_datasets(folder: Path) -> None:
    """Write two datasets of labels."""
    cube = rep.create.cube(semantics=[("class", "cube")])
    product = rep.create.render_product(rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0)), (32, 24))
    with rep.trigger.on_frame(), cube:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
    for name in ("a", "b"):
        writer = rep.writers.get("KittiWriter")
        writer.initialize(output_dir=str(folder / name))
        writer.attach(product)
    for _ in range(FRAMES):
        rep.orchestrator.step()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(two_datasets, folder)
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return datasets of which all parts are made, and none is joined."""
    folder = tmp_path_factory.mktemp("made")
    for text in PORTIONS:
        run(two_datasets, folder, Portion.of_frames(text))
    return folder


def go_on(folder: Path, make: Callable[..., None]) -> None:
    """Do what `--workers 2 --resume` does once it knows the datasets."""
    make_claimed(claimed(folder), FRAMES, 2, make)
    session.restart()


def claimed(folder: Path) -> list[DatasetFolder]:
    """Claim and release the datasets, as it does before it plans their parts."""
    session.restart()
    current().run.begin(
        Recipe("python", {"name": "script.py", "sha256": "1"}, device="cpu", seed=None), Mode.RESUME, None
    )
    current().run.shares_out = True
    for home in folders(folder):
        current().run.claim(str(home))
    found = current().run.folders
    current().run.release()
    session.restart()
    return found


class Died(BaseException):
    """What ends a process."""


def die(*_: object, **__: object) -> None:
    """End the process."""
    raise Died


def remake_no_frame(wanted, tick):
    assert wanted == []


def test_two_processes_that_begin_at_once_do_not_plan_the_same_parts(whole, made, tmp_path):
    folder = tmp_path / "out"
    shutil.copytree(made, folder)
    (folder / "a/.usdsdg/.workers.lock").touch()  # of a process that died
    first = claimed(folder)
    with pytest.raises(DatasetInTheWay, match=r"another process is writing to this dataset \(.*\.workers\.lock\)"):
        claimed(folder)
    make_claimed(first, FRAMES, 2, remake_no_frame)
    session.restart()
    assert differences(folder, whole) == []
    assert not list(folder.rglob("*.lock"))


@pytest.mark.parametrize("where", ["before the second", "before it is closed", "before the rest is removed"])
def test_datasets_are_joined_by_the_next_process(where, whole, made, tmp_path, monkeypatch):
    folder = tmp_path / "out"
    shutil.copytree(made, folder)
    if where == "before the second":
        parts.join_parts(FolderPlace(folder / "a"))
    else:
        patched = (parts, "finish_run") if where == "before it is closed" else (shutil, "rmtree")
        with monkeypatch.context() as patch:
            patch.setattr(*patched, die)
            with pytest.raises(Died):
                parts.join_parts(FolderPlace(folder / "a"))
        current().run.release()
    go_on(folder, remake_no_frame)
    assert differences(folder, whole) == []


def test_a_process_alone_does_not_make_frames_of_parts_again(whole, made, tmp_path):
    shutil.copytree(made, tmp_path / "out")
    with pytest.raises(DatasetInTheWay, match="--workers N --resume"):
        run(two_datasets, tmp_path / "out", mode=Mode.RESUME)
    go_on(tmp_path / "out", remake_no_frame)
    assert differences(tmp_path / "out", whole) == []


def test_a_process_alone_goes_on_where_parts_have_no_frames(whole, tmp_path):
    run(two_datasets, tmp_path, Portion.of_frames("0:2"))
    for each in tmp_path.rglob("parts/*/journal.jsonl"):
        each.write_bytes(b"")  # as where the process has died before its first frame was whole
    run(two_datasets, tmp_path, mode=Mode.RESUME)
    assert differences(tmp_path, whole) == []


def test_joined_parts_are_gone_when_a_process_alone_ends_the_dataset(whole, made, tmp_path, monkeypatch):
    shutil.copytree(made, tmp_path / "out")
    for name in ("a", "b"):
        with monkeypatch.context() as patch:
            patch.setattr(parts, "finish_run", die)
            with pytest.raises(Died):
                parts.join_parts(FolderPlace(tmp_path / "out" / name))
        current().run.release()
    run(two_datasets, tmp_path / "out", mode=Mode.RESUME)
    assert differences(tmp_path / "out", whole) == []


def test_joined_in_one_go(whole, tmp_path):
    run_parts(two_datasets, tmp_path, *PORTIONS)
    assert differences(tmp_path, whole) == []


def test_files_that_whole_datasets_have_lost_are_named(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "out")
    (tmp_path / "out/a/.usdsdg/classes.json").unlink()
    with pytest.warns(UsdsdgWarning, match=r"a: missing or changed: \.usdsdg/classes\.json about all frames"):
        go_on(tmp_path / "out", remake_no_frame)
    assert differences(tmp_path / "out", whole) == ["a/.usdsdg/classes.json"]

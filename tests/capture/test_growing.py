"""A dataset to which frames are added has the bytes of one that was made with all of them at once."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.capture import part_runs
from tests.capture.part_runs import differences, folders
from tests.capture.test_parts_of_writers import (
    FRAMES,
    OTHERS,
    PICTURES,
    POSES,
    SHARDS,
    Died,
    Table,
    dying,
    moving,
)
from tests.cli.datasets import content
from tests.sampled_cases import in_soak, sampled
from usdsdg.errors import DatasetInTheWay, WriterError
from usdsdg.verify.integrity.integrity import check
from usdsdg.writers.formats.shards.reopened import restore_samples
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.growth import MoreFrames, fewer
from usdsdg.writers.journal.portion import Portion

SOME: Table = {name: (PICTURES | OTHERS | SHARDS)[name] for name in ("coco", "yolo", "webdataset", "parquet")}
# What a process is about to do when it dies, by what it has written last.
STEPS = {
    "samples": "usdsdg.writers.journal.journal.Journal.append",
    "journal": "usdsdg.writers.journal.recipe.Recipe.write",
    "recipe": "usdsdg.writers.journal.folders.remove_unfinished",
}
MOST = 4  # frames after which most things have happened


def by_argument(wanted, earlier, folder):
    """Return what keeps a run from growing whose argument is the number of frames."""
    mine, theirs = int(wanted.arguments[0]), int(earlier.arguments[0])
    return "" if mine > theirs else fewer(str(theirs), str(mine))


def made(table, folder, frames, mode=Mode.NEW, portion=None, script=None):
    growth = MoreFrames(by_argument, restore_samples)
    part_runs.run(script or moving(table, frames), folder, portion, mode, [str(frames)], growth)


@pytest.mark.parametrize(
    "table",
    [*(pytest.param(table, marks=in_soak) for table in (PICTURES, POSES, OTHERS, SHARDS)), SOME],
    ids=["pictures", "poses", "others", "shards", "some"],
)
def test_frames_are_added_as_if_they_had_been_made_at_once(table, tmp_path):
    made(table, tmp_path / "whole", FRAMES)
    for frames in (1, MOST):
        grown = tmp_path / f"from_{frames}"
        made(table, grown, frames)
        made(table, grown, FRAMES, Mode.RESUME)
        assert differences(grown, tmp_path / "whole") == [], f"from {frames} frames"
        made(table, grown, FRAMES, Mode.RESUME)
        assert differences(grown, tmp_path / "whole") == [], "resumed once more"


@pytest.fixture(scope="module")
def whole_and_early(tmp_path_factory):
    """The datasets of all frames, and of some."""
    folder = tmp_path_factory.mktemp("grown")
    made(SOME, folder / "whole", FRAMES)
    made(SOME, folder / "early", 2)
    return folder / "whole", folder / "early"


@pytest.mark.parametrize(
    ("place", "again"), sampled([(place, again) for place in (*STEPS, "frames") for again in (2, FRAMES)], 4)
)
def test_growth_that_is_interrupted_loses_nothing(whole_and_early, place, again, tmp_path, monkeypatch):
    whole, early = whole_and_early
    out = tmp_path / "out"
    shutil.copytree(early, out)

    def die(*_, **__):
        raise Died

    script = dying(SOME, MOST) if place == "frames" else None
    with monkeypatch.context() as patch:
        if place in STEPS:
            patch.setattr(STEPS[place], die)
        with pytest.raises(Died):
            made(SOME, out, FRAMES, Mode.RESUME, script=script)
    if again == 2 and place in ("recipe", "frames"):
        with pytest.raises(DatasetInTheWay, match="removes none"):
            made(SOME, out, 2, Mode.RESUME)
        again = FRAMES
    made(SOME, out, again, Mode.RESUME)
    assert differences(out, whole if again == FRAMES else early) == []


def test_a_dataset_does_not_become_smaller_and_parts_do_not_grow(whole_and_early, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(whole_and_early[1], out)
    with pytest.raises(DatasetInTheWay, match="removes none"):
        made(SOME, out, 1, Mode.RESUME)
    with pytest.raises(DatasetInTheWay, match="one part of it alone cannot grow"):
        made(SOME, out, FRAMES, Mode.RESUME, Portion(2, FRAMES))
    with pytest.raises(DatasetInTheWay, match="--resume makes those that are missing"):
        made(SOME, out, FRAMES)
    assert differences(out, whole_and_early[1]) == []
    parts = tmp_path / "parts"
    made(SOME, parts, 2, portion=Portion(0, 1))
    before = content(parts)
    with pytest.raises(DatasetInTheWay, match="parts that are not joined"):
        made(SOME, parts, FRAMES, Mode.RESUME)
    assert content(parts) == before


def lose_end(home: Path, lines: int) -> None:
    """Let a journal lose its last lines, of which one is cut off."""
    path = home / ".usdsdg/journal.jsonl"
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:-lines]) + b'{"fra')


@pytest.mark.parametrize("lines", sampled([2, 1, 4]))
def test_samples_of_shards_are_there_again_where_a_journal_has_lost_its_end(whole_and_early, lines, tmp_path):
    whole, early = whole_and_early
    grown, same = shutil.copytree(early, tmp_path / "grown"), shutil.copytree(whole, tmp_path / "same")
    for name in ("webdataset", "parquet"):
        lose_end(same / name, lines)
        lose_end(grown / name, min(lines, 2))
    made(SOME, same, FRAMES, Mode.RESUME)
    assert differences(same, whole) == []
    made(SOME, grown, FRAMES, Mode.RESUME)
    assert differences(grown, whole) == []


@pytest.mark.parametrize("frames", [2, FRAMES])
def test_samples_of_shards_are_there_again_where_going_on_with_a_whole_dataset_was_interrupted(
    whole_and_early, frames, tmp_path
):
    """As earlier versions left it: its journal is of an unfinished run, of which the samples are gone."""
    whole, early = whole_and_early
    out = shutil.copytree(early, tmp_path / "out")
    for name in ("webdataset", "parquet"):
        path = out / name / ".usdsdg/journal.jsonl"
        path.write_text(path.read_text().replace('"complete":true', '"complete":false'))
    made(SOME, out, frames, Mode.RESUME)
    assert differences(out, whole if frames == FRAMES else early) == []


@pytest.mark.parametrize("damage", ["changed", "missing"])
@pytest.mark.parametrize("shard", ["webdataset/train-000000.tar", "parquet/data/train-00000.parquet"])
def test_shards_that_were_damaged_do_not_grow(whole_and_early, shard, damage, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(whole_and_early[1], out)
    data = bytearray((out / shard).read_bytes())
    data[700] ^= 1
    (out / shard).write_bytes(data)
    if damage == "missing":
        (out / shard).unlink()
    with pytest.raises(WriterError, match=f"{shard} is missing or is not as the run has left it"):
        made(SOME, out, FRAMES, Mode.RESUME)
    if damage == "changed":
        found = check(out / Path(shard).parts[0])
        assert found is not None
        assert [fault.file for fault in found.faults] == ["/".join(Path(shard).parts[1:])]


def test_recordings_do_not_grow_since_they_name_their_recipe(tmp_path):
    pytest.importorskip("rerun")
    table: Table = {"rerun": ("RerunWriter", {}, 1)}
    made(table, tmp_path, 1)
    before = content(tmp_path)
    with pytest.raises(DatasetInTheWay, match="RerunWriter have an id of the whole recipe"):
        made(table, tmp_path, 2, Mode.RESUME)
    assert content(tmp_path) == before
    assert folders(tmp_path)

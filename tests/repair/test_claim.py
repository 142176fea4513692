"""Which datasets can be repaired, the errors for the others, and which frames are made for which damage."""

import errno
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys

import pytest

from tests.cli.datasets import ROOT
from usdsdg.errors import DatasetError, DatasetInTheWay, OutputNotWritable
from usdsdg.repair import claim
from usdsdg.repair.claim import claimed
from usdsdg.repair.summary import numbered
from usdsdg.stores import whole_file
from usdsdg.stores.locks import FileLock
from usdsdg.writers.journal.journal import Journal
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.recipe import Recipe
from usdsdg.writers.parts import join_parts

FILES = {f"{number}.png": bytes([number] * 9) for number in range(4)}
SHARED = {"table.json": b"{}"}


def facts(data: bytes) -> list:
    return [len(data), hashlib.sha256(data).hexdigest()]


@pytest.fixture
def out(tmp_path):
    """A dataset of four frames, each of one file, as a run leaves it."""
    for name, data in (FILES | SHARED).items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / ".usdsdg").mkdir()
    recipe = Recipe("run", {"name": "script.py", "sha256": ""}, device="cpu").write(tmp_path)
    journal = Journal(tmp_path / ".usdsdg/journal.jsonl")
    lines = [{"frame": number, "files": {name: facts(FILES[name])}} for number, name in enumerate(FILES)]
    journal.append(lines, {name: tuple(facts(data)) for name, data in SHARED.items()})
    journal.close(complete=True, recipe=recipe)
    return tmp_path


def raising(error):
    def fail(*_args, **_options):
        raise error

    return fail


def change(file, old, new):
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new, 1))


def unfinish(out):
    journal = out / ".usdsdg/journal.jsonl"
    journal.write_text("".join(journal.read_text().splitlines(keepends=True)[:-1]))


def cut_off(out):
    """As a process leaves it that died while it wrote a line, or a disk that lost power: zeros where data were."""
    journal = out / ".usdsdg/journal.jsonl"
    journal.write_bytes(journal.read_bytes()[:-50] + bytes(50))


def leave_part(out):
    (out / ".usdsdg/parts/0-2").mkdir(parents=True)
    (out / ".usdsdg/parts/0-2/journal.jsonl").write_bytes(b"")


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (unfinish, "is of a run that has not ended. Resume it first, with --resume"),
        (leave_part, "has parts that are not joined. Make the missing ones, and join them: usdsdg merge"),
        (lambda out: (out / ".usdsdg/journal.jsonl").unlink(), "has no journal"),
        (lambda out: (out / ".usdsdg/journal.jsonl").write_bytes(b""), "is of a run that has not ended"),
        (cut_off, "is of a run that has not ended. Resume it first, with --resume"),
        (lambda out: change(out / ".usdsdg/journal.jsonl", '"files"', '"fil'), "the journal is damaged"),
        (lambda out: change(out / ".usdsdg/journal.jsonl", "2.png", "7.png"), "its lines are not those"),
        (lambda out: (out / ".usdsdg/recipe.json").unlink(), "recipe.json is missing"),
        (lambda out: (out / ".usdsdg/recipe.json").write_bytes(b"{"), "recipe.json is no recipe"),
        (lambda out: change(out / ".usdsdg/recipe.json", "script.py", "other.py"), "was changed after the run"),
    ],
)
def test_what_cannot_be_relied_on_is_refused_with_a_remedy(out, spoil, said):
    spoil(out)
    before = sorted(out.rglob("*"))
    with pytest.raises(DatasetError, match=said), claimed(str(out), is_dry=False):
        pass
    assert sorted(out.rglob("*")) == before


def test_a_dataset_that_a_run_writes_to_is_refused(out):
    lock = FileLock(out / ".usdsdg/journal.jsonl")
    with pytest.raises(DatasetInTheWay, match="another process is writing"), claimed(str(out), is_dry=False):
        pass
    with claimed(str(out), is_dry=True):
        pass
    lock.release()
    with claimed(str(out), is_dry=False), pytest.raises(OSError, match="journal"):
        FileLock(out / ".usdsdg/journal.jsonl")


REPAIR = """
import sys
from pathlib import Path
from usdsdg.errors import DatasetError
from usdsdg.repair.damage import check_repairable
try:
    check_repairable(Path(sys.argv[1]), "out")
except DatasetError as error:
    print(error)
"""


def test_a_dataset_that_may_not_be_read_is_told(out):
    is_root = os.geteuid() == 0
    if is_root and shutil.which("setpriv") is None:
        pytest.skip("nothing is closed to root")
    rights = "-dac_override,-dac_read_search"
    prefix = ["setpriv", f"--bounding-set={rights}", f"--inh-caps={rights}"] if is_root else []
    beside = out / ".usdsdg"
    beside.chmod(0)
    try:
        command = [*prefix, sys.executable, "-c", REPAIR, str(out)]
        done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, timeout=60)
    finally:
        beside.chmod(0o700)
    assert re.fullmatch(rf"out: {beside}/\S+ cannot be read: Permission denied\. Give this user .*\n", done.stdout), (
        done
    )


def test_a_folder_that_may_not_be_written_to_is_told_without_an_output_dir(out, monkeypatch):
    denied = PermissionError(errno.EACCES, "Permission denied")
    remedy = "this user may not write there. Work on a copy of the dataset, or make this one writable"
    for module, name in ((FolderPlace, "locks"), (claim, "remove_unfinished")):
        with monkeypatch.context() as patched:
            patched.setattr(module, name, raising(denied))
            with pytest.raises(OutputNotWritable, match=remedy), claimed(str(out), is_dry=False):
                pass
    monkeypatch.setattr(FolderPlace, "locks", raising(denied))
    with pytest.raises(OutputNotWritable, match=remedy):
        join_parts(FolderPlace(out))


def test_a_file_that_may_not_be_replaced_is_told_without_an_output_dir(out, monkeypatch, tmp_path_factory):
    made = tmp_path_factory.mktemp("made")
    (made / "0.png").write_bytes(FILES["0.png"])
    (out / "0.png").unlink()
    with claimed(str(out), is_dry=False) as found, monkeypatch.context() as patched:
        patched.setattr(whole_file.os, "replace", raising(PermissionError(errno.EACCES, "Permission denied")))
        found.repair.take([made])
    assert found.repair.left["0.png"] == (
        "cannot be replaced: this user may not write there; repair again once that is put right"
    )


def test_frames_of_damaged_files_are_made_and_of_shared_ones_the_first_and_the_last(out):
    (out / "2.png").write_bytes(b"")
    with claimed(str(out), is_dry=True) as found:
        assert found.plan.numbers == {2}
    (out / "table.json").unlink()
    with claimed(str(out), is_dry=True) as found:
        assert found.plan.numbers == {0, 2, 3}
        assert not found.plan.whole
        assert [*found.lines(9)][-1] == f"{out}: 2 damaged files; frames 0, 2-3 would be made again"


def test_files_are_taken_that_are_equal_and_no_others(out, tmp_path_factory):
    made = tmp_path_factory.mktemp("made")
    for name in ("0.png", "1.png", "2.png"):
        (out / name).unlink()
    (made / "0.png").write_bytes(FILES["0.png"])
    (made / "1.png").write_bytes(FILES["2.png"])
    with claimed(str(out), is_dry=False) as found:
        found.repair.take([made / "nothing", made])
    assert found.repair.repaired == ["0.png"]
    assert found.repair.left == {
        "1.png": "is made with other bytes than the run wrote", "2.png": "was not made again",
    }  # fmt: skip
    assert (out / "0.png").read_bytes() == FILES["0.png"]
    assert not (out / "1.png").exists()
    assert not found.is_clean
    assert json.dumps(found.values())


def test_a_name_that_leaves_the_folder_is_not_written(out):
    """As in a journal that was tampered with, whose lines have the right sum."""
    beside = out.parent / "beside.png"
    beside.unlink(missing_ok=True)
    journal = out / ".usdsdg/journal.jsonl"
    *lines, closing = journal.read_text().replace('"1.png"', '"../beside.png"').splitlines(keepends=True)
    sealed = json.loads(closing) | {"lines": hashlib.sha256("".join(lines).encode()).hexdigest()}
    journal.write_text("".join(lines) + json.dumps(sealed, separators=(",", ":")) + "\n")
    made = out.parent / "made/deep"
    made.mkdir(parents=True, exist_ok=True)
    (made.parent / "beside.png").write_bytes(FILES["1.png"])
    with claimed(str(out), is_dry=False) as found:
        found.repair.take([made])
    assert "would leave" in found.repair.left["../beside.png"]
    assert not beside.exists()


@pytest.mark.parametrize(
    ("frames", "said"),
    [({4}, "frame 4"), ({0, 1, 2, 7}, "frames 0-2, 7"),
     (set(range(0, 60, 2)), "frames 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22 and more, 30 in all")],
)  # fmt: skip
def test_frames_are_named_in_runs(frames, said):
    assert numbered(frames) == said

"""Spools that have lost lines, or were changed, since they were written: neither joined nor resumed."""

import hashlib
import json
import shutil

import pytest

from tests.writers.journal.test_folders import recipe, write_frame
from usdsdg.cli.commands import merge
from usdsdg.errors import DatasetError, WriterError
from usdsdg.session import session
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.journal import journal
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.parts import join_parts
from usdsdg.writers.spool import Spool

NAMES = ("W/train.jsonl", "samples/W/train.jsonl")


@pytest.fixture(autouse=True)
def new_session():
    session.restart()
    yield
    session.restart()


def claim(path, mode=Mode.NEW, portion=None):
    return DatasetFolder(FolderPlace(path), recipe(), mode, portion)


def append(folder, name, *lines):
    """Append lines to a spool, as `Spool` does."""
    path = folder.aggregates / name
    path.parent.mkdir(parents=True, exist_ok=True)
    data = "".join(json.dumps(each) + "\n" for each in lines).encode()
    begins = not path.exists()
    with open(path, "ab") as file:
        file.write(data)
    folder.spools.add(path, data, begins=begins)


def make(path, frames, portion=None, *, end="complete", ahead=0):
    """Make frames, each with a record in two spools. ahead: records of so many frames more, which are not whole."""
    folder = claim(path, portion=portion)
    for name in NAMES:
        append(folder, name, {"kind": "TrainList"}, {"about": {"list": "train.txt"}})
    for number in [*frames, *range(frames[-1] + 1, frames[-1] + 1 + ahead)]:
        for name in NAMES:
            append(folder, name, {"frame": number, "number": number})
        if number in frames:
            write_frame(folder, number)
    if end == "killed":
        folder.release()
    else:
        folder.close(complete=end == "complete")
    return folder.aggregates


def lose_a_line(spool):
    lines = spool.read_bytes().splitlines(keepends=True)
    spool.write_bytes(b"".join([*lines[:3], *lines[4:]]))


def cut_off(spool):
    spool.write_bytes(spool.read_bytes()[:-20])


def change_a_byte(spool):
    spool.write_bytes(spool.read_bytes().replace(b'"number": 1', b'"number": 9'))


def put_a_folder(spool):
    spool.unlink()
    spool.mkdir()


DAMAGE = {
    "is missing": lambda spool: spool.unlink(),
    "is a folder": put_a_folder,
    "lost": lose_a_line,
    "cut": cut_off,
    "changed": change_a_byte,
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("how", DAMAGE)
@pytest.mark.parametrize("end", ["killed", "closed"])
def test_a_run_does_not_go_on_with_a_damaged_spool(tmp_path, end, how, name):
    spools = make(tmp_path, range(3), end=end)
    DAMAGE[how](spools / name)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(WriterError, match=f"{name} (is missing|was changed).*--overwrite"):
        claim(tmp_path, Mode.RESUME)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    make_again = claim(tmp_path, Mode.OVERWRITE)
    assert not make_again.has(0)
    make_again.release()


def test_a_run_does_not_go_on_where_labels_of_frames_would_be_lost_that_are_not_made_again(tmp_path):
    """As where the journal has lost a line: its frame is made again, and those after it are not."""
    spools = make(tmp_path, range(4), end="killed")
    path = tmp_path / ".usdsdg/journal.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(each for each in lines if b'"frame":1,' not in each))
    before = {name: (spools / name).read_bytes() for name in NAMES}
    with pytest.raises(WriterError, match=r"journal.jsonl has lost the line of frame 1, .*--overwrite"):
        claim(tmp_path, Mode.RESUME)
    assert {name: (spools / name).read_bytes() for name in NAMES} == before


@pytest.mark.parametrize("end", ["killed", "closed"])
@pytest.mark.parametrize("ahead", [0, 2])
def test_a_run_goes_on_with_whole_spools_as_often_as_it_ends(tmp_path, end, ahead):
    spools = make(tmp_path, range(3), end=end, ahead=ahead)
    for name in NAMES:
        with open(spools / name, "ab") as file:
            file.write(b'{"frame": 3, "num')  # of a process that died
    for number in (3, 4):
        folder = claim(tmp_path, Mode.RESUME)
        for name in NAMES:
            kept = [json.loads(line) for line in (spools / name).read_text().splitlines()]
            assert [line["frame"] for line in kept[2:]] == list(range(number))
            append(folder, name, {"frame": number, "number": number})
        write_frame(folder, number)
        folder.release()
    told = journal.read(tmp_path / ".usdsdg/journal.jsonl").spools
    assert told == {name: facts(spools / name) for name in NAMES}


def test_a_process_that_dies_while_it_cuts_spools_leaves_some_that_are_gone_on_with(tmp_path, monkeypatch):
    spools = make(tmp_path, [0], end="closed", ahead=2)
    with monkeypatch.context() as patched:
        patched.setattr("usdsdg.writers.journal.spool_hashes.os.truncate", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            claim(tmp_path, Mode.RESUME)
    claim(tmp_path, Mode.RESUME).release()
    claim(tmp_path, Mode.RESUME).release()
    assert all(len((spools / name).read_bytes().splitlines()) == 3 for name in NAMES)


def test_spools_without_a_whole_frame_are_begun_anew(tmp_path):
    folder = claim(tmp_path)
    append(folder, NAMES[0], {"frame": 0})
    folder.close(complete=False)
    for _ in range(2):
        folder = claim(tmp_path, Mode.RESUME)
        assert not list(folder.spools.files())
        folder.release()


def facts(file):
    data = file.read_bytes()
    return len(data), hashlib.sha256(data).hexdigest()


def test_the_journal_tells_of_the_bytes_that_spools_have(tmp_path):
    session.current().run.begin(recipe(), Mode.NEW, None)
    made = Spool(DiskBackend(tmp_path), "W/train", "TrainList")
    folder = session.current().run.claim(str(tmp_path))
    assert folder is not None
    for number in range(3):
        made.note({"list": number // 2})
        made.append(number, {"number": number})
        write_frame(folder, number)
        told = journal.read(tmp_path / ".usdsdg/journal.jsonl").spools
        assert told == {"W/train.jsonl": facts(made.path)}
    made.append(3, {"number": 3})
    assert journal.read(tmp_path / ".usdsdg/journal.jsonl").spools == told


# Parts


def parts(path):
    for first in (0, 2):
        make(path, range(first, first + 2), Portion(first, first + 2))
    return path / ".usdsdg/parts/0-2"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("how", DAMAGE)
def test_a_part_with_a_damaged_spool_is_not_joined(tmp_path, how, name):
    part = parts(tmp_path)
    DAMAGE[how](part / "aggregates" / name)
    with pytest.raises(WriterError, match=f"0-2/aggregates/{name} (is missing|was changed).*remove the folder {part} "):
        join_parts(FolderPlace(tmp_path))
    assert part.is_dir()
    shutil.rmtree(part)
    make(tmp_path, range(2), Portion(0, 2))
    assert join_parts(FolderPlace(tmp_path)) == 4


def test_a_dataset_that_is_joined_already_is_called_whole(tmp_path):
    parts(tmp_path / "set")
    assert join_parts(FolderPlace(tmp_path / "set")) == 4
    with pytest.raises(DatasetError, match=r"set has no parts to be joined: it is whole already"):
        join_parts(FolderPlace(tmp_path / "set"))
    assert merge.datasets_to_join(str(tmp_path)) == [str(tmp_path / "set")]


def test_parts_of_earlier_versions_which_tell_nothing_of_spools_are_joined(tmp_path):
    parts(tmp_path)
    for file in tmp_path.glob(".usdsdg/parts/*/journal.jsonl"):
        _, *lines, closing = map(json.loads, file.read_bytes().splitlines())
        file.write_bytes(b"".join(map(journal.encoded, [*lines, {**closing, "shared": {"a.txt": [1, "0"]}}])))
    assert join_parts(FolderPlace(tmp_path)) == 4
    told = journal.read(tmp_path / ".usdsdg/journal.jsonl")
    assert "a.txt" in told.shared
    assert told.spools == {NAMES[0]: facts(tmp_path / ".usdsdg/aggregates" / NAMES[0])}

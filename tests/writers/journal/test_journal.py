"""The journal: what it tells is on the disk, and a process that dies leaves nothing half told."""

import hashlib
import json
import os

import pytest

from usdsdg.errors import OutputNotWritable, WriterError
from usdsdg.writers.journal import journal
from usdsdg.writers.journal.journal import Journal

FACTS = (3, "ab")


def line(number, **more):
    return {"frame": number, "files": {f"{number}.png": FACTS}, **more}


def test_frames_and_shared_files_come_back(tmp_path):
    made = Journal(tmp_path / "journal.jsonl")
    made.append([line(0), line(1, state={"W-0": {"n": 2}})], {"classes.json": FACTS})
    made.append([line(2)], {"classes.json": (4, "cd")})
    found = journal.read(made.path)
    assert found.frames == {0, 1, 2}
    assert found.states == {"W-0": {"n": 2}}
    assert found.shared == {"classes.json": (4, "cd")}
    assert not found.is_complete
    made.close(complete=True)
    assert journal.read(made.path).is_complete
    lines = list(journal.lines(made.path))
    assert [each.get("frame") for each in lines] == [0, 1, 2, None]
    before = b"".join(made.path.read_bytes().splitlines(keepends=True)[:-1])
    digest = hashlib.sha256(before).hexdigest()
    assert lines[-1] == {"shared": {"classes.json": [4, "cd"]}, "frames": 3, "complete": True, "lines": digest}


def test_a_journal_that_goes_on_has_the_bytes_of_one_that_did_not_stop(tmp_path):
    whole = Journal(tmp_path / "whole.jsonl")
    whole.append([line(n) for n in range(5)], {"a": FACTS})
    whole.close(complete=True)
    first = Journal(tmp_path / "parts.jsonl")
    first.append([line(n) for n in range(2)], {"a": FACTS})
    first.close(complete=False)
    second = Journal(tmp_path / "parts.jsonl")
    assert second.contents.first_missing == 2
    second.append([line(n) for n in range(2, 5)], {})
    second.close(complete=True)
    assert second.path.read_bytes() == whole.path.read_bytes()


def test_a_line_that_a_dying_process_has_not_finished_is_dropped(tmp_path):
    path = tmp_path / "journal.jsonl"
    Journal(path).append([line(0), line(1)], {})
    whole = path.read_bytes()
    for size in range(whole.index(b"\n") + 1, len(whole)):
        path.write_bytes(whole[:size])
        assert Journal(path).contents.frames == {0}
        assert path.read_bytes() == whole[: whole.index(b"\n") + 1]


def test_a_damaged_line_in_the_middle_is_an_error(tmp_path):
    path = tmp_path / "journal.jsonl"
    Journal(path).append([line(0), line(1)], {})
    path.write_bytes(b"x" + path.read_bytes())
    with pytest.raises(WriterError, match="byte 0 is damaged"):
        Journal(path)


def test_a_full_disk_leaves_whole_lines(tmp_path, monkeypatch):
    made = Journal(tmp_path / "journal.jsonl")
    made.append([line(0)], {})
    before = made.path.read_bytes()

    def full(descriptor):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(OutputNotWritable, match="the disk is full"):
            made.append([line(1)], {})
    assert made.path.read_bytes() == before
    json.loads(before)


def test_frames_out_of_order_are_refused(tmp_path):
    made = Journal(tmp_path / "journal.jsonl")
    made.append([line(1), line(0)], {})
    with pytest.raises(WriterError, match="frame 0 after frame 1"):
        made.close(complete=True)

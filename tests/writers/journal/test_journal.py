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
    assert lines[0] == {"shared": {"classes.json": [4, "cd"]}}
    assert [each.get("frame") for each in lines] == [None, 0, 1, 2, None]
    before = b"".join(made.path.read_bytes().splitlines(keepends=True)[:-1])
    digest = hashlib.sha256(before).hexdigest()
    assert lines[-1] == {"shared": {}, "frames": 3, "complete": True, "lines": digest}


def test_a_journal_that_goes_on_has_the_bytes_of_one_that_did_not_stop(tmp_path):
    whole = Journal(tmp_path / "whole.jsonl")
    whole.append([line(n) for n in range(5)], {"a": FACTS})
    whole.close(complete=True)
    first = Journal(tmp_path / "parts.jsonl")
    first.append([line(n) for n in range(2)], {"a": FACTS})
    first.close(complete=False)
    second = Journal(tmp_path / "parts.jsonl")
    assert second.contents.end == 2
    second.append([line(n) for n in range(2, 5)], {})
    second.close(complete=True)
    assert second.path.read_bytes() == whole.path.read_bytes()


def test_names_of_files_that_are_no_utf8_come_back(tmp_path):
    path = tmp_path / "journal.jsonl"
    name = os.fsdecode(b"caf\xe9.png")
    kept = Journal(path)
    kept.append([{"frame": 0, "files": {name: (1, "0"), "café.png": (2, "0")}}], {os.fsdecode(b"\xff.py"): (3, "0")})
    kept.close(complete=True)
    found = journal.read(path)
    assert found.is_complete
    assert list(found.shared) == [os.fsdecode(b"\xff.py")]
    assert [list(line["files"]) for line in journal.lines(path) if "frame" in line] == [[name, "café.png"]]


def test_a_line_that_a_dying_process_has_not_finished_is_dropped(tmp_path):
    path = tmp_path / "journal.jsonl"
    Journal(path).append([line(0), line(1)], {})
    whole = path.read_bytes()
    for size in range(whole.index(b"\n") + 1, len(whole)):
        path.write_bytes(whole[:size])
        assert Journal(path).contents.frames == {0}
        assert path.read_bytes() == whole[: whole.index(b"\n") + 1]


FACTS_OF_RUN = {"settings": {"/a": 1}, "writers": {"W-0": {}}}


def test_a_run_goes_on_with_all_that_it_told_of_no_frame_where_the_closing_line_is_damaged(tmp_path):
    path = tmp_path / "journal.jsonl"
    made = Journal(path)
    made.append([line(0), line(1)], {"metadata.txt": FACTS}, FACTS_OF_RUN, spools={"W/a.jsonl": FACTS})
    made.close(complete=False, kept={"W/a.jsonl": FACTS}, spools={"W/a.jsonl": FACTS})
    whole = path.read_bytes()
    closing = len(whole.splitlines(keepends=True)[-1])
    for size in range(1, closing + 1):
        path.write_bytes(whole[:-size])
        found = Journal(path).contents
        assert found.frames == {0, 1}
        assert found.shared == {"metadata.txt": FACTS, ".usdsdg/aggregates/W/a.jsonl": FACTS}
        assert (found.facts, found.spools) == (FACTS_OF_RUN, {"W/a.jsonl": FACTS})


def closed_by_an_earlier_version(path):
    """Write a journal of which the closing line has all that belongs to no frame."""
    closing = {"shared": {"metadata.txt": FACTS, ".usdsdg/aggregates/W/a.jsonl": FACTS}, "frames": 2, "complete": False}
    lines = [line(0), line(1), {**closing, "facts": FACTS_OF_RUN, "recipe": "r", "lines": "l"}]
    path.write_bytes(b"".join(map(journal.encoded, lines)))


def test_a_journal_that_an_earlier_version_has_closed_is_read_or_refused_where_that_line_is_damaged(tmp_path):
    path = tmp_path / "journal.jsonl"
    closed_by_an_earlier_version(path)
    found = journal.read(path)
    assert (found.frames, found.facts, found.spools) == ({0, 1}, FACTS_OF_RUN, {"W/a.jsonl": FACTS})
    with open(path, "ab") as file:
        file.write(journal.encoded(line(2)))  # of a run that went on, after which nothing is known of spools
    assert journal.read(path).spools == {}
    assert journal.read(path).shared["metadata.txt"] == FACTS
    closed_by_an_earlier_version(path)
    path.write_bytes(path.read_bytes()[:-37])
    with pytest.raises(WriterError, match=r"closing line is damaged.*--overwrite"):
        Journal(path)


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


def closed(path, frames=4):
    made = Journal(path)
    made.append([line(number) for number in range(frames)], {"a.txt": FACTS})
    made.close(complete=True)
    return path.read_bytes().splitlines(keepends=True)


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (lambda lines: [*lines[:2], *lines[3:]], "it has the lines of 3 frames, and 4 were written"),
        (lambda lines: [*lines[:2], lines[1], *lines[2:]], "the line of frame 0 comes after that of frame 0"),
        (lambda lines: [lines[0], lines[2], lines[1], *lines[3:]], "the line of frame 0 comes after that of frame 1"),
    ],
    ids=["lost", "doubled", "exchanged"],
)
def test_a_journal_whose_lines_are_not_those_that_were_written_is_not_gone_on_with(tmp_path, edit, said):
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b"".join(edit(closed(path))))
    before = path.read_bytes()
    with pytest.raises(WriterError, match=f"{said}.*put a copy of the journal back .* --overwrite"):
        Journal(path)
    assert path.read_bytes() == before


def test_a_frame_whose_line_is_lost_is_not_appended_after_later_ones(tmp_path):
    path = tmp_path / "journal.jsonl"
    lines = closed(path)
    path.write_bytes(b"".join([*lines[:2], *lines[3:-1]]))
    made = Journal(path)
    assert [made.has(number) for number in range(4)] == [True, False, True, True]
    with pytest.raises(WriterError, match="has lost the line of frame 1"):
        made.append([line(1)], {})


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError])
def test_an_append_that_is_ended_is_told_again(tmp_path, monkeypatch, error):
    """Also what Python would still have in a buffer: that is not written after the journal was cut."""
    made = Journal(tmp_path / "journal.jsonl")
    made.append([line(0)], {})

    def end(file):
        raise error

    with monkeypatch.context() as patched:
        patched.setattr(journal, "synced", end)
        with pytest.raises((KeyboardInterrupt, OutputNotWritable)):
            made.append([line(1), line(2)], {"a.txt": FACTS})
    assert not made.has(1)
    assert journal.read(made.path).frames == {0}
    made.append([line(1), line(2)], {"a.txt": FACTS})
    made.close(complete=True)
    told = journal.read(made.path)
    assert (told.frames, told.is_complete, told.shared) == ({0, 1, 2}, True, {"a.txt": FACTS})


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        (lambda path: path.unlink(), OutputNotWritable, "it or its folder was removed"),
        (lambda path: path.write_bytes(b""), WriterError, "was changed by another program"),
        (lambda path: path.write_bytes(path.read_bytes() * 2), WriterError, "was changed by another program"),
    ],
)
def test_a_journal_that_others_remove_or_change_meanwhile_is_not_made_to_look_whole(tmp_path, change, error, said):
    """A file in its place would lack the frames of which it was told, whatever is appended to it, and be closed."""
    made = Journal(tmp_path / "journal.jsonl")
    made.append([line(0), line(1)], {})
    change(made.path)
    before = made.path.read_bytes() if made.path.exists() else None
    for use in (lambda: made.append([line(2)], {}), lambda: made.close(complete=True)):
        with pytest.raises(error, match=said):
            use()
        assert (made.path.read_bytes() if made.path.exists() else None) == before


def test_a_copy_in_the_place_of_a_journal_is_gone_on_with(tmp_path):
    made = Journal(tmp_path / "journal.jsonl")
    made.append([line(0)], {})
    (tmp_path / "copy").write_bytes(made.path.read_bytes())
    os.replace(tmp_path / "copy", made.path)
    made.append([line(1)], {})
    made.close(complete=True)
    assert (journal.read(made.path).frames, journal.read(made.path).is_complete) == ({0, 1}, True)

"""Frames at which a writer fails, or that are interrupted, where the script goes on: what is whole counts."""

from __future__ import annotations

import json

import pytest

import usdsdg as rep
from tests.capture.part_runs import run
from usdsdg.capture.capture import Capture
from usdsdg.capture.output import WriterOutput
from usdsdg.verify.integrity import integrity
from usdsdg.writers.aggregates import finish_run
from usdsdg.writers.journal.earlier_run import Mode


class Failing(rep.Writer):
    """Writes a text for each frame, and a second one but for frame 1, at which it fails in between."""

    def __init__(self, output_dir):
        self.backend = rep.backends.get("DiskBackend", init_params={"output_dir": output_dir})
        self.annotators = ["rgb"]
        self._frame_id = 0

    def write(self, data):
        self.backend.write_blob(f"first_{self._frame_id}.txt", b"1")
        if self._frame_id == 1:
            raise ValueError("of the writer")
        self.backend.write_blob(f"second_{self._frame_id}.txt", b"2")
        self._frame_id += 1


def attached(folder, kind=None):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "cube")])
    product = rep.create.render_product(rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0)), (32, 24))
    first = rep.writers.get("BasicWriter")
    first.initialize(output_dir=str(folder / "a"), rgb=True)
    second = kind(str(folder / "b")) if kind is not None else rep.writers.get("BasicWriter")
    if kind is None:
        second.initialize(output_dir=str(folder / "b"), rgb=True)
    for writer in (second, first):
        writer.attach(product)


def steps(count, error):
    """Step, and go on after an error."""
    for _ in range(count):
        try:
            rep.orchestrator.step()
        except error:
            continue


def lines_of(folder):
    return list(map(json.loads, (folder / ".usdsdg/journal.jsonl").read_text().splitlines()))


def frames_of(folder):
    """Return the files of writers that the journal lists, by frame."""
    listed = {line["frame"]: line["files"] for line in lines_of(folder) if "frame" in line}
    return {number: sorted(name for name in files if "/" not in name) for number, files in listed.items()}


def faults_of(folder):
    found = integrity.check(folder)
    assert found is not None
    return [fault.line() for fault in found.faults]


def test_a_writer_that_fails_leaves_the_journals_of_others_whole_and_its_own_tells_of_the_error(tmp_path):
    def script(folder):
        attached(folder, Failing)
        steps(4, ValueError)
        rep.orchestrator.wait_until_complete()

    run(script, tmp_path)
    assert frames_of(tmp_path / "a") == {number: [f"rgb_{number:04}.png"] for number in range(4)}
    assert faults_of(tmp_path / "a") == []
    assert frames_of(tmp_path / "b")[1] == ["first_1.txt"]
    assert list(frames_of(tmp_path / "b")) == [0, 1, 2, 3]
    assert [fault for fault in faults_of(tmp_path / "b") if "unfinished" in fault] == []
    assert "frame 1" in faults_of(tmp_path / "b")[0]
    assert "Failing: ValueError: of the writer" in faults_of(tmp_path / "b")[0]


def test_a_frame_at_which_the_run_ended_is_made_again(tmp_path):
    def script(folder):
        attached(folder, Failing)
        with pytest.raises(ValueError, match="of the writer"):
            steps(4, ())
        finish_run(complete=False)

    run(script, tmp_path)
    assert list(frames_of(tmp_path / "b")) == [0]


def test_a_frame_that_is_interrupted_before_writers_have_it_is_captured_again(tmp_path, monkeypatch):
    expose, counts = Capture.expose, []

    def interrupted(capture, mode):
        counts.append(1)
        if len(counts) == 2:
            raise KeyboardInterrupt
        expose(capture, mode)

    def script(folder):
        attached(folder)
        steps(4, KeyboardInterrupt)
        rep.orchestrator.wait_until_complete()

    monkeypatch.setattr(Capture, "expose", interrupted)
    run(script, tmp_path)
    for name in "ab":
        assert frames_of(tmp_path / name) == {number: [f"rgb_{number:04}.png"] for number in range(3)}
        assert faults_of(tmp_path / name) == []


def test_a_frame_that_is_interrupted_while_it_is_handed_over_counts_where_it_is_whole(tmp_path, monkeypatch):
    write, counts = WriterOutput.write, []

    def interrupted(output, *args):
        counts.append(1)
        if len(counts) == 4:
            raise KeyboardInterrupt
        write(output, *args)

    def script(folder):
        attached(folder)
        steps(4, KeyboardInterrupt)
        rep.orchestrator.wait_until_complete()

    monkeypatch.setattr(WriterOutput, "write", interrupted)
    run(script, tmp_path)
    assert frames_of(tmp_path / "b") == {number: [f"rgb_{number:04}.png"] for number in range(4)}
    assert faults_of(tmp_path / "b") == []
    assert frames_of(tmp_path / "a") == {number: [f"rgb_{number:04}.png"] * (number != 1) for number in range(4)}
    assert "it was interrupted" in faults_of(tmp_path / "a")[0]


def test_going_on_after_a_frame_that_has_failed_makes_the_later_ones(tmp_path):
    def script(folder):
        attached(folder, Failing)
        steps(4, ValueError)
        rep.orchestrator.wait_until_complete()

    run(script, tmp_path / "whole")
    run(script, tmp_path / "again")
    journal = tmp_path / "again/b/.usdsdg/journal.jsonl"
    # As kill -9 leaves it: without the last frames and the closing line.
    journal.write_text("".join(journal.read_text().splitlines(keepends=True)[:-3]))
    for number in (2, 3):
        (tmp_path / f"again/b/first_{number}.txt").unlink()
    run(script, tmp_path / "again", mode=Mode.RESUME)
    assert frames_of(tmp_path / "again/b") == frames_of(tmp_path / "whole/b")
    assert (tmp_path / "again/b/first_3.txt").exists()


class ReadsDepth(rep.Writer):
    """A writer that reads what it has not asked for."""

    def __init__(self):
        self.annotators = ["rgb"]

    def write(self, data):
        data["depth"]


def test_a_key_that_the_data_of_a_writer_do_not_have_is_answered_with_those_that_there_are(stage):
    writer = ReadsDepth()
    writer.attach(rep.create.render_product(rep.create.camera(), (8, 8)))
    with pytest.raises(KeyError, match="depth") as caught:
        rep.orchestrator.step()
    (note,) = [note for note in caught.value.__notes__ if "ReadsDepth was handed frame 0" in note]
    assert "whose data have the keys" in note
    assert "'rgb'" in note

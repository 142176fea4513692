"""Frames that fail, before anything of them is captured or in one of the writers, after which a script goes on."""

from __future__ import annotations

from typing import Any

import pytest

import usdsdg as rep
from tests.capture.part_runs import run
from usdsdg.capture.exposure import Exposure
from usdsdg.errors import Unsupported
from usdsdg.writers.base import Writer
from usdsdg.writers.journal import journal


@pytest.mark.parametrize(("owner", "name"), [(Writer, "annotators_of"), (Exposure, "__init__")])
def test_a_frame_that_fails_before_it_is_captured_ends(owner, name, tmp_path, monkeypatch):
    def fail(*_):
        raise Unsupported("not this frame")

    def script(folder):
        product = rep.create.render_product(rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0)), (32, 24))
        for each in ("first", "second"):
            writer = rep.writers.get("BasicWriter")
            writer.initialize(output_dir=str(folder / each), bounding_box_2d_tight=True)
            writer.attach(product)
        rep.orchestrator.step()
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, fail)
            with pytest.raises(Unsupported, match="not this frame"):
                rep.orchestrator.step()
        rep.orchestrator.step()

    run(script, tmp_path)
    for each in ("first", "second"):
        found = journal.read(tmp_path / each / ".usdsdg/journal.jsonl")
        assert (found.frames, found.is_complete) == ({0}, False)


class Counting(Writer):
    """Keeps the times of the frames that it gets, by the numbers of their files; a time in `fails` stops it midway."""

    def __init__(self, fails: tuple[float, ...] = ()) -> None:
        self.annotators = ["ReferenceTime"]
        self.fails = fails
        self._frame_id = 0
        self.files: list[tuple[int, float]] = []

    def write(self, data: dict[str, Any]) -> None:
        time = data["ReferenceTime"]["referenceTimeNumerator"] / 1e6
        self.files.append((self._frame_id, time))
        if time in self.fails:
            raise KeyError("midway")
        self._frame_id += 1


class Scattered(Counting):
    """Counts where the count cannot be read from the source alone."""

    def write(self, data: dict[str, Any]) -> None:
        super().write(data)
        self.latest = data


@pytest.mark.parametrize("kind", [Counting, Scattered])
def test_no_writer_gets_a_frame_twice_where_another_one_fails(kind, stage):
    product = rep.create.render_product(rep.create.camera(), (8, 8))
    before, failing, after = kind(), kind(fails=(0.25,)), kind()
    for writer in (before, failing, after):
        writer.attach(product)
    rep.orchestrator.step(delta_time=0.25)
    with pytest.raises(KeyError, match="midway") as raised:
        rep.orchestrator.step(delta_time=0.25)
    assert any("handed frame 1" in note for note in raised.value.__notes__)
    rep.orchestrator.step(delta_time=0.25)
    # The first frame shows the scene as it was set up, without the step.
    expected = [(0, 0.0), (1, 0.25), (2, 0.5)]
    assert (before.files, failing.files, after.files) == (expected, expected, expected)
    assert {writer.num_written for writer in (before, failing, after)} == {3}

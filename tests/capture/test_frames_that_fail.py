"""Frames that fail before anything of them is captured, after which a script goes on."""

from __future__ import annotations

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

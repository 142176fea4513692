"""Several writers in one folder, one after the other: files that one of them replaces are never replaced in silence."""

from __future__ import annotations

import json
import re

import pytest

import usdsdg as rep
from tests.capture.part_runs import run
from usdsdg.errors import UsdsdgWarning
from usdsdg.session import stage_context
from usdsdg.writers.journal.portion import Portion

SEVERAL = "is written to by several writers: files of the same names, such as metadata.txt, replace each other"


def product():
    """Author a labeled cube; return a render product."""
    rep.create.cube(semantics=[("class", "cube")])
    return rep.create.render_product(rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0)), (32, 24))


def attached(folder, writer=None):
    """Return a writer of labels that is attached."""
    writer = writer or rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(folder), bounding_box_2d_tight=True)
    writer.attach(product())
    return writer


def two_stages(folder):
    """Capture a frame on each of two stages, which both have a writer of their own."""
    for _ in range(2):
        stage_context.new_stage()
        attached(folder)
        rep.orchestrator.step()


def initialized_again(folder):
    """Capture a frame, and another one with the same writer, which numbers its files from 0 again."""
    writer = attached(folder)
    rep.orchestrator.step()
    writer.detach()
    attached(folder, writer)
    rep.orchestrator.step()


def attached_again(folder):
    """Capture a frame, and another one with the same writer, which has been detached in between."""
    writer = attached(folder)
    rep.orchestrator.step()
    writer.detach()
    writer.attach(product())
    rep.orchestrator.step()


@pytest.mark.parametrize("script", [two_stages, initialized_again])
@pytest.mark.parametrize("portion", [None, Portion.of_frames("0:2"), Portion.of_frames("1:2")])
def test_a_writer_in_the_folder_of_one_that_has_ended_gives_a_warning(script, portion, tmp_path):
    with pytest.warns(UsdsdgWarning, match=f"{re.escape(str(tmp_path))} {SEVERAL}"):
        run(script, tmp_path, portion)


@pytest.mark.parametrize(("script", "is_told"), [(two_stages, False), (initialized_again, True)])
def test_that_the_first_frames_are_lost_is_told_where_one_writer_was_initialized_again(script, is_told, tmp_path):
    with pytest.warns(UsdsdgWarning, match=SEVERAL) as told:
        run(script, tmp_path)
    [message] = [str(each.message) for each in told if SEVERAL in str(each.message)]
    assert ("BasicWriter was initialized again, and numbers its files from 0" in message) is is_told
    assert ("Give each writer an output_dir of its own" in message) is not is_told


def test_a_writer_that_is_attached_again_goes_on(tmp_path, recwarn):
    run(attached_again, tmp_path)
    assert not [each for each in recwarn if SEVERAL in str(each.message)]
    assert {path.name for path in tmp_path.glob("*_0001.npy")} == {"bounding_box_2d_tight_0001.npy"}


def test_writers_of_one_folder_have_one_class_file_with_the_classes_of_all(tmp_path):
    def script(folder):
        shown = product()
        rep.modify.semantics([("color", "red")], input_prims=rep.get.prim_at_path("/Replicator/Cube_Xform"))
        for name, options in (
            ("BasicWriter", {"bounding_box_2d_tight": True, "semantic_types": ["color"]}),
            ("CvatWriter", {}),
            ("YoloWriter", {}),
        ):
            writer = rep.writers.get(name)
            writer.initialize(output_dir=str(folder), **options)
            writer.attach(shown)
        rep.orchestrator.step()

    with pytest.warns(UsdsdgWarning, match=SEVERAL):
        run(script, tmp_path)
    tables = json.loads((tmp_path / ".usdsdg/classes.json").read_text())["tables"]
    names = {table["filter"]: [each["name"] for each in table["classes"]] for table in tables}
    assert names == {"class:*": ["cube"], "color:*": ["red"]}

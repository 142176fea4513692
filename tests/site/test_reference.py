"""The examples of the reference run; every member of a family, every annotator and every writer has one."""

import subprocess
import sys
from pathlib import Path

import pytest
import warp as wp

import usdsdg as rep
from docs.site.cells import SETTING, cells
from docs.site.reference_pages import EXAMPLES, FAMILIES
from usdsdg.annotators.base import annotator_specs

PROGRAMS = sorted(EXAMPLES.glob("*.py"))
# Members of families that the other families use, and types.
INTERNAL = {
    "modify": {"apply_or_schedule", "apply_or_schedule_pose", "bind_material", "check_material", "non_xform_prims"}
    | {"set_attribute"},
    "distribution": {"draw", "draw_scalars", "from_inputs", "is_vector", "one_of", "options_of"},
    "trigger": {"graph", "get_settings", "get_timeline", "register_function", "shown", "trigger_of", "whole_number"},
}


def named(program: str) -> set[str]:
    return {name for cell in cells(EXAMPLES / f"{program}.py") for name in cell.names} - {SETTING}


def members(family: str) -> set[str]:
    """Return the functions of a family that scripts call."""
    module = getattr(rep, family)
    names = getattr(module, "__all__", None) or [name for name in vars(module) if not name.startswith("_")]
    values = {name: getattr(module, name) for name in names}
    functions = {name for name, value in values.items() if callable(value) and not isinstance(value, type)}
    return {name for name in functions if name.islower()} - INTERNAL.get(family, set())


@pytest.mark.parametrize("family", FAMILIES)
def test_every_member_of_a_family_has_an_example(family):
    assert named(family) == {
        name for name in members(family) if getattr(getattr(rep, family), name).__module__ != "typing"
    }


def test_every_annotator_and_writer_has_an_example():
    own = {name for name in annotator_specs if annotator_specs.get(name).compute.__module__.startswith("usdsdg.")}
    assert named("annotators") == own
    assert named("writers") == {
        name for name, kind in rep.writers.get_writers().items() if kind.__module__.startswith("usdsdg.")
    }


def test_the_examples_run(tmp_path, monkeypatch):
    """All in one process, each with a new stage, in a folder of its own."""
    wp.init()
    monkeypatch.setenv("WARP_CACHE_PATH", str(Path(wp.config.kernel_cache_dir).parent))
    monkeypatch.setenv("HOME", str(tmp_path))
    run = (
        "import os, runpy, sys, usdsdg as rep\n"
        "for path in sys.argv[1:]:\n"
        "    rep.open_stage()\n"
        "    os.makedirs(name := os.path.basename(path)[:-3])\n"
        "    os.chdir(name)\n"
        "    runpy.run_path(path)\n"
        "    os.chdir('..')\n"
    )
    command = [sys.executable, "-c", run, *map(str, PROGRAMS)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    made = {path.name for path in (tmp_path / "writers").iterdir()}
    assert {"basic", "coco", "yolo", "bop", "kitti", "voc", "cvat", "poses", "dope", "ycb", "shards"} <= made

"""The examples of the reference run; every member of a family, every annotator and every writer has one."""

import re

import pytest

import usdsdg as rep
from docs.site.cells import SETTING, cells
from docs.site.reference_pages import EXAMPLES, FAMILIES
from tests import forked
from tests.contracts import mirror
from tests.demo_assets import share_demo_assets
from tests.site.walk import kernels
from usdsdg.annotators.base import annotator_specs

PROGRAMS = sorted(EXAMPLES.glob("*.py"))


def named(program: str) -> set[str]:
    return {name for cell in cells(EXAMPLES / f"{program}.py") for name in cell.names} - {SETTING}


@pytest.mark.parametrize("family", FAMILIES)
def test_every_member_of_a_family_has_an_example(family):
    module = getattr(rep, family)
    mirrored = {path.split(".")[1] for path in mirror.names() if re.fullmatch(rf"{family}\.[a-z]\w*", path)}
    assert {name for name in mirrored if hasattr(module, name)} <= named(family)
    assert all(hasattr(module, name) for name in named(family))


def test_every_annotator_and_writer_has_an_example():
    own = {name for name in annotator_specs if annotator_specs.get(name).compute.__module__.startswith("usdsdg.")}
    assert named("annotators") == own
    assert named("writers") == {
        name for name, kind in rep.writers.get_writers().items() if kind.__module__.startswith("usdsdg.")
    }


def test_the_examples_run(tmp_path, monkeypatch):
    """All in one process, each with a new stage, in a folder of its own."""
    monkeypatch.setenv("WARP_CACHE_PATH", kernels())
    monkeypatch.setenv("HOME", str(tmp_path))
    share_demo_assets(tmp_path / ".cache")
    run = (
        "import os, runpy, sys, usdsdg as rep\n"
        "for path in sys.argv[1:]:\n"
        "    rep.new_stage()\n"
        "    os.makedirs(name := os.path.basename(path)[:-3])\n"
        "    os.chdir(name)\n"
        "    runpy.run_path(path)\n"
        "    os.chdir('..')\n"
    )
    arguments = ["-c", run, *map(str, PROGRAMS)]
    done = forked.run(arguments, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    made = {path.name for path in (tmp_path / "omni.replicator_out").iterdir()}
    assert {"basic", "coco", "yolo", "bop", "kitti", "voc", "cvat", "poses", "dope", "ycb", "shards"} <= made

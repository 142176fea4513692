"""Verdicts on names, the reports of `usdsdg compat`, and the totals in docs/compatibility.md."""

import json
import re
import sys
from collections import Counter

import pytest

from tests.compat.coverage import page
from tests.contracts import gaps, mirror
from tests.sampled_cases import in_soak
from tests.scripts.conftest import usdsdg
from usdsdg.compat import finder
from usdsdg.compat.coverage import board, verdicts
from usdsdg.compat.coverage.verdicts import MISSING, OUT_OF_SCOPE, PARTIAL, SUPPORTED, verdict
from usdsdg.session import session


@pytest.fixture(scope="module", autouse=True)
def import_hooks():
    """The foreign names are importable in this module only."""
    before, modules = list(sys.meta_path), set(sys.modules)
    verdict.cache_clear()
    yield
    sys.meta_path[:] = before
    for name in set(sys.modules) - modules:
        if name.split(".")[0] in ("omni", "carb", "isaacsim", "usdrt"):
            del sys.modules[name]
    session.restart()  # verdicts on members of objects make the application's viewport


@pytest.mark.parametrize(
    ("name", "state", "why"),
    [
        ("omni.replicator.core.create.cube", SUPPORTED, ""),
        ("omni.replicator.core.orchestrator.Status.STARTED", SUPPORTED, ""),
        ("omni.replicator.core.writers.BasicWriter", SUPPORTED, ""),
        ("omni.usd.get_context", SUPPORTED, ""),
        ("pxr.PhysxSchema.PhysxSceneAPI", SUPPORTED, ""),
        ("annotators.get('rgb')", SUPPORTED, ""),
        ("writers.get('BasicWriter')", SUPPORTED, ""),
        ("omni.replicator.core.create.torus", PARTIAL, "Unsupported: as_mesh=False"),
        ("omni.replicator.core.trigger.on_key_press", MISSING, "no window to press keys in"),
        ("omni.replicator.core.create.cub", MISSING, "did you mean cube"),
        ("isaacsim.core.utils.stage.open_stag", MISSING, "did you mean open_stage"),
        ("omni.isaac.synthetic_utils.SyntheticDataHelper", SUPPORTED, ""),
        ("omni.isaac.synthetic_utils.DataWriter", MISSING, "elsewhere: .*annotators"),
        ("nothing_of_the_kind.x", MISSING, "no such module"),
        ("annotators.get('rbg')", MISSING, "rgb"),
        ("annotators.get('RtxSensorCpu')", OUT_OF_SCOPE, "lidar"),
        ("writers.get('ROS2PublishImage')", OUT_OF_SCOPE, "ROS"),
        ("omni.ui.Window", OUT_OF_SCOPE, "no window"),
        ("isaacsim.robot.manipulators.SingleManipulator", OUT_OF_SCOPE, "robots"),
    ],
)
def test_verdicts(name, state, why):
    found = verdict(name)
    assert found.state == state
    assert re.search(why, found.why)


def test_names_that_are_there_are_found_without_looking_for_similar_ones(monkeypatch):
    def look(*_, **__):
        raise AssertionError("this takes as long as the import of the renderer, at the start of every script")

    monkeypatch.setattr(finder, "near_misses", look)
    names = ("omni.replicator.core.create.cube", "omni.usd.get_context", "isaacsim.core.utils.stage.open_stage")
    verdict.cache_clear()
    assert {verdict(name).state for name in names} == {SUPPORTED}
    verdict.cache_clear()


def test_a_module_says_what_it_does_in_part(monkeypatch):
    import usdsdg.compat.omni.usd as shim

    monkeypatch.setattr(shim, "PARTIAL", {"get_context": "one context", "UsdContext.open_stage": "no options"}, False)
    verdict.cache_clear()
    assert verdict("omni.usd.get_context") == verdicts.Verdict(PARTIAL, "one context")
    assert verdict("omni.usd.UsdContext.open_stage").why == "no options"
    verdict.cache_clear()


def test_tables_of_partial_names_name_what_there_is():
    for name in {name.rpartition(".")[0] for name in board.known_names()} & set(sys.modules):
        for partial in vars(sys.modules[name]).get("PARTIAL", {}):
            assert verdict(f"{name}.{partial}").state == PARTIAL


def test_known_names_are_sorted_and_have_those_of_replicator():
    known = board.known_names()
    assert known == sorted(set(known))
    plain = {f"omni.replicator.core.{path}" for path in mirror.names() if re.fullmatch(r"[a-z_.]+", path)}
    assert plain <= set(known)


def test_names_that_gaps_lists_as_missing_are_not_supported():
    names = [name for name in gaps.listed(gaps.MISSING) if re.fullmatch(r"[\w.]+", name)]
    assert [name for name in names if verdict(f"omni.replicator.core.{name}").state in (SUPPORTED, PARTIAL)] == []


@in_soak
def test_the_page_has_the_totals():
    """Run `python -m tests.compat.coverage.page` where this fails."""
    assert page.rewritten(page.PAGE.read_text(encoding="utf-8")) == page.PAGE.read_text(encoding="utf-8")


@in_soak
def test_the_board_counts_every_known_name_once():
    total = sum(board.board().values(), Counter())
    assert total.total() == len(board.known_names())
    assert str(total[SUPPORTED]) in board.totals(total)


def test_the_command_reports_lines_and_ends_with_1_if_a_name_is_missing(tmp_path):
    (tmp_path / "good.py").write_text("import omni.usd\nomni.usd.get_context()\nimport omni.ui\n")
    (tmp_path / "bad.py").write_text("from omni.usd import get_contex\nraise SystemExit(3)\n")
    good = usdsdg("compat", "good.py", cwd=tmp_path).stdout
    assert good.startswith("3 names: 2 supported, 0 partial, 0 missing, 1 out of scope\n")
    assert re.search(r"out of scope  omni\.ui: windows.*\n +good\.py:3\n", good)
    both = usdsdg("compat", "--all", "good.py", "bad.py", cwd=tmp_path, expect=1).stdout
    assert re.search(r"missing       omni\.usd\.get_contex: did you mean get_context.*\n +bad\.py:1\n", both)
    assert re.search(r"supported     omni\.usd\.get_context\n +good\.py:2\n", both)
    (tmp_path / "own.py").write_text(
        "import omni.replicator.core as rep\ndef shapes(): ...\nrep.randomizer.register(shapes)\n"
        "rep.randomizer.shape()\nrep.randomizer.rotation()\n"
    )
    meant = "or did you mean shapes, which the script defines?"
    own = usdsdg("compat", "--all", "own.py", cwd=tmp_path, expect=1).stdout
    assert re.search(rf"missing       omni\.replicator\.core\.randomizer\.shape: .*{re.escape(meant)}\n", own)
    assert own.count("did you mean") == 1
    assert meant in usdsdg("run", "own.py", cwd=tmp_path, expect=1).stderr
    (tmp_path / "ours.py").write_text("import usdsdg as rep\nrep.create.cube()\n")
    assert "nothing of Isaac Sim or Omniverse is imported" in usdsdg("compat", "ours.py", cwd=tmp_path).stdout
    (tmp_path / "wrong.py").write_text("def (")
    with_wrong = usdsdg("compat", "wrong.py", "good.py", cwd=tmp_path, expect=1)
    assert with_wrong.stdout == good
    assert with_wrong.stderr == "error: wrong.py, line 1: not Python: invalid syntax\n"
    told = json.loads(usdsdg("compat", "--json", "bad.py", cwd=tmp_path, expect=1).stdout)
    assert told["totals"][MISSING] == 1
    assert told["names"][0]["lines"] == {"bad.py": [1]}

"""The assets that a recipe names: those that its own run has used."""

import gc
import itertools
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

from usdsdg.stage.assets.opened import last_note, note_opened
from usdsdg.writers.journal import facts as journal_facts
from usdsdg.writers.journal.facts import AssetFacts, assets_of_two_contents, changed_assets
from usdsdg_render.images import image_files


def names(facts: AssetFacts) -> list[str]:
    return sorted(each["name"] for each in facts.take().values())


def test_a_run_names_the_files_that_it_used_itself(tmp_path):
    files = [str(tmp_path / name) for name in ("a.png", "b.png", "c.png")]
    for file in files:
        with open(file, "w") as stream:
            stream.write(file)
    for file in files[:2]:
        image_files.read_bytes(file)  # by an earlier run of this process
    facts = AssetFacts(last_note())
    assert names(facts) == []
    image_files.modified(files[1])  # looked up in a cache
    assert names(facts) == ["b.png"]
    image_files.read_bytes(files[1])
    image_files.read_bytes(files[2])
    assert names(facts) == ["c.png"]


def test_what_is_no_file_is_not_read(tmp_path):
    facts = AssetFacts(last_note())
    note_opened("/dev/zero")
    note_opened(os.fspath(tmp_path))
    note_opened(str(tmp_path / "gone.png"))
    assert names(facts) == []


def test_assets_have_their_names_below_the_root_also_where_no_stage_was_seen(tmp_path, monkeypatch):
    # As where the disk is full at the first frame: a run that goes on then would name its textures twice.
    monkeypatch.setenv("USDSDG_ASSETS_ROOT", str(tmp_path))
    (tmp_path / "Isaac").mkdir()
    (tmp_path / "Isaac/sky.hdr").touch()
    facts = AssetFacts(last_note())
    note_opened(str(tmp_path / "Isaac/sky.hdr"))
    assert names(facts) == ["/Isaac/sky.hdr"]


def test_files_elsewhere_make_no_demo_assets(tmp_path, monkeypatch):
    # They take seconds of all cores, in the middle of a run with a scene of the user's own.
    def demo():
        raise AssertionError("demo assets were asked for")

    monkeypatch.delenv("USDSDG_ASSETS_ROOT", raising=False)
    monkeypatch.setattr("usdsdg.stage.assets.root._fallback", demo)
    facts = AssetFacts(last_note())
    (tmp_path / "own.png").touch()
    note_opened(str(tmp_path / "own.png"))
    assert names(facts) == ["own.png"]


def test_files_of_one_name_in_several_folders_are_told_apart(tmp_path):
    files = [tmp_path / folder / "skin.png" for folder in "ab"]
    for file in files:
        file.parent.mkdir()
        file.write_text(str(file))

    def read(*chosen):
        facts = AssetFacts(last_note())
        facts.source = tmp_path / "script.py"
        for file in chosen:
            note_opened(str(file))
        return facts.take()

    first, second = read(files[0]), read(files[1])
    assert [each["path"] for each in second.values()] == ["b/skin.png"]
    assert changed_assets(first, second) == []
    assert assets_of_two_contents(first | second) == []
    files[0].write_text("another")
    again = read(*files)
    assert changed_assets(first | second, again) == ["a/skin.png"]
    assert assets_of_two_contents(first | second | again) == ["a/skin.png"]


def test_temporary_files_have_no_path_which_would_be_another_in_each_run(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (tmp_path / "drawn.png").write_text("drawn by the script")
    facts = AssetFacts(last_note())
    note_opened(str(tmp_path / "drawn.png"))
    assert ["path" in each for each in facts.take().values()] == [False]


AT_EXIT = """
import atexit, sys
from usdsdg.stage.assets.opened import last_note, note_opened
from usdsdg.writers.journal.facts import AssetFacts

facts = AssetFacts(last_note())
atexit.register(lambda: print(*(each["name"] for each in facts.take().values())))
note_opened(sys.argv[1])
"""


def test_an_asset_that_is_told_of_when_the_program_ends_has_its_hash(tmp_path):
    # As by a run that SIGTERM ends before its first frame is in the journal.
    (tmp_path / "a.png").touch()
    command = [sys.executable, "-c", AT_EXIT, str(tmp_path / "a.png")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).resolve().parents[3])
    assert (done.stdout, done.stderr) == ("a.png\n", "")


def test_modules_may_be_imported_meanwhile(tmp_path, monkeypatch):
    """Python 3.11 collects garbage, and may go on with another thread, wherever something is allocated."""
    monkeypatch.setattr(sys, "modules", dict(sys.modules))
    numbers = itertools.count()

    def imports(_phase: str, _info: dict[str, int]) -> None:
        sys.modules[f"imported_{next(numbers)}"] = ModuleType("imported")

    threshold = gc.get_threshold()
    gc.callbacks.append(imports)
    gc.set_threshold(1)
    try:
        assert list(journal_facts._modules_beside(tmp_path / "script.py")) == []
    finally:
        gc.set_threshold(*threshold)
        gc.callbacks.remove(imports)

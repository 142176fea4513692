"""`usdsdg verify` finds every kind of damage to the files of a dataset, and invents none."""

import hashlib
import json
import shutil

import pytest

from tests import forked
from tests.verify import damage, damaged
from usdsdg.verify import NothingRecognized, verify
from usdsdg.writers.journal.journal import encoded


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return damaged.make(tmp_path_factory.mktemp("dataset"), 6)


@pytest.mark.parametrize("name", damage.KINDS)
def test_damage_is_found_and_nothing_else(whole, tmp_path, name):
    assert damaged.wrong(whole, name, tmp_path / "copy") is None


@pytest.mark.parametrize("name", damage.HARMLESS)
def test_what_is_no_damage_is_no_fault(whole, tmp_path, name):
    assert damaged.wrong(whole, name, tmp_path / "copy") is None


@pytest.mark.parametrize("name", [*damage.KINDS][::9])
def test_damage_is_found_beside_the_checks_of_labels(whole, tmp_path, name):
    assert damaged.wrong(whole, name, tmp_path / "copy", labels=True) is None


def test_the_command_line_names_the_file_and_fails(whole, tmp_path):
    copy = tmp_path / "copy"
    assert damaged.wrong(whole, "a missing image", copy) is None
    done = forked.run(["-m", "usdsdg", "verify", "--files", "--json", str(copy / "out")], cwd=damaged.ROOT)
    assert done.returncode == 1
    assert [fault["what"] for fault in json.loads(done.stdout)["faults"]] == ["is missing"]


def test_a_dataset_of_files_that_no_reader_knows_is_compared(whole, tmp_path):
    """As of a custom writer, whose files are of its own kind."""
    out = tmp_path / "out"
    (out / ".usdsdg").mkdir(parents=True)
    for name in ("recipe.json", "journal.jsonl"):
        (out / ".usdsdg" / name).write_bytes((whole / ".usdsdg" / name).read_bytes())
    report = verify(out)
    assert {fault.what for fault in report.faults} == {"is missing"}
    assert report.compared > 6


def test_a_folder_without_a_journal_cannot_be_compared(tmp_path):
    (tmp_path / "a.png").write_bytes(b"")
    with pytest.raises(NothingRecognized, match="no journal"):
        verify(tmp_path, labels=False)


def test_a_file_of_another_size_is_named_with_both_sizes(whole, tmp_path):
    out = shutil.copytree(whole, tmp_path / "out")
    image = next(out.glob("*rgb*.png"))
    size = image.stat().st_size
    image.write_bytes(b"something else")
    (fault,) = verify(out, labels=False).faults
    assert fault.line().endswith(f": its size is not the one in the journal: expected {size} bytes, found 14")


@pytest.mark.parametrize(
    ("content", "what"),
    [(b"one\n", None), (b"one\ntwo\n", None), (b"One\ntwo\n", "was changed"), (b"on", "its size is not the one in")],
)
def test_of_an_unfinished_run_a_spool_may_have_grown(tmp_path, content, what):
    """A process that was killed has told only how it began; what an earlier end of the run told is outdated."""
    spool = tmp_path / ".usdsdg/aggregates/Writer/index.jsonl"
    spool.parent.mkdir(parents=True)
    spool.write_bytes(content)
    (tmp_path / ".usdsdg/recipe.json").write_text("{}")
    told = [4, hashlib.sha256(b"one\n").hexdigest()]
    shared = {".usdsdg/aggregates/Writer/index.jsonl": [99, "0" * 64]}
    (tmp_path / ".usdsdg/journal.jsonl").write_bytes(
        encoded({"shared": shared, "spools": {"Writer/index.jsonl": told}})
    )
    found = [fault.what for fault in verify(tmp_path, labels=False).faults]
    assert found.pop(0).startswith("the run is unfinished")
    assert [each.startswith(what or "?") for each in found] == [True] * bool(what)

"""Temporary folders: none is left behind; where none can be made, what needs one says how to name one."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from usdsdg.errors import OutputNotWritable
from usdsdg.stores.mirror import Mirror
from usdsdg.stores.temporary import TemporaryFolder, temporary_root
from usdsdg.workers.local import make_parts
from usdsdg.workers.plan import Part


@pytest.fixture
def nowhere(monkeypatch, tmp_path):
    """As on a full disk: Python tries folders, and can make a file in none of them."""
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setattr(tempfile, "_candidate_tempdir_list", lambda: [str(tmp_path / "gone")])
    monkeypatch.chdir(tmp_path)


def test_it_is_the_folder_that_python_takes(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert temporary_root() == str(tmp_path)


@pytest.mark.parametrize(
    "use",
    [
        temporary_root,
        lambda: make_parts(lambda part: ["true"], [Part(0, 1)], 1, lambda: None),
        lambda: Mirror(None, "", lambda name: True, lambda name: False),  # type: ignore[arg-type] - not come to
    ],
)
def test_without_one_the_error_names_what_was_tried_and_the_remedy(use, nowhere):
    with pytest.raises(OutputNotWritable, match=r"gone.*export TMPDIR=FOLDER"):
        use()


MAKES = """
import os, signal, sys
from usdsdg.stores.temporary import TemporaryFolder

folder = TemporaryFolder("frames")
(folder.path / "0.png").write_bytes(b"0")
print(folder.path, flush=True)
if sys.argv[1] == "killed":
    os.kill(os.getpid(), signal.SIGKILL)
if sys.argv[1] == "forks" and not os.fork():
    os._exit(0)
sys.stdin.read()
"""


def _begin(tmp_path, how):
    """Start a process that makes a folder below tmp_path, and return it with the folder."""
    made = subprocess.Popen(
        [sys.executable, "-c", MAKES, how],
        env={**os.environ, "TMPDIR": str(tmp_path)},
        text=True,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert made.stdout is not None
    return made, Path(made.stdout.readline().strip())


@pytest.mark.skipif(os.name == "nt", reason="Windows locks no folders")
def test_folders_of_killed_processes_are_removed_by_the_next_one_and_those_in_use_are_not(tmp_path):
    used, in_use = _begin(tmp_path, "forks")
    killed, left = _begin(tmp_path, "killed")
    with used, killed:
        killed.wait()
        assert left.is_dir()
        (foreign := tmp_path / "usdsdg-frames-x.elsewhere").mkdir()
        with _begin(tmp_path, "waits")[0] as third:
            assert in_use.is_dir()
            assert not left.exists()
            assert foreign.is_dir(), "another machine's, whose locks cannot be seen"
            third.communicate()
        used.communicate()
    assert list(tmp_path.iterdir()) == [foreign]


def test_a_folder_goes_with_its_block_and_with_its_object(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with TemporaryFolder("block") as folder:
        (folder / "a").mkdir()
    kept = TemporaryFolder("object")
    assert list(tmp_path.iterdir()) == [kept.path]
    del kept
    assert not list(tmp_path.iterdir())

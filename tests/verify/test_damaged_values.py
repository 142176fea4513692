"""`usdsdg verify` finds damaged values and tables without a journal, names their file, and ends without a traceback."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.verify import damaged, damaged_values, datasets
from usdsdg.datasets.always import always
from usdsdg.datasets.faults import Fault
from usdsdg.record.frame_record import FrameRecord
from usdsdg.verify import verify
from usdsdg.verify.checks.compare import angles_differ, beyond, differs, is_rotation

COMMAND = [sys.executable, "-m", "usdsdg"]
RIGHTS = "-dac_override,-dac_read_search"  # by which root reads what is closed
IN_ONE_PROCESS = """
import json, sys
from pathlib import Path
from click.testing import CliRunner
from usdsdg.cli.app import app

folder, found = Path(sys.argv[1]), []
for closed, *arguments in ("rgb_0000.png", "verify", "-q"), (".usdsdg/journal.jsonl", "verify", "-q", "--files"), (
    ".", "verify"), (".", "inspect"):
    (folder / closed).chmod(0)
    done = CliRunner().invoke(app, [*arguments, str(folder)])
    found.append([done.exit_code, type(done.exception).__name__, done.output.splitlines()])
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    needed = sorted({each.dataset for each in damaged_values.ALL})
    return datasets.make(tmp_path_factory.mktemp("datasets"), needed, frames=4)


@pytest.fixture(scope="module")
def journaled(tmp_path_factory):
    return damaged.make(tmp_path_factory.mktemp("journaled"), 2)


@pytest.mark.parametrize("damage", damaged_values.ALL, ids=[each.name for each in damaged_values.ALL])
def test_a_damaged_value_is_found(clean, tmp_path, damage):
    folder = shutil.copytree(clean / damage.dataset, tmp_path / "data")
    if damage.name == "a picture without a number":
        shutil.copy(folder / "train_pbr/000000/rgb/000000.png", folder / damage.file)
    file = damaged_values.found(folder, damage)
    damage.inject(file)
    named = {fault.file.split(":")[0] for fault in verify(folder).faults}
    assert file.relative_to(folder).as_posix() in named


@pytest.mark.parametrize("name", ["recipe.json", "journal.jsonl"])
def test_a_pipe_for_a_journal_is_a_fault(journaled, tmp_path, name):
    folder = shutil.copytree(journaled, tmp_path / "out")
    damaged_values.pipe(folder / ".usdsdg" / name)
    assert f".usdsdg/{name}" in {fault.file for fault in verify(folder, labels=False).faults}


def test_what_a_dataset_always_has_depends_on_the_version_that_wrote_it():
    record = FrameRecord(0, "BopWriter", ())
    assert always([record]) == ["camera.json", "models/models_info.json", "models/names.json"]
    assert "models/names.json" not in always([replace(record, version=1)])


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, ["coco_annotations_mine.json"]),
        ({"panoptic": True}, ["coco_annotations_mine.json", "coco_panoptic_mine.json"]),
        ({"plain_names": True}, ["annotations/instances_train.json"]),
        (
            {"splits": {"train": 1}, "panoptic": True},
            ["annotations/instances_train.json", "annotations/panoptic_train.json"],
        ),
        ({"splits": {"train": 1}, "plain_names": False}, ["coco_annotations_mine.json"]),
    ],
)
def test_the_tables_of_coco_depend_on_its_options(options, expected):
    files = ("train/rgb_0000.png", "annotations/panoptic_train/rgb_0000.png")
    assert (
        always([FrameRecord(0, "CocoWriter", (), files=files, parameters={"dataset_id": "mine", **options})])
        == expected
    )


def test_nothing_that_is_no_number_is_equal_to_one():
    for wrong in (float("nan"), float("inf"), float("-inf"), None):
        assert differs(wrong, 1.0, relative=0.1, absolute=10.0)
        assert differs([1.0, wrong], [1.0, 1.0], relative=0.1, absolute=10.0)
        if wrong is not None:
            assert beyond([0.0, wrong if wrong > 0 else -wrong], 1.0).tolist() == [False, True]
            assert angles_differ(wrong, 0.0, absolute=10.0)
            assert not is_rotation(np.diag([1.0, wrong, 1.0]), absolute=1e-3)
    assert not differs(float("inf"), float("inf"), relative=0.0)
    assert not angles_differ(6.28, 0.0, absolute=0.01)
    assert is_rotation(np.eye(3), absolute=1e-9)
    assert not is_rotation(np.diag([1.0, 1.0, -1.0]), absolute=1e-9)


def test_a_line_of_a_fault_can_be_printed_anywhere():
    line = Fault("x\n\x1b[31m.png", "\udcff", "is \ud800", "Köln", "b\u202ea").line()
    assert line == "x\\n\\x1b[31m.png: frame \\udcff: is \\ud800: expected Köln, found b\\u202ea"
    assert line.isprintable()


def run(*arguments: str | Path, prefix: Sequence[str] = (), **options: Any) -> subprocess.CompletedProcess:
    command = [*prefix, *COMMAND, *map(str, arguments)]
    return subprocess.run(command, cwd=damaged.ROOT, text=True, **{"capture_output": True, **options})


def test_any_names_are_printed_to_any_terminal(journaled, tmp_path):
    folder = shutil.copytree(journaled, tmp_path / "out")
    for name in (b"x\xff.png", b"x\n\x1b[31m.png", "Köln.png".encode()):
        Path(os.fsdecode(os.fsencode(folder) + b"/" + name)).touch()
    done = run("verify", "-q", "--files", folder, env=os.environ | {"PYTHONIOENCODING": "ascii:strict"})
    assert (done.returncode, done.stderr) == (1, "")
    assert [line.split(": ")[0] for line in done.stdout.splitlines()[:3]] == [
        "K\\xf6ln.png", "x\\n\\x1b[31m.png", "x\\udcff.png"
    ]  # fmt: skip


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_a_full_disk_for_the_results_is_one_line(journaled):
    with open("/dev/full", "w") as full:
        done = run("verify", "-q", "--files", journaled, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert done.stderr == "error: the results cannot be printed: No space left on device\n"


def test_closed_streams_are_no_failure(journaled):
    shell = ["sh", "-c", 'exec "$@" 2>&-', "sh"]
    done = run("verify", "--files", journaled, prefix=shell)
    assert done.returncode == 0
    assert done.stdout.startswith(f"{journaled}: 0 faults")


def test_what_may_not_be_read_is_a_fault_or_one_line(journaled, tmp_path):
    is_root = os.geteuid() == 0
    if is_root and shutil.which("setpriv") is None:
        pytest.skip("nothing is closed to root")
    prefix = ["setpriv", f"--bounding-set={RIGHTS}", f"--inh-caps={RIGHTS}"] if is_root else []
    folder = shutil.copytree(journaled, tmp_path / "out")
    (folder / "extra.bin").touch(0)
    (folder / "closed").mkdir(0)
    try:
        command = [*prefix, sys.executable, "-c", IN_ONE_PROCESS, str(folder)]
        done = subprocess.run(command, cwd=damaged.ROOT, text=True, capture_output=True, check=True)
    finally:
        folder.chmod(0o700)
        (folder / "closed").chmod(0o700)
    found = json.loads(done.stdout.splitlines()[-1])
    assert [(code, kind) for code, kind, _ in found] == [(1, "SystemExit")] * 4
    whole, files, verified, inspected = (lines for *_, lines in found)
    assert "extra.bin: frame ?: no run wrote it" in whole
    assert "closed: all frames: cannot be read: Permission denied" in whole
    assert "rgb_0000.png: frame 0: cannot be read: Permission denied" in whole
    assert ".usdsdg/journal.jsonl: all frames: cannot be read: Permission denied" in files
    assert verified == inspected == [f"error: {folder} cannot be read: Permission denied"]


def test_a_line_about_a_file_that_is_no_picture_is_in_words(tmp_path):
    """It named an object of Python by its address, so that no two lines were the same."""
    folder = damaged.make(tmp_path, 1)
    picture = next(folder.glob("rgb*.png"))
    picture.write_bytes(b"no picture")
    (line,) = {each.line() for each in verify(folder).faults if "cannot be read" in each.what}
    assert line == f"{picture.name}: frame 0000: cannot be read: it is no picture of a format that is read"


def test_a_fault_of_which_nothing_was_expected_says_so():
    assert Fault("a.txt", "1", "a line", found="3").line() == "a.txt: frame 1: a line: expected nothing, found 3"
    assert Fault("a.txt", "all", "is missing").line() == "a.txt: all frames: is missing"

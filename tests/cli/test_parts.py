"""Parts of a dataset that several processes make, and runs that go on, give the bytes of one uninterrupted run."""

import json
import shutil

import pytest

from tests.cli.datasets import FRAMES, content, generate, merge, write_job


@pytest.fixture(scope="module", params=["PoseWriter", "CocoWriter"])
def made(request, tmp_path_factory):
    """The job, and the folder that one process has made."""
    folder = tmp_path_factory.mktemp("whole")
    job = write_job(folder, request.param, **({"splits": {"train": 2, "val": 1}} if "Coco" in request.param else {}))
    done = generate(job, folder / "out", fresh=True)
    assert done.returncode == 0, done.stderr
    return job, folder / "out"


def test_frames_of_three_processes_are_those_of_one(made, tmp_path):
    job, whole = made
    for frames in ("4:6", "0:1", "1:4"):
        done = generate(job, tmp_path / "out", "--frames", frames)
        assert done.returncode == 0, done.stderr
    assert merge(tmp_path / "out").returncode == 0
    assert content(tmp_path / "out") == content(whole)


def test_shards_are_the_whole(made, tmp_path):
    job, whole = made
    for shard in ("1/2", "0/2"):
        done = generate(job, tmp_path / "out", "--shard", shard)
        assert done.returncode == 0, done.stderr
        assert f"{FRAMES // 2} of {FRAMES} frames" in done.stdout
    early = merge(tmp_path / "out")
    assert early.returncode == 0, early.stderr
    assert content(tmp_path / "out") == content(whole)


@pytest.mark.parametrize("frames", [0, 3, FRAMES])
def test_a_run_that_died_goes_on_where_it_was(made, tmp_path, frames):
    job, whole = made
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    journal = out / ".usdsdg/journal.jsonl"
    *lines, closing = journal.read_text().splitlines(keepends=True)
    shared = json.dumps({name: json.loads(closing)[name] for name in ("shared", "facts")}) + "\n"
    journal.write_text(shared + "".join(lines[:frames]) + '{"frame": 77, "fil')
    for line in lines[frames:]:
        for name in json.loads(line)["files"]:
            (out / name).write_bytes(b"of a process that died")
    (out / ".000003.png.17-4.part").write_bytes(b"half")
    again = generate(job, out)
    assert again.returncode == 1
    assert "--resume" in again.stderr
    assert "--overwrite" in again.stderr
    done = generate(job, out, "--resume")
    assert done.returncode == 0, done.stderr
    assert content(out) == content(whole)

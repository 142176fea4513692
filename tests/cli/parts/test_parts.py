"""Parts of a dataset that several processes make, and runs that go on, give the bytes of one uninterrupted run."""

import json
import os
import shutil
from pathlib import Path

import pytest
import yaml

from tests.cli.datasets import FRAMES, ROOT, content, generate, merge, run, write_job
from tests.sampled_cases import in_soak, sampled
from usdsdg.cli.commands.merge import datasets_to_join
from usdsdg.cli.datasets_in import datasets_in
from usdsdg.stores import open_store
from usdsdg.writers.journal import recipe


@pytest.fixture(scope="module", params=sampled(["CocoWriter", "PoseWriter"]))
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


def test_a_dataset_without_its_recipe_is_found_and_named(tmp_path):
    for name in ("b", "c", "d"):
        (tmp_path / name / ".usdsdg").mkdir(parents=True)
    (tmp_path / "b" / recipe.FILE).write_text("{}")
    (tmp_path / "c/.usdsdg/journal.jsonl").write_text("{}\n")
    (tmp_path / "d/.usdsdg/journal.jsonl").touch()
    assert datasets_in(str(tmp_path)) == [str(tmp_path / "b"), str(tmp_path / "c")]
    assert datasets_in(str(tmp_path / "c")) == [str(tmp_path / "c")]


def test_the_datasets_at_a_url_are_found_and_those_with_parts_are_joined():
    url = "memory://datasets"
    store = open_store(url)
    for name in ("a/one", "a/two", "a/two/.usdsdg/parts/0-of-2", "a/two/within", "b"):
        store.put(f"{name}/{recipe.FILE}", b"{}")
    store.put("a/lost/.usdsdg/journal.jsonl", b"{}\n")
    store.put("a/one/rgb_0000.png", b"")
    assert datasets_in(url) == [f"{url}/a/lost", f"{url}/a/one", f"{url}/a/two", f"{url}/b"]
    assert datasets_in(f"{url}/a/") == [f"{url}/a/lost", f"{url}/a/one", f"{url}/a/two"]
    assert datasets_in(f"{url}/b") == [f"{url}/b"]
    assert datasets_in(f"{url}/none") == [f"{url}/none"]
    assert datasets_to_join(url) == [f"{url}/a/two"]


def test_a_dataset_whose_recipe_this_user_may_not_read_is_found(tmp_path, monkeypatch):
    (tmp_path / "b/.usdsdg").mkdir(parents=True)
    assert datasets_in(str(tmp_path)) == [str(tmp_path)]
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path / "b/.usdsdg")
    assert datasets_in(str(tmp_path)) == [str(tmp_path / "b")]


def test_datasets_in_deeper_folders_are_found(tmp_path):
    for name in ("jobs/a/out", "jobs/b", "jobs/b/inner", "jobs/c/.usdsdg/d"):
        (tmp_path / name / ".usdsdg").mkdir(parents=True)
        (tmp_path / name / recipe.FILE).write_text("{}")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "jobs/a/link").symlink_to(tmp_path / "jobs/b")
    jobs = tmp_path / "jobs"
    assert datasets_in(str(tmp_path)) == [str(jobs / "a/link"), str(jobs / "a/out"), str(jobs / "b")]
    assert datasets_in(str(jobs / "b")) == [str(jobs / "b")]
    assert datasets_in(str(tmp_path / "elsewhere")) == [str(tmp_path / "elsewhere")]
    refused = merge(tmp_path)  # of these, which are no parts; one folder deep there is nothing
    assert refused.returncode == 1
    assert str(jobs / "a/link") in refused.stderr
    assert f"{tmp_path / 'gone'} does not exist" in merge(tmp_path / "gone").stderr


def test_processes_go_on_with_parts_that_an_earlier_command_has_left(made, tmp_path):
    job, whole = made
    for frames in ("0:2", "2:6"):
        done = generate(job, tmp_path / "out", "--frames", frames)
        assert done.returncode == 0, done.stderr
    done = generate(job, tmp_path / "out", "--workers", "2", "--resume")
    assert done.returncode == 0, done.stderr
    assert content(tmp_path / "out") == content(whole)


@in_soak
def test_shards_are_the_whole(made, tmp_path):
    job, whole = made
    for shard in ("1/2", "0/2"):
        done = generate(job, tmp_path / "out", "--shard", shard)
        assert done.returncode == 0, done.stderr
        assert f"{FRAMES // 2} of {FRAMES} frames" in done.stdout
    early = merge(tmp_path / "out")
    assert early.returncode == 0, early.stderr
    assert content(tmp_path / "out") == content(whole)


@pytest.mark.parametrize("frames", sampled([3, 0, FRAMES]))
def test_a_run_that_died_goes_on_where_it_was(made, tmp_path, frames):
    job, whole = made
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    journal = out / ".usdsdg/journal.jsonl"
    shared, *lines, _ = journal.read_text().splitlines(keepends=True)
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


@in_soak
def test_parts_of_another_seed_are_not_joined(tmp_path):
    job = write_job(tmp_path, "PoseWriter")
    for shard, name, seed in (("0/2", "out", "3"), ("1/2", "other", "4")):
        done = generate(job, tmp_path / name, "--shard", shard, "--seed", seed, "--set", "num_frames=2")
        assert done.returncode == 0, done.stderr
    shutil.copytree(tmp_path / "other", tmp_path / "out", dirs_exist_ok=True, ignore=_known(tmp_path / "out"))
    refused = merge(tmp_path / "out")
    assert refused.returncode == 1
    assert "part 1-of-2 is of another recipe" in refused.stderr
    assert "seed" in refused.stderr


def _known(target):
    """Leave out what is in a folder already, as `cp -n` does."""

    def ignored(folder, names):
        own = target / Path(folder).relative_to(target.parent / "other")
        return [name for name in names if (own / name).is_file()]

    return ignored


def test_a_run_that_goes_on_names_files_that_are_gone(made, tmp_path):
    job, whole = made
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    gone = sorted(out.rglob("*.png"))[:2]
    gone[0].unlink()
    gone[1].write_bytes(gone[1].read_bytes() + b"1")
    done = generate(job, out, "--resume")
    assert "missing or changed" in done.stderr
    assert gone[0].name in done.stderr
    assert "and 1 more file" in done.stderr


FORMATS = """
num_frames: 4
seed: 3
resolution: [64, 48]
rendering: {path_tracing: false}
"""


@in_soak
def test_formats_with_journals_of_different_length_go_on_to_the_same_bytes(tmp_path):
    """As after a kill between the syncs of two journals: records do not depend on which files are there."""
    job, out = tmp_path / "job.yaml", tmp_path / "out"
    command = ["-m", "usdsdg", "generate", "-q", str(job), "--device", "cpu", "--set", f"output_dir={out}"]
    text = (ROOT / "configs/detection.yaml").read_text()
    settings = yaml.safe_load(text) | yaml.safe_load(FORMATS) | {"formats": {"yolo": {}, "coco": {}}}
    job.write_text(yaml.safe_dump(settings))
    done = run(command, fresh=True)
    assert done.returncode == 0, done.stderr
    whole = content(out)
    for name, frames in (("coco", 1), ("yolo", 3)):
        journal = out / name / ".usdsdg/journal.jsonl"
        shared, *lines, _ = journal.read_text().splitlines(keepends=True)
        journal.write_text(shared + "".join(lines[:frames]))
    done = run([*command, "--resume"], fresh=True)
    assert done.returncode == 0, done.stderr
    assert content(out) == whole


def test_the_only_dataset_below_a_folder_is_verified(made, tmp_path):
    shutil.copytree(made[1], tmp_path / "all" / "data")
    done = run(["-m", "usdsdg", "verify", str(tmp_path / "all")])
    assert done.returncode == 0, done.stderr
    assert "data: 0 faults" in done.stdout

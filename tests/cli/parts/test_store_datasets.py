"""Datasets in a bucket have a journal, a lease and parts as those in folders, and the same bytes."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tests.cli.datasets import FRAMES, ROOT, content, generate, merge, write_job
from tests.sampled_cases import in_soak
from tests.stores.servers import KEYS, Bucket

LEASES = ".usdsdg/leases/"


@pytest.fixture
def bucket(monkeypatch):
    made = Bucket()
    for name, value in {**KEYS, "AWS_REGION": "us-east-1", "AWS_ENDPOINT_URL": made.url}.items():
        monkeypatch.setenv(name, value)
    return made


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The job, and the files that one process makes of it in a folder."""
    folder = tmp_path_factory.mktemp("whole")
    job = write_job(folder, "CocoWriter", splits={"train": 2, "val": 1})
    done = generate(job, folder / "out", fresh=True)
    assert done.returncode == 0, done.stderr
    return job, content(folder / "out")


@in_soak
def test_a_dataset_in_a_bucket_has_the_files_of_one_in_a_folder(bucket, whole):
    job, files = whole
    done = generate(job, f"s3://{bucket.name}/run")
    assert done.returncode == 0, done.stderr
    assert {key.removeprefix("run/"): data for key, data in bucket.objects.items()} == files
    again = generate(job, f"s3://{bucket.name}/run")
    assert "the files of the earlier run there are replaced" in again.stderr
    assert {key.removeprefix("run/"): data for key, data in bucket.objects.items()} == files
    other = generate(job, f"s3://{bucket.name}/run", "--set", "seed=77")
    assert other.returncode == 1
    assert "has a run of another recipe" in other.stderr


@in_soak
def test_parts_of_a_dataset_in_a_bucket_are_joined(bucket, whole):
    job, files = whole
    for part in (f"2:{FRAMES}", "0:2"):
        done = generate(job, f"s3://{bucket.name}/run", "--frames", part)
        assert done.returncode == 0, done.stderr
    done = merge(f"s3://{bucket.name}/run")
    assert done.returncode == 0, done.stderr
    assert {key.removeprefix("run/"): data for key, data in bucket.objects.items()} == files


@in_soak
def test_workers_make_a_dataset_in_a_bucket(bucket, whole):
    job, files = whole
    done = generate(job, f"s3://{bucket.name}/run", "--workers", "2")
    assert done.returncode == 0, done.stderr
    assert {key.removeprefix("run/"): data for key, data in bucket.objects.items()} == files


@in_soak
def test_a_run_into_a_bucket_that_was_killed_is_gone_on_with(bucket, whole):
    job, files = whole
    command = [sys.executable, "-m", "usdsdg", "generate", "-q", str(job), "--device", "cpu"]
    process = subprocess.Popen([*command, "--set", f"writer_kwargs.output_dir=s3://{bucket.name}/run"], cwd=ROOT)
    while process.poll() is None and not any("/coco_" in key or key.endswith(".png") for key in bucket.objects):
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert any(LEASES in key for key in bucket.objects)
    done = generate(job, f"s3://{bucket.name}/run", "--resume")
    assert done.returncode == 0, done.stderr
    assert {key.removeprefix("run/"): data for key, data in bucket.objects.items()} == files


@in_soak
def test_a_dataset_in_a_bucket_grows(bucket, whole):
    job, files = whole
    made = generate(job, f"s3://{bucket.name}/run", "--set", "num_frames=2")
    assert made.returncode == 0, made.stderr
    text = job.read_text()
    job.write_text(f"{text}\nsettle: false\n")  # what it is without this, in a file of other bytes
    try:
        refused = generate(job, f"s3://{bucket.name}/run", "--resume", "--set", "num_frames=1")
    finally:
        job.write_text(text)
    assert "removes none" in refused.stderr
    grown = generate(job, f"s3://{bucket.name}/run", "--resume")
    assert grown.returncode == 0, grown.stderr
    assert {key.removeprefix("run/"): data for key, data in bucket.objects.items()} == files

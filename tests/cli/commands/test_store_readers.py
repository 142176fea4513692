"""`verify`, `inspect` and `reproduce` read a dataset in a bucket as one in a folder."""

import re

import pytest

from tests.cli.datasets import run
from tests.stores.servers import KEYS, Bucket
from tests.verify.damaged import SCRIPT
from usdsdg.datasets.on_disk import on_disk
from usdsdg.errors import StoreError

FRAMES = 3


def usdsdg(*arguments: str):
    return run(["-m", "usdsdg", *arguments])


@pytest.fixture(scope="module")
def bucket(tmp_path_factory):
    """A bucket with a dataset of a script, of which the script is gone."""
    folder = tmp_path_factory.mktemp("script")
    (folder / "script.py").write_text(SCRIPT)
    with pytest.MonkeyPatch.context() as environment:
        made = Bucket()
        for name, value in {**KEYS, "AWS_REGION": "us-east-1", "AWS_ENDPOINT_URL": made.url}.items():
            environment.setenv(name, value)
        made.place = f"s3://{made.name}/run"
        command = ["run", "-q", "--device", "cpu", "--seed", "5", str(folder / "script.py")]
        done = usdsdg(*command, str(FRAMES), made.place)
        assert done.returncode == 0, done.stderr
        (folder / "script.py").unlink()
        yield made


@pytest.fixture
def files(bucket):
    """What is in the bucket; it is put back afterward."""
    before = bucket.objects
    yield before
    for key in bucket.objects:
        if key not in before:
            bucket.client.delete_object(Bucket=bucket.name, Key=key)
    for key, data in before.items():
        bucket.client.put_object(Bucket=bucket.name, Key=key, Body=data)


def test_verify_finds_what_was_changed_in_a_bucket(bucket, files):
    whole = usdsdg("verify", bucket.place)
    assert whole.returncode == 0, whole.stdout + whole.stderr
    assert f"{bucket.place}: 0 faults" in whole.stdout
    assert f"images: {FRAMES} of BasicWriter" in whole.stdout
    name = "rgb_0001.png"
    bucket.client.put_object(Bucket=bucket.name, Key=f"run/{name}", Body=files["run/rgb_0002.png"])
    bucket.client.delete_object(Bucket=bucket.name, Key="run/rgb_0000.png")
    bucket.client.put_object(Bucket=bucket.name, Key="run/notes/of_mine.txt", Body=b"?")
    found = usdsdg("verify", "--files", bucket.place)
    assert found.returncode == 1
    assert re.findall(r"^(\S+): (?:all frames|frame)", found.stdout, re.MULTILINE) == [
        "rgb_0000.png",
        name,
        "notes/of_mine.txt",
    ]
    assert "it has the content of rgb_0002.png" in found.stdout
    assert f"{bucket.place}: 3 faults" in found.stdout


def test_the_page_of_a_dataset_in_a_bucket_is_put_beside_it(bucket, files, tmp_path):
    done = usdsdg("inspect", bucket.place)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == f"{bucket.place}/inspect.html"
    page = bucket.objects["run/inspect.html"].decode()
    assert "<title>run – usdsdg inspect</title>" in page
    assert bucket.place in page
    assert "usdsdg-mirror" not in page
    assert usdsdg("verify", "--files", bucket.place).returncode == 0
    done = usdsdg("inspect", bucket.place, "--output", str(tmp_path / "page.html"))
    assert done.stdout.strip() == str(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == page


def test_frames_of_a_dataset_in_a_bucket_are_made_again_and_nothing_is_written_there(bucket, files):
    done = usdsdg("reproduce", "-q", bucket.place, "--device", "cpu", "--frames", "1")
    assert done.returncode == 0, done.stderr + done.stdout
    assert re.search(rf"1 frame of {bucket.place}: \d+ files equal, 0 different", done.stdout)
    assert bucket.objects == files


def test_what_is_no_dataset_in_a_bucket_is_told_with_its_url(bucket):
    empty = f"s3://{bucket.name}/nothing"
    for command in ("verify", "inspect", "reproduce"):
        done = usdsdg(command, empty)
        assert done.returncode == 1
        assert empty in done.stderr
        assert "usdsdg-mirror" not in done.stderr
        assert "Traceback" not in done.stderr


def test_a_dataset_that_does_not_fit_on_the_disk_is_not_copied(bucket, files, monkeypatch):
    with on_disk(bucket.place) as dataset:
        monkeypatch.setattr("usdsdg.datasets.on_disk._SPARE", 1 << 60)
        with pytest.raises(StoreError, match="Set TMPDIR to a folder with more room"):
            dataset.fetch()
        assert not (dataset.path / "rgb_0000.png").exists()
        monkeypatch.undo()


def test_names_that_are_a_file_and_a_folder_are_an_error(bucket, files):
    bucket.client.put_object(Bucket=bucket.name, Key="run/rgb_0000.png/inside", Body=b"?")
    with on_disk(bucket.place) as dataset, pytest.raises(StoreError, match="this name twice, as a file and as a fol"):
        dataset.fetch()


def test_damaged_files_of_a_bucket_are_made_again(bucket, files):
    bucket.client.put_object(Bucket=bucket.name, Key="run/rgb_0001.png", Body=b"?")
    bucket.client.delete_object(Bucket=bucket.name, Key="run/.usdsdg/frames/000002.npz")
    bucket.client.delete_object(Bucket=bucket.name, Key="run/.usdsdg/source/script.py")
    done = usdsdg("repair", "-q", "--device", "cpu", bucket.place)
    assert done.returncode == 1
    assert f"{bucket.place}/.usdsdg/source/script.py; give the file that made it with --source" in done.stderr
    bucket.client.put_object(
        Bucket=bucket.name, Key="run/.usdsdg/source/script.py", Body=files["run/.usdsdg/source/script.py"]
    )
    done = usdsdg("repair", "-q", "--device", "cpu", bucket.place)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{bucket.place}: 2 files repaired, 0 left; frames 1-2 made again" in done.stdout
    assert bucket.objects == files

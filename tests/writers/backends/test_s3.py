"""S3Backend and StoreBackend: against a server on this machine that speaks S3's protocol, and in memory."""

import io
import itertools
import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import street
from tests.stores.servers import Bucket, FailingProxy, only_ours
from usdsdg import annotators, backends, writers
from usdsdg.errors import OutputNotWritable, UsdsdgWarning, WriterError
from usdsdg.writers import BackendDispatch, files

PRODUCT = "/Render/HydraTextures/rp1"
_names = itertools.count()


@pytest.fixture(autouse=True)
def nothing_of_the_user(monkeypatch, tmp_path):
    only_ours(monkeypatch, str(tmp_path / "none"))


@pytest.fixture
def bucket():
    return Bucket()


@pytest.fixture
def memory():
    return f"memory://backend-{next(_names)}"


def backend(bucket, prefix="runs/7", **options):
    return backends.S3Backend(bucket.name, prefix, endpoint_url=bucket.url, **options)


def test_blobs_come_back_from_below_the_prefix(bucket):
    ours = backend(bucket)
    ours.write_blob("a/b c+ü.json", b"123")
    ours.write_blob("empty", b"")
    assert bucket.objects == {"runs/7/a/b c+ü.json": b"123", "runs/7/empty": b""}
    assert (ours.read_blob("a/b c+ü.json"), ours.read_blob("empty")) == (b"123", b"")
    url = f"s3://{bucket.name}/runs/7"
    assert (ours.output_dir, ours.resolve_path("x")) == (url, f"{url}/x")
    assert bucket.kind("runs/7/a/b c+ü.json") == "application/json"
    assert bucket.kind("runs/7/empty") == "application/octet-stream"
    with pytest.raises(FileNotFoundError, match=f"{url}/none"):
        ours.read_blob("none")


def test_chunks_are_one_file(bucket):
    ours = backend(bucket)
    chunks = [b"a" * 5_000_000, memoryview(b"b" * 5_000_000)]
    ours.write_chunks("x.mp4", chunks)
    assert bucket.objects == {"runs/7/x.mp4": b"".join(chunks)}
    assert bucket.kind("runs/7/x.mp4") == "video/mp4"


@pytest.mark.parametrize("prefix", [None, "", "/"])
def test_without_a_prefix_keys_are_paths(bucket, prefix):
    ours = backend(bucket, prefix)
    ours.write_blob("x.txt", b"1")
    assert (bucket.objects, ours.output_dir) == ({"x.txt": b"1"}, f"s3://{bucket.name}")


def test_without_overwrite_an_existing_prefix_is_left_alone(bucket):
    prefixes = []
    for _ in range(3):
        ours = backend(bucket, "/out/")
        ours.write_blob("x", b"")
        prefixes.append(ours.output_dir.rpartition("/")[2])
    assert prefixes == ["out", "out_0001", "out_0002"]
    # A prefix is a folder: "out_0001/x" is not below "out_00".
    assert backend(bucket, "out_00").output_dir.endswith("/out_00")


def test_leftovers_of_an_earlier_run_are_pointed_out(bucket):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        backend(bucket, overwrite=True).write_blob("x", b"")
    with pytest.warns(UsdsdgWarning, match=f"s3://{bucket.name}/runs/7 is not empty"):
        assert backend(bucket, overwrite=True).output_dir == f"s3://{bucket.name}/runs/7"


def test_jobs_are_written_from_the_queue(bucket):
    ours = backends.get("S3Backend", {"bucket": bucket.name, "key_prefix": "q", "endpoint_url": bucket.url})
    pictures = np.random.default_rng(0).integers(0, 255, (30, 8, 8, 3), np.uint8)
    for index, picture in enumerate(pictures):
        ours.schedule(files.write_image, path=f"{index:02d}.png", data=picture)
    ours.wait_until_done()
    assert sorted(bucket.objects) == [f"q/{index:02d}.png" for index in range(30)]
    with Image.open(io.BytesIO(ours.read_blob("07.png"))) as image:
        np.testing.assert_array_equal(np.asarray(image), pictures[7])


def _write(name, options):
    writer = writers.get(name, options, PRODUCT)
    frame = make_frame(street(), (40, 30), filters=["class:*"])
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.on_final_frame()
    writer.backend.wait_until_done()
    return writer


def _files(folder):
    found = [path for path in folder.rglob("*") if path.is_file() and "aggregates" not in path.parts]
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


@pytest.mark.parametrize(
    ("name", "options", "place"),
    [
        ("BasicWriter", {"rgb": True, "bounding_box_3d": True}, {"s3_bucket": "BUCKET", "s3_endpoint": "SERVER"}),
        ("PoseWriter", {}, {"use_s3": True, "s3_bucket": "BUCKET", "s3_endpoint_url": "SERVER", "s3_region": "eu"}),
        ("CocoWriter", {}, {"s3_bucket": "BUCKET", "s3_endpoint": "SERVER"}),
    ],
)
def test_writers_leave_the_same_files_in_a_bucket_as_in_a_folder(bucket, tmp_path, name, options, place):
    values = {"BUCKET": bucket.name, "SERVER": bucket.url}
    place = {key: values.get(value, value) for key, value in place.items()}
    _write(name, {"output_dir": str(tmp_path / "out"), **options})
    writer = _write(name, {"output_dir": "out", **place, **options})
    written = _files(tmp_path)
    assert len(written) >= 3
    assert bucket.objects == written
    assert writer.backend.output_dir == f"s3://{bucket.name}/out"


def test_urls_are_found_by_scheme(bucket, memory, tmp_path, monkeypatch):
    monkeypatch.setenv("AWS_ENDPOINT_URL", bucket.url)
    BackendDispatch(output_dir=f"s3://{bucket.name}/a/b").write_blob("x", b"1")
    assert bucket.objects == {"a/b/x": b"1"}
    assert BackendDispatch(output_dir=f"{memory}/a").output_dir == f"{memory}/a"
    assert BackendDispatch(output_dir=(tmp_path / "ü").as_uri()).output_dir == str(tmp_path / "ü")
    ours = backends.get("StoreBackend", {"url": memory, "overwrite": False})
    ours.write_blob("x", b"1")
    assert ours.read_blob("x") == b"1"
    with pytest.raises(OutputNotWritable, match=r"is no folder\. Give it to the writer as output_dir"):
        backends.DiskBackend(f"s3://{bucket.name}/a")
    with pytest.raises(OutputNotWritable, match="is a folder: use DiskBackend"):
        backends.StoreBackend(str(tmp_path))
    for place in ("ftp://x/y", "https://127.0.0.1:1/x", "s3://", "s3://b/../c", "omniverse://x/y"):
        with pytest.raises(OutputNotWritable, match=r"not known|only read|no place"):
            BackendDispatch(output_dir=place)
    with pytest.raises(WriterError, match="leave one out"):
        BackendDispatch(output_dir="s3://one/x", bucket="two")


def test_a_dispatch_writes_to_a_folder_a_bucket_or_both(bucket, tmp_path):
    place = {"endpoint_url": bucket.url, "bucket": bucket.name}
    both = BackendDispatch(output_dir=tmp_path / "both", key_prefix="k", **place)
    both.write_blob("x", b"1")
    assert ((tmp_path / "both" / "x").read_bytes(), bucket.objects) == (b"1", {"k/x": b"1"})
    config = {"paths": {"out_dir": "dir", "s3_bucket": bucket.name}}
    BackendDispatch(config, endpoint_url=bucket.url).write_blob("y", b"2")
    assert bucket.objects.keys() == {"k/x", "dir/y"}
    # As writers of older versions of Replicator configure it.
    paths = {"out_dir": "old", "s3_bucket": bucket.name, "s3_region": "eu-west-1", "s3_endpoint_url": bucket.url}
    BackendDispatch({"use_s3": True, "paths": paths}).write_blob("z", b"3")
    assert bucket.objects.keys() == {"k/x", "dir/y", "old/z"}
    paths["out_dir"] = str(tmp_path / "local")
    BackendDispatch({"use_s3": False, "paths": paths}).write_blob("z", b"3")
    BackendDispatch(output_dir=tmp_path / "other", key_prefix="k", use_s3=False, **place).write_blob("z", b"4")
    assert ((tmp_path / "local" / "z").read_bytes(), (tmp_path / "other" / "z").read_bytes()) == (b"3", b"4")
    assert len(bucket.objects) == 3
    with pytest.raises(WriterError, match="output_dir, or bucket"):
        BackendDispatch(key_prefix="k")


@pytest.mark.parametrize("path", ["../x", "/x", "a/../../x", "", "."])
def test_keys_never_leave_the_prefix(bucket, path):
    ours = backend(bucket)
    for call in (lambda: ours.write_blob(path, b""), lambda: ours.resolve_path(path), lambda: ours.read_blob(path)):
        with pytest.raises(WriterError, match=r"would leave|is no name"):
            call()
    assert bucket.objects == {}


# What goes wrong


def test_a_bucket_that_is_not_there_is_found_before_any_work_and_not_made(bucket):
    with pytest.raises(OutputNotWritable, match=r"s3://other/k.*no such bucket; make it.*server: http"):
        backends.S3Backend("other", "k", endpoint_url=bucket.url)
    assert "other" not in [each["Name"] for each in bucket.client.list_buckets()["Buckets"]]
    with pytest.raises(OutputNotWritable, match="name no place"):
        backends.S3Backend(bucket.name, "../k", endpoint_url=bucket.url)


@pytest.mark.parametrize("overwrite", [True, False])
def test_credentials_that_may_not_are_told_what_they_need(bucket, overwrite):
    with FailingProxy(bucket.port, lambda *_: "403 AccessDenied") as proxy:
        bucket.url = proxy.url
        with pytest.raises(OutputNotWritable, match="s3:PutObject"):
            backend(bucket, overwrite=overwrite)


def test_no_credentials_at_all(bucket, monkeypatch):
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.delenv(name)
    with pytest.raises(OutputNotWritable, match="AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"):
        backend(bucket)


def test_a_server_that_is_not_there(bucket, monkeypatch):
    monkeypatch.setenv("USDSDG_STORE_RETRY_SECONDS", "0")
    with FailingProxy(bucket.port) as gone:
        pass
    with pytest.raises(OutputNotWritable, match="does not answer; look at its address"):
        backends.S3Backend("mine", "k", endpoint_url=gone.url)


def test_a_refused_write_is_raised_by_whoever_waits(bucket):
    with FailingProxy(bucket.port) as proxy:
        bucket.url = proxy.url
        ours = backend(bucket)
        proxy.fate = lambda *_: "400 EntityTooLarge"
        ours.schedule(files.write_np, path="x.npy", data=np.zeros(3))
        with pytest.raises(OutputNotWritable, match=r"s3://.*/runs/7/x.npy.*EntityTooLarge"):
            ours.wait_until_done()
    assert bucket.objects == {}


def test_a_backend_without_a_bucket_says_so():
    with pytest.raises(WriterError, match="initialize"):
        _ = backends.get("S3Backend").output_dir


def test_without_obstore_the_extra_is_named():
    code = """
        import sys
        sys.modules["obstore"] = None
        import usdsdg as rep
        rep.backends.S3Backend("mine", "key")
    """
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(line.strip() for line in code.splitlines())],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[3])},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 1
    assert "pip install 'usdsdg[stores]'" in done.stderr

"""S3Backend: boto3 itself against a server on this machine."""

import io
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
from tests.writers.backends.s3_server import S3Server
from usdsdg import annotators, backends, writers
from usdsdg.errors import OutputNotWritable, UsdsdgWarning, WriterError
from usdsdg.writers import BackendDispatch, files

PRODUCT = "/Render/HydraTextures/rp1"


@pytest.fixture(autouse=True)
def nothing_of_the_user(monkeypatch, tmp_path):
    """No credentials, regions or endpoints but the test's."""
    for name in [name for name in os.environ if name.startswith("AWS_")]:
        monkeypatch.delenv(name)
    for name in ("AWS_CONFIG_FILE", "AWS_SHARED_CREDENTIALS_FILE"):
        monkeypatch.setenv(name, str(tmp_path / "none"))
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "of-the-test")
    monkeypatch.setenv("AWS_REGION", "eu-central-1")


@pytest.fixture
def server():
    with S3Server("mine") as running:
        yield running


def backend(server, prefix="runs/7", **options):
    return backends.S3Backend("mine", prefix, endpoint_url=server.url, **options)


def test_blobs_come_back_from_below_the_prefix(server):
    ours = backend(server)
    ours.write_blob("a/b c+ü.json", b"123")
    ours.write_blob("empty", b"")
    assert server.objects["mine"] == {"runs/7/a/b c+ü.json": b"123", "runs/7/empty": b""}
    assert (ours.read_blob("a/b c+ü.json"), ours.read_blob("empty")) == (b"123", b"")
    assert (ours.output_dir, ours.resolve_path("x")) == ("s3://mine/runs/7", "s3://mine/runs/7/x")
    assert server.kinds["runs/7/a/b c+ü.json"] == "application/json"
    assert all(server.signed)
    with pytest.raises(FileNotFoundError, match="s3://mine/runs/7/none"):
        ours.read_blob("none")


@pytest.mark.parametrize("prefix", [None, "", "/"])
def test_without_a_prefix_keys_are_paths(server, prefix):
    ours = backend(server, prefix)
    ours.write_blob("x.txt", b"1")
    assert (server.objects["mine"], ours.output_dir) == ({"x.txt": b"1"}, "s3://mine")


def test_without_overwrite_an_existing_prefix_is_left_alone(server):
    prefixes = []
    for _ in range(3):
        ours = backend(server, "/out/")
        ours.write_blob("x", b"")
        prefixes.append(ours.output_dir)
    assert prefixes == ["s3://mine/out", "s3://mine/out_0001", "s3://mine/out_0002"]
    # A prefix is a folder: "out_0001/x" is not below "out_00".
    assert backend(server, "out_00").output_dir == "s3://mine/out_00"


def test_leftovers_of_an_earlier_run_are_pointed_out(server):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        backend(server, overwrite=True).write_blob("x", b"")
    with pytest.warns(UsdsdgWarning, match="s3://mine/runs/7 is not empty"):
        assert backend(server, overwrite=True).output_dir == "s3://mine/runs/7"


def test_jobs_are_written_from_the_queue(server):
    ours = backends.get("S3Backend", {"bucket": "mine", "key_prefix": "q", "endpoint_url": server.url})
    pictures = np.random.default_rng(0).integers(0, 255, (30, 8, 8, 3), np.uint8)
    for index, picture in enumerate(pictures):
        ours.schedule(files.write_image, path=f"{index:02d}.png", data=picture)
    ours.wait_until_done()
    assert sorted(server.objects["mine"]) == [f"q/{index:02d}.png" for index in range(30)]
    with Image.open(io.BytesIO(ours.read_blob("07.png"))) as image:
        np.testing.assert_array_equal(np.asarray(image), pictures[7])


@pytest.mark.parametrize(
    ("name", "options", "bucket"),
    [
        ("BasicWriter", {"rgb": True, "bounding_box_3d": True}, {"s3_bucket": "mine", "s3_endpoint": "URL"}),
        ("PoseWriter", {}, {"use_s3": True, "s3_bucket": "mine", "s3_endpoint_url": "URL", "s3_region": "eu"}),
    ],
)
def test_writers_leave_the_same_files_in_a_bucket_as_in_a_folder(server, tmp_path, name, options, bucket):
    frame = make_frame(street(), (40, 30), filters=["class:*"])
    bucket = {key: server.url if value == "URL" else value for key, value in bucket.items()}
    for where in ({"output_dir": str(tmp_path / "out")}, {"output_dir": "out", **bucket}):
        writer = writers.get(name, {**where, **options}, PRODUCT)
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        writer.on_final_frame()
        writer.backend.wait_until_done()
    written = {str(p.relative_to(tmp_path)): p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    assert len(written) >= 3
    assert server.objects["mine"] == written
    assert writer.backend.output_dir == "s3://mine/out"


def test_a_dispatch_writes_to_a_folder_a_bucket_or_both(server, tmp_path):
    place = {"endpoint_url": server.url, "bucket": "mine"}
    both = BackendDispatch(output_dir=tmp_path / "both", key_prefix="k", **place)
    both.write_blob("x", b"1")
    assert ((tmp_path / "both" / "x").read_bytes(), server.objects["mine"]) == (b"1", {"k/x": b"1"})
    config = {"paths": {"out_dir": "dir", "s3_bucket": "mine"}}
    BackendDispatch(config, endpoint_url=server.url).write_blob("y", b"2")
    assert server.objects["mine"].keys() == {"k/x", "dir/y"}
    with pytest.raises(WriterError, match="output_dir, or bucket"):
        BackendDispatch(key_prefix="k")


# What goes wrong


def test_a_bucket_that_is_not_there_is_found_before_any_work(server):
    with pytest.raises(OutputNotWritable, match=r"s3://other/k.*no such bucket; make it.*server: http"):
        backends.S3Backend("other", "k", endpoint_url=server.url)


@pytest.mark.parametrize("overwrite", [True, False])
def test_credentials_that_may_not_are_told_what_they_need(server, overwrite):
    server.refuse = (403, "AccessDenied")
    with pytest.raises(OutputNotWritable, match="s3:PutObject"):
        backend(server, overwrite=overwrite)


def test_no_credentials_at_all(server, monkeypatch):
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.delenv(name)
    with pytest.raises(OutputNotWritable, match="AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"):
        backend(server)


def test_a_server_that_is_not_there(monkeypatch):
    monkeypatch.setattr("usdsdg.writers.backends.s3.ATTEMPTS", 1)
    with S3Server() as gone:
        url = gone.url
    with pytest.raises(OutputNotWritable, match="does not answer; look at endpoint_url"):
        backends.S3Backend("mine", "k", endpoint_url=url)


def test_a_refused_write_is_raised_by_whoever_waits(server):
    ours = backend(server)
    server.refuse = (400, "EntityTooLarge")
    ours.schedule(files.write_np, path="x.npy", data=np.zeros(3))
    with pytest.raises(OutputNotWritable, match=r"s3://mine/runs/7/x.npy.*EntityTooLarge"):
        ours.wait_until_done()
    assert server.objects["mine"] == {}


def test_a_backend_without_a_bucket_says_so():
    with pytest.raises(WriterError, match="initialize"):
        _ = backends.get("S3Backend").output_dir


def test_other_errors_are_not_explained_away(server, monkeypatch):
    """The documented seam: `connect` makes the client."""

    class Broken:
        def list_objects_v2(self, **request):
            return {}

        def put_object(self, **request):
            raise ZeroDivisionError(request["Key"])

    monkeypatch.setattr("usdsdg.writers.backends.s3.connect", lambda region, endpoint_url: Broken())
    with pytest.raises(ZeroDivisionError, match="runs/7/x"):
        backend(server).write_blob("x", b"")


def test_without_boto3_the_extra_is_named():
    code = """
        import sys
        sys.modules["boto3"] = None
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
    assert "pip install 'usdsdg[s3]'" in done.stderr

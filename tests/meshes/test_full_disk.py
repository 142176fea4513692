"""Mesh files where nothing can be written: the disk is full, or the cache may only be read."""

import contextlib

import pytest
import trimesh
from click.testing import CliRunner
from pxr import Usd

from usdsdg.cli.app import app
from usdsdg.errors import OutputNotWritable
from usdsdg.meshes.cache import converted
from usdsdg.meshes.conversion import Options
from usdsdg.stage.usd_errors import save

resource = pytest.importorskip("resource", reason="limits of a process, which Windows has not")
pytestmark = pytest.mark.usefixtures("own_cache")


@pytest.fixture
def ball(tmp_path):
    """A mesh of which the USD file has some 60 KB."""
    trimesh.creation.icosphere(subdivisions=3).export(tmp_path / "ball.obj")
    return tmp_path / "ball.obj"


@contextlib.contextmanager
def full_disk():
    """Let no file be larger than 1,000 bytes, which USD meets as it does a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("form", ["usd", "usda"])
def test_convert_names_the_file_that_cannot_be_written(form, ball, tmp_path):
    target = tmp_path / "out" / f"ball.{form}"
    with full_disk():
        done = CliRunner().invoke(app, ["convert", str(ball), str(target)])
    assert done.exit_code == 1
    assert done.output.startswith(f"error: {target} cannot be written: Error occurred writing file: File too large")
    assert done.output.count("\n") == 1
    assert done.output.count("Error occurred writing file") == 1
    assert list(target.parent.iterdir()) == []


def test_a_mesh_of_a_scene_says_how_to_have_another_cache(ball, tmp_path):
    with full_disk(), pytest.raises(OutputNotWritable, match=r"cannot be written: .*set XDG_CACHE_HOME to a writable"):
        converted(ball, Options())
    assert Usd.Stage.Open(converted(ball, Options()))  # with room nothing is in the way


def test_a_cache_that_may_only_be_read_has_what_was_converted_before(ball, tmp_path):
    first = converted(ball, Options())
    for lock in (tmp_path / "cache" / "usdsdg" / "meshes").glob("*.lock"):
        lock.unlink()
        lock.mkdir()  # root may write anywhere, but not open a folder
    assert converted(ball, Options()) == first


def test_a_cache_that_cannot_be_written_is_named(ball, tmp_path):
    (tmp_path / "cache").write_text("a file in the place of the folder")
    with pytest.raises(OutputNotWritable, match=rf"{ball} cannot be converted to USD in {tmp_path}.*XDG_CACHE_HOME"):
        converted(ball, Options())


def test_a_layer_that_cannot_be_saved_is_an_error_of_the_system(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "many.usda"))
    for number in range(200):
        stage.DefinePrim(f"/Prim_{number}")
    with full_disk(), pytest.raises(OSError, match="File too large"):
        save(stage.GetRootLayer())

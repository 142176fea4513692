"""Files are written beside later frames, with the bytes that they have when each is written before the next frame."""

import json
import subprocess
import textwrap
import threading
from pathlib import Path

import pytest

import usdsdg.backends
from tests.sampled_cases import sampled
from tests.scripts.conftest import usdsdg as run_usdsdg
from tests.verify import datasets
from usdsdg.session import session
from usdsdg.writers.backends.io_queue import IoQueue

NAMES = tuple(datasets.DATASETS)


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def written(folder: Path, queue: IoQueue, monkeypatch, names=NAMES, frames=4) -> dict[str, bytes]:
    """Return the files, by name, of a run with this queue."""
    monkeypatch.setitem(vars(session.current()), "io_queue", queue)  # a restart keeps it
    return bytes_of(datasets.make(folder, names, frames=frames))


def check_same(found: dict[str, bytes], expected: dict[str, bytes]) -> None:
    assert sorted(found) == sorted(expected)
    assert [name for name in expected if found[name] != expected[name]] == []


@pytest.fixture(autouse=True)
def _the_queue_of_others():
    """Later tests have the queue of before, which restarts of the session hand on."""
    yield
    vars(session.current())["io_queue"] = usdsdg.backends.io_queue


@pytest.fixture(scope="module")
def one_by_one(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        return written(tmp_path_factory.mktemp("one_by_one"), IoQueue(threads=0), patch)


@pytest.mark.parametrize("threads", sampled([4, 1]))
def test_threads_change_no_byte(threads, one_by_one, tmp_path, monkeypatch):
    check_same(written(tmp_path, IoQueue(threads=threads), monkeypatch), one_by_one)


def test_frames_that_are_written_after_all_others_were_rendered_are_the_same(one_by_one, tmp_path, monkeypatch):
    """Nothing that waits for its thread is changed by later frames."""
    queue, opened, waited = IoQueue(threads=2), threading.Event(), []
    for _ in range(2):
        queue.submit(opened.wait, what="gate", size=0, owner=opened)
    wait = queue.wait_until_done

    def open_first(owner=None):
        waited.append(queue.open_jobs())
        opened.set()
        wait(owner)

    monkeypatch.setattr(queue, "wait_until_done", open_first)
    monkeypatch.setattr("usdsdg.capture.output.drain", queue.wait_until_done)
    monkeypatch.setattr("usdsdg.app.frame_loop.drain", queue.wait_until_done)
    check_same(written(tmp_path, queue, monkeypatch), one_by_one)
    assert waited[0] > 4 * len(NAMES)  # frames that waited


def test_little_room_in_the_queue_changes_no_byte(one_by_one, tmp_path, monkeypatch):
    check_same(written(tmp_path, IoQueue(threads=3, max_jobs=2, max_bytes=1000), monkeypatch), one_by_one)


FAILING = """
    import omni.replicator.core as rep
    from usdsdg.errors import OutputNotWritable
    from usdsdg.stores import whole_file

    real = whole_file._write

    def full(part, chunks):
        if "rgb_0002" in part:
            raise OSError(28, "No space left on device")
        real(part, chunks)

    whole_file._write = full
    rep.settings.carb_settings("/omni/replicator/backend/writeThreads", THREADS)
    camera = rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0))
    rep.create.cube(semantics=[("class", "cube")])
    product = rep.create.render_product(camera, (16, 16))
    for name in ("BasicWriter", "CocoWriter"):
        writer = rep.WriterRegistry.get(name)
        writer.initialize(output_dir=f"OUTPUT/{name}", rgb=True)
        writer.attach(product)
    rep.orchestrator.run(num_frames=6)
"""


@pytest.mark.parametrize("threads", sampled([4, 0]))
def test_a_full_disk_ends_the_program_with_its_frame_and_whole_files(threads, tmp_path):
    script = textwrap.dedent(FAILING).replace("OUTPUT", str(tmp_path)).replace("THREADS", str(threads))
    (tmp_path / "script.py").write_text(script)
    done = run_usdsdg("run", "--quiet", "--device", "cpu", "script.py", cwd=tmp_path, expect=1)
    assert isinstance(done, subprocess.CompletedProcess)
    assert "error: frame 2: " in done.stderr
    assert "rgb_0002.png cannot be written: the disk is full" in done.stderr
    names = [path.name for path in (tmp_path / "BasicWriter").rglob("*") if path.is_file()]
    assert {"rgb_0000.png", "rgb_0001.png"} <= set(names)
    assert not [name for name in names if name.endswith(".part") or name == "rgb_0002.png"]
    # The other writer's list has the images that it has.
    (listed,) = (tmp_path / "CocoWriter").glob("*.json")
    images = [tmp_path / "CocoWriter" / each["file_name"] for each in json.loads(listed.read_text())["images"]]
    assert len(images) >= 2
    assert all(path.exists() for path in images)

import os
import threading
import warnings
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from tests.writers.backends.python_runs import run_python
from usdsdg import backends
from usdsdg.datasets.folder import check_folder
from usdsdg.errors import DatasetError, OutputNotWritable, UsdsdgWarning, WriterError, WriterRegistryError
from usdsdg.stores import whole_file
from usdsdg.stores.whole_file import write_whole
from usdsdg.writers import BackendDispatch, BackendGroup, BaseBackend, DiskBackend, files, set_disk_root
from usdsdg.writers.backends import registry
from usdsdg.writers.backends.io_queue import IoQueue


def names(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


# Where files go


def test_the_folder_is_made_and_blobs_come_back(tmp_path):
    backend = DiskBackend(tmp_path / "deep" / "out")
    backend.write_blob("a/b.bin", b"123")
    assert backend.read_blob("a/b.bin") == b"123"
    assert backend.resolve_path("x") == str(tmp_path / "deep/out/x")
    assert names(tmp_path) == ["deep/out/a/b.bin"]


def test_without_overwrite_an_existing_folder_is_left_alone(tmp_path):
    first, second, third = (DiskBackend(tmp_path / "out", overwrite=False).output_dir for _ in range(3))
    assert [first, second, third] == [str(tmp_path / n) for n in ("out", "out_0001", "out_0002")]
    assert DiskBackend(tmp_path / "out").output_dir == first


def test_leftovers_of_an_earlier_run_are_pointed_out(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        DiskBackend(tmp_path / "out")
    (tmp_path / "out" / "000009.json").write_text("{}")
    with pytest.warns(UsdsdgWarning, match="out is not empty"):
        DiskBackend(tmp_path / "out")


def test_relative_folders_lie_under_the_root_that_was_set(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert DiskBackend("out").output_dir == str(tmp_path / "home/omni.replicator_out/out")
    set_disk_root(tmp_path / "root")
    try:
        assert DiskBackend("out").output_dir == str(tmp_path / "root/out")
        assert DiskBackend(tmp_path / "abs").output_dir == str(tmp_path / "abs")
    finally:
        set_disk_root(None)


def test_a_user_without_a_home_gives_absolute_folders(tmp_path, monkeypatch):
    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", no_home)
    assert DiskBackend(tmp_path / "abs").output_dir == str(tmp_path / "abs")
    with pytest.raises(OutputNotWritable, match="give an absolute output_dir, or export HOME"):
        DiskBackend("out")
    with pytest.raises(DatasetError, match="out does not exist"):
        check_folder(Path("out"))


def test_a_backend_from_the_registry_has_to_be_initialized(tmp_path):
    backend = registry.get("DiskBackend")
    with pytest.raises(WriterError, match="initialize"):
        _ = backend.output_dir
    backend.initialize(output_dir=tmp_path / "x")
    assert backend.output_dir == str(tmp_path / "x")
    with pytest.raises(WriterRegistryError, match="'DiskBackend'"):
        registry.get("DiscBackend")


def test_misspelt_backends_and_arguments_are_told_with_near_misses(tmp_path):
    with pytest.raises(WriterRegistryError, match="Did you mean 'DiskBackend'"):
        registry.get("DiskBackent")
    with pytest.raises(WriterError, match=r"DiskBackend has no option 'outputdir'\. Did you mean 'output_dir'"):
        registry.get("DiskBackend", init_params={"outputdir": str(tmp_path)})
    with pytest.raises(WriterError, match="DiskBackend needs output_dir"):
        registry.get("DiskBackend", init_params={})
    with pytest.raises(WriterRegistryError, match="'DiskBackend' is not a subclass of BaseBackend"):
        registry.register("DiskBackend")


@pytest.mark.parametrize("function", ["write_image", "write_array", "write_exr"])
def test_path_and_data_that_have_changed_places_are_told(tmp_path, function):
    backend = backends.get("DiskBackend", init_params={"output_dir": tmp_path})
    with pytest.raises(WriterError, match=f"{function}: path is of type ndarray; give a path first, then the data"):
        getattr(backend, function)(np.zeros((2, 2, 3), np.uint8), "a.png")


@pytest.mark.parametrize(("data", "remedy"), [("text", r"encode\(\)"), ({"a": 1}, r"json\.dumps"), (3, r"json\.dumps")])
def test_blobs_that_are_no_bytes_are_told(tmp_path, data, remedy):
    backend = backends.get("DiskBackend", init_params={"output_dir": tmp_path})
    with pytest.raises(WriterError, match=rf"a.txt: write_blob takes bytes, not \w+; .*{remedy}"):
        backend.write_blob("a.txt", data)
    assert list(tmp_path.iterdir()) == []


def test_a_group_writes_everywhere(tmp_path):
    group = BackendGroup([DiskBackend(tmp_path / "a"), DiskBackend(tmp_path / "b")])
    group.schedule(files.write_json, path="x.json", data={})
    group.wait_until_done()
    assert names(tmp_path) == ["a/x.json", "b/x.json"]
    assert group.output_dir == str(tmp_path / "a")


def test_dispatch_takes_old_and_new_arguments(tmp_path):
    assert BackendDispatch({"paths": {"out_dir": str(tmp_path / "a")}}).output_dir == str(tmp_path / "a")
    backend = BackendDispatch(output_dir=tmp_path / "b")
    backend.write_image("x.png", np.full((2, 2), 7, np.uint8))
    backend.write_array("x.npy", np.arange(2))
    backend.write_exr("x.exr", np.full((2, 2), 0.5, np.float32), half_precision=True)
    backend.write_blob("x.txt", b"seven")
    backend.wait_until_done()
    assert names(tmp_path / "b") == ["x.exr", "x.npy", "x.png", "x.txt"]
    assert np.asarray(Image.open(tmp_path / "b" / "x.png")).tolist() == [[7, 7], [7, 7]]
    assert np.load(tmp_path / "b" / "x.npy").tolist() == [0, 1]
    assert files.read_exr(str(tmp_path / "b" / "x.exr")).tolist() == [[0.5, 0.5], [0.5, 0.5]]
    assert backend.read_blob("x.txt") == b"seven"
    with pytest.raises(WriterError, match="output_dir"):
        BackendDispatch()


# Jobs


class Memory(BaseBackend):
    """A user's backend, which does not call super().__init__()."""

    def __init__(self):
        self.blobs = {}

    def write_blob(self, path, data):
        self.blobs[path] = data


def test_a_users_backend_gets_itself_passed():
    backend = Memory()
    backend.schedule(files.write_json, path="x.json", data=[1])
    backend.schedule(lambda path: backend.blobs.update(seen=path), "plain")
    backend.wait_until_done()
    assert backend.blobs == {"x.json": b"[1]", "seen": "plain"}
    assert backend.is_done_writing()


def test_waiting_raises_the_first_failure_once_with_file_and_cause(tmp_path):
    backend = DiskBackend(tmp_path)

    def broken(path):
        raise ZeroDivisionError("oops")

    backend.schedule(broken, path="a/b.bin")
    with pytest.raises(WriterError, match=r"a/b\.bin.*ZeroDivisionError: oops") as caught:
        backend.wait_until_done()
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    backend.wait_until_done()


def test_the_next_job_after_a_failure_raises_it_too(tmp_path):
    backend = DiskBackend(tmp_path)
    backend.schedule(files.write_image, path="x.png", data=np.zeros((2, 2)))
    while not backend.is_done_writing():
        pass
    with pytest.raises(WriterError, match=r"x\.png"):
        backend.schedule(files.write_json, path="y.json", data={})


def test_failures_stay_with_their_backend(tmp_path):
    good, bad = DiskBackend(tmp_path / "good"), DiskBackend(tmp_path / "bad")
    bad.schedule(files.write_image, path="x.png", data=np.zeros((2, 2)))
    good.schedule(files.write_json, path="x.json", data={})
    good.wait_until_done()
    with pytest.raises(WriterError):
        bad.wait_until_done()


def test_files_of_one_frame_come_in_order_and_stop_at_a_failure(tmp_path):
    backend = DiskBackend(tmp_path)
    backend.schedule_together(
        [
            partial(files.write_np, path="a.npy", data=np.zeros(2)),
            partial(files.write_image, path="b.png", data=np.zeros((2, 2))),  # floats: fails
            partial(files.write_json, path="c.json", data={}),
        ]
    )
    with pytest.raises(WriterError, match=r"b\.png"):
        backend.wait_until_done()
    assert names(tmp_path) == ["a.npy"]


def test_the_queue_is_bounded_in_jobs_and_bytes():
    queue = IoQueue(threads=1, max_jobs=2, max_bytes=100)
    gate, done = threading.Event(), []
    owner = object()
    queue.submit(gate.wait, what="gate", size=0, owner=owner)
    for index in range(2):
        queue.submit(partial(done.append, index), what="x", size=40, owner=owner)
    # The third waits for room; it must not be in before the gate opens.
    late = threading.Thread(target=lambda: queue.submit(partial(done.append, 2), what="x", size=40, owner=owner))
    late.start()
    late.join(0.2)
    waits = late.is_alive()
    gate.set()
    late.join()
    assert waits
    queue.wait_until_done(owner)
    assert done == [0, 1, 2]


def test_a_job_larger_than_the_bound_is_still_taken():
    queue = IoQueue(threads=1, max_jobs=4, max_bytes=10)
    done = []
    queue.submit(partial(done.append, 1), what="x", size=1000, owner=queue)
    queue.wait_until_done()
    assert done == [1]


def test_a_job_that_schedules_does_not_wait_for_itself():
    queue = IoQueue(threads=1, max_jobs=1)
    done = []

    def outer():
        for index in range(5):
            queue.submit(partial(done.append, index), what="x", size=0, owner=queue)

    queue.submit(outer, what="outer", size=0, owner=queue)
    queue.wait_until_done()
    assert done == [0, 1, 2, 3, 4]


# Disks that do not want


def test_a_folder_below_a_file_is_refused_with_path_reason_and_remedy(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputNotWritable, match=r"file/out cannot be written: .*not a folder.*another output_dir"):
        DiskBackend(tmp_path / "file" / "out")


def test_a_folder_with_a_null_character_is_refused(tmp_path):
    """As a configuration or a graph of a stranger may have."""
    for folder in ("a\0b", tmp_path / "a\0b"):
        with pytest.raises(OutputNotWritable, match="has a null character"):
            DiskBackend(folder)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputNotWritable, match="may not write"):
            DiskBackend(tmp_path / "out")
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.parametrize(("inodes", "said"), [(9, "the disk is full"), (0, "the disk takes no more files, .* `df -i`")])
def test_a_full_disk_leaves_no_part_of_a_file(tmp_path, monkeypatch, inodes, said):
    def full(part, chunks):
        with open(part, "wb") as file:
            file.write(b"".join(chunks)[:4])
        raise OSError(28, "No space left on device")

    (tmp_path / "x.bin").write_bytes(b"before")
    monkeypatch.setattr(whole_file, "_write", full)
    monkeypatch.setattr(whole_file.shutil, "disk_usage", lambda _: SimpleNamespace(free=4e6))
    monkeypatch.setattr(os, "statvfs", lambda _: SimpleNamespace(f_files=9, f_favail=inodes))
    message = rf"x\.bin cannot be written: {said}.* \(4 MB free\).*whole"
    with pytest.raises(OutputNotWritable, match=message) as caught:
        write_whole(tmp_path / "x.bin", b"12345678")
    assert isinstance(caught.value.__cause__, OSError)
    assert names(tmp_path) == ["x.bin"]
    assert (tmp_path / "x.bin").read_bytes() == b"before"


def test_a_real_limit_on_file_size_keeps_whole_files_and_raises(tmp_path):
    """The kernel stops the write half way: the small file stays, the large one leaves nothing."""
    result = run_python(
        """
        import resource, sys
        import numpy as np
        from usdsdg.writers import DiskBackend, OutputNotWritable, files
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
        backend = DiskBackend(sys.argv[1])
        backend.schedule(files.write_np, path="small.npy", data=np.zeros(100))
        backend.wait_until_done()
        backend.schedule(files.write_np, path="large.npy", data=np.zeros(100000))
        try:
            backend.wait_until_done()
        except OutputNotWritable as error:
            print(error)
        """,
        str(tmp_path),
    )
    assert "large.npy cannot be written: the file would be larger" in result.stdout, result.stderr
    assert names(tmp_path) == ["small.npy"]


def test_what_is_queued_when_the_program_ends_is_written(tmp_path):
    """Also when it ends by Ctrl-C: every file is whole and no temporary one is left."""
    result = run_python(
        """
        import sys
        import numpy as np
        from usdsdg.writers import DiskBackend, files
        backend = DiskBackend(sys.argv[1])
        image = np.zeros((200, 200, 3), np.uint8)
        for index in range(30):
            backend.schedule(files.write_image, path=f"{index:02d}.png", data=image)
        raise KeyboardInterrupt
        """,
        str(tmp_path),
    )
    assert "KeyboardInterrupt" in result.stderr
    assert names(tmp_path) == [f"{index:02d}.png" for index in range(30)]
    assert len({p.stat().st_size for p in tmp_path.iterdir()}) == 1


def test_a_failure_that_nobody_waited_for_is_told_at_the_end(tmp_path):
    result = run_python(
        """
        import sys
        import numpy as np
        from usdsdg.writers import DiskBackend, files
        DiskBackend(sys.argv[1]).schedule(files.write_image, path="x.png", data=np.zeros((2, 2)))
        """,
        str(tmp_path),
    )
    assert "x.png" in result.stderr


def test_the_queue_of_all_backends_is_bounded_by_name(tmp_path, monkeypatch):
    queue = backends.io_queue
    monkeypatch.setattr(queue, "max_jobs", queue.max_jobs)
    BackendDispatch(output_dir=tmp_path).set_max_queue_size(7)
    assert queue.max_jobs == 7
    queue.set_max_queue_size(8)
    assert queue.max_jobs == 8
    queue.wait_until_done()
    assert queue.is_done_writing()


def test_a_users_backend_is_registered_and_found_under_its_class_name(tmp_path):
    registry.BackendRegistry.register_backend(Memory)
    try:
        assert {"Memory", "DiskBackend", "S3Backend", "BackendGroup"} <= set(
            registry.BackendRegistry.get_registered_backends()
        )
        memory = registry.get("Memory", {})
        assert memory.get_name() == "Memory"
        group = registry.get("BackendGroup", {"backends": [memory, DiskBackend(tmp_path)]})
        group.schedule(files.write_np, path="x.npy", data=np.arange(3))
        group.wait_until_done()
        assert memory.blobs["x.npy"] == group.backends[1].read_blob("x.npy") == (tmp_path / "x.npy").read_bytes()
    finally:
        registry.BackendRegistry.unregister_backend("Memory")
    with pytest.raises(WriterRegistryError, match="Memory"):
        registry.BackendRegistry.get_backend("Memory")
    with pytest.raises(NotImplementedError, match="Memory does not read blobs"):
        memory.read_blob("x.npy")


def test_the_class_waits_for_every_backend(tmp_path):
    first, second = DiskBackend(tmp_path / "a"), BackendDispatch(output_dir=tmp_path / "b")
    for backend in (first, second):
        backend.schedule(backend.write_blob, "x.bin", b"x")
    BackendDispatch.wait_until_done()
    assert BackendDispatch.is_done_writing()
    assert (tmp_path / "a" / "x.bin").read_bytes() == (tmp_path / "b" / "x.bin").read_bytes() == b"x"
    second.schedule(second.write_blob, "y.bin", b"y")
    second.wait_until_done()
    assert second.is_done_writing()
    assert (tmp_path / "b" / "y.bin").exists()

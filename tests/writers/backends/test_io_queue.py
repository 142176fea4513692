"""Order, bounds, failures and the end of the I/O queue."""

import contextlib
import json
import os
import sys
import textwrap
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.writers.backends.python_runs import run_python
from usdsdg.errors import OutputNotWritable, WriterError
from usdsdg.session.session import current
from usdsdg.writers import BackendGroup, BaseBackend, DiskBackend, files
from usdsdg.writers.backends.io_queue import IoQueue


def submit(queue, run, owner=None, **order):
    queue.submit(run, what=getattr(run, "__name__", "a job"), size=order.pop("size", 0), owner=owner or queue, **order)


def broken(text="oops"):
    raise OutputNotWritable(text)


class Gate:
    """Jobs that hold every thread of a queue until they are let go."""

    def __init__(self, queue, count=1):
        self.opened = threading.Event()
        for _ in range(count):
            submit(queue, self.opened.wait, owner=self)


# Order


def test_jobs_in_turn_end_in_their_order_while_others_overtake_them():
    queue, done = IoQueue(threads=4), []
    first = threading.Event()

    def late():
        assert first.wait(10)
        done.append("slow 0")

    submit(queue, late, turn="slow")
    for index in range(1, 6):
        submit(queue, partial(done.append, f"slow {index}"), turn="slow")
        submit(queue, partial(done.append, f"quick {index}"))
    while queue.open_jobs() > 6:
        time.sleep(0.001)
    assert sorted(done) == [f"quick {index}" for index in range(1, 6)]
    first.set()
    queue.wait_until_done()
    assert done[5:] == [f"slow {index}" for index in range(6)]


def test_a_job_after_all_waits_for_those_of_its_owner_only():
    queue, done, mine, other = IoQueue(threads=4), [], object(), object()
    gate = Gate(queue)
    held = threading.Event()
    submit(queue, partial(held.wait, 10), owner=mine)
    submit(queue, partial(done.append, "last of mine"), owner=mine, after_all=True)
    submit(queue, partial(done.append, "last of the other"), owner=other, after_all=True)
    queue.wait_until_done(other)
    assert done == ["last of the other"]
    held.set()
    queue.wait_until_done(mine)
    assert done == ["last of the other", "last of mine"]
    gate.opened.set()


def test_what_lists_files_is_left_out_where_one_of_them_failed():
    queue, done = IoQueue(threads=2), []
    gate = Gate(queue, 2)
    submit(queue, broken)
    submit(queue, partial(done.append, "list"), after_all=True)
    submit(queue, partial(done.append, "list of lists"), after_all=True)
    submit(queue, partial(done.append, "file"))
    gate.opened.set()
    with pytest.raises(OutputNotWritable, match="oops"):
        queue.wait_until_done()
    assert done == ["file"]


def test_a_group_keeps_the_order_of_each_of_its_backends(tmp_path):
    group = BackendGroup([DiskBackend(tmp_path / name) for name in ("a", "b")])

    def append(text, backend_instance):
        path = Path(backend_instance.resolve_path("log"))
        path.write_text((path.read_text() if path.exists() else "") + text)

    for index in range(20):
        group.schedule_in_turn("log", append, f"{index} ")
    group.schedule_after_all(append, "end")
    group.wait_until_done()
    expected = " ".join(map(str, [*range(20), "end"]))
    assert [(tmp_path / name / "log").read_text() for name in ("a", "b")] == [expected] * 2


def test_backends_of_one_folder_write_a_file_in_turn(tmp_path):
    first, second, slow = DiskBackend(tmp_path), DiskBackend(tmp_path), threading.Event()

    def write(text, backend_instance):
        assert text != "first" or slow.wait(10)
        Path(backend_instance.resolve_path("log")).write_text(text)

    first.schedule_in_turn("log", write, "first")
    second.schedule_in_turn("log", write, "second")
    threading.Timer(0.1, slow.set).start()
    first.wait_until_done()
    second.wait_until_done()
    assert (tmp_path / "log").read_text() == "second"


# Failures


def test_the_failure_of_the_first_job_is_raised_even_if_a_later_one_failed_before():
    queue, late = IoQueue(threads=2), threading.Event()

    def slowly():
        assert late.wait(10)
        broken("the first")

    submit(queue, slowly)
    submit(queue, partial(broken, "the second"))
    while queue.open_jobs() > 1:
        time.sleep(0.001)
    threading.Timer(0.1, late.set).start()
    with pytest.raises(OutputNotWritable, match="the first") as caught:
        submit(queue, list)
    assert caught.value.__notes__ == ["(1 more file failed)"]
    queue.wait_until_done()


@pytest.mark.parametrize("threads", [0, 3])
def test_a_failure_names_its_frame_and_file(threads):
    queue = IoQueue(threads=threads)

    def run(job, frame):
        with queue.frame(frame):
            queue.submit(job, what="rgb_0012.png", size=0, owner=queue)
        queue.wait_until_done()

    with pytest.raises(WriterError) as caught:
        run(partial(int, "x"), 12)
    assert str(caught.value).startswith("frame 12: rgb_0012.png could not be written: ValueError: invalid literal")
    with pytest.raises(OutputNotWritable, match=r"^frame 13: /full/x\.png cannot be written$"):
        run(partial(broken, "/full/x.png cannot be written"), 13)


@pytest.mark.parametrize("threads", [0, 3])
def test_a_failure_names_the_line_of_the_script_that_raised_it(threads):
    queue = IoQueue(threads=threads)

    def parse(text):
        return json.loads(text)  # raises in a file of Python, which is not the script's

    def run():
        queue.submit(partial(parse, "{"), what="labels", size=0, owner=queue)
        queue.wait_until_done()

    with pytest.raises(WriterError, match="labels could not be written: JSONDecodeError") as caught:
        run()
    line = parse.__code__.co_firstlineno + 1
    assert caught.value.__notes__ == [f"(raised at test_io_queue.py:{line}, in {parse.__qualname__})"]


def test_a_job_that_ends_its_thread_is_a_failure_and_nobody_waits_for_ever():
    queue, done = IoQueue(threads=1), []
    gate = Gate(queue)
    submit(queue, partial(sys.exit, 3))
    submit(queue, partial(done.append, 1))
    gate.opened.set()
    with pytest.raises(WriterError, match="SystemExit: 3"):
        queue.wait_until_done()
    assert done == [1]


def test_a_job_that_waits_for_its_own_queue_is_told_so():
    queue = IoQueue(threads=1)
    submit(queue, queue.wait_until_done)
    with pytest.raises(WriterError, match="a job waits for its own queue"):
        queue.wait_until_done()


def test_who_waits_for_room_hears_of_a_failure():
    queue = IoQueue(threads=1, max_bytes=10)
    submit(queue, lambda: (time.sleep(0.05), broken()), size=10)
    with pytest.raises(OutputNotWritable, match="oops"):
        submit(queue, list, size=10)


# Bounds


def test_a_slow_backend_bounds_the_bytes_that_wait():
    """Fifty frames of a megabyte for a disk of a frame in 5 ms, with room for four frames."""
    queue = current().io_queue
    queue.set_max_bytes(4 << 20)
    most, blobs = [], {}

    class Slow(BaseBackend):
        def write_blob(self, path, data):
            time.sleep(0.005)
            most.append(queue._bytes)
            blobs[path] = len(data)

    try:
        backend = Slow()
        for index in range(50):
            backend.schedule(files.write_np, path=f"{index}.npy", data=np.zeros(1 << 20, np.uint8))
        backend.wait_until_done()
    finally:
        queue.set_max_bytes(1 << 30)
    assert len(blobs) == 50
    assert 1 << 20 < max(most) <= 4 << 20
    assert queue._bytes == 0


def test_jobs_that_wait_for_others_count_as_waiting():
    queue = IoQueue(threads=2, max_jobs=3)
    gate = Gate(queue)
    for _ in range(3):
        submit(queue, list, owner=gate, after_all=True)
    late = threading.Thread(target=submit, args=(queue, list))
    late.start()
    late.join(0.1)
    assert late.is_alive()
    gate.opened.set()
    late.join(10)
    queue.wait_until_done()


@pytest.mark.parametrize("counts", [(0, 3), (3, 0, 2), (4, 1)])
def test_the_number_of_threads_changes_what_runs_where_and_not_what_is_done(counts):
    queue, done = IoQueue(threads=1), []
    for count in counts:
        queue.set_threads(count)
        for _ in range(20):
            submit(queue, lambda: done.append(threading.current_thread() is threading.main_thread()))
        assert count or done[-20:] == [True] * 20
        assert not count or not queue.wait_until_done()
        assert count == 0 or not any(done[-20:])
    assert len(done) == 20 * len(counts)


def test_settings_reach_the_queue(stage):
    import usdsdg as rep

    queue = current().io_queue
    before = queue._threads, queue.max_bytes
    try:
        rep.settings.carb_settings("/omni/replicator/backend/writeThreads", 0)
        rep.settings.carb_settings("/usdsdg/writers/queueBytes", 123)
        assert (queue._threads, queue.max_bytes) == (0, 123)
    finally:
        queue.set_threads(before[0])
        queue.set_max_bytes(before[1])


# The end


SLOW = """
    import sys, time, threading, _thread
    import numpy as np
    from usdsdg.stores import whole_file
    from usdsdg.writers import DiskBackend, files

    def slowly(part, chunks):
        with open(part, "wb") as file:
            for byte in b"".join(chunks):
                file.write(bytes([byte]))
                file.flush()
                time.sleep(0.001)

    whole_file._write = slowly
    backend = DiskBackend(sys.argv[1])
    for index in range(200):
        backend.schedule(files.write_text, path=f"{index:03d}.txt", text="x" * 100)
    time.sleep(0.3)
"""


def check_that_files_are_whole(folder: Path) -> int:
    found = sorted(folder.iterdir())
    assert all(path.suffix == ".txt" and path.read_text() == "x" * 100 for path in found), found
    return len(found)


def test_a_second_ctrl_c_drops_what_waits_and_leaves_whole_files(tmp_path):
    result = run_python(
        "from usdsdg.cli.options.command_context import command_context\n"
        "with command_context(quiet=True):\n"
        f"{SLOW}\n"
        "    threading.Timer(0.3, _thread.interrupt_main).start()\n"
        "    raise KeyboardInterrupt\n",
        str(tmp_path),
    )
    assert result.returncode == 130, result.stderr
    assert "Ctrl-C again stops at once" in result.stderr
    dropped = int(result.stderr.split("stopped: ")[1].split()[0])
    assert dropped > 0
    assert check_that_files_are_whole(tmp_path) == 200 - dropped


def test_ctrl_c_at_the_exit_of_a_python_program_says_what_is_missing(tmp_path):
    interrupt = "timer = threading.Timer(0.3, _thread.interrupt_main)\ntimer.daemon = True\ntimer.start()\n"
    code = textwrap.dedent(SLOW) + interrupt
    result = run_python(code, str(tmp_path))
    assert result.returncode == 1
    dropped = int(result.stderr.split("interrupted; ")[1].split()[0])
    assert 0 < dropped == 200 - check_that_files_are_whole(tmp_path)


def test_temporary_folders_of_jobs_are_there_until_the_jobs_have_ended(tmp_path):
    result = run_python(
        """
        import sys, tempfile, threading, time
        from pathlib import Path
        from usdsdg.writers import DiskBackend, files

        started = threading.Event()

        def write(path, backend_instance):
            with tempfile.TemporaryDirectory() as folder:
                started.set()
                time.sleep(0.5)
                Path(folder, "made").write_text("made")
                files.write_text(path, Path(folder, "made").read_text(), backend_instance=backend_instance)

        DiskBackend(sys.argv[1]).schedule(write, path="file.txt")
        started.wait()
        """,
        str(tmp_path),
    )
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "file.txt").read_text() == "made"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_a_forked_process_writes_with_threads_of_its_own(tmp_path):
    result = run_python(
        """
        import os, sys, threading
        from usdsdg.writers import DiskBackend, files
        backend = DiskBackend(sys.argv[1])
        held = threading.Event()
        backend.schedule(held.wait)  # a job of the parent, which the child must not wait for
        child = os.fork()
        backend.schedule(files.write_text, path=f"{'parent' if child else 'child'}.txt", text="x")
        if child:
            held.set()
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        backend.wait_until_done()
        """,
        str(tmp_path),
    )
    assert result.returncode == 0, result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["child.txt", "parent.txt"]


def test_an_interrupt_while_the_lock_is_taken_leaves_it_to_others(monkeypatch):
    """Ctrl-C in the Python code that takes a lock, once it is taken, would let no thread go on."""
    queue, done = IoQueue(threads=1), []
    enter = threading.Condition.__enter__

    def interrupted(condition):
        enter(condition)
        raise KeyboardInterrupt

    with monkeypatch.context() as patched, contextlib.suppress(KeyboardInterrupt):
        patched.setattr(threading.Condition, "__enter__", interrupted)
        queue.open_jobs()
    writer = threading.Thread(
        target=lambda: (submit(queue, partial(done.append, 1)), queue.wait_until_done()), daemon=True
    )
    writer.start()
    writer.join(20.0)
    assert done == [1]

"""The journals of runs whose script catches an error, or that Ctrl-C ends while threads capture."""

from __future__ import annotations

import signal

import pytest

from tests.cli.datasets import content, run

SCENE = """
import os, sys, threading, time
import omni.replicator.core as rep
rep.create.light(light_type="dome")
rep.create.cube(semantics=[("class", "person")])
product = rep.create.render_product(rep.create.camera(position=(0, -6, 2), look_at=(0, 0, 0)), (32, 24))
writer = rep.writers.get("CocoWriter")
writer.initialize(output_dir=sys.argv[1] + "/coco")
writer.attach(product)
"""

CATCHING = (
    SCENE
    + """
class Failing(rep.Writer):
    def __init__(self):
        self.backend = rep.backends.get("DiskBackend", init_params={"output_dir": sys.argv[1] + "/own"})
        self.annotators, self._frame_id = ["rgb"], 0
    def write(self, data):
        self.backend.write_blob(f"{self._frame_id}.txt", b"1")
        if self._frame_id == 1:
            raise ValueError("of the writer")
        self._frame_id += 1
Failing().attach(product)
for _ in range(3):
    try:
        rep.orchestrator.step()
    except ValueError:
        pass
"""
)

THREADS = (
    SCENE
    + """
def many():
    for _ in range(3000):
        rep.orchestrator.step()
rep.orchestrator.step()
for _ in range(3):
    threading.Thread(target=many, daemon=True).start()
threading.Timer(1.0, lambda: os.kill(os.getpid(), int(sys.argv[2]))).start()
many()
"""
)


def started(tmp_path, source, *arguments, options=(), out="out"):
    script = tmp_path / "script.py"
    script.write_text(source)
    return run(["-m", "usdsdg", "run", "-q", *options, str(script), str(tmp_path / out), *arguments])


def ended_alone(tmp_path, source, *arguments):
    """As `started`, by Python without a command."""
    script = tmp_path / "script.py"
    script.write_text("import usdsdg.compat\nusdsdg.compat.install()\n" + source)
    return run([str(script), str(tmp_path / "out"), *arguments])


def verified(folder):
    return run(["-m", "usdsdg", "verify", "--files", str(folder)]).stdout


def test_a_run_whose_script_caught_an_error_of_a_writer_came_to_its_end(tmp_path):
    done = started(tmp_path, CATCHING)
    assert done.returncode == 1
    assert "the script caught an error and went on" in done.stderr
    assert ": 0 faults" in verified(tmp_path / "out/coco")
    told = verified(tmp_path / "out/own")
    assert "frame 1: a writer did not get to its end, so files may be missing: Failing: ValueError" in told
    assert "unfinished" not in told


def test_processes_whose_script_caught_an_error_leave_what_one_leaves(tmp_path):
    one = started(tmp_path, CATCHING)
    several = started(tmp_path, CATCHING, options=["--workers", "2"], out="several")
    assert several.returncode == 1
    (said,) = several.stderr.splitlines()
    assert said in one.stderr
    assert "the script caught an error and went on" in said
    assert content(tmp_path / "several") == content(tmp_path / "out")


def test_a_process_whose_script_ends_before_its_frames_are_made_has_failed(tmp_path):
    several = started(tmp_path, CATCHING.replace("pass", "break"), options=["--workers", "2"])
    assert several.returncode == 1
    assert "the script ended after 2 frames here" in several.stderr
    assert "run it without --workers" in several.stderr


@pytest.mark.parametrize("raised", ["asyncio.CancelledError()", "GeneratorExit", "type('Own', (BaseException,), {})"])
def test_an_exception_that_is_no_error_of_python_has_the_traceback_of_the_script(tmp_path, raised):
    done = started(tmp_path, SCENE + f"import asyncio\nrep.orchestrator.step()\nraise {raised}\n")
    assert done.returncode == 1
    first, frame, *_ = done.stderr[done.stderr.index("Traceback") :].splitlines()
    assert first == "Traceback (most recent call last):"
    assert frame == f'  File "{tmp_path / "script.py"}", line {SCENE.count(chr(10)) + 3}, in <module>'
    assert done.stderr.count('  File "') == 1
    told = verified(tmp_path / "out/coco")
    assert "the run is unfinished: 1 frame is whole" in told
    assert ": 1 fault;" in told


def test_what_a_writer_that_failed_did_not_write_is_named_by_repair_and_resume(tmp_path):
    """Only damaged files that it did write are made again."""
    started(tmp_path, CATCHING)
    own = tmp_path / "out/own"
    before = content(own)
    for name in ("1.txt", "2.txt"):
        (own / name).unlink()
    done = run(["-m", "usdsdg", "repair", "-q", str(own)])
    failed, last = done.stdout.splitlines()
    assert done.returncode == 1
    assert "frame 1: a writer did not get to its end, so files may be missing: Failing: ValueError" in failed
    assert "make the dataset anew with --overwrite" in failed
    assert "2 files repaired, 0 left; frames 1-2 made again; 1 frame at which a writer failed is left" in last
    assert content(own) == before
    again = started(tmp_path, CATCHING, options=["--resume"])
    assert f"{own}: a writer failed at frame 1; what it did not write is not made again" in " ".join(
        again.stderr.split()
    )
    assert content(own) == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_threads_get_no_frames_once_a_signal_ends_the_run(tmp_path, number):
    done = started(tmp_path, THREADS, str(int(number)))
    assert done.returncode == 128 + number, done.stderr
    told = verified(tmp_path / "out/coco").splitlines()
    assert "the run is unfinished" in told[0]
    assert ": 1 fault;" in told[-1]


LEFT_BEHIND = (
    SCENE
    + """
def many():
    while True:
        rep.orchestrator.step()
rep.orchestrator.step()
for _ in range(3):
    threading.Thread(target=many, daemon=True).start()
time.sleep(0.5)
if sys.argv[2:]:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(60)
"""
)


@pytest.mark.parametrize("start", [started, ended_alone])
def test_daemon_threads_that_capture_end_their_frame_where_the_script_ends(start, tmp_path):
    done = start(tmp_path, LEFT_BEHIND)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    (told,) = verified(tmp_path / "out/coco").splitlines()
    assert ": 0 faults" in told


def test_daemon_threads_that_capture_leave_whole_files_after_ctrl_c(tmp_path):
    done = ended_alone(tmp_path, LEFT_BEHIND.replace("import os", "import os, signal"), "interrupt")
    assert done.returncode in (-2, 1, 130)  # 1: another thread was importing, which lets Python forget of the interrupt
    assert done.stderr.count("Traceback") == 1
    assert "Fatal Python error" not in done.stderr
    told = verified(tmp_path / "out/coco").splitlines()
    assert "the run is unfinished" in told[0]
    assert ": 1 fault;" in told[-1]


CUT_OFF = (
    SCENE
    + """
class Interrupted(rep.Writer):
    def __init__(self):
        self.backend = rep.backends.get("DiskBackend", init_params={"output_dir": sys.argv[1] + "/own"})
        self.annotators = ["rgb"]
    def write(self, data):
        self.backend.write_blob(f"{threading.current_thread().name}{time.monotonic_ns()}.txt", b"1")
        if threading.current_thread() is threading.main_thread() and others.is_set():
            raise KeyboardInterrupt
others = threading.Event()
Interrupted().attach(product)
def many():
    while True:
        rep.orchestrator.step()
        others.set()
for _ in range(3):
    threading.Thread(target=many, daemon=True).start()
others.wait()
try:
    rep.orchestrator.step()
except KeyboardInterrupt:
    if sys.argv[2] == "end":
        raise
    others.clear()
    others.wait()
    sys.exit(3)
"""
)


@pytest.mark.parametrize(("script", "code"), [("end", 130), ("go on", 3)])
def test_threads_wait_until_an_interrupted_frame_has_ended_the_run(tmp_path, script, code):
    done = started(tmp_path, CUT_OFF, script)
    assert done.returncode == code, done.stderr
    told = verified(tmp_path / "out/own")
    assert ("it was interrupted" in told) == (script == "go on")
    assert "the run is unfinished" in told  # its exit code tells that it failed

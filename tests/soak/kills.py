"""Runs that are ended at random moments and resumed: `python -m tests.soak kills` compares every byte at the end.

The job drops parts into a bin and writes PoseWriter's files and COCO. Each trial ends its process once or several
times, by --how: kill (SIGKILL), term, hup, int, full (the disk is full; needs the right to mount a tmpfs), worker
(one of the processes of --workers 3 is killed, at times the one that waits for them, too), removed (the output folder
is removed, which is an error of one line, and the run begun again), bucket (SIGKILL while it writes to a bucket), or
gone (the server of the bucket does not answer for 20 s, which the run outlasts).
"""

import argparse
import contextlib
import logging
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

from tests.cli.datasets import content
from tests.soak.command_runs import POLL_SECONDS, CommandRun
from tests.soak.processor_time import processor_seconds
from tests.stores.servers import KEYS, Bucket, FailingProxy

JOB = """
job: bin_picking
seed: 4
resolution: [64, 48]
drops: 3
frames_per_drop: 4
parts: {per_bin: [3, 5], max_time: 0.5, collider: convexHull}
cameras: {count: 2}
rendering: {samples: 4}
formats: {pose: {skip_empty_frames: true}, coco: {}}
"""
SIGNALS = {"kill": signal.SIGKILL, "term": signal.SIGTERM, "hup": signal.SIGHUP, "int": signal.SIGINT}
HOWS = (*SIGNALS, "full", "worker", "removed", "bucket", "gone")
FULL = 150_000  # bytes of a disk that becomes full
GONE_SECONDS = 20.0


class Trials:
    """Trials that compare with one run that was not interrupted."""

    def __init__(self, folder: Path, most_ends: int) -> None:
        """most_ends: how often a dataset is ended before it is left to its end."""
        self._folder, self._most_ends, self._random = folder, most_ends, random.Random()
        (folder / "job.yaml").write_text(JOB)
        whole = self._start(folder / "whole")
        if whole.wait():
            sys.exit(f"the uninterrupted run failed with {whole.returncode}: {whole.said}")
        self._processor_seconds = whole.processor_seconds
        self._whole = content(folder / "whole")

    def run(self, how: str, seed: int) -> str | None:
        """Run one trial; return what is wrong."""
        self._random.seed(seed)
        if how in ("bucket", "gone"):
            return self._differences(*(self._kill_at_bucket() if how == "bucket" else self._outlast()))
        out = self._folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        own = {"full": self._fill, "worker": self._kill_workers, "removed": self._remove}
        ends: Callable[[Path], None] = own.get(how) or self._signal(how)
        for _ in range(self._random.randint(1, self._most_ends)):
            ends(out)
        last = self._start(out, *self._resume(out))
        return self._differences(last, lambda: content(out))

    def _differences(self, last: CommandRun, read: Callable[[], dict[str, bytes]]) -> str | None:
        """Wait for the last run; return what is wrong with what it has left."""
        if last.wait():
            return f"the last run ended with {last.returncode}: {last.said}"
        found = read()
        differ = [name for name in sorted({*found, *self._whole}) if found.get(name) != self._whole.get(name)]
        return f"{len(differ)} files differ: {differ[:5]}" if differ else None

    def _signal(self, how: str) -> Callable[[Path], None]:
        def end(out: Path) -> None:
            run = self._start(out, *self._resume(out))
            self._wait_at_random(run)
            run.send(SIGNALS[how])
            run.wait()

        return end

    def _fill(self, out: Path) -> None:
        """Let the disk be full after some bytes; what is there then is resumed on a larger one."""
        disk = self._folder / "disk"
        disk.mkdir(exist_ok=True)
        size = self._random.randint(FULL // 20, FULL)
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(disk)], check=True)
        try:
            self._start(disk / "out").wait()
            shutil.rmtree(out, ignore_errors=True)
            if (disk / "out").exists():
                shutil.copytree(disk / "out", out)
        finally:
            subprocess.run(["umount", str(disk)], check=True)

    def _remove(self, out: Path) -> None:
        run = self._start(out)
        self._wait_at_random(run, first=0.3)
        shutil.rmtree(out, ignore_errors=True)
        said = f"{run.wait()} {run.said}"
        shutil.rmtree(out, ignore_errors=True)  # what was written between
        if run.returncode not in (0, 1) or "Traceback" in said:
            raise SystemExit(f"a run of which the folder was removed ended with {said}")

    def _kill_at_bucket(self) -> tuple[CommandRun, Callable[[], dict[str, bytes]]]:
        bucket = _Bucket()
        for _ in range(self._random.randint(1, self._most_ends)):
            run = self._start(bucket.place, *(["--resume"] if bucket.objects else []))
            self._wait_at_random(run)
            run.kill()
        return self._start(bucket.place, *(["--resume"] if bucket.objects else [])), lambda: _in(bucket)

    def _outlast(self) -> tuple[CommandRun, Callable[[], dict[str, bytes]]]:
        bucket, gone = _Bucket(), threading.Event()
        with FailingProxy(bucket.port, lambda *_: "drop" if gone.is_set() else "pass") as proxy:
            os.environ["AWS_ENDPOINT_URL"] = proxy.url
            run = self._start(bucket.place)
            self._wait_at_random(run, first=0.2)
            gone.set()
            time.sleep(GONE_SECONDS)
            gone.clear()
            run.wait()
        return run, lambda: _in(bucket)

    def _kill_workers(self, out: Path) -> None:
        first = self._start(out, *self._resume(out), "--workers", "3")
        for _ in range(self._random.randint(1, 2)):
            self._wait_at_random_for_children(first)
            if children := _children(first.pid):
                _kill(self._random.choice(children))
        if self._random.random() < 0.5:
            for pid in (first.pid, *_children(first.pid)):
                _kill(pid)
        if first.wait() not in (0, -signal.SIGKILL):
            raise SystemExit(f"--workers ended with {first.returncode}: {first.said}")

    def _wait_at_random(self, run: CommandRun, *, first: float = 0.0) -> None:
        """Wait for a moment of a run: it is drawn from its processor time, which other work beside it leaves alone."""
        run.wait_for_processor_seconds(self._random.uniform(first, 1.0) * self._processor_seconds)

    def _wait_at_random_for_children(self, run: CommandRun) -> None:
        """As `_wait_at_random`, of the processes that a run has started, which import what the run has imported."""
        until = self._random.uniform(0.0, 2.0) * self._processor_seconds
        spent: dict[int, float] = {}
        while not run.has_ended() and sum(spent.values()) < until:
            time.sleep(POLL_SECONDS)
            spent |= {pid: processor_seconds(pid) for pid in _children(run.pid)}

    def _resume(self, out: Path) -> list[str]:
        return ["--resume"] if (out / "pose/.usdsdg").exists() or (out / "coco/.usdsdg").exists() else []

    def _start(self, out: Path | str, *options: str) -> CommandRun:
        arguments = ["generate", "-q", str(self._folder / "job.yaml"), "--device", "cpu"]
        return CommandRun([*arguments, "--set", f"output_dir={out}", *options])


class _Bucket(Bucket):
    """A bucket that processes which are started find."""

    def __init__(self) -> None:
        super().__init__()
        self.place = f"s3://{self.name}/out"
        os.environ.update(KEYS | {"AWS_REGION": "us-east-1", "AWS_ENDPOINT_URL": self.url})


def _in(bucket: Bucket) -> dict[str, bytes]:
    return {key.removeprefix("out/"): data for key, data in bucket.objects.items()}


def _children(pid: int) -> list[int]:
    try:
        return [int(each) for each in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def _kill(pid: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--how", nargs="+", choices=HOWS, default=["kill"])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--ends", type=int, default=3, help="how often a dataset is ended at most")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    options = parser.parse_args()
    logging.getLogger("werkzeug").setLevel(logging.ERROR)  # of the server of buckets, each request
    wrong = 0
    folder = tempfile.mkdtemp()  # no object, which copies of this process would remove at their end
    try:
        trials = Trials(Path(folder), options.ends)
        for how in options.how:
            for seed in range(options.first, options.first + options.count):
                problem = trials.run(how, seed)
                wrong += problem is not None
                print(f"{how} {seed}: {problem or 'equal'}", flush=True)
    finally:
        shutil.rmtree(folder)
    print(f"{wrong} wrong")
    return int(wrong > 0)

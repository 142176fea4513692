"""Runs that are ended at random moments and gone on with: `python -m tests.soak kills` compares every byte at the end.

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

from tests.cli.datasets import ROOT, content
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
MOST_ENDS = 3  # of one dataset
FULL = 150_000  # bytes of a disk that becomes full
GONE_SECONDS = 20.0


class Trials:
    """Trials that compare with one run that was not interrupted."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._random = folder, random.Random()
        (folder / "job.yaml").write_text(JOB)
        self._seconds = 0.0
        started = time.monotonic()
        whole = self._start(folder / "whole")
        if whole.wait():
            sys.exit(f"the uninterrupted run failed with {whole.returncode}: {_said(whole)}")
        self._seconds, self._whole = time.monotonic() - started, content(folder / "whole")

    def run(self, how: str, seed: int) -> str | None:
        """Run one trial; return what is wrong."""
        self._random.seed(seed)
        if how in ("bucket", "gone"):
            return self._differences(*(self._kill_at_bucket() if how == "bucket" else self._outlast()))
        out = self._folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        own = {"full": self._fill, "worker": self._kill_workers, "removed": self._remove}
        ends: Callable[[Path], None] = own.get(how) or self._signal(how)
        for _ in range(self._random.randint(1, MOST_ENDS)):
            ends(out)
        last = self._start(out, *self._resume(out))
        return self._differences(last, lambda: content(out))

    def _differences(self, last: subprocess.Popen[str], read: Callable[[], dict[str, bytes]]) -> str | None:
        """Wait for the last run; return what is wrong with what it has left."""
        if last.wait():
            return f"the last run ended with {last.returncode}: {_said(last)}"
        found = read()
        differ = [name for name in sorted({*found, *self._whole}) if found.get(name) != self._whole.get(name)]
        return f"{len(differ)} files differ: {differ[:5]}" if differ else None

    def _signal(self, how: str) -> Callable[[Path], None]:
        def end(out: Path) -> None:
            process = self._start(out, *self._resume(out))
            time.sleep(self._random.uniform(0.0, self._seconds))
            process.send_signal(SIGNALS[how])
            process.wait()

        return end

    def _fill(self, out: Path) -> None:
        """Let the disk be full after some bytes; what is there then is gone on with on a larger one."""
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
        process = self._start(out)
        time.sleep(self._random.uniform(0.3, 1.0) * self._seconds)
        shutil.rmtree(out, ignore_errors=True)
        said = f"{process.wait()} {_said(process)}"
        shutil.rmtree(out, ignore_errors=True)  # what was written between
        if process.returncode not in (0, 1) or "Traceback" in said:
            raise SystemExit(f"a run of which the folder was removed ended with {said}")

    def _kill_at_bucket(self) -> tuple[subprocess.Popen[str], Callable[[], dict[str, bytes]]]:
        bucket = _Bucket()
        for _ in range(self._random.randint(1, MOST_ENDS)):
            process = self._start(bucket.place, *(["--resume"] if bucket.objects else []))
            time.sleep(self._random.uniform(0.0, self._seconds))
            process.kill()
            process.wait()
        return self._start(bucket.place, *(["--resume"] if bucket.objects else [])), lambda: _in(bucket)

    def _outlast(self) -> tuple[subprocess.Popen[str], Callable[[], dict[str, bytes]]]:
        bucket, gone = _Bucket(), threading.Event()
        with FailingProxy(bucket.port, lambda *_: "drop" if gone.is_set() else "pass") as proxy:
            os.environ["AWS_ENDPOINT_URL"] = proxy.url
            process = self._start(bucket.place)
            time.sleep(self._random.uniform(0.2, 1.0) * self._seconds)
            gone.set()
            time.sleep(GONE_SECONDS)
            gone.clear()
            process.wait()
        return process, lambda: _in(bucket)

    def _kill_workers(self, out: Path) -> None:
        first = self._start(out, *self._resume(out), "--workers", "3")
        for _ in range(self._random.randint(1, 2)):
            time.sleep(self._random.uniform(0.0, self._seconds))
            children = _children(first.pid)
            if children:
                _kill(self._random.choice(children))
        if self._random.random() < 0.5:
            for pid in (first.pid, *_children(first.pid)):
                _kill(pid)
        if first.wait() not in (0, -signal.SIGKILL):
            raise SystemExit(f"--workers ended with {first.returncode}: {_said(first)}")

    def _resume(self, out: Path) -> list[str]:
        return ["--resume"] if (out / "pose/.usdsdg").exists() or (out / "coco/.usdsdg").exists() else []

    def _start(self, out: Path | str, *options: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "usdsdg", "generate", "-q", str(self._folder / "job.yaml"), "--device", "cpu"]
        command += ["--set", f"output_dir={out}", *options]
        said = tempfile.TemporaryFile("w+")  # noqa: SIM115 - closed with the process
        process = subprocess.Popen(command, cwd=ROOT, stdout=said, stderr=subprocess.STDOUT, text=True)
        process.said = said  # type: ignore[attr-defined]
        return process


class _Bucket(Bucket):
    """A bucket that processes which are started find."""

    def __init__(self) -> None:
        super().__init__()
        self.place = f"s3://{self.name}/out"
        os.environ.update(KEYS | {"AWS_REGION": "us-east-1", "AWS_ENDPOINT_URL": self.url})


def _in(bucket: Bucket) -> dict[str, bytes]:
    return {key.removeprefix("out/"): data for key, data in bucket.objects.items()}


def _said(process: subprocess.Popen[str]) -> str:
    said = process.said  # type: ignore[attr-defined]
    said.seek(0)
    return said.read()[-2000:]


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
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    options = parser.parse_args()
    logging.getLogger("werkzeug").setLevel(logging.ERROR)  # of the server of buckets, each request
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        trials = Trials(Path(folder))
        for how in options.how:
            for seed in range(options.first, options.first + options.count):
                problem = trials.run(how, seed)
                wrong += problem is not None
                print(f"{how} {seed}: {problem or 'equal'}", flush=True)
    print(f"{wrong} wrong")
    return int(wrong > 0)

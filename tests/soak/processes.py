"""Many processes that make one dataset and are ended at random moments: `python -m tests.soak processes`.

Each trial makes a dataset with up to --workers processes, or with parts that begin and end at random moments, ends some
of them, or all, by SIGKILL, SIGTERM or Ctrl-C, and goes on with --resume. What is there at the end must be, byte by
byte, what one process makes alone. Trials of --place bucket write to a bucket.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import logging
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from tests import forked
from tests.capture.part_runs import content
from tests.forked.client import EXECUTABLE
from tests.soak.kills import JOB
from tests.stores.servers import KEYS, Bucket

FRAMES = 24
SCRIPT = """\
import random
import sys

import omni.replicator.core as rep
import omni.usd

OUT = sys.argv[1]
cubes = rep.create.cube(count=3, semantics=[('class', 'cube')])
balls = rep.create.sphere(count=2, semantics=[('class', 'ball')])
rep.create.light(light_type='dome')
camera = rep.create.camera(position=(8, 1, 3), look_at=(0, 0, 0))
product = rep.create.render_product(camera, (64, 48))
with rep.trigger.on_frame():
    with cubes:
        rep.modify.pose(position=rep.distribution.uniform((-2, -2, 0), (2, 2, 2)))
        rep.randomizer.color(colors=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
kinds = [
    ('BasicWriter', 'basic', dict(rgb=True, semantic_segmentation=True, bounding_box_2d_tight=True)),
    ('CocoWriter', 'coco', dict(splits={'train': 2, 'val': 1})),
    ('YoloWriter', 'yolo', dict(task='segment')),
    ('KittiWriter', 'basic/below', dict(bbox_height_threshold=2)),
]
for kind, folder, options in kinds:
    writer = rep.writers.get(kind)
    writer.initialize(output_dir=f'{OUT}/{folder}', **options)
    writer.attach(product)
for frame in range(24):
    if frame % 5 == 3:
        rep.create.cone(position=(random.random(), 1, 1), semantics=[('class', f'new_{frame}')])
    rep.orchestrator.step()
rep.orchestrator.wait_until_complete()
"""
SIGNALS = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
ENDS = {0, 130, 129, 143, -2, -1, -9, -15}  # of a process that is ended, and of one that was too fast
# What those may say that were there while others had the dataset, or lost a process to this program.
REFUSALS = (
    "another process is writing",
    "ended with exit code",
    "are unfinished",
    "has no parts to be joined",
    "has parts of --workers",
)


class Command(subprocess.Popen[str]):
    """A process of `usdsdg`, in a group of its own, of which all that it prints is kept in a file."""

    def __init__(self, arguments: Sequence[str], folder: Path, variables: Mapping[str, str]) -> None:
        """Start it in a folder."""
        self._output = tempfile.TemporaryFile("w+")  # noqa: SIM115 - closed with the process
        super().__init__(
            [*forked.command(), "-m", "usdsdg", *arguments], env=variables, cwd=folder, text=True,
            stdin=subprocess.DEVNULL, stdout=self._output, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip

    def said(self) -> str:
        """Return the end of what it has printed."""
        self._output.seek(0)
        return self._output.read()[-3000:]


class Commands:
    """Starts commands of one job in forks, each in a group of its own."""

    def __init__(self, kind: str, folder: Path) -> None:
        """kind: "run", a script, or "generate", a job."""
        self.kind, self.folder = kind, folder
        self.file = folder / ("script.py" if kind == "run" else "job.yaml")
        self.file.write_text(SCRIPT if kind == "run" else JOB.replace("drops: 3", "drops: 6"))
        self.variables = {**os.environ, EXECUTABLE: forked.executable()}

    def start(self, out: str, *options: str) -> Command:
        """Start one that makes frames in `out`."""
        given = ["--device", "cpu", "-q", *options]
        if self.kind == "run":
            arguments = ["run", *given, *([] if "--workers" in options else ["--threads", "1"]), str(self.file), out]
        else:
            arguments = ["generate", *given, str(self.file), "--set", f"output_dir={out}"]
        return self.command(*arguments)

    def command(self, *arguments: str) -> Command:
        """Start any command."""
        return Command(arguments, self.folder, self.variables)


class Trials:
    """Trials that compare with one run that was not interrupted."""

    def __init__(self, kind: str, place: str, folder: Path, most: int) -> None:
        """most: processes at once."""
        self._place, self._folder, self._most = place, folder, most
        self._commands = Commands(kind, folder)
        whole = self._commands.start(str(folder / "whole"))
        begun = time.monotonic()
        if whole.wait():
            raise SystemExit(f"the uninterrupted run failed: {whole.said()}")
        self._seconds = min(time.monotonic() - begun, 8.0)  # the first run may have compiled kernels
        self._whole = content(folder / "whole")
        self._problems: list[str] = []

    def run(self, seed: int) -> str:
        """Run one trial; return what is wrong."""
        self._draws, self._problems = random.Random(seed), []
        out, read = self._new_place(seed)
        how = self._draws.choice(["workers", "workers", "parts"])
        made = self._make_by_workers(out) if how == "workers" else self._make_in_parts(out)
        if not made:
            return f"{how}: {'; '.join(self._problems)}"
        found = read()
        differ = [name for name in sorted({*found, *self._whole}) if found.get(name) != self._whole.get(name)]
        wrong = [*self._problems, *([f"{len(differ)} files differ: {differ[:8]}"] if differ else [])]
        return f"{how}: {'; '.join(wrong)}" if wrong else ""

    def _new_place(self, seed: int):
        if self._place == "bucket":
            bucket = Bucket()
            self._commands.variables |= KEYS | {"AWS_REGION": "us-east-1", "AWS_ENDPOINT_URL": bucket.url}
            return f"s3://{bucket.name}/out", lambda: {
                key.removeprefix("out/"): data for key, data in bucket.objects.items()
            }
        out = self._folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        return str(out), lambda: content(out)

    def _make_by_workers(self, out: str) -> bool:
        """Begin with some processes, end some or all, and go on until one is left alone."""
        draws, begun = self._draws, False
        for _ in range(draws.randint(0, 4)):
            count = draws.randint(1, self._most)
            options = ["--workers", str(count)] if count > 1 else []
            process = self._commands.start(out, *options, *(["--resume"] if begun else []))
            begun = True
            for _ in range(draws.randint(1, 3)):
                self._pause(process)
                self._end_one_of(process)
            if draws.random() < 0.3:
                self._end_whole_group(process)
            elif draws.random() < 0.5:
                self._send(process.pid, draws.choice(SIGNALS))
            self._wait(process, ok=ENDS)
            self._wait_for_orphans(process)
        options = ["--workers", str(draws.randint(2, self._most)), *(["--resume"] * begun)]
        for _ in range(20):
            last = self._commands.start(out, *options)
            if last.wait() == 0 or "another process is writing" not in last.said():
                break
            time.sleep(0.5)  # forks of killed clients are ended by others, a little later
        return self._wait(last, ok={0})

    def _make_in_parts(self, out: str) -> bool:
        """Let parts be made by processes that begin one after the other, all at once; those that are ended go on."""
        draws = self._draws
        edges = sorted({0, FRAMES, *(draws.randrange(1, FRAMES) for _ in range(draws.randint(1, self._most - 1)))})
        if draws.random() < 0.3:
            count = draws.randint(2, self._most)
            waiting = [["--shard", f"{part}/{count}"] for part in range(count)]
        else:
            waiting = [["--frames", f"{first}:{last}"] for first, last in itertools.pairwise(edges)]
        draws.shuffle(waiting)
        running: list[tuple[list[str], Command]] = []
        ends = draws.randint(0, 2 * len(waiting))
        while waiting or running:
            if waiting and (len(running) < self._most) and (draws.random() < 0.7 or not running):
                part = waiting.pop(0)
                # A part that was begun needs --resume; the option may also be given to one that was not.
                options = part if "--resume" in part or draws.random() < 0.5 else [*part, "--resume"]
                running.append((part, self._commands.start(out, *options)))
            time.sleep(draws.uniform(0, 0.3))
            if ends and running and draws.random() < 0.3:
                ends -= 1
                self._send(draws.choice(running)[1].pid, draws.choice(SIGNALS))
            if draws.random() < 0.1:
                early = self._commands.command("merge", out)  # which has to refuse, and to leave all as it is
                early.wait()
            for each in [each for each in running if each[1].poll() is not None]:
                running.remove(each)
                part, process = each
                if process.returncode == 0:
                    continue
                if process.returncode not in ENDS and not any(text in process.said() for text in REFUSALS):
                    self._problems.append(f"{part} ended with {process.returncode}: {process.said()}")
                    return self._end_all(running)
                waiting.append([*(p for p in part if p != "--resume"), "--resume"])
        return self._merged(out)

    def _merged(self, out: str) -> bool:
        """Join the parts, which an early merge may have done already."""
        for place in self._folders_in(out):
            process = self._commands.command("merge", place)
            if process.wait() and "it is whole already" not in process.said():
                self._problems.append(f"merge ended with {process.returncode}: {process.said()}")
                return False
        return True

    def _folders_in(self, out: str) -> list[str]:
        if self._commands.kind == "run":
            return [f"{out}/{name}" for name in ("basic", "coco", "yolo", "basic/below")]
        return [f"{out}/{name}" for name in ("pose", "coco")]

    def _end_all(self, running: Sequence[tuple[list[str], Command]]) -> bool:
        for _, process in running:
            process.kill()
            process.wait()
        return False

    def _pause(self, process: Command) -> None:
        """Wait for a random time, or until a process has ended."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(self._draws.uniform(0, self._draws.choice([0.3, 1, 1, 2])) * self._seconds)

    def _end_one_of(self, process: Command) -> None:
        """End one of the processes that make parts."""
        if workers := self._workers_of(process):
            self._send(self._draws.choice(workers), self._draws.choice(SIGNALS[:3]))

    def _end_whole_group(self, process: Command) -> None:
        for pid in [process.pid, *self._workers_of(process)]:
            self._send(pid, signal.SIGKILL)

    def _workers_of(self, process: Command) -> list[int]:
        """Return the processes that a process has started: clients of the server of forks."""
        token = f"{self._folder}".encode()
        found = []
        for each in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                words = (each / "cmdline").read_bytes()
                if b"client.py" in words and token in words and b"--resume\0--quiet" in words:
                    found.append(int(each.name))
        return sorted(found)

    def _wait_for_orphans(self, process: Command) -> None:
        """End what a killed process has left."""
        until = time.monotonic() + 240  # as others do that make parts, where a machine has much to do
        for pid in self._workers_of(process):
            if self._draws.random() < 0.5:
                self._send(pid, signal.SIGKILL)
        while self._workers_of(process):
            time.sleep(0.05)
            if time.monotonic() > until:
                for pid in self._workers_of(process):  # which would write to the folder while it is removed
                    self._send(pid, signal.SIGKILL)
                raise SystemExit("processes of workers do not end")
        time.sleep(0.1)  # until forks of killed clients have ended

    def _send(self, pid: int, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)

    def _wait(self, process: Command, *, ok: set[int]) -> bool:
        try:
            code = process.wait(timeout=240)
        except subprocess.TimeoutExpired:
            process.kill()
            self._problems.append(f"HANGS: {process.said()}")
            return False
        said = process.said()
        if code in ok and "Traceback" not in said:
            return True
        if 0 not in ok or len(ok) == 1 or not any(text in said for text in REFUSALS):
            self._problems.append(f"{process.args[6:]} ended with {code}: {said}")
        return False


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", nargs="+", choices=("run", "generate"), default=["run", "generate"])
    parser.add_argument("--place", choices=("folder", "bucket"), default="folder")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--workers", type=int, default=12)
    parser.add_argument("--keep", type=Path, help="a folder for what trials that fail have left")
    options = parser.parse_args()
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    wrong = 0
    for kind in options.kind:
        with tempfile.TemporaryDirectory(prefix="usdsdg-processes-") as folder:
            trials = Trials(kind, options.place, Path(folder), options.workers)
            for seed in range(options.first, options.first + options.count):
                begun = time.monotonic()
                problem = trials.run(seed)
                wrong += bool(problem)
                if problem and options.keep is not None:
                    kept = options.keep / f"{kind}-{options.place}-{seed}"
                    shutil.copytree(Path(folder), kept, dirs_exist_ok=True)
                print(f"{kind} {seed}: {problem or 'equal'} ({time.monotonic() - begun:.0f} s)", flush=True)
    print(f"{wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())

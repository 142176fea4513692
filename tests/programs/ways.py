"""Ways to run a script that must leave the same files, and the smallest script for which one does not."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import random
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from tests import forked
from tests.capture.part_runs import cut, folders
from tests.cli.datasets import content
from tests.programs.blocks import Block, Script

OUTPUT = "out"


class Refused(Exception):
    """A run ended with an error."""


def usdsdg(folder: Path, *arguments: str, fresh: bool = False) -> str:
    """Run a command of usdsdg in a folder and return what it prints.

    Raises:
        Refused: It ended with an error.
    """
    folder.mkdir(parents=True, exist_ok=True)
    done = forked.run(["-m", "usdsdg", *arguments], cwd=folder, fresh=fresh, timeout=200)
    if done.returncode:
        raise Refused(f"exit code {done.returncode}: {(done.stderr or done.stdout).strip()[-3000:]}")
    return done.stdout + done.stderr


def run(folder: Path, *options: str) -> str:
    """Run `script.py`, which lies beside the folder, into `out` below it."""
    options = (*options, "--device", "cpu") + (() if "--threads" in options else ("--threads", "1"))
    return usdsdg(folder, "run", "-q", *options, "../script.py", OUTPUT)


def plain(folder: Path, draws: random.Random) -> None:
    run(folder)


def threads(folder: Path, draws: random.Random) -> None:
    run(folder, "--threads", "2")


def workers(folder: Path, draws: random.Random) -> None:
    run(folder, "--workers", "2")


def worlds(folder: Path, draws: random.Random) -> None:
    run(folder, "--worlds", draws.choice(["2", "3"]))


def shards(folder: Path, draws: random.Random) -> None:
    for part in draws.sample(["0/2", "1/2"], 2):
        run(folder, "--shard", part)
    usdsdg(folder, "merge", OUTPUT)


def parts(folder: Path, draws: random.Random) -> None:
    frames = count(folder.parent / "plain" / OUTPUT)
    bounds = sorted({0, frames, draws.randint(1, frames), draws.randint(1, frames)})
    spans = [f"{a}:{b}" for a, b in itertools.pairwise(bounds)]
    for span in draws.sample(spans, len(spans)):
        run(folder, "--frames", span)
    usdsdg(folder, "merge", OUTPUT)


def resumed(folder: Path, draws: random.Random, *options: str) -> None:
    whole = folder.parent / "plain" / OUTPUT
    shutil.copytree(whole, folder / OUTPUT)
    after = draws.randint(0, count(whole))
    for home in folders(folder / OUTPUT):
        cut(home, after)
    run(folder, *options, "--resume")


def resumed_by_workers(folder: Path, draws: random.Random) -> None:
    resumed(folder, draws, "--workers", "2")


def reproduced(folder: Path, draws: random.Random) -> None:
    """Compares by itself."""
    frames = count(folder.parent / "plain" / OUTPUT)
    some = draws.choice(
        [[], ["--frames", str(draws.randrange(frames))], ["--frames", f"{draws.randrange(frames)}:{frames}"]]
    )
    said = usdsdg(folder.parent / "plain", "reproduce", "-q", "--device", "cpu", "--threads", "1", OUTPUT, *some)
    assert " different" in said, said
    assert all(line.endswith(" 0 different") for line in said.splitlines() if " different" in line), said


def killed(folder: Path, draws: random.Random) -> None:
    """End the script by SIGKILL, SIGTERM or Ctrl-C at random moments, and go on."""
    for _ in range(draws.randint(1, 3)):
        folder.mkdir(parents=True, exist_ok=True)
        script = ["run", "-q", "--device", "cpu", "--threads", "1", "--resume", "../script.py", OUTPUT]
        begun = subprocess.Popen(
            [*forked.command(), "-m", "usdsdg", *script],
            cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        with contextlib.suppress(subprocess.TimeoutExpired):
            begun.wait(draws.uniform(0.1, 4))
        begun.send_signal(draws.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT]))
        begun.wait(60)
    _go_on(folder)


def _go_on(folder: Path) -> None:
    """Go on as soon as the fork of a client that was killed has ended, too."""
    for attempt in range(20):
        try:
            run(folder, "--resume")
            return
        except Refused as refused:
            if "another process is writing" not in str(refused) or attempt == 19:
                raise
            time.sleep(0.5)


def spawned(folder: Path, draws: random.Random) -> None:
    """Run the script in a process that multiprocessing has spawned."""
    folder.mkdir(parents=True, exist_ok=True)
    given = ["run", "-q", "--device", "cpu", "--threads", "1", "../script.py", OUTPUT]
    variables = {**os.environ, "PYTHONPATH": str(forked.ROOT)}
    done = forked.run(["-m", "tests.programs.spawned", *given], cwd=folder, env=variables, timeout=200, fresh=True)
    if done.returncode:
        raise Refused(f"exit code {done.returncode}: {(done.stderr or done.stdout).strip()[-3000:]}")


def streamed(folder: Path, draws: random.Random) -> None:
    """Compares by itself: what processes of a stream show is the same with any number of them."""
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    for count in ("0", "1", "3"):
        done = forked.run(
            ["-m", "tests.programs.streamed", count, "../script.py", OUTPUT],
            cwd=folder, env={**os.environ, "PYTHONPATH": str(forked.ROOT)}, timeout=200,
        )  # fmt: skip
        if "is not in the class table of this dataset, which all its parts share" in done.stderr:
            return  # a class that comes up late, which such parts have to be told
        if done.returncode:
            raise Refused(f"{count} processes: {(done.stderr or done.stdout).strip()[-3000:]}")
        found.append(json.loads(done.stdout.split("SHOWN ", 1)[1]))
    for count, other in ((1, found[1]), (3, found[2])):
        differ = [key for key in found[0].keys() | other.keys() if found[0].get(key) != other.get(key)]
        assert not differ, f"{count} processes show {len(differ)} of {len(found[0])} otherwise: {sorted(differ)[:9]}"


COMPARED = ("reproduced", "streamed")  # ways that compare by themselves
WAYS: dict[str, Callable[[Path, random.Random], None]] = {
    each.__name__: each
    for each in (plain, threads, workers, worlds, shards, parts, resumed, resumed_by_workers, reproduced)
} | {each.__name__: each for each in (killed, spawned, streamed)}


def count(output: Path) -> int:
    """Return the number of frames of the run that made these datasets."""
    found = 0
    for home in folders(output):
        for line in (home / ".usdsdg/journal.jsonl").read_text().splitlines()[1:-1]:
            found = max(found, json.loads(line)["frame"] + 1)
    return found


def difference(script: Script, way: str, folder: Path, seed: int) -> str:
    """Return what differs between the plain run and another way, or an empty string.

    Raises:
        Refused: A run ended with an error.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "script.py").write_text(script.text)
    run(folder / "plain")
    if way == "plain":
        return ""
    return compared(way, folder, seed)


def compared(way: str, folder: Path, seed: int) -> str:
    """As `difference`, where the plain run has been made."""
    shutil.rmtree(folder / way, ignore_errors=True)
    try:
        WAYS[way](folder / way, random.Random(seed))
    except AssertionError as error:
        return str(error)[:1500]
    except Refused as error:
        return f"REFUSED {error}"
    if way in COMPARED:
        return ""
    mine, theirs = content(folder / way / OUTPUT), content(folder / "plain" / OUTPUT)
    return ", ".join(sorted(name for name in mine.keys() | theirs.keys() if mine.get(name) != theirs.get(name)))


def shrunk(script: Script, fails: Callable[[Script], bool]) -> Script:
    """Return a smallest script, of the lines of a given one, that still fails."""
    changed = True
    while changed:
        changed = False
        for holder, position in reversed(_places(script.blocks)):
            block = holder[position]
            for instead in ([], block.below) if block.below else ([],):
                holder[position : position + 1] = instead
                if fails(script):
                    changed = True
                    break
                holder[position : position + len(instead)] = [block]
            else:
                continue
    return script


def _places(blocks: list[Block]) -> list[tuple[list[Block], int]]:
    return [place for k, block in enumerate(blocks) for place in [(blocks, k), *_places(block.below)]]

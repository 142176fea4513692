"""Runs of one recipe in this process, as several processes or a run that dies and goes on would make them."""

from __future__ import annotations

import contextlib
import gc
import json
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.cli.datasets import content
from usdsdg import orchestrator
from usdsdg.graph.sampling import set_global_seed
from usdsdg.session import session
from usdsdg.session.session import current
from usdsdg.writers.aggregates import finish_run
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.growth import MoreFrames
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import Recipe
from usdsdg.writers.parts import join_parts

# Writes datasets below a folder.
Script = Callable[[Path], None]


def run(
    script: Script,
    folder: Path,
    portion: Portion | None = None,
    mode: Mode = Mode.NEW,
    arguments: Sequence[str] = (),
    growth: MoreFrames | None = None,
) -> None:
    """Run a script as a process of its own would, and close its journals."""
    session.restart()
    try:
        set_global_seed(1)
        recipe = Recipe("python", {"name": "script.py", "sha256": "1"}, device="cpu", arguments=list(arguments))
        current().run.begin(recipe, mode, portion, growth=growth)
        script(folder)
        orchestrator.wait_until_complete()
        finish_run(complete=True)
    finally:
        current().run.release()
        with contextlib.suppress(Exception):
            current().io_queue.wait_until_done()
        session.restart()
        gc.collect()  # writers, which would write their last files when this process ends


def run_parts(script: Script, folder: Path, *portions: str) -> None:
    """Run a script once for each part, "A:B" or "i/n", and join them."""
    for text in portions:
        run(script, folder, Portion.of_shard(text) if "/" in text else Portion.of_frames(text))
    for home in folders(folder):
        join_parts(FolderPlace(home))
    session.restart()


def run_again(script: Script, folder: Path, whole: Path, frames: int) -> None:
    """Resume a run that died after so many frames of `whole`: the files of later ones are not whole."""
    shutil.copytree(whole, folder)
    for home in folders(folder):
        cut(home, frames)
    run(script, folder, mode=Mode.RESUME)


def cut(home: Path, frames: int) -> None:
    """Make a dataset one whose process died after so many frames."""
    journal = home / ".usdsdg/journal.jsonl"
    shared, *lines, _ = journal.read_text().splitlines(keepends=True)
    kept = [line for line in lines if json.loads(line)["frame"] < frames]
    told = shared if kept else '{"shared": {}}\n'
    journal.write_text(told + "".join(kept) + '{"frame": 77, "fil')
    lost = [name for line in lines[len(kept) :] for name in json.loads(line)["files"]]
    for name in lost if kept else [*lost, *json.loads(shared)["shared"]]:
        (home / name).write_bytes(b"of a process that died")


def folders(folder: Path) -> list[Path]:
    """Return the folders with datasets, in the order of their names."""
    return sorted(path.parent.parent for path in folder.rglob(".usdsdg/recipe.json"))


def differences(found: Path, expected: Path) -> list[str]:
    """Return the paths of files that differ, or are in one folder only."""
    mine, theirs = content(found), content(expected)
    return sorted(name for name in mine.keys() | theirs.keys() if mine.get(name) != theirs.get(name))

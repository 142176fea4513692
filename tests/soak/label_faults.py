"""Put every kind of label fault into a dataset: `python -m tests.soak label_faults` tells which are found."""

import argparse
import shutil
import tempfile
from pathlib import Path

from tests.verify import datasets, faults_above
from tests.verify.all_label_faults import KINDS
from usdsdg.verify import verify


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="only kinds whose name contains this")
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--allowed", type=int, default=1, help="how many may be missed")
    options = parser.parse_args()
    missed = 0
    with tempfile.TemporaryDirectory() as temporary:
        clean = datasets.make(Path(temporary) / "clean", frames=options.frames)
        print("| fault | dataset | found | first line |\n|---|---|---|---|")
        for kind in KINDS:
            if options.only in kind.name:
                spoiled = Path(temporary) / "spoiled"
                shutil.rmtree(spoiled, ignore_errors=True)
                shutil.copytree(clean / kind.dataset, spoiled)
                kind.inject(spoiled)
                faults = verify(spoiled).faults
                missed += not faults
                line = faults[0].line() if faults else "**missed**"
                print(f"| {kind.name} | {kind.dataset} | {len(faults)} | {line[:150]} |", flush=True)
        above = render(Path(temporary), options.only, options.frames)
    print(f"{len(KINDS)} kinds, {missed} missed; above the record {len(faults_above.KINDS)}, {above} missed")
    return int(missed > options.allowed or above > 0)


def render(folder: Path, only: str, frames: int) -> int:
    """Put the faults above the record into runs of their own; return how many `--render` misses."""
    missed = 0
    print("\n| fault above the record | without / with --render | first line |\n|---|---|---|")
    for kind in faults_above.KINDS:
        if only in kind.name:
            with faults_above.patched(kind):
                made = datasets.make(folder / kind.name, ("basic",), frames=frames, edit=kind.edit) / "basic"
            plain, again = verify(made).faults, verify(made, render=frames)
            found = again.faults[len(plain) :]
            missed += not found
            line = next((each.line() for each in found if each.file.startswith(".usdsdg")), "**missed**")
            print(f"| {kind.name} | {len(plain)} / {len(again.faults)} | {line[:150]} |", flush=True)
    return missed

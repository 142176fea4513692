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
    parser.add_argument("--first", type=int, default=0, help="the kind to begin with, to go on after another run")
    parser.add_argument("--count", type=int, help="how many kinds; those above the record follow the others")
    options = parser.parse_args()
    chosen = [each for each in (*KINDS, *faults_above.KINDS) if options.only in each.name]
    chosen = chosen[options.first :][: options.count]
    missed = 0
    with tempfile.TemporaryDirectory() as temporary:
        needed = [name for name in datasets.DATASETS if any(each.dataset == name for each in KINDS if each in chosen)]
        clean = datasets.make(Path(temporary) / "clean", needed, frames=options.frames)
        print("| fault | dataset | found | first line |\n|---|---|---|---|")
        for kind in (each for each in KINDS if each in chosen):
            spoiled = Path(temporary) / "spoiled"
            shutil.rmtree(spoiled, ignore_errors=True)
            shutil.copytree(clean / kind.dataset, spoiled)
            kind.inject(spoiled)
            faults = verify(spoiled).faults
            missed += not faults
            line = faults[0].line() if faults else "**missed**"
            print(f"| {kind.name} | {kind.dataset} | {len(faults)} | {line[:150]} |", flush=True)
        kinds_above = [each for each in faults_above.KINDS if each in chosen]
        above = render(Path(temporary), kinds_above, options.frames)
    count = len(chosen) - len(kinds_above)
    print(f"{count} kinds, {missed} missed; above the record {len(kinds_above)}, {above} missed")
    return int(missed > options.allowed or above > 0)


def render(folder: Path, kinds: list[faults_above.Above], frames: int) -> int:
    """Put the faults above the record into runs of their own; return how many `--render` misses."""
    missed = 0
    print("\n| fault above the record | without / with --render | first line |\n|---|---|---|")
    for kind in kinds:
        with faults_above.patched(kind):
            made = datasets.make(folder / kind.name, ("basic",), frames=frames, edit=kind.edit) / "basic"
        plain, again = verify(made).faults, verify(made, render=frames)
        found = again.faults[len(plain) :]
        missed += not found
        line = next((each.line() for each in found if each.file.startswith(".usdsdg")), "**missed**")
        print(f"| {kind.name} | {len(plain)} / {len(again.faults)} | {line[:150]} |", flush=True)
    return missed

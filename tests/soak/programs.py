"""Random scripts, each run in every way that must leave the same files: `python -m tests.soak programs`."""

import argparse
import sys
import tempfile
import time
from collections import Counter
from functools import partial
from pathlib import Path

from tests.programs.blocks import Script
from tests.programs.random_programs import RandomScript
from tests.programs.ways import WAYS, Refused, compared, difference, shrunk


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first script, to go on after another run")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=[way for way in WAYS if way != "plain"])
    parser.add_argument("--shrink", action="store_true", help="print the smallest script that shows a difference")
    parser.add_argument("--folder", type=Path, default=None)
    options = parser.parse_args()
    folder = options.folder or Path(tempfile.mkdtemp())
    found: Counter[str] = Counter()
    for seed in range(options.first, options.first + options.count):
        script = RandomScript(seed).make()
        begun = time.monotonic()
        place = folder / str(seed)
        try:
            difference(script, "plain", place, seed)
        except Refused as error:
            found["failed"] += 1
            print(f"seed {seed} fails: {str(error)[-700:]}", flush=True)
            continue
        equal = True
        for way in options.ways:
            if way == "worlds" and not script.features & {"run", "run_async", "two_runs"}:
                continue  # steps of a script make several frames each then
            if wrong := compared(way, place, seed):
                equal = False
                found[way] += 1
                print(f"seed {seed}, {way}: {wrong[:1500]}", flush=True)
                if options.shrink:
                    smallest = shrunk(script, partial(_fails, way=way, folder=place, seed=seed))
                    print(smallest.text, flush=True)
                    break
        print(f"seed {seed} {sorted(script.features)} {time.monotonic() - begun:.0f} s", flush=True)
        found["equal"] += equal
    print(f"{options.count} scripts: {dict(found)}")
    return int(found["equal"] + found["failed"] < options.count)


def _fails(script: Script, way: str, folder: Path, seed: int) -> bool:
    try:
        wrong = difference(script, way, folder, seed)
    except Refused:
        return False
    return bool(wrong) and not wrong.startswith("REFUSED")


if __name__ == "__main__":
    sys.exit(main())

"""Write one cluttered scene in every dataset format, and ask the formats' own readers and evaluators.

A module for each family of formats, with `rows(folder, frames)`: it writes `frames` frames below `folder`, and yields
what was looked at, what came out, and whether it is as it should be.
"""

import argparse
import importlib
import pkgutil
import tempfile
from pathlib import Path

_SHARED = ("scene", "records")


def main() -> int:
    families = [each.name for each in pkgutil.iter_modules(__path__) if each.name not in _SHARED and not each.ispkg]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=families, help="only this family of formats")
    parser.add_argument("--frames", type=int, default=200)
    options = parser.parse_args()
    wrong = 0
    print("| format | what | found | |\n|---|---|---|---|")
    for family in options.only or families:
        with tempfile.TemporaryDirectory() as folder:
            rows = importlib.import_module(f"tests.soak.formats.{family}").rows(Path(folder), options.frames)
            for what, found, is_right in rows:
                wrong += not is_right
                print(f"| {family} | {what} | {found} | {'' if is_right else '**wrong**'} |", flush=True)
    print(f"{wrong} wrong")
    return int(wrong > 0)

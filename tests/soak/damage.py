"""Damage to a dataset of some 10,000 files: `python -m tests.soak damage` verifies a copy with each kind of it.

Each kind must be found, with no file named that was not touched; it prints how many files a second are compared.
"""

import argparse
import tempfile
import time
from pathlib import Path

from tests.verify import damaged
from tests.verify.damage import HARMLESS, KINDS
from usdsdg.verify import verify

FILES_A_FRAME = 7


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--only", help="part of the name of a kind")
    options = parser.parse_args()
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        whole = damaged.make(Path(folder, "whole"), -(-options.files // FILES_A_FRAME))
        started = time.perf_counter()
        count = verify(whole, labels=False).compared
        print(f"{count} files, {count / (time.perf_counter() - started):.0f} compared a second", flush=True)
        names = [name for name in (*KINDS, *HARMLESS) if options.only is None or options.only in name]
        for seed, name in enumerate(names):
            problem = damaged.wrong(whole, name, Path(folder, "copy"), seed=seed)
            failures += problem is not None
            print(f"{name}: {problem or ('found' if name in KINDS else 'no fault')}", flush=True)
    print(f"{len(names)} kinds, {failures} wrong")
    return int(failures > 0)

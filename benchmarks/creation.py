"""Time to create many prims, which must grow with their number only.

python -m benchmarks.creation [--counts 1000 10000]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import usdsdg as rep
from benchmarks import report
from usdsdg.functional import create_batch
from usdsdg.session.stage_context import new_stage

MAKERS: dict[str, Callable[[int], Any]] = {
    "create.cube(count=n)": lambda n: rep.create.cube(count=n),
    "create.cube(count=n, as_mesh=False)": lambda n: rep.create.cube(count=n, as_mesh=False),
    "the same with labels and positions": lambda n: rep.create.cube(
        count=n, as_mesh=False, semantics={"class": "cube"}, position=[(k, 0, 0) for k in range(n)]
    ),
    "create.light(count=n)": lambda n: rep.create.light(count=n),
    "create.xform(count=n)": lambda n: rep.create.xform(count=n),
    "create.material_omnipbr(count=n)": lambda n: rep.create.material_omnipbr(count=n),
    "functional.create_batch.cube(count=n)": lambda n: create_batch.cube(count=n),
    "functional.create_batch.xform(count=n)": lambda n: create_batch.xform(count=n),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--counts", type=int, nargs="+", default=[1000, 10000])
    counts = parser.parse_args().counts
    report.begin()
    for name, make in MAKERS.items():
        print_row(name, [seconds(make, count) for count in counts], counts)
    print_row("create.group of n items", [seconds_to_group(count) for count in counts], counts)


def print_row(name: str, taken: list[float], counts: list[int]) -> None:
    cells = ", ".join(f"{count:,}: {each:.2f} s" for count, each in zip(counts, taken))
    report.row(f"{name:<40}", cells, target="10,000 in 2 s")


def seconds(make: Callable[[int], object], count: int) -> float:
    """Return the seconds that `make(count)` takes on a new stage."""
    new_stage()
    start = time.perf_counter()
    make(count)
    return time.perf_counter() - start


def seconds_to_group(count: int) -> float:
    new_stage()
    items = rep.create.xform(count=count).get_output_prims()["prims"]
    start = time.perf_counter()
    rep.create.group(items)
    return time.perf_counter() - start


if __name__ == "__main__":
    main()

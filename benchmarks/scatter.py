"""1,000 objects scattered without collisions over a floor and in a box: seconds per execution on one core.

    taskset -c 0 python benchmarks/scatter.py [objects]

Half of the objects are spheres of 2,208 triangles, the others tori and cubes of random size and rotation; on the floor
they cover about a third of it, and stay off a table made of eleven boxes.
"""

from __future__ import annotations

import math
import sys
import time

import numpy as np

import usdsdg as rep
from usdsdg.graph import evaluate
from usdsdg.session.stage_context import current_stage, new_stage


def scene(count: int) -> list[str]:
    """Create objects of 6 to 14 cm in random orientations; return their paths."""
    new_stage()
    rep.set_global_seed(1)
    size, angles = rep.distribution.uniform(0.06, 0.14), rep.distribution.uniform((0, 0, 0), (360, 360, 360))
    kinds = [(rep.create.sphere, count // 2), (rep.create.torus, count // 4), (rep.create.cube, count // 4)]
    paths = [path for make, number in kinds for path in make(count=number, scale=size, rotation=angles).prims]
    evaluate.graph().evaluate()
    return paths


def table(span: float) -> list[str]:
    boxes = [rep.create.cube(position=(0, 0, 0.6), scale=(span / 4, span / 4, 0.05))]
    for angle in np.linspace(0, 2 * math.pi, 10, endpoint=False):
        position = (span / 9 * math.cos(angle), span / 9 * math.sin(angle), 0.3)
        boxes.append(rep.create.cube(position=position, scale=(0.05, 0.05, 0.6)))
    return [path for box in boxes for path in box.prims]


def timed(count: int, build) -> tuple[float, float]:
    """Return the seconds of the first execution, which also reads the meshes, and of the second."""
    paths = scene(count)
    with rep.trigger.on_custom_event("go"):
        build(paths)
    seconds = []
    for _ in range(2):
        rep.utils.send_og_event("go")
        start = time.perf_counter()
        evaluate.graph().evaluate()
        seconds.append(time.perf_counter() - start)
    assert len(paths) == len({tuple(position_of(path)) for path in paths})
    return seconds[0], seconds[1]


def position_of(path: str) -> tuple[float, float, float]:
    return tuple(current_stage().GetPrimAtPath(path).GetAttribute("xformOp:translate").Get())


def over_floor(paths: list[str]) -> None:
    span = math.sqrt(len(paths) * 0.1**2 * 3)
    floor = rep.create.plane(scale=span)
    rep.randomizer.scatter_2d(floor, no_coll_prims=table(span), check_for_collisions=True, input_prims=paths)


def in_box(paths: list[str]) -> None:
    span = (len(paths) * 0.1**3 * 5) ** (1 / 3)
    box = rep.create.cube(scale=span)
    rep.randomizer.scatter_3d(box, check_for_collisions=True, input_prims=paths)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    for name, build in (("scatter_2d", over_floor), ("scatter_3d", in_box)):
        first, second = timed(count, build)
        print(f"{name}: {count} objects, first execution {first:.2f} s, second {second:.2f} s")


if __name__ == "__main__":
    main()

"""Ten randomizers on 1,000 prims: milliseconds of graph evaluation and stage writes per frame, on one core.

python benchmarks/graph_evaluation.py [--prims 1000] [--frames 20]
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import usdsdg as rep
from usdsdg.graph.evaluate import graph


def author(count: int) -> None:
    """Author the pipeline: three poses, a rotation, a color, visibility, two attributes, velocities and masses."""
    draw = rep.distribution
    prims = rep.create.cube(count=count, as_mesh=False)
    with rep.trigger.on_frame(), prims:
        rep.modify.pose(position=draw.uniform((-5, -5, 0), (5, 5, 2)))
        rep.modify.pose(rotation=draw.uniform((0, 0, 0), (360, 360, 360)))
        rep.modify.pose(scale=draw.uniform(0.1, 0.5))
        rep.randomizer.rotation()
        rep.randomizer.color(draw.uniform((0, 0, 0), (1, 1, 1)))
        rep.modify.visibility(draw.choice([True, False]))
        rep.modify.attribute("size", draw.uniform(0.5, 2))
        rep.modify.attribute("wear", draw.normal(0, 1), attribute_type="float")
        rep.physics.rigid_body(velocity=draw.uniform((-1, -1, -1), (1, 1, 1)))
        rep.physics.mass(mass=draw.uniform(1, 2))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--prims", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=20)
    options = parser.parse_args()
    rep.set_global_seed(0)
    author(options.prims)
    milliseconds = []
    for frame in range(options.frames + 1):
        start = time.perf_counter()
        graph().evaluate(capture=frame, preview=frame == 0)
        milliseconds.append(1e3 * (time.perf_counter() - start))
    first, rest = milliseconds[0], milliseconds[1:]
    print(f"{options.prims} prims, 10 randomizers: the first frame {first:.0f} ms, which authors the materials")
    print(f"then {np.median(rest):.1f} ms a frame, the median of {options.frames}; at most {max(rest[1:]):.1f}")


if __name__ == "__main__":
    main()

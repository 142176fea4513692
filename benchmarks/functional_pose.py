"""functional.modify.pose on many prims with arrays: `python benchmarks/functional_pose.py [--prims 1000]`.

New positions, rotations (Euler angles) and scales in each of 50 calls, on existing meshes, without and with a listener
to change notices such as a renderer's. Target: at most 8 ms for 1,000 prims.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from usdsdg.functional import create_batch, modify
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.change_tracker import ChangeTracker


def milliseconds(call, repetitions: int = 50) -> np.ndarray:
    """Return the wall time [ms] of each of several calls."""
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        call()
        times.append((time.perf_counter() - start) * 1e3)
    return np.array(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--prims", type=int, default=1000)
    count = parser.parse_args().prims
    stage = new_stage()
    rng = np.random.default_rng(0)
    cubes = create_batch.cube(count=count, parent="/World")

    def pose() -> None:
        modify.pose(cubes, rng.random((count, 3)), rng.random((count, 3)) * 360, scale_value=rng.random((count, 3)))

    print(f"{count} prims, first call: {milliseconds(pose, 1)[0]:.1f} ms")
    for listening in (False, True):
        tracker = ChangeTracker(stage) if listening else None
        taken = milliseconds(pose)
        what = "position, rotation, scale" + (", with a listener" if tracker else "")
        print(f"{what}: best {taken.min():.2f} ms, median {np.median(taken):.2f} ms, worst {taken.max():.2f} ms")
    taken = milliseconds(lambda: modify.position(cubes, rng.random((count, 3))))
    print(f"position alone: best {taken.min():.2f} ms, median {np.median(taken):.2f} ms")


if __name__ == "__main__":
    main()

"""What physics costs: steps, loading, adding bodies, write-back and queries, in the scene of `physics_scene`.

    python -m benchmarks.physics_speed [--device cpu] [--bodies 10 337 2000] [--frames 60]

On the CPU all times are CPU times of the process, on CUDA wall times. It ends with exit code 1 where a replayed step
differs by a bit from one that is launched from Python, or a run from its repetition.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
from collections.abc import Callable
from unittest import mock

import numpy as np
from pxr import UsdGeom, UsdPhysics

from benchmarks.physics_scene import AREA, SceneMaker
from usdsdg_physics import NewtonEngine
from usdsdg_physics.play import PlaySession
from usdsdg_physics.world import step_records
from usdsdg_physics.world.world import World

DT = 1.0 / 60.0
WARM_UP = 30
MEDIUM = 337


class Clock:
    """CPU time of the process, or wall time where a GPU works."""

    def __init__(self, device: str) -> None:
        self._now = time.process_time if device == "cpu" else time.perf_counter

    def milliseconds(self, work: Callable[[], object]) -> float:
        start = self._now()
        work()
        return 1e3 * (self._now() - start)


def maker(bodies: int) -> SceneMaker:
    """Author the scene, with as much room for each body as the 337 have."""
    stretch = max(1.0, bodies / MEDIUM) ** (1 / 3)
    x, y, z = AREA
    return SceneMaker(bodies, all_gravity=False, area=(stretch * x, stretch * y, stretch * z))


def session_of(engine: NewtonEngine) -> PlaySession:
    assert engine._session is not None
    return engine._session


def world_of(engine: NewtonEngine) -> World:
    world = session_of(engine).world
    assert world is not None
    return world


def report(what: str, milliseconds: float, note: str = "") -> None:
    print(f"{what:48} {milliseconds:9.2f} ms  {note}", flush=True)


def start(engine: NewtonEngine) -> None:
    engine.play()
    engine.advance(DT)
    world_of(engine).poses()


def measure_steps(bodies: int, frames: int, device: str, clock: Clock) -> NewtonEngine:
    """Print loading and the median step of a scene; return its engine."""
    engine = NewtonEngine(maker(bodies).stage, device=device)
    report(f"load {bodies} bodies and take a step", clock.milliseconds(lambda: start(engine)))
    for _ in range(WARM_UP):
        engine.advance(DT)
    steps = [clock.milliseconds(lambda: (engine.advance(DT), world_of(engine).poses())) for _ in range(frames)]
    found = int(world_of(engine)._contacts.rigid_contact_count.numpy()[0])
    report(f"step of {bodies} bodies", float(np.median(steps)), f"{found} contacts, with write-back")
    return engine


def measure_edits(engine: NewtonEngine, clock: Clock) -> None:
    """Print write-back, queries, adding bodies and loading again."""
    session, world = session_of(engine), world_of(engine)
    poses, velocities, rng = world.poses(), world.velocities(), np.random.default_rng(0)

    def write_back(noise: np.ndarray) -> None:
        with session._tracker.muted():
            session._writer.write(poses + noise[:, :1], velocities + noise[:, 1:])

    noises = rng.normal(size=(30, len(poses), 2)).astype(np.float32) * 1e-3
    writes = [clock.milliseconds(lambda noise=noise: write_back(noise)) for noise in noises]
    written = sum(len(channel.specs) for channel in session._writer._channels.values())
    report(f"write-back of {len(poses)} moving bodies", float(np.median(writes)), f"{written} attributes")

    def lower_half() -> int:
        return len(engine.overlap_box((2.475, 2.475, 0.75), (0, 0, -0.75)))

    queries, rays, hits = [], [], 0
    for _ in range(30):
        engine.advance(DT)
        queries.append(clock.milliseconds(lower_half))
        hits = lower_half()
        rays.append(clock.milliseconds(lambda: engine.raycast((0, 0, 1.4), (0.1, 0.2, -1.0), 10.0)))
    report("overlap query after a step", float(np.median(queries)), f"{hits} hits")
    report("ray after a step", float(np.median(rays)))

    adds = []
    for batch in range(3):
        for index in range(10):
            prim = engine._stage.DefinePrim(f"/World/Added/{'abc'[batch]}_{index}", "Cube")
            UsdGeom.Xformable(prim).AddTranslateOp().Set((0.2 * index - 1.0, 0.5 * batch, 0.0))
            UsdGeom.Xformable(prim).AddScaleOp().Set((0.05, 0.05, 0.05))
            UsdPhysics.CollisionAPI.Apply(prim)
            UsdPhysics.RigidBodyAPI.Apply(prim)
        adds.append(clock.milliseconds(lambda: (engine.advance(DT), world_of(engine).poses())))
        engine.advance(DT)
    report("add 10 bodies while playing, with the step", float(np.median(adds)))

    engine.stop()
    report("load again and take a step", clock.milliseconds(lambda: start(engine)))


def digest(device: str, frames: int, *, recorded: bool) -> str:
    """Return a hash of all poses and velocities of a run."""
    found = hashlib.sha256()
    with mock.patch.object(step_records, "RECORD_AT_USE", 2 if recorded else sys.maxsize):
        engine = NewtonEngine(maker(MEDIUM).stage, device=device)
        engine.play()
        for _ in range(frames):
            engine.advance(DT)
            found.update(world_of(engine).poses().tobytes() + world_of(engine).velocities().tobytes())
        engine.stop()
    return found.hexdigest()[:16]


def main() -> int:
    parser = argparse.ArgumentParser(description="What physics costs.")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--bodies", type=int, nargs="+", default=[10, MEDIUM, 2000])
    parser.add_argument("--frames", type=int, default=60)
    options = parser.parse_args()
    clock = Clock(options.device)
    first = NewtonEngine(maker(MEDIUM).stage, device=options.device, progress=lambda *step: print(*step, flush=True))
    report("first load in a process, 337 bodies, and a step", clock.milliseconds(lambda: start(first)))
    first.stop()
    for bodies in options.bodies:
        engine = measure_steps(bodies, options.frames, options.device, clock)
        if bodies == MEDIUM:
            measure_edits(engine, clock)
        engine.stop()
    runs = [digest(options.device, options.frames, recorded=recorded) for recorded in (True, True, False)]
    same = len(set(runs)) == 1
    print(f"recorded, recorded again, unrecorded: {' '.join(runs)}: {'bit-equal' if same else 'DIFFERENT'}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())

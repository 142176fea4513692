"""What physics costs: steps, loading, adding bodies, write-back and queries, in the scene of `physics_scene`.

    python -m benchmarks.physics_speed [--device cpu] [--bodies 10 337 2000] [--frames 60]
    python -m benchmarks.physics_speed --device cuda --worlds 100 [--bodies 20]
    python -m benchmarks.physics_speed --device cuda --empty-cache

On the CPU all times are CPU times of the process, on CUDA wall times. The first form ends with exit code 1 where a
replayed step differs by a bit from one that is launched from Python, or a run from its repetition. `--worlds` lays
copies of a closed box of bodies side by side on one stage; `--empty-cache` compiles the kernels of all shapes as on a
machine that has none.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from unittest import mock

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from benchmarks.physics_scene import AREA, SceneMaker
from usdsdg_physics import NewtonEngine
from usdsdg_physics.play import PlaySession
from usdsdg_physics.world import step_records
from usdsdg_physics.world.world import World

DT = 1.0 / 60.0
WARM_UP = 30
MEDIUM = 337
_KEPT: list[Usd.Stage] = []  # whose layers others refer to by name


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


def worlds(count: int, bodies: int) -> Usd.Stage:
    """Author copies of a scene side by side."""
    copied = SceneMaker(bodies, all_gravity=False).stage
    _KEPT.append(copied)
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    scene = UsdPhysics.Scene.Define(stage, "/PhysicsScene").GetPrim()
    scene.CreateAttribute("physxScene:timeStepsPerSecond", Sdf.ValueTypeNames.UInt).Set(60)
    columns = int(np.ceil(np.sqrt(count)))
    for index in range(count):
        prim = stage.DefinePrim(f"/Worlds/world_{index}", "Xform")
        prim.GetReferences().AddReference(copied.GetRootLayer().identifier, "/World")
        UsdGeom.Xformable(prim).AddTranslateOp().Set((8.0 * (index % columns), 8.0 * (index // columns), 0.0))
    return stage


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


def measure_steps(stage: Usd.Stage, frames: int, device: str, clock: Clock, *, velocities: bool = True) -> NewtonEngine:
    """Print loading and the median step of a scene; return its engine. `velocities`: whether they are written."""
    engine = NewtonEngine(stage, device=device, writes_velocities=lambda: velocities)
    load = clock.milliseconds(lambda: start(engine))
    bodies = len(engine.rigid_bodies)
    report(f"load {bodies} bodies and take a step", load)
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


_PRECOMPILE = """
import sys, time
start = time.perf_counter()
import usdsdg_physics
usdsdg_physics.precompile(
    device=sys.argv[1], progress=lambda *step: print(f"{time.perf_counter() - start:6.1f} s", *step, flush=True)
)
print(f"kernels of all shapes: {time.perf_counter() - start:.1f} s with the imports, {sys.argv[2]}")
"""


def measure_empty_cache(device: str) -> int:
    """Print how long the kernels take with an empty cache, and then with what this left there."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "WARP_CACHE_PATH": folder, "WARP_CACHE_DIR": folder}
        for cache in ("empty cache", "cached"):
            code = subprocess.run([sys.executable, "-c", _PRECOMPILE, device, cache], env=environment).returncode
            if code:
                return code
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description="What physics costs.")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--bodies", type=int, nargs="+")
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--worlds", type=int, default=0)
    parser.add_argument("--empty-cache", action="store_true")
    parser.add_argument(
        "--without-velocities", action="store_true", help="leave them off the stage: /physics/updateVelocitiesToUsd"
    )
    options = parser.parse_args()
    if options.empty_cache:
        return measure_empty_cache(options.device)
    clock = Clock(options.device)
    if options.worlds:
        for bodies in options.bodies or [20]:
            print(f"{options.worlds} worlds of {bodies} bodies")
            measure_steps(worlds(options.worlds, bodies), options.frames, options.device, clock).stop()
        return 0
    first = NewtonEngine(maker(MEDIUM).stage, device=options.device, progress=lambda *step: print(*step, flush=True))
    report("first load in a process, 337 bodies, and a step", clock.milliseconds(lambda: start(first)))
    first.stop()
    for bodies in options.bodies or [10, MEDIUM, 2000]:
        engine = measure_steps(
            maker(bodies).stage, options.frames, options.device, clock, velocities=not options.without_velocities
        )
        if bodies == MEDIUM:
            measure_edits(engine, clock)
        engine.stop()
    runs = [digest(options.device, options.frames, recorded=recorded) for recorded in (True, True, False)]
    same = len(set(runs)) == 1
    print(f"recorded, recorded again, unrecorded: {' '.join(runs)}: {'bit-equal' if same else 'DIFFERENT'}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())

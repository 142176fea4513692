"""Measure how calmly things lie down: `python -m tests.soak physics_calm [--only WORD]` prints a row per measure.

Each row has what was measured, its limit, and PhysX's value (ovphysx 0.7.0) where the same stage was run with it.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pxr import Usd

from tests.physics.impacts import calm_scenes
from tests.physics.scenes import playing, position
from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics import NewtonEngine

Row = tuple[str, float, float, str]  # what, measured, limit, PhysX


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="only groups whose name contains this")
    options = parser.parse_args()
    groups = (small_things, drops, rebounds, stacks, overlap, settled, pile, pebbles, object_based, repeats)
    failed = 0
    print("| what | measured | limit | PhysX |\n|---|---|---|---|")
    for group in groups:
        if options.only in group.__name__:
            for what, measured, limit, physx in group():
                failed += not measured <= limit
                print(
                    f"| {what} | {measured:.4g}{'' if measured <= limit else ' **above**'} | {limit:g} | {physx} |",
                    flush=True,
                )
    return int(failed > 0)


def small_things() -> Iterator[Row]:
    stage = calm_scenes.small_things(64)
    starts, paths = _starts(stage), _paths(stage, 10.0)
    heights = np.array([_highest_after_impact(paths[:, i, 2]) for i in range(64)]) / calm_scenes.half_sizes(stage)
    yield "64 small things: height after impact by half size, p90", float(np.percentile(heights, 90)), 1.5, "1.43"
    yield "same, max", float(heights.max()), 2.0, "1.72"
    aside = np.linalg.norm(paths[-1, :, :2] - starts[:, :2], axis=1)
    yield "same, sideways, median [mm]", 1e3 * float(np.median(aside)), 5.0, "0.3"


def drops() -> Iterator[Row]:
    paths = _paths(calm_scenes.drops(), 10.0)
    for i, physx in enumerate(("0.0", "1.0", "0.0", "0.6", "0.0", "1.2")):
        height = 1e3 * (_highest_after_impact(paths[:, i, 2]) - 0.05)
        yield f"{('sphere', 'box')[i % 2]} of 10 cm from {5 * 2 ** (i // 2)} m: hop [mm]", abs(height), 3.0, physx


def rebounds() -> Iterator[Row]:
    for kind, known in (("Sphere", (0.249, 0.806)), ("Cube", (0.246, 0.797))):
        paths = _paths(calm_scenes.rebounds(kind=kind), 2.0)
        found = [_highest_after_impact(paths[:, i, 2]) - 0.1 for i in range(3)]
        yield f"{kind}, restitution 0: rebound [mm]", 1e3 * abs(found[0]), 1.0, "0"
        for e, height, physx in zip((0.5, 0.9), found[1:], known):
            yield (
                f"{kind}, restitution {e}: rebound of {height:.3f} m off [%]",
                100 * abs(height / physx - 1),
                5.0,
                f"{physx} m",
            )


def stacks() -> Iterator[Row]:
    for half, limit, physx in ((0.1, 5.0, "5.4"), (0.01, 1.0, "2.4"), (0.001, 0.2, "falls over")):
        stage = calm_scenes.stack(half)
        starts, paths = _starts(stage), _paths(stage, 10.0)
        drift = 1e3 * np.linalg.norm(paths[-1] - starts, axis=1).max()
        yield f"stack of 10 cubes of {2e3 * half:g} mm, 10 s: drift [mm]", float(drift), limit, physx


def overlap() -> Iterator[Row]:
    paths = _paths(calm_scenes.overlapping_pair(), 5.0)
    yield "box 19 cm inside another: peak above rest [mm]", 1e3 * float(paths[:, 1, 2].max() - 0.3), 130.0, "118"


def settled() -> Iterator[Row]:
    stage = calm_scenes.overlapping_pair()
    playing(stage).settle()
    yield "same, settled: height above rest [mm]", 1e3 * abs(float(_starts(stage)[1, 2]) - 0.3), 1.0, ""
    stage = calm_scenes.one_place()
    engine = playing(stage)
    started = time.process_time()
    moving = engine.settle()
    yield "60 bodies at one place, settled: CPU time [s]", time.process_time() - started, 10.0, ""
    yield "same, still moving", float(len(moving)), 0.0, ""
    yield "same, deepest overlap [mm]", 1e3 * float(_depths(engine).max()), 1.0, ""
    yield (
        "same, farthest center sideways by size",
        float(np.linalg.norm(_starts(stage)[:, :2], axis=1).max() / 0.1),
        6.0,
        "460",
    )


def pile() -> Iterator[Row]:
    stage = calm_scenes.bin_of(200)
    engine = playing(stage)
    engine.advance(14.0)
    before = _starts(stage)
    engine.advance(1.0)
    moved = np.linalg.norm(_starts(stage) - before, axis=1)
    yield "pile of 200 in a bin, 15 s: farthest moved in the last second [mm]", 1e3 * float(moved.max()), 0.1, "0"
    depths = _depths(engine)
    yield "same, penetration p99 [mm]", 1e3 * float(np.percentile(depths, 99)), 1.0, ""
    yield "same, penetration max [mm]", 1e3 * float(depths.max()), 3.0, ""


def pebbles() -> Iterator[Row]:
    stage = calm_scenes.bin_of_pebbles(200)
    engine = playing(stage)
    engine.advance(14.0)
    before = _starts(stage)
    engine.advance(1.0)
    moved = 1e3 * np.linalg.norm(_starts(stage) - before, axis=1)
    yield "pile of 200 meshes in a bin, 15 s: farthest moved in the last second [mm]", float(moved.max()), 1.0, ""
    yield "same, of those that moved by 0.1 mm or more [%]", 100.0 * float((moved > 0.1).mean()), 1.0, ""


def object_based() -> Iterator[Row]:
    sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
    from physics_scene import AREA, SceneMaker  # pyright: ignore[reportMissingImports]

    for seed in range(5):
        engine = NewtonEngine(SceneMaker(337, all_gravity=False, seed=seed).stage, device="cpu")
        engine.play()
        engine.advance(10.0)
        world = engine._session.world  # pyright: ignore[reportOptionalMemberAccess]
        outside = (np.abs(world.poses()[:, :3]) > np.array(AREA) / 2).any(axis=1).mean()
        depths = _depths(engine)
        yield f"object-based scene, seed {seed}, 10 s: outside [%]", 100 * float(outside), 1.0, "0.6 to 1.2"
        yield "same, penetration p99 [mm]", 1e3 * float(np.percentile(depths, 99)), 5.0, "16"
        yield "same, penetration max [mm]", 1e3 * float(depths.max()), 30.0, "24"


def repeats() -> Iterator[Row]:
    first, second = (_paths(calm_scenes.bin_of(60), 3.0) for _ in range(2))
    yield "bin of 60 twice: positions that differ", float((first != second).sum()), 0.0, ""


def _paths(stage: Usd.Stage, seconds: float) -> np.ndarray:
    """Positions of the things (steps, N, 3) of a simulation [m]."""
    engine = playing(stage)
    found: list[np.ndarray] = []
    engine.subscribe_step(lambda dt: found.append(_starts(stage)))
    engine.advance(seconds)
    return np.array(found)


def _starts(stage: Usd.Stage) -> np.ndarray:
    return np.array([position(thing) for thing in calm_scenes.things(stage)])


def _highest_after_impact(height: np.ndarray) -> float:
    low = np.flatnonzero(np.diff(height) >= 0.0)
    return float(height[low[0] if len(low) else -1 :].max())


def _depths(engine: NewtonEngine) -> np.ndarray:
    """Depths [m] of the contacts that penetrate, as the narrow phase finds them."""
    world = engine._session.world  # pyright: ignore[reportOptionalMemberAccess]
    contacts = world._contacts
    world.pipeline.collide(world._state, contacts)
    count = int(contacts.rigid_contact_count.numpy()[0])
    poses, owner = world.poses().astype(np.float64), world.model.shape_body.numpy()
    turns = matrix_from_quat(poses[:, 3:])

    def world_points(side: int) -> np.ndarray:
        points = getattr(contacts, f"rigid_contact_point{side}").numpy()[:count].astype(np.float64)
        body = owner[getattr(contacts, f"rigid_contact_shape{side}").numpy()[:count]]
        moved = np.einsum("ni,nij->nj", points, turns[body]) + poses[body, :3]
        return np.where(body[:, None] >= 0, moved, points)

    normals = contacts.rigid_contact_normal.numpy()[:count]
    margins = contacts.rigid_contact_margin0.numpy()[:count] + contacts.rigid_contact_margin1.numpy()[:count]
    depths = margins - ((world_points(1) - world_points(0)) * normals).sum(axis=1)
    return depths[depths > 0.0] if (depths > 0.0).any() else np.zeros(1)


if __name__ == "__main__":
    sys.exit(main())

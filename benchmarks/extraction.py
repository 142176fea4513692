"""Extraction from USD to the renderer's arrays: the whole benchmark scene, 337 new poses, and one skinned character.

    python -m benchmarks.extraction [--rounds 9]

Poses are updated in two ways: on a stage, by change notices, and in the renderer's own `Scene`, as a simulation may
write them.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from pxr import Usd

from benchmarks import report
from benchmarks.render_scene import build
from benchmarks.render_stage import author, random_poses, write_poses
from benchmarks.timing import Timings, alone
from tests.stage.geometry.characters import add_character
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.scene.scene import Scene
from usdsdg_render.sync.extract import SceneExtractor


def print_timings(name: str, timings: Timings, target: str = "") -> None:
    """Print a row with the medians of wall and CPU time."""
    report.row(name, f"{1e3 * timings.wall:.2f} ms", f"{1e3 * timings.cpu:.2f} ms CPU", target=target)


def poses_on_a_stage(stage: Usd.Stage, ops: list[Usd.Attribute], rounds: int) -> None:
    """Time 337 new poses: writing them, extracting them, and everything until rays can be traced."""

    def write(number: int) -> None:
        write_poses(ops, random_poses(len(ops), number))

    print_timings("writing them, no listener", alone(write, rounds=rounds))
    extractor = SceneExtractor(stage)
    extractor.update()
    print_timings("writing them, with our listener", alone(write, rounds=rounds))
    reading = alone(lambda _: extractor.update(), rounds=rounds, before=write)
    print_timings(f"update of {len(ops)} poses", reading, "at most 3 ms")
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    synced = alone(lambda _: renderer.sync(), rounds=rounds, before=write)
    print_timings("the same, ready for rays", synced)


def poses_in_a_scene(scene: Scene, rounds: int) -> None:
    """Time 337 new poses without a stage."""
    renderer = WarpRenderer.of_scene(scene, device="cpu")
    renderer.sync()

    def move(number: int) -> None:
        scene.instances.local_to_world = random_poses(len(scene.instances), number)
        scene.touch("transforms")

    print_timings("poses of a Scene, ready", alone(lambda _: renderer.sync(), rounds=rounds, before=move))


def a_character(stage: Usd.Stage, rounds: int) -> None:
    """Time one skinned mesh that deforms among the others."""
    extractor = SceneExtractor(stage)
    add_character(stage, "/World/Man")
    codes = np.linspace(1, 23, rounds + 1)
    extractor.update(Usd.TimeCode(0))
    print_timings("a skinned character", alone(lambda k: extractor.update(Usd.TimeCode(codes[k])), rounds=rounds))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    rounds = parser.parse_args().rounds
    report.begin()
    with tempfile.TemporaryDirectory() as folder:
        stage, ops = author(build(), Path(folder))
        whole = alone(lambda _: SceneExtractor(stage).update(), rounds=rounds)
        print_timings(f"extraction of {len(ops)} objects", whole, "at most 100 ms")
        poses_on_a_stage(stage, ops, rounds)
        a_character(stage, rounds)
    poses_in_a_scene(build(), rounds)


if __name__ == "__main__":
    main()

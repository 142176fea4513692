"""Time from an edit of many prims at once until rays can be traced again.

    python -m benchmarks.edits [--rounds 15] [--prims 1000] [--only hand|graph]

First edits of a stage by hand: the edit itself is not timed, but `WarpRenderer.sync` and the reading of the camera.
Then edits by randomizers: the evaluation of the graph, which draws and writes the stage, and the sync after it.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path

import usdsdg as rep
from benchmarks import report
from benchmarks.edit_stage import CAMERA, ManyPrims
from benchmarks.timing import Timings, Work, alone, in_turns
from usdsdg.graph.evaluate import graph
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg_render.renderer import WarpRenderer


def rows(many: ManyPrims) -> dict[str, tuple[Work, str]]:
    """Return the edits by hand, with their targets."""
    return {
        "nothing": (lambda _: None, ""),
        "1,000 positions": (many.move, ""),
        "1,000 displayColors": (many.recolor, ""),
        "1,000 displayColors and positions": (many.recolor_and_move, ""),
        "1,000 displayOpacities": (many.fade, ""),
        "1,000 labels": (many.label, ""),
        "300 colors of OmniPBR": (many.paint, "5 ms"),
        "300 roughnesses of OmniPBR": (many.roughen, "5 ms"),
        "100 textures of OmniPBR": (many.swap_textures, ""),
        "300 bindings": (many.bind, ""),
        "300 intensities of lights": (many.dim, ""),
        "300 colors of lights": (many.tint, ""),
        "camera": (many.look, ""),
        "texture coordinates of 1,000": (many.unwrap, ""),
        "colors of the points of 100": (many.recolor_points, ""),
        "visibility of 1,000, half each": (many.show, ""),
    }


def by_hand(rounds: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        many = ManyPrims(Path(folder))
        renderer = WarpRenderer(many.stage, device="cpu")

        def ready(_: int) -> None:
            renderer.sync()
            read_camera(many.stage, CAMERA, (640, 480))

        ready(0)
        for name, (edit, target) in rows(many).items():
            print_row(name, alone(ready, rounds=rounds, before=edit), target)


def by_graph(prims: int, rounds: int) -> None:
    draw = rep.distribution
    color, position = draw.uniform((0, 0, 0), (1, 1, 1)), draw.uniform((-5, -5, 0), (5, 5, 2))
    randomize_graph("moved", prims, rounds, lambda: rep.modify.pose(position=position))
    randomize_graph("given an OmniPBR's color", prims, rounds, lambda: rep.randomizer.color(color))
    randomize_graph(
        "the same and moved",
        prims,
        rounds,
        lambda: (rep.randomizer.color(color), rep.modify.pose(position=position)),
        "10 ms",
    )
    shown = draw.uniform((0, 0, 0), (1, 1, 1))
    kind = "color3f[]"
    randomize_graph(
        "given a displayColor and moved",
        prims,
        rounds,
        lambda: (rep.modify.attribute("primvars:displayColor", shown, kind), rep.modify.pose(position=position)),
        "10 ms",
    )
    randomize_graph("hidden or shown", prims, rounds, lambda: rep.modify.visibility(draw.choice([True, False])))


def randomize_graph(what: str, prims: int, rounds: int, randomizers: Callable[[], object], target: str = "") -> None:
    """Time the evaluation of randomizers on so many cubes, and the sync that reads what they wrote."""
    stage = new_stage()
    rep.set_global_seed(0)
    cubes = rep.create.cube(count=prims)
    with rep.trigger.on_frame(), cubes:
        randomizers()
    renderer = WarpRenderer(stage, device="cpu")
    graph().evaluate(capture=0, preview=True)
    renderer.sync()
    parts = {"evaluation": lambda k: graph().evaluate(capture=k), "sync": lambda _: renderer.sync()}
    timings = in_turns(parts, rounds=rounds)
    for name, each in timings.items():
        print_row(f"{prims:,} {what}: {name}", each)
    both = Timings(*([a + b for a, b in zip(*pair)] for pair in zip(*((t.cpus, t.walls) for t in timings.values()))))
    print_row(f"{prims:,} {what}", both, target)


def print_row(name: str, timings: Timings, target: str = "") -> None:
    report.row(f"{name:<50}", f"{1e3 * timings.wall:.2f} ms", f"{1e3 * timings.cpu:.2f} ms CPU", target=target)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--prims", type=int, default=1000)
    parser.add_argument("--only", choices=["hand", "graph"])
    options = parser.parse_args()
    report.begin()
    if options.only != "graph":
        by_hand(options.rounds)
    if options.only != "hand":
        by_graph(options.prims, options.rounds)


if __name__ == "__main__":
    main()

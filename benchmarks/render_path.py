"""Path tracing beside Mitsuba 3 and Blender's Cycles: CPU time to a picture of equal noise.

    python -m benchmarks.render_path [--size 320x240] [--samples 64] [--rounds 3] [--quick] [--png PREFIX]

All draw the same scene with paths of three surfaces, without clamps, filters or roulette. Noise is the spread of
exposed values (1 is white, compressed to x / (1 + x)) between rounds of different seeds. Variance falls with the number
of samples, so what a tracer takes to equal noise is its CPU time times its variance. With `--device cuda:0` ours runs
alone, and rates are per second of the clock.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np

from benchmarks import peers, render_scene, report
from benchmarks.path_tracers import Ours, PathTracer
from benchmarks.timing import Timings, in_turns
from usdsdg.stage.cameras import CameraView
from usdsdg_render.scene import Scene
from usdsdg_render.settings import DEFAULT_WHITE

AT_LEAST = {"Mitsuba": 1.3, "Cycles": 3.0}
# Luminance above which a mean counts no more, as multiples of white: one pixel with the sun in it would decide it.
BRIGHTEST = 20.0


class Quality(NamedTuple):
    """What a tracer's pictures of one view are like."""

    picture: np.ndarray  # (H, W, 3) mean of all rounds, in units of white
    mean: np.ndarray  # (3,) of what is not brighter than BRIGHTEST
    noise: float  # standard deviation of one picture's compressed values


def quality_of(timings: Timings) -> Quality:
    """Of all rounds' pictures, the one to warm up included."""
    pictures = np.stack(timings.results) / DEFAULT_WHITE
    variance = (pictures / (1 + pictures)).var(axis=0, ddof=1).mean()
    return Quality(pictures.mean(0), np.minimum(pictures, BRIGHTEST).mean((0, 1, 2)), float(np.sqrt(variance)))


def tracers(scene: Scene, threads: int, device: str) -> list[PathTracer]:
    """Ours first, then the peers that are installed."""
    found: list[PathTracer] = [Ours(scene, threads=threads, device=device)]
    if device == "cpu" and peers.find("mitsuba"):
        from benchmarks.mitsuba_scene import Mitsuba

        found.append(Mitsuba(scene, threads=threads))
    if device == "cpu" and peers.find("bpy"):
        from benchmarks.cycles_scene import Cycles

        found.append(Cycles(scene, threads=threads))
    return found


def compare(view: CameraView, contenders: list[PathTracer], options: argparse.Namespace) -> list[Quality]:
    """Print one view's rows; the quality of every contender's pictures."""
    works = {each.name: lambda seed, each=each: each.picture(view, options.samples, seed) for each in contenders}
    timings = in_turns(works, rounds=options.rounds)
    qualities = [quality_of(timings[each.name]) for each in contenders]
    million = view.width * view.height * options.samples / 1e6
    on_cpu = options.device == "cpu"
    cost: list[float] = []
    print(f"{view.prim_path}, {view.width}x{view.height}, {options.samples} samples a pixel, {options.rounds} rounds")
    for each, quality in zip(contenders, qualities, strict=True):
        taken = timings[each.name].cpu if on_cpu else timings[each.name].wall
        cost.append(taken * quality.noise**2)
        family = each.name.split()[0]
        target = f"at least {AT_LEAST[family]}x, equal noise" if family in AT_LEAST else ""
        rate = f"{million / taken:.3f} Msamples/{'CPU-' if on_cpu else ''}s"
        ratio = cost[-1] / cost[0] if len(cost) > 1 else None
        report.row(each.name, rate, f"noise {quality.noise:.4f}", ratio=ratio, target=target)
        difference = quality.mean / qualities[0].mean - 1
        print("    mean " + " ".join(f"{m:.4f} ({d:+.1%})" for m, d in zip(quality.mean, difference, strict=True)))
    return qualities


def save(prefix: str, view: CameraView, qualities: list[Quality]) -> None:
    """All tracers' pictures of a view side by side, in sRGB."""
    from PIL import Image

    shown = np.clip(np.concatenate([each.picture for each in qualities], 1), 0, 1)
    encoded = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    Image.fromarray((encoded * 255 + 0.5).astype(np.uint8)).save(f"{prefix}{view.prim_path.rsplit('/', 1)[1]}.png")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--quick", action="store_true", help="pictures of 160x120")
    parser.add_argument("--png", help="prefix of pictures to write, all tracers side by side")
    options = parser.parse_args()
    report.begin()
    scene = render_scene.build()
    contenders = tracers(scene, options.threads, options.device)
    width, height = (int(each) for each in ("160x120" if options.quick else options.size).split("x"))
    for view in render_scene.views(scene, (width, height)):
        qualities = compare(view, contenders, options)
        if options.png:
            save(options.png, view, qualities)


if __name__ == "__main__":
    main()

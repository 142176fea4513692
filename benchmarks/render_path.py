"""Path tracing compared with Mitsuba 3 and Blender's Cycles: CPU time to an image of equal noise.

    python -m benchmarks.render_path [--size 320x240] [--samples 64] [--rounds 3] [--quick] [--png PREFIX]

All render the same scene with paths of three surfaces, without clamps, filters or roulette. Noise is the spread of
exposed values (1 is white, compressed to x / (1 + x)) between rounds of different seeds. Variance falls with the number
of samples, so the time of a tracer to equal noise is its CPU time times its variance. With `--device cuda:0` ours runs
alone, and rates are per wall second.
"""

from __future__ import annotations

import argparse
import statistics
from typing import NamedTuple

import numpy as np

from benchmarks import peers, render_scene, report
from benchmarks.path_tracers import TracerProcess, View
from benchmarks.timing import Timings, in_turns
from usdsdg_render.scene.scene import Scene
from usdsdg_render.settings import DEFAULT_WHITE

AT_LEAST = {"Mitsuba": 1.3, "Cycles": 3.0}
# Clamp of the mean, in multiples of white: otherwise one pixel that shows the sun would decide it.
BRIGHTEST = 20.0


class Outcome(NamedTuple):
    """The result of a tracer for one view."""

    name: str
    rate: float  # million samples a second
    noise: float  # standard deviation of one image's compressed values
    mean: np.ndarray  # (3,) of values clamped to BRIGHTEST, in units of white
    image: np.ndarray  # (H, W, 3) mean of all rounds, in units of white

    @property
    def cost(self) -> float:
        """Time of an image of given noise, up to a factor that is the same for all tracers."""
        return self.noise**2 / self.rate


def outcome_of(name: str, timings: Timings, samples: int, *, on_cpu: bool) -> Outcome:
    """Summarize all rounds, the warm-up included for images; time is CPU or wall time."""
    images = np.stack([timed.image for timed in timings.results]) / DEFAULT_WHITE
    taken = statistics.median(timed.cpu if on_cpu else timed.wall for timed in timings.results[1:])
    rate = samples * images[0, ..., 0].size / 1e6 / taken
    variance = (images / (1 + images)).var(axis=0, ddof=1).mean()
    mean = np.minimum(images, BRIGHTEST).mean((0, 1, 2))
    return Outcome(name, rate, float(np.sqrt(variance)), mean, images.mean(0))


def tracers(scene: Scene, threads: int, device: str) -> list[TracerProcess]:
    """Start our tracer, then the peers that are installed."""
    found = [TracerProcess("benchmarks.our_paths:Ours", scene, threads=threads, device=device)]
    if device == "cpu" and peers.installed("mitsuba"):
        found.append(TracerProcess("benchmarks.mitsuba_scene:Mitsuba", scene, threads=threads))
    if device == "cpu" and peers.installed("bpy"):
        found.append(TracerProcess("benchmarks.cycles_scene:Cycles", scene, threads=threads))
    return found


def views_of(scene: Scene, size: str) -> list[View]:
    """Return both views in a size like "320x240"."""
    width, height = (int(each) for each in size.split("x"))
    return [
        View(*(getattr(each, name) for name in View._fields)) for each in render_scene.views(scene, (width, height))
    ]


def compare(view: View, contenders: list[TracerProcess], options: argparse.Namespace) -> list[Outcome]:
    """Render one view with all contenders and print a row for each, ours first."""
    works = {each.name: lambda seed, each=each: each.render(view, options.samples, seed) for each in contenders}
    timings = in_turns(works, rounds=options.rounds)
    on_cpu = options.device == "cpu"
    outcomes = [outcome_of(name, each, options.samples, on_cpu=on_cpu) for name, each in timings.items()]
    print(f"{view.prim_path}, {view.width}x{view.height}, {options.samples} samples a pixel, {options.rounds} rounds")
    for each in outcomes:
        print_outcome(each, outcomes[0], "Msamples/CPU-s" if on_cpu else "Msamples/s")
    return outcomes


def print_outcome(outcome: Outcome, ours: Outcome, unit: str) -> None:
    """Print a row with the ratio at equal noise, and a line with the means compared with ours."""
    rate, noise = f"{outcome.rate:.3f} {unit}", f"noise {outcome.noise:.4f}"
    if outcome is ours:
        report.row(outcome.name, rate, noise)
    else:
        target = f"equal noise; at least {AT_LEAST[outcome.name.split()[0]]:g}x"
        beside = f"{ours.rate / outcome.rate:.2f}x a sample, {noise}"
        report.row(outcome.name, rate, beside, ratio=outcome.cost / ours.cost, target=target)
    differences = outcome.mean / ours.mean - 1
    print("    mean " + " ".join(f"{m:.4f} ({d:+.1%})" for m, d in zip(outcome.mean, differences, strict=True)))


def save(prefix: str, view: View, outcomes: list[Outcome]) -> None:
    """Write all tracers' images of a view side by side, in sRGB."""
    from PIL import Image

    shown = np.clip(np.concatenate([each.image for each in outcomes], 1), 0, 1)
    encoded = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    Image.fromarray((encoded * 255 + 0.5).astype(np.uint8)).save(f"{prefix}{view.prim_path.rsplit('/', 1)[1]}.png")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--quick", action="store_true", help="images of 160x120")
    parser.add_argument("--png", help="prefix of images to write, all tracers side by side")
    options = parser.parse_args()
    report.begin()
    scene = render_scene.build()
    contenders = tracers(scene, options.threads, options.device)
    for view in views_of(scene, "160x120" if options.quick else options.size):
        outcomes = compare(view, contenders, options)
        if options.png:
            save(options.png, view, outcomes)
    for each in contenders:
        each.close()


if __name__ == "__main__":
    main()

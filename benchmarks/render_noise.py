"""Denoisers on the benchmark scene: error of images against a reference of many samples, and their time.

    python -m benchmarks.render_noise [--size 640x480] [--samples 8,32] [--reference 1024] [--quick] [--png PREFIX]

The error is the root mean square over all channels of the 8-bit images that `LdrColor` shows. Besides the two views
of the scene the far one is rendered with a wide lens, so that the denoisers' guide AOVs have noise too.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np

from benchmarks import render_scene, report
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.path import oidn_denoiser
from usdsdg_render.path.film import Film
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings, ToneSettings

# Radius of the wide lens is focal length / (2 * f-number): 3 cm.
WIDE = {"f_stop": 40.0, "focus_distance": 2.5}
FILTERS = {
    "raw": ToneSettings(denoise=False),
    "wavelet": ToneSettings(denoiser="wavelet"),
    "oidn": ToneSettings(denoiser="oidn"),
}


def views(size: str) -> dict[str, CameraView]:
    """Return the views by name, in a size like "640x480"."""
    width, height = (int(each) for each in size.split("x"))
    near, far = render_scene.views(render_scene.build(), (width, height))
    return {"near": near, "far": far, "far, wide lens": replace(far, **WIDE)}


def exposed(renderer: WarpRenderer, view: CameraView, samples: int) -> tuple[Film, float]:
    """Return a film of `samples` per pixel, with a seed of its own for each number, and the seconds that it took."""
    film = renderer.new_film(view.width, view.height)
    before = time.perf_counter()
    renderer.accumulate(film, view, samples=samples, settings=PathSettings(seed=samples, denoise=True))
    film.arrays.color.numpy()  # waits for CUDA
    return film, time.perf_counter() - before


def developed(renderer: WarpRenderer, film: Film, tone: ToneSettings) -> tuple[np.ndarray, float]:
    """Return the image (height, width, 3) in 8-bit levels, and the minimum seconds of three runs."""
    seconds = []
    for _ in range(3):
        before = time.perf_counter()
        image = renderer.develop(film, tone)["LdrColor"]
        seconds.append(time.perf_counter() - before)
    return image[..., :3].astype(np.float32), min(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--samples", default="8,32")
    parser.add_argument("--reference", type=int, default=1024)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--quick", action="store_true", help="images of 160x120 beside one of 64 samples")
    parser.add_argument("--png", help="prefix of images to write: every filter, then the reference")
    options = parser.parse_args()
    report.begin()
    if not oidn_denoiser.is_installed():
        print("no oidn: pip install 'usdsdg[denoise]'")
        del FILTERS["oidn"]
    renderer = WarpRenderer.of_scene(render_scene.build(), device=options.device)
    renderer.sync()
    for name, view in views("160x120" if options.quick else options.size).items():
        compare(renderer, name, view, options)


def compare(renderer: WarpRenderer, name: str, view: CameraView, options: argparse.Namespace) -> None:
    """Print a row for each number of samples and each denoiser."""
    reference, _ = exposed(renderer, view, 64 if options.quick else options.reference)
    truth, _ = developed(renderer, reference, FILTERS["raw"])
    for samples in (int(each) for each in options.samples.split(",")):
        film, traced = exposed(renderer, view, samples)
        plain, images = 0.0, []
        for tone_name, tone in FILTERS.items():
            image, seconds = developed(renderer, film, tone)
            error = float(np.sqrt(((image - truth) ** 2).mean()))
            plain = plain or error
            took = f"{1e3 * seconds:.0f} ms to develop, {traced:.2f} s to trace"
            report.row(f"{name}, {samples}, {tone_name}", f"RMS error {error:.2f}", took, ratio=plain / error)
            images.append(image)
        if options.png:
            save(f"{options.png}{name.replace(', ', '_').replace(' ', '_')}_{samples}.png", [*images, truth])


def save(path: str, images: list[np.ndarray]) -> None:
    """Write images side by side."""
    from PIL import Image

    Image.fromarray(np.concatenate(images, 1).astype(np.uint8)).save(path)


if __name__ == "__main__":
    main()

"""The dataset of the README's first command, for several seeds: images show labeled objects, and no two are alike."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from itertools import combinations
from pathlib import Path

import numpy as np
from PIL import Image

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.truth import Truth

CONFIG = "configs/object_based.yaml"
# Of all images; pixels of the largest labeled object; mean difference of small gray copies [gray levels].
SHOWING, PIXELS, ALIKE = 0.9, 300, 4.0
THUMBNAIL = (16, 12)
FAST = ("path_tracing.spp=2", "path_tracing.sub_frames=2", "writer_kwargs.write_debug_images=false")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--config", default=CONFIG)
    parser.add_argument("--fast", action="store_true", help="few samples per pixel: the same labels")
    parser.add_argument("--keep", type=Path, help="folder for the datasets")
    options = parser.parse_args()
    shown = images = 0
    nearest = np.inf
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.seeds):
            target = (options.keep or Path(folder)) / str(seed)
            _generate(options.config, seed, target, FAST if options.fast else ())
            sizes, difference = largest_objects(target), least_difference(target)
            print(f"seed {seed}: pixels of the largest object {sizes}; least difference {difference:.1f}", flush=True)
            shown, images = shown + sum(size >= PIXELS for size in sizes), images + len(sizes)
            nearest = min(nearest, difference)
    print(f"{shown} of {images} images show a labeled object; the least difference of two is {nearest:.1f} gray levels")
    return int(shown < SHOWING * images or nearest < ALIKE)


def _generate(config: str, seed: int, target: Path, overrides: tuple[str, ...]) -> None:
    settings = [part for each in (f"writer_kwargs.output_dir={target}", *overrides) for part in ("--set", each)]
    subprocess.run([sys.executable, "-m", "usdsdg", "generate", config, "--seed", str(seed), *settings], check=True)


def largest_objects(folder: Path) -> list[int]:
    """Return the visible pixels of the largest labeled object of each image, by the records of the frames."""
    found = []
    for record in Folder(folder).records:
        for product in record.products:
            (key, *_) = product.selections
            found.append(max((each.visible for each in Truth(record, product).things(key)), default=0))
    return found


def least_difference(folder: Path) -> float:
    """Return the least mean difference [gray levels] of small gray copies of any two images."""
    paths = [path for path in sorted(folder.glob("*.png")) if not path.stem.endswith("_overlay")]
    small = [np.asarray(Image.open(path).convert("L").resize(THUMBNAIL), float) for path in paths]
    return min(float(np.abs(a - b).mean()) for a, b in combinations(small, 2))

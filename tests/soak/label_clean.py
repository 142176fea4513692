"""Verify datasets without faults: `python -m tests.soak label_clean` shall find none in 2,000 frames of many scenes."""

import argparse
import tempfile
import time
from pathlib import Path

from tests.verify import datasets
from usdsdg.verify import verify


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=2000)
    parser.add_argument("--each", type=int, default=50, help="frames of a scene")
    parser.add_argument("--first", type=int, default=1, help="seed of the first scene, to go on after another run")
    options = parser.parse_args()
    alarms = frames = images = 0
    started = time.process_time()
    for seed in range(options.first, options.first - (-options.frames // options.each)):
        with tempfile.TemporaryDirectory() as folder:
            datasets.make(Path(folder), frames=options.each, seed=seed)
            frames += options.each
            for name in datasets.DATASETS:
                report = verify(Path(folder) / name)
                images += report.formats.total()
                alarms += len(report.faults)
                for fault in report.faults[:3]:
                    print(f"seed {seed}, {name}: {fault.line()}", flush=True)
        print(f"seed {seed}: {frames} frames, {images} images, {alarms} false alarms so far", flush=True)
    seconds = time.process_time() - started
    print(
        f"{frames} frames in {len(datasets.DATASETS)} datasets, {images} images: {alarms} false alarms, {seconds:.0f} s"
    )
    return int(alarms > 0)

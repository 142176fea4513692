"""A long dataset of small label frames in episodes: `python -m tests.soak long` prints time, memory and journal share.

For every tenth of the frames: seconds a frame, and the memory of the process; at the end the share of the time that
the journal took with its syncs, on any thread.
"""

import argparse
import tempfile
import time
from pathlib import Path

from usdsdg.capture import capture
from usdsdg.cli.options.command_context import seed_everything
from usdsdg.cli.options.dataset_options import begin_run
from usdsdg.scenarios import jobs
from usdsdg.session import devices
from usdsdg.writers.aggregates import finish_run
from usdsdg.writers.journal.run import Run

JOB = """
num_frames: {frames}
frames_per_episode: {episode}
num_cameras: 1
resolution: [64, 64]
path_tracing: {{every: 0}}
labeled_assets_and_properties:
  - {{url: /Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd, label: pudding_box, count: 3, floating: true}}
  - {{url: /Isaac/Props/YCB/Axis_Aligned_Physics/006_mustard_bottle.usd, label: mustard, count: 3}}
shape_distractors_num: 4
writer_type: BasicWriter
writer_kwargs: {{output_dir: out, rgb: false, semantic_segmentation: true, bounding_box_2d_tight: true}}
"""
TENTHS = 10


class Journaling:
    """Adds up the time that the journal takes."""

    def __init__(self) -> None:
        self.seconds = 0.0
        append = Run.append

        def timed_append(run: Run) -> None:
            started = time.perf_counter()
            append(run)
            self.seconds += time.perf_counter() - started

        Run.append = timed_append


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--episode", type=int, default=500)
    options = parser.parse_args()
    devices.use_device("cpu")
    journaling = Journaling()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "job.yaml")
        file.write_text(JOB.format(frames=options.frames, episode=options.episode))
        overrides = [f"writer_kwargs.output_dir={folder}/out"]
        begin_run(
            "generate", file, arguments=overrides, seed=None, classes=None, resume=False, overwrite=False, frames=None,
            shard=None,
        )  # fmt: skip
        _report_tenths(options.frames)
        job, values = jobs.load_job(file, overrides)
        seed_everything(values.seed)
        started = time.perf_counter()
        job.run(values)
        finish_run(complete=True)
        seconds = time.perf_counter() - started
        share = 100 * journaling.seconds / seconds
        # Before the files are removed, which takes long on some disks.
        print(f"{options.frames} frames in {seconds:.0f} s; journal {share:.1f} % of the time", flush=True)
    return 0


def _report_tenths(frames: int) -> None:
    finish, count, last = capture.Capture.finish, 0, time.perf_counter()

    def counted(self: capture.Capture, frame: int, seconds: float) -> None:
        nonlocal count, last
        finish(self, frame, seconds)
        count += 1
        if count % max(1, frames // TENTHS) == 0:
            now = time.perf_counter()
            each = (now - last) / max(1, frames // TENTHS)
            print(f"frame {count}: {1000 * each:.2f} ms a frame, {_resident() / 1e6:.0f} MB", flush=True)
            last = now

    capture.Capture.finish = counted


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

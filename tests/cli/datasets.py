"""A small job with physics and two cameras, run by the command line, and the files that it leaves."""

import os
import subprocess
from pathlib import Path

from tests import forked

ROOT = Path(__file__).resolve().parents[2]
FRAMES = 6
JOB = f"""
num_frames: {FRAMES}
num_cameras: 2
seed: 3
resolution: [64, 48]
path_tracing: {{every: 4, spp: 2, sub_frames: 2}}
labeled_assets_and_properties:
  - {{url: /Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd, label: pudding_box, count: 3, floating: true}}
  - {{url: /Isaac/Props/YCB/Axis_Aligned_Physics/006_mustard_bottle.usd, label: mustard, count: 3}}
shape_distractors_num: 4
"""


def write_job(folder: Path, writer: str, **options: object) -> Path:
    """Write the configuration of the job for a writer."""
    file = folder / "job.yaml"
    file.write_text(JOB + f"writer_type: {writer}\nwriter_kwargs: {options | {'output_dir': 'out'}}\n")
    return file


def generate(job: Path, output: Path, *options: str, fresh: bool = False) -> subprocess.CompletedProcess[str]:
    """Run the job into a folder; `fresh` as for `run`."""
    command = ["-m", "usdsdg", "generate", "-q", str(job), "--device", "cpu"]
    return run([*command, "--set", f"writer_kwargs.output_dir={output}", *options], fresh=fresh)


def run(arguments: list[str], *, fresh: bool = False) -> subprocess.CompletedProcess[str]:
    """Run `python ARGUMENTS`.

    fresh: in a process of its own; forks hash strings alike, so that bytes may only be compared with those of one.
    """
    return forked.run(arguments, cwd=ROOT, fresh=fresh)


def merge(output: Path | str) -> subprocess.CompletedProcess[str]:
    """Join the parts in a folder, which is given relative to the working directory, or at a URL."""
    place = output if isinstance(output, str) else os.path.relpath(output, ROOT)
    return run(["-m", "usdsdg", "merge", place])


def content(folder: Path) -> dict[str, bytes]:
    """Return the bytes of every file below a folder, by its path."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

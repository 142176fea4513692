"""The scene of `benchmarks.capture_rate` as a script for `usdsdg run --workers`: FRAMES FOLDER ANNOTATORS."""

import sys
from pathlib import Path

import usdsdg as rep

sys.path.insert(0, str(Path(__file__).parents[1]))
from benchmarks.capture_rate import build

frames, folder, annotators = int(sys.argv[1]), sys.argv[2], sys.argv[3].split(",")
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=folder, **{name: True for name in annotators})
writer.attach(build(1, (1280, 720)))
rep.orchestrator.run_until_complete(num_frames=frames)

"""The scene of `benchmarks.capture_rate` for `usdsdg run`: FRAMES FOLDER ANNOTATORS CAMERAS WIDTH HEIGHT."""

import sys
from pathlib import Path

import usdsdg as rep

sys.path.insert(0, str(Path(__file__).parents[1]))
from benchmarks.capture_rate import build

frames, folder, annotators = int(sys.argv[1]), sys.argv[2], sys.argv[3].split(",")
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=folder, **{"rgb": False, **{name: True for name in annotators}})
cameras, width, height = map(int, sys.argv[4:7])
writer.attach(build(cameras, (width, height)))
rep.orchestrator.run_until_complete(num_frames=frames)

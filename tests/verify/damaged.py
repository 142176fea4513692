"""A dataset with a journal, damaged: what `usdsdg verify` finds is compared with what was done to it."""

import os
import random
import shutil
from pathlib import Path

from tests import forked
from tests.verify.damage import HARMLESS, KINDS
from usdsdg.verify import verify

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
import sys
import omni.replicator.core as rep

with rep.new_layer():
    camera = rep.create.camera(position=(0, 0, 6), look_at=(0, 0, 0))
    rep.create.light(light_type="dome")
    shapes = rep.create.cube(semantics=[("class", "cube")], count=3)
    with rep.trigger.on_frame(num_frames=int(sys.argv[1])):
        with shapes:
            rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir=sys.argv[2], rgb=True, semantic_segmentation=True, bounding_box_2d_tight=True)
    writer.attach(rep.create.render_product(camera, (64, 64)))
rep.orchestrator.run()
"""


def make(folder: Path, frames: int) -> Path:
    """Make a dataset with the command line, of some seven files a frame; return its folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "script.py").write_text(SCRIPT)
    command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", "--seed", "5"]
    given = [str(folder / "script.py"), str(frames), str(folder / "out")]
    # Its bytes are compared with those of forks, which hash strings alike.
    forked.run([*command, *given], cwd=ROOT, fresh=True).check_returncode()
    return folder / "out"


def wrong(whole: Path, name: str, place: Path, *, seed: int = 0, labels: bool = False) -> str | None:
    """Damage a copy of a dataset, whose files are links to those of `whole`, and verify it; return what is wrong."""
    damage = (KINDS | HARMLESS)[name]
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(whole, place / "out", copy_function=os.link)
    if name == "other times of files":  # which links share
        shutil.rmtree(place)
        shutil.copytree(whole, place / "out")
    expected = damage(place / "out", random.Random(seed))
    report = verify(place / "out", labels=labels)
    named = {fault.file for fault in report.faults}
    if not labels:
        return None if named == expected else f"expected {sorted(expected)}, found {[f.line() for f in report.faults]}"
    return None if expected <= named and bool(named) == bool(expected) else f"{sorted(expected - named)} is not named"

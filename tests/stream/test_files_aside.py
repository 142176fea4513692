"""A stream hands out frames, and leaves what is at the places alone to which its job would write."""

import pytest

from tests import forked
from tests.cli.datasets import content
from usdsdg import stream
from usdsdg.errors import Unsupported

# Its writer writes a file of its own before the first frame and one at the end, as writers of scripts do.
SCRIPT = """
import os, sys
import omni.replicator.core as rep

class Shots(rep.Writer):
    def __init__(self, output_dir):
        self.backend = rep.backends.get("DiskBackend")
        self.backend.initialize(output_dir=output_dir)
        self.annotators, self.number = ["rgb"], 0
        self.backend.write_blob("classes.txt", b"box")

    def write(self, data):
        self.backend.write_image(f"{self.number}.png", data["rgb"])
        self.number += 1

    def on_final_frame(self):
        self.backend.write_blob("count.txt", b"%d" % self.number)

box = rep.create.cube(semantics=[("class", "box")])
product = rep.create.render_product(rep.create.camera(position=(0, -6, 2), look_at=(0, 0, 0)), (24, 16))
rep.WriterRegistry.register(Shots)
writer = rep.WriterRegistry.get("Shots")
writer.initialize(output_dir=os.path.abspath("out"))
writer.attach(product)
with rep.trigger.on_frame(), box:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 1)))
rep.orchestrator.run(num_frames=2)
open("out/own.txt", "w").write(sys.argv[1])
"""
JOB = "job: detection\noutput_dir: out\nformats: {yolo: {}}\nnum_frames: 2\nresolution: [24, 16]\n"

# A program of a user, whose file would be the recipe of what it wrote.
PROGRAM = """
import sys
from usdsdg import stream

job, kind, *arguments = sys.argv[1:]
if kind == "worlds":
    shown = [each.frame for each in stream.worlds(job, ["rgb"], count=2, arguments=arguments, device="cpu")]
else:
    shown = [each.frame for each in stream.frames(job, ["rgb"], arguments=arguments, device="cpu")]
print("shown", shown)
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "shots.py").write_text(SCRIPT)
    (tmp_path / "job.yaml").write_text(JOB)
    (tmp_path / "train.py").write_text(PROGRAM)
    return tmp_path


def done(folder, *arguments):
    process = forked.run(list(arguments), cwd=folder)
    assert process.returncode == 0, process.stderr
    return process.stdout.splitlines()[-1:]


@pytest.mark.parametrize(("kind", "shown"), [("frames", "[0, 1]"), ("worlds", "[0]")])
def test_a_dataset_of_the_script_stays_as_it_is(folder, kind, shown):
    done(folder, "-m", "usdsdg", "run", "-q", "--device", "cpu", "shots.py", "first")
    before = content(folder / "out")
    assert {"0.png", "1.png", "classes.txt", "count.txt", "own.txt", ".usdsdg/journal.jsonl"} <= set(before)
    assert done(folder, "train.py", "shots.py", kind, "second") == [f"shown {shown}"]
    # What the script writes itself is no business of its writer.
    assert content(folder / "out") == before | {"own.txt": b"second"}


def test_a_script_finds_the_folder_of_its_writer(folder):
    assert done(folder, "train.py", "shots.py", "frames", "first") == ["shown [0, 1]"]
    assert content(folder / "out") == {"own.txt": b"first"}


def test_a_job_streams_beside_the_dataset_that_it_has_made(folder):
    done(folder, "-m", "usdsdg", "generate", "-q", "--device", "cpu", "job.yaml")
    before = content(folder / "out")
    assert done(folder, "train.py", "job.yaml", "frames", "num_frames=1", "seed=3") == ["shown [0]"]
    assert content(folder / "out") == before


def test_a_job_makes_no_folder_and_needs_none(folder):
    done(folder, "train.py", "job.yaml", "frames")
    assert not (folder / "out").exists()
    (folder / "out").write_text("a file")
    assert done(folder, "train.py", "job.yaml", "frames") == ["shown [0, 1]"]


def test_worlds_of_a_configuration_are_refused_since_all_would_show_the_same(folder):
    with pytest.raises(Unsupported, match=r"worlds: .*job\.yaml is a configuration.*usdsdg\.stream\.frames"):
        stream.worlds(folder / "job.yaml", ["rgb"], count=2)

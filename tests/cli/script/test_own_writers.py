"""Writers of scripts, with files about all frames, in runs that go on."""

import shutil

import pytest

from tests.cli.datasets import content, run
from tests.sampled_cases import sampled

SCRIPT = """
import json, os, sys
import omni.replicator.core as rep

class Total(rep.Writer):
    kept = ("total", "count")

    def __init__(self, output_dir):
        self.backend = rep.backends.DiskBackend(output_dir=output_dir)
        self.annotators, self.total, self.count = ["bounding_box_2d_tight"], 0, 0

    def write(self, data):
        self.total += sum(int(box["x_max"]) for box in data["bounding_box_2d_tight"]["data"])
        self.backend.write_blob(f"{self.count}.json", json.dumps(self.total).encode())
        self.count += 1

    def on_final_frame(self):
        self.backend.write_blob("all.json", json.dumps([self.total, self.count]).encode())

class Forgetful(Total):
    kept = ("total",)

class Beside(rep.BasicWriter):
    def __init__(self, output_dir):
        super().__init__(output_dir=output_dir, distance_to_camera=True)
        self.number = 0

    def write(self, data):
        super().write(data)
        self.backend.write_blob(f"beside_{self.number}.txt", str(self.num_written).encode())
        self.number += 1

class Counting(rep.Writer):
    def __init__(self, output_dir):
        self.backend = rep.backends.DiskBackend(output_dir=output_dir)
        self.annotators, self.frame_id = ["distance_to_camera"], 0

    def write(self, data):
        self.backend.schedule(rep.functional.write_np, path=f"{self.frame_id}.npy", data=data["distance_to_camera"])
        self.frame_id += 1

    def on_final_frame(self):
        self.backend.write_blob("count.json", json.dumps(self.frame_id).encode())

rep.create.cube(semantics=[("class", "cube")])
product = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24))
for kind in (Total, Counting, Forgetful, Beside):
    rep.WriterRegistry.register(kind)
    writer = rep.WriterRegistry.get(kind.__name__)
    writer.initialize(output_dir=os.path.join(sys.argv[1], kind.__name__))
    writer.attach(product)
for frame in range(4):
    if frame == int(os.environ.get("FAILS_AT", -1)):
        raise KeyboardInterrupt if os.environ.get("INTERRUPTED") else RuntimeError("the script fails")
    rep.orchestrator.step(delta_time=0.0)
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    (folder / "script.py").write_text(SCRIPT)
    done = go(folder, fresh=True)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture
def copied(made, tmp_path):
    return shutil.copytree(made, tmp_path / "copy")


def go(folder, *options, fresh=False):
    return run(["-m", "usdsdg", "run", "-q", *options, str(folder / "script.py"), str(folder / "out")], fresh=fresh)


def test_a_whole_dataset_that_is_gone_on_with_stays_as_it_is(made, copied):
    done = go(copied, "--resume")
    assert done.returncode == 0, done.stderr
    assert content(copied / "out") == content(made / "out")


@pytest.mark.parametrize(("frame", "interrupted"), sampled([(2, True), (0, True), (2, False), (0, False)]))
def test_a_whole_dataset_stays_so_where_going_on_ends_early(made, copied, frame, interrupted, monkeypatch):
    monkeypatch.setenv("FAILS_AT", str(frame))
    if interrupted:
        monkeypatch.setenv("INTERRUPTED", "1")
    assert go(copied, "--resume").returncode == (130 if interrupted else 1)
    assert content(copied / "out") == content(made / "out")


def test_frames_that_follow_those_made_before_replace_none(made, tmp_path, monkeypatch):
    """Also of writers that count what their `kept`, or the `skip` of their base, leaves out."""
    shutil.copy(made / "script.py", tmp_path)
    monkeypatch.setenv("FAILS_AT", "2")
    assert go(tmp_path).returncode == 1
    assert {path.name for path in (tmp_path / "out").glob("*/beside_*")} == {"beside_0.txt", "beside_1.txt"}
    monkeypatch.delenv("FAILS_AT")
    done = go(tmp_path, "--resume")
    assert done.returncode == 0, done.stderr
    assert content(tmp_path / "out") == content(made / "out")

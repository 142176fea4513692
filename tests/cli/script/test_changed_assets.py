"""A run that is resumed tells of assets, and modules of its script, that were changed since its first frames."""

import json
import os

import numpy as np
import pytest
import trimesh
from PIL import Image

from tests import forked

BOX = '#usda 1.0\n(\n    defaultPrim = "Box"\n)\ndef Cube "Box"\n{{\n    double size = {size}\n}}\n'
# Move the box in each frame, and write pictures.
MOVES = """
with rep.trigger.on_frame(), box:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
product = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True)
writer.attach(product)
"""
SCRIPT = """
import sys
import omni.replicator.core as rep
from isaacsim.storage.native import get_assets_root_path
rep.create.light(light_type="Dome")
box = rep.create.from_usd(get_assets_root_path() + "/Isaac/box.usda", semantics=[("class", "box")])
"""
SAID = "the asset /Isaac/box.usda has other content than when earlier frames were made"


@pytest.mark.parametrize("size", [1.0, 2.0])
def test_frames_that_are_added_after_an_asset_was_changed_are_named(size, tmp_path):
    asset = tmp_path / "assets/Isaac/box.usda"
    asset.parent.mkdir(parents=True)
    asset.write_text(BOX.format(size=1.0))
    (tmp_path / "script.py").write_text(SCRIPT + MOVES)
    first = _run(tmp_path, "--frames", "2")
    asset.write_text(BOX.format(size=size))
    more = _run(tmp_path, "--frames", "4", "--resume")
    assert SAID not in first.stderr
    assert (SAID in more.stderr) == (size != 1.0)
    assert more.stderr.count(SAID) <= 1
    assert len(list((tmp_path / "data").glob("rgb_*.png"))) == 5  # 0 to 4


BESIDE = """
import os, sys
import omni.replicator.core as rep
import helper
rep.create.light(light_type="Dome")
rep.create.from_usd(os.path.abspath("sub/ball.obj"), semantics=[("class", "ball")], position=(0, 0, helper.HEIGHT))
box = rep.create.from_usd(os.path.abspath("box.usda"), semantics=[("class", "box")])
with box:
    rep.randomizer.texture(textures=[os.path.abspath("sub/box.png"), os.path.abspath("box.png")])
"""


def _picture(path, level):
    Image.new("RGB", (4, 4), (level, level, level)).save(path)


def test_files_beside_the_script_that_were_changed_are_named(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "assets").mkdir()
    (tmp_path / "helper.py").write_text("HEIGHT = 1.0")
    trimesh.creation.icosphere().export(tmp_path / "sub/ball.obj")
    (tmp_path / "box.usda").write_text(BOX.format(size=1.0))
    _picture(tmp_path / "box.png", 10)
    _picture(tmp_path / "sub/box.png", 200)
    (tmp_path / "script.py").write_text(BESIDE + MOVES)
    _run(tmp_path, "--frames", "1")
    changed = {
        "helper.py": lambda: (tmp_path / "helper.py").write_text("HEIGHT = 2.0"),
        "sub/ball.obj": lambda: trimesh.creation.icosphere(radius=0.5).export(tmp_path / "sub/ball.obj"),
        "box.usda": lambda: (tmp_path / "box.usda").write_text(BOX.format(size=0.5)),
    }
    for count, (name, change) in enumerate([(None, lambda: None), *changed.items()], 3):
        change()
        more = _run(tmp_path, "--frames", str(count), "--resume")
        said = [line for line in more.stderr.splitlines() if "has other content than" in line]
        assert len(said) == (name is not None)
        assert name is None or f"the asset {name} has" in said[0]
    recipe = json.loads((tmp_path / "data/.usdsdg/recipe.json").read_text())
    # Two textures of one name are two assets, of which none was changed.
    pictures = [each["path"] for each in recipe["assets"] if each["name"] == "box.png"]
    assert set(pictures) <= {"box.png", "sub/box.png"}
    assert len(pictures) == len(set(pictures))


READS = """
import json, os, sys
from pathlib import Path
import numpy as np
import omni.replicator.core as rep
os.chdir("sub")
height = json.load(open("../height.json"))["z"] + np.load(Path("sizes.npy"))[0]
for kept in ("../state.txt", sys.argv[1] + "/metadata.txt"):  # of a run before, and of this dataset
    if os.path.exists(kept):
        Path(kept).read_text()
Path("../state.txt").write_text(str(os.getpid()))
with open("../.secret") as secret, open("../log.txt", "a") as log:
    log.write(secret.read())
Path("../log.txt").read_bytes()
os.chdir("..")
rep.create.light(light_type="Dome")
box = rep.create.cube(semantics=[("class", "box")], position=(0, 0, height))
"""


def test_data_files_that_the_script_has_read_itself_and_that_were_changed_are_named(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "assets").mkdir()
    (tmp_path / "height.json").write_text('{"z": 0.25}')
    np.save(tmp_path / "sub/sizes.npy", [0.5])
    (tmp_path / ".secret").write_text("token")
    (tmp_path / "script.py").write_text(READS + MOVES)
    _run(tmp_path, "--frames", "1")
    changed = {
        "height.json": lambda: (tmp_path / "height.json").write_text('{"z": 0.75}'),
        "sub/sizes.npy": lambda: np.save(tmp_path / "sub/sizes.npy", [0.25]),
        "": lambda: (tmp_path / ".secret").write_text("another"),
    }
    for count, (name, change) in enumerate(changed.items(), 3):
        change()
        more = _run(tmp_path, "--frames", str(count), "--resume")
        said = [line for line in more.stderr.splitlines() if "has other content than" in line]
        assert [f"the asset {name} has" in line for line in said] == [True] * bool(name)
    recipe = json.loads((tmp_path / "data/.usdsdg/recipe.json").read_text())
    # Neither what the script has written itself, nor files of datasets.
    assert {each["path"] for each in recipe["assets"]} == {"height.json", "sub/sizes.npy"}


INTERRUPTED = """
import signal, sys
import omni.replicator.core as rep

class Ends(rep.Writer):
    def __init__(self):
        self.annotators = ["rgb"]

    def write(self, data):
        signal.raise_signal(signal.SIGINT)

box = rep.create.from_usd("box.usda", semantics=[("class", "box")])
product = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True)
writer.attach(product)
ends = Ends()
ends.attach(product)
"""


def test_the_assets_of_a_frame_are_known_where_ctrl_c_came_while_it_was_written(tmp_path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "box.usda").write_text(BOX.format(size=1.0))
    (tmp_path / "script.py").write_text(INTERRUPTED)
    assert _run(tmp_path, "--frames", "3", code=130).returncode == 130
    lines = [json.loads(line) for line in (tmp_path / "data/.usdsdg/journal.jsonl").read_text().splitlines()]
    assert [line["frame"] for line in lines if "frame" in line] == [0]
    assert [each["path"] for each in lines[0]["facts"]["assets"].values()] == ["box.usda"]


JOB = """
job: detection
num_frames: {count}
resolution: [48, 32]
meshes: meshes
objects: {{per_image: [1, 1]}}
camera: {{calibration: camera.yaml}}
formats: {{yolo: {{}}}}
output_dir: out
"""


CALIBRATION = """
image_width: 48
image_height: 32
camera_matrix: {{rows: 3, cols: 3, data: [{focal}, 0, 24, 0, {focal}, 16, 0, 0, 1]}}
distortion_model: plumb_bob
distortion_coefficients: {{rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}}
"""


def test_a_job_is_not_gone_on_with_once_its_folder_of_meshes_has_another_class(tmp_path):
    meshes, calibration = tmp_path / "meshes", tmp_path / "camera.yaml"
    calibration.write_text(CALIBRATION.format(focal=40))
    meshes.mkdir()
    trimesh.creation.box((0.05, 0.05, 0.02)).export(meshes / "nut.obj")

    def generate(count, *options):
        (tmp_path / "job.yaml").write_text(JOB.format(count=count))
        return forked.run(
            ["-m", "usdsdg", "generate", "-q", "--device", "cpu", *options, str(tmp_path / "job.yaml")], cwd=tmp_path
        )

    assert generate(1).returncode == 0
    label = (tmp_path / "out/yolo").rglob("labels/*/*.txt")
    before = {path: path.read_bytes() for path in label}
    trimesh.creation.icosphere(radius=0.03).export(meshes / "ball.obj")  # of id 0, which was that of nuts
    refused = generate(2, "--resume")
    assert refused.returncode == 1
    assert 'folder of meshes: "1 file, names ' in refused.stderr
    assert before
    assert {path: path.read_bytes() for path in before} == before
    os.remove(meshes / "ball.obj")
    calibration.write_text(CALIBRATION.format(focal=60))
    done = generate(2, "--resume")
    assert done.returncode == 0, done.stderr
    assert "the asset camera.yaml has other content" in done.stderr


def _run(folder, *options, code=0):
    command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", "--assets-root", str(folder / "assets"), *options]
    done = forked.run([*command, "script.py", str(folder / "data")], cwd=folder)
    assert done.returncode == code, done.stderr
    return done

"""`--map PREFIX=FOLDER` of commands that read configurations and stages, and what they say of it."""

import json
import os

import pytest

from tests import forked
from tests.sampled_cases import sampled

URL = "omniverse://host/P/box.usda"
BOX = """#usda 1.0
( defaultPrim = "A" )
def Xform "A" ( prepend apiSchemas = ["PhysicsRigidBodyAPI"] ) {
    def Cube "Cube" ( prepend apiSchemas = ["PhysicsCollisionAPI"] ) {
        double size = 0.4
    }
}
"""
STAGE = f"""#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
def PhysicsScene "Physics" {{}}
def "Box" ( references = @{URL}@ ) {{}}
"""
JOB = f"""
num_frames: 2
seed: 3
resolution: [48, 32]
labeled_assets_and_properties: [{{url: "{URL}", label: box, count: 9, floating: true}}]
shape_distractors_num: 0
camera_properties_kwargs: {{clippingRange: [0.01, 1000]}}
writer_type: BasicWriter
writer_kwargs: {{semantic_segmentation: true}}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/box.usda").write_text(BOX)
    (tmp_path / "scene.usda").write_text(STAGE)
    (tmp_path / "job.yaml").write_text(JOB)
    return tmp_path


def usdsdg(folder, command, *options):
    return forked.run(["-m", "usdsdg", command, "-q", "--device", "cpu", *options], cwd=folder)


def generate(folder, out, *options):
    done = usdsdg(folder, "generate", "--set", f"writer_kwargs.output_dir={folder / out}", *options, "job.yaml")
    labels = sorted((folder / out).glob("semantic_segmentation_labels_*.json"))
    return done, [{label.get("class") for label in json.loads(each.read_text()).values()} for each in labels]


@pytest.mark.parametrize("workers", sampled([("--workers", "2"), ()]))
def test_a_job_finds_mapped_assets(folder, workers):
    done, _ = generate(folder, "none", *workers)
    assert done.returncode == 1
    assert done.stderr.count("or map its folder with --map PREFIX=FOLDER.\n") == 1
    done, shown = generate(folder, "out", "--map", "omniverse://host/P=mine", *workers)
    assert done.returncode == 0, done.stderr
    assert len(shown) == 2
    assert "box" in set().union(*shown)


def test_a_job_reads_the_file_of_maps(folder):
    (folder / "usdsdg.toml").write_text('[map]\n"omniverse://host/P" = "mine"\n')
    done, shown = generate(folder, "out")
    assert done.returncode == 0, done.stderr
    assert len(shown) == 2


def test_an_image_shows_mapped_assets(folder):
    options = ("--width", "32", "--height", "24", "--spp", "1", "scene.usda", "out")
    done = usdsdg(folder, "render", *options)
    assert "scene.usda has no visible geometry" in done.stderr
    done = usdsdg(folder, "render", "--map", "omniverse://host/P=mine", *options)
    assert done.returncode == 0, done.stderr
    (table,) = (folder / "out").glob("instance_id_segmentation_mapping_*.json")
    assert "/Box/Cube" in json.loads(table.read_text()).values()


def test_mapped_assets_are_simulated(folder):
    options = ("--seconds", "0.2", "--map", "omniverse://host/P=mine")
    done = usdsdg(folder, "simulate", *options, "scene.usda", "after.usda")
    assert done.returncode == 0, done.stderr
    assert "xformOp:translate = (0, 0, -0." in (folder / "after.usda").read_text()


@pytest.mark.parametrize("command", ["generate", "render", "simulate", "view"])
def test_a_map_that_cannot_work_is_an_error(folder, command):
    source = ["job.yaml"] if command == "generate" else ["scene.usda"]
    output = [] if command in ("generate", "view") else ["out"]
    done = usdsdg(folder, command, "--map", "omniverse://host/P=gone", *source, *output)
    assert done.returncode == 1
    assert f"omniverse://host/P is mapped to {folder / 'gone'}, which is not a folder" in done.stderr


def test_a_program_without_the_option_is_told_which_commands_have_it(folder):
    program = f"import usdsdg as rep\nrep.create.from_usd({URL!r})\n"
    done = forked.run(["-c", program], cwd=folder, env=os.environ)
    assert done.returncode == 1
    assert "with --map PREFIX=FOLDER, an option of usdsdg run, generate, render, simulate and view." in done.stderr

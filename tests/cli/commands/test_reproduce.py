"""`usdsdg reproduce` makes frames of a dataset again from what is beside it, and finds what differs."""

import json
import shutil

import pytest

from tests.cli.datasets import generate, run, write_job
from tests.sampled_cases import in_soak
from tests.verify import damaged

INTERRUPTED = """
import os, sys
import omni.replicator.core as rep
rep.create.light(light_type="Dome")
rep.create.cube()
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True)
writer.attach(rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24)))
for _ in range(4):
    rep.orchestrator.step()
if os.environ.get("ENDS_EARLY"):
    raise KeyboardInterrupt
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A dataset, of which the configuration is gone and which has been moved."""
    folder = tmp_path_factory.mktemp("made")
    done = generate(write_job(folder, "PoseWriter", skip_empty_frames=True), folder / "out", fresh=True)
    assert done.returncode == 0, done.stderr
    (folder / "job.yaml").unlink()
    return (folder / "out").rename(folder / "moved")


def reproduce(folder, *options):
    return run(["-m", "usdsdg", "reproduce", "-q", str(folder), "--device", "cpu", *options])


def test_all_files_are_made_again_with_their_bytes(made):
    before = {path: path.read_bytes() for path in made.rglob("*") if path.is_file()}
    done = reproduce(made)
    assert done.returncode == 0, done.stderr + done.stdout
    count = len(before) - 2  # the recipe and the journal
    assert f"{count} files equal, 0 different" in done.stdout
    assert {path: path.read_bytes() for path in made.rglob("*") if path.is_file()} == before


def test_a_damaged_recipe_is_not_said_to_be_removed_by_an_option_of_another_command(tmp_path):
    (tmp_path / "out/.usdsdg").mkdir(parents=True)
    (tmp_path / "out/.usdsdg/recipe.json").write_text('{"format": 1}}')
    for command in ("reproduce", "merge"):
        done = run(["-m", "usdsdg", command, "-q", str(tmp_path / "out")])
        assert done.returncode == 1
        remedy = "Put a copy of it back, or make the dataset anew with --overwrite."
        assert done.stderr.splitlines()[-1].endswith(remedy)


def test_changed_files_of_the_chosen_frames_are_named(made, tmp_path):
    shutil.copytree(made, tmp_path / "out")
    lines = [json.loads(line) for line in (made / ".usdsdg/journal.jsonl").read_text().splitlines()[1:-1]]
    shown = [line["frame"] for line in lines if len(line["files"]) > 1]
    for number in shown[1:3]:
        name = next(name for name in lines[number]["files"] if name.endswith(".json"))
        (tmp_path / "out" / name).write_bytes(b"{}")
    done = reproduce(tmp_path / "out", "--frames", f"{shown[0]},{shown[1]}")
    assert done.returncode == 1, done.stderr
    assert done.stdout.count("is made with other bytes, which are those of the journal") == 1
    assert "2 frames of" in done.stdout


def test_other_versions_are_told_and_compared_within_a_tolerance(made, tmp_path):
    shutil.copytree(made, tmp_path / "out")
    recipe = tmp_path / "out/.usdsdg/recipe.json"
    recipe.write_text(recipe.read_text().replace('"warp-lang": "', '"warp-lang": "0.'))
    name = next(path for path in sorted((tmp_path / "out").glob("*.json")))
    values = json.loads(name.read_text())
    name.write_text(json.dumps(values))  # in another form, with the same values
    other = sorted((tmp_path / "out").glob("*.json"))[1]
    other.write_text(other.read_text().replace("pudding_box", "tea_box").replace("mustard", "tea"))
    done = reproduce(tmp_path / "out", "--frames", "0:3")
    assert done.returncode == 1, done.stdout
    assert "versions.warp-lang" in done.stderr
    assert "1 within the tolerance, 1 different" in done.stdout


def test_bodies_are_simulated_on_the_device_of_the_recipe(made, tmp_path):
    shutil.copytree(made, tmp_path / "out")
    recipe = tmp_path / "out/.usdsdg/recipe.json"
    recipe.write_text(recipe.read_text().replace('"options": {}', '"options": {"physics_device": "abacus"}'))
    done = reproduce(tmp_path / "out")
    assert done.returncode == 1
    assert done.stderr.startswith("error: cannot simulate on 'abacus'")


def test_an_interrupted_run_says_nothing_of_its_temporary_folder(tmp_path, monkeypatch):
    """Files that waited to be written there were errors of a removed folder."""
    script = tmp_path / "script.py"
    script.write_text(INTERRUPTED)
    done = run(["-m", "usdsdg", "run", "-q", "--device", "cpu", str(script), str(tmp_path / "out")])
    assert done.returncode == 0, done.stderr
    monkeypatch.setenv("ENDS_EARLY", "yes")
    done = reproduce(tmp_path / "out")
    assert done.returncode == 130
    assert "interrupted" in done.stderr
    assert "cannot be written" not in done.stderr


def test_a_script_with_arguments_is_run_again(tmp_path):
    out = damaged.make(tmp_path, 3)
    done = reproduce(out)
    assert done.returncode == 0, done.stderr + done.stdout
    assert "0 different" in done.stdout
    (tmp_path / "another.py").write_text("print('another')")
    done = reproduce(out, "--source", str(tmp_path / "another.py"))
    assert done.returncode == 1
    assert "is not the file that made" in done.stderr
    done = reproduce(out, "--source", str(tmp_path / "script.py"), "--frames", "1")
    assert done.returncode == 0, done.stderr


def test_a_script_of_plain_python_is_run_again(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        damaged.SCRIPT.replace("omni.replicator.core", "usdsdg")
        + "rep.orchestrator.wait_until_complete()\nsys.exit(0)\n"
    )
    out = tmp_path / "out"
    run([str(script), "2", str(out)]).check_returncode()
    done = reproduce(out)
    assert done.returncode == 0, done.stderr + done.stdout
    assert "0 different" in done.stdout


FORMATS = """
import os, sys
import omni.replicator.core as rep
camera = rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0))
rep.create.light(light_type="dome")
cube = rep.create.cube(semantics=[("class", "cube")])
product = rep.create.render_product(camera, (32, 24))
for name in ("VocWriter", "KittiWriter"):
    writer = rep.WriterRegistry.get(name)
    writer.initialize(output_dir=os.path.join(sys.argv[1], name))
    writer.attach(product)
with rep.trigger.on_frame():
    with cube:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
for _ in range(2):
    rep.orchestrator.step()
print("made once")
"""


CLASSES = """
import sys
import omni.replicator.core as rep
rep.create.light(light_type="Dome")
rep.create.cube(semantics=[("class", "cube"), ("part", "side")])
rp = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24))
for name, options in (("yolo", {}), ("parts", {"semantic_types": ["class", "part"]})):
    writer = rep.WriterRegistry.get("YoloWriter")
    writer.initialize(output_dir=f"{sys.argv[1]}/{name}", **options)
    writer.attach(rp)
rep.orchestrator.step()
"""


def test_classes_that_an_option_gave_are_given_again(tmp_path):
    (tmp_path / "script.py").write_text(CLASSES)
    classes = tmp_path / "classes.yaml"
    classes.write_text("{cone: 2, cube: {id: 5, color: [1, 2, 3]}}")
    command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", "--semantic-classes", str(classes)]
    done = run([*command, str(tmp_path / "script.py"), str(tmp_path / "out")], fresh=True)
    assert done.returncode == 0, done.stderr
    classes.unlink()
    done = reproduce(tmp_path / "out")
    assert done.returncode == 0, done.stderr + done.stdout
    assert done.stdout.count(" files equal, 0 different") == 2


@in_soak
def test_a_folder_of_several_formats_is_made_again_at_once_for_each_run(tmp_path):
    (tmp_path / "script.py").write_text(FORMATS)
    for name, seed in (("out", "1"), ("other", "2")):
        command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", "--seed", seed, str(tmp_path / "script.py")]
        done = run([*command, str(tmp_path / name)], fresh=True)
        assert done.returncode == 0, done.stderr
    done = reproduce(tmp_path / "out")
    assert done.returncode == 0, done.stderr + done.stdout
    assert done.stderr.count("made once") == 1
    lines = done.stdout.splitlines()
    assert [line.split(": ")[0] for line in lines] == [str(tmp_path / "out" / n) for n in ("KittiWriter", "VocWriter")]
    assert all(line.endswith(" files equal, 0 different") for line in lines)
    (tmp_path / "other/VocWriter").rename(tmp_path / "out/another run")
    next((tmp_path / "out/KittiWriter").rglob("*.png")).write_bytes(b"")
    done = reproduce(tmp_path / "out")
    assert done.returncode == 1, done.stderr + done.stdout
    assert done.stderr.count("made once") == 2
    assert [line.rpartition(", ")[2] for line in done.stdout.splitlines() if " files equal" in line] == [
        "1 different", "0 different", "0 different",
    ]  # fmt: skip


def test_frames_that_only_some_formats_have_are_made_again(tmp_path):
    options = (
        "writer.attach(product, **({'trigger': rep.trigger.on_frame(interval=2)} if name == 'KittiWriter' else {}))"
    )
    script = FORMATS.replace("writer.attach(product)", options).replace("range(2)", "range(3)")
    (tmp_path / "script.py").write_text(script)
    command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", str(tmp_path / "script.py"), str(tmp_path / "out")]
    done = run(command)
    assert done.returncode == 0, done.stderr
    done = reproduce(tmp_path / "out", "--frames", "1")
    assert done.returncode == 0, done.stderr + done.stdout
    assert [line.split(": ")[0] for line in done.stdout.splitlines()] == [f"1 frame of {tmp_path / 'out/VocWriter'}"]
    done = reproduce(tmp_path / "out/KittiWriter", "--frames", "0:3")
    assert done.returncode == 0, done.stderr + done.stdout
    done = reproduce(tmp_path / "out/KittiWriter", "--frames", "1")
    assert "does not have frame 1; it has 2 frames, from 0 to 2" in done.stderr


def test_a_folder_without_a_recipe_cannot_be_made_again(tmp_path):
    done = reproduce(tmp_path)
    assert done.returncode == 1
    assert "has no recipe" in done.stderr
    assert f"{tmp_path / 'gone'} does not exist" in reproduce(tmp_path / "gone").stderr


@pytest.mark.parametrize(
    ("frames", "named"), [("9", "frame 9"), ("7:9", "frames 7, 8"), ("2,77", "frame 77"), ("6:", "frame 6"),
                          ("4:99999999999", "frames 6, 7, 8, 9, 10, 11, 12, 13 and 99999999985 more")],
)  # fmt: skip
def test_frames_that_the_dataset_does_not_have_are_an_error(made, frames, named):
    done = reproduce(made, "--frames", frames)
    assert done.returncode == 1
    assert done.stderr.strip() == f"error: --frames: {made} does not have {named}; it has 6 frames, from 0 to 5"
    assert not done.stdout


EDITED = """
import sys
from pathlib import Path
import omni.replicator.core as rep
if ".usdsdg" not in __file__:  # as its author may, who prepares the next run meanwhile
    Path(__file__).write_text("raise SystemExit(7)")
rep.create.cube()
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], bounding_box_2d_tight=True)
writer.attach(rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24)))
rep.orchestrator.step()
"""


def test_a_script_that_is_edited_while_it_runs_is_kept_as_it_began(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(EDITED)
    done = run(["-m", "usdsdg", "run", "-q", str(script), str(tmp_path / "out")])
    assert done.returncode == 0, done.stderr
    assert script.read_text() != EDITED
    assert (tmp_path / "out/.usdsdg/source/script.py").read_text() == EDITED
    done = reproduce(tmp_path / "out")
    assert done.returncode == 0, done.stderr + done.stdout

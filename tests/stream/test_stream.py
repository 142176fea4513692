"""Frames of scripts and configurations in memory."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from PIL import Image

from tests import forked
from tests.cli.datasets import write_job
from tests.sampled_cases import in_soak
from usdsdg import stream
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError, ArgumentError, ConfigError, GraphError
from usdsdg.session import session

HERE = Path(__file__).parent
SCENE = HERE / "scene.py"

# Prints what each stream of a list of arguments yields, in one process.
STREAMS = """
import hashlib, json, sys
from tests.cli.datasets import write_job
from usdsdg import stream
from usdsdg.errors import UsdsdgError

def digest(array):
    return hashlib.md5(str(array.dtype).encode() + array.tobytes()).hexdigest()

main, given = sys.modules["__main__"], list(sys.argv)
rows = []
for options in json.loads(sys.argv[1]):
    job, limit = options.pop("job"), options.pop("limit", None)
    row, failure = [], None
    samples = stream.frames(job, **options)
    try:
        for sample in samples:
            row.append([sample.frame, sample.render_product, {n: digest(a) for n, a in sample.arrays.items()}])
            if limit is not None and len(row) == limit:
                break
    except UsdsdgError as error:
        failure = f"{type(error).__name__}: {error}"
    samples.close()
    rows.append([row, failure])
assert sys.modules["__main__"] is main and sys.argv == given
print(json.dumps(rows))
"""


def streams(folder: Path, *options: dict) -> list:
    """Return the rows and the failure of each stream, all in one new process."""
    done = forked.run(["-c", STREAMS, json.dumps(options)], cwd=folder)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@in_soak
def test_every_part_has_the_frames_of_the_whole(tmp_path):
    annotators = ["rgb", "bounding_box_2d_tight", "semantic_segmentation", "motion_vectors"]
    common = {"job": str(SCENE), "annotators": annotators, "arguments": ["5"], "seed": 3}
    (whole, failure), *parts, (other, _) = streams(
        tmp_path,
        common,
        *({**common, "part": [i, 3]} for i in range(3)),
        {**common, "seed": 4, "arguments": ["1"]},
    )
    assert failure is None
    assert [row[0] for row in whole] == [0, 1, 2, 3, 4]
    assert len({json.dumps(row[2]) for row in whole}) == 5
    for i, (rows, _) in enumerate(parts):
        assert rows == whole[i::3]
    assert other[0][2] != whole[0][2]
    # The writer of the script made its folder, and was given no frame.
    assert not list((tmp_path / "written").iterdir())


def test_a_stream_shows_what_the_writer_of_the_script_writes(tmp_path):
    done = forked.run(["-m", "usdsdg", "run", "--quiet", "--seed", "3", str(SCENE), "2"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    pictures = [np.asarray(Image.open(tmp_path / f"written/rgb_{frame:04}.png")) for frame in range(2)]
    (rows, _) = streams(tmp_path, {"job": str(SCENE), "arguments": ["2"], "seed": 3})[0]
    expected = [hashlib.md5(b"uint8" + picture.tobytes()).hexdigest() for picture in pictures]
    assert [row[2]["rgb"] for row in rows] == expected


# Takes a sample late, so that the job waits with the next ones, and asks usdsdg for something before it takes another.
CALLS = """
import sys, time
import usdsdg as rep
from usdsdg import stream
samples = stream.frames(sys.argv[1], ["rgb"], arguments=["4"])
next(samples)
time.sleep(3)
rep.annotators.get("rgb")
print(len(list(samples)))
"""


def test_who_takes_samples_may_call_usdsdg_between_them(tmp_path):
    done = forked.run(["-c", CALLS, str(SCENE)], cwd=tmp_path)
    assert done.stdout.splitlines()[-1:] == ["3"], done.stderr


def test_a_stream_that_is_closed_early_leaves_the_process_as_it_was(tmp_path):
    common = {"job": str(SCENE), "annotators": ["rgb"], "arguments": ["4"], "seed": 3}
    (first, _), (again, _), (failed, failure) = streams(
        tmp_path, {**common, "limit": 1}, common, {**common, "arguments": ["2", "--fail"]}
    )
    assert again[:1] == first
    assert len(again) == 4
    assert len(failed) == 2
    assert failure is not None
    assert "ended with exit code 1: ValueError: the script failed (scene.py:39)" in failure


# Takes one frame of each of two scripts, of which the second one steps in tasks, and of a configuration.
FIRST_FRAMES = """
import sys
from pathlib import Path
from tests.cli.datasets import write_job
from usdsdg import stream
job = write_job(Path("."), "BasicWriter", rgb=True)
small = ["num_frames=4", "path_tracing.every=0", "num_cameras=1"]
for path, arguments in (("plain.py", ["4"]), (sys.argv[1], ["4"]), (job, small)):
    for sample in stream.frames(path, ["distance_to_camera"], arguments=arguments):
        break
    print("left", sample.frame)
"""
PLAIN = """
import sys
import omni.replicator.core as rep

product = rep.create.render_product(rep.create.camera(), (24, 16))
try:
    rep.orchestrator.run_until_complete(num_frames=int(sys.argv[1]))
except Exception as error:
    print("caught", error)
"""


def test_nothing_is_printed_of_a_job_that_is_left_in_the_middle(tmp_path):
    (tmp_path / "plain.py").write_text(PLAIN)
    done = forked.run(["-c", FIRST_FRAMES, str(SCENE)], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert [line for line in done.stdout.splitlines() if line.startswith(("left", "caught"))] == ["left 0"] * 3
    assert "Traceback" not in done.stderr
    assert "Closed" not in done.stderr


FORKS = """
import hashlib, os, sys
from usdsdg import stream
def digest():
    samples = stream.frames(sys.argv[1], arguments=["2"], seed=3)
    return [hashlib.md5(sample.arrays["rgb"].tobytes()).hexdigest() for sample in samples]
before = digest()
child = os.fork()
if child == 0:
    try:
        code = 0 if digest() == before else 3
    except Exception as error:
        print("refused:", error, file=sys.stderr, flush=True)
        code = 4
    os._exit(code)
_, status = os.waitpid(child, 0)
sys.exit(os.waitstatus_to_exitcode(status))
"""


def run_forks(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a program that forks after it has rendered, and whose copy renders again."""
    command, whole = [sys.executable, "-c", FORKS, str(SCENE)], {**os.environ, **environment}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, env=whole)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_process_that_was_forked_after_rendering_renders(tmp_path):
    done = run_forks(tmp_path, CUDA_VISIBLE_DEVICES="")
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not wp.is_cuda_available(), reason="this machine has no CUDA device")
def test_a_process_that_was_forked_from_one_with_cuda_is_refused_in_one_line(tmp_path):
    """Nor does Warp say for each array of the other process that it cannot give it back here."""
    done = run_forks(tmp_path)
    assert done.returncode == 4
    assert "refused: cannot render on 'cuda:0': this process was forked" in done.stderr
    assert "Warp CUDA error" not in done.stderr + done.stdout


def test_what_cannot_be_streamed_is_said_before_anything_runs(tmp_path):
    (tmp_path / "stage.usda").write_text("#usda 1.0\n")
    (tmp_path / "wrong.yaml").write_text("num_frams: 3\nresolution: [32, 32]\n")
    with pytest.raises(ConfigError, match="there is no job"):
        stream.frames(tmp_path / "absent.py")
    with pytest.raises(ConfigError, match="is no job"):
        stream.frames(tmp_path / "stage.usda")
    with pytest.raises(ConfigError, match="num_frams"):
        stream.frames(tmp_path / "wrong.yaml")
    with pytest.raises(AnnotatorRegistryError, match="rgbb"):
        stream.frames(SCENE, ["rgbb"])
    with pytest.raises(ArgumentError, match="part is"):
        stream.frames(SCENE, part=(2, 2))
    with pytest.raises(ArgumentError, match="ahead is 0"):
        stream.frames(SCENE, ahead=0)
    for part in (None, (0,), (0, 1, 2), 3, "01", (0.5, 2), (0, 2.0), (-1, 2)):
        with pytest.raises(ArgumentError, match=r"part is .*; expected \(i, n\)"):
            stream.frames(SCENE, part=part)  # pyright: ignore[reportArgumentType]
    for ahead in (None, 1.5, "2"):
        with pytest.raises(ArgumentError, match="ahead is"):
            stream.frames(SCENE, ahead=ahead)  # pyright: ignore[reportArgumentType]
    colors = ("semantic_segmentation", {"colorize": True})
    with pytest.raises(ArgumentError, match="semantic_segmentation with several parameters"):
        stream.frames(SCENE, ["semantic_segmentation", colors])


@pytest.fixture
def no_stage():
    """A session in which a job may run: tests before may have left a stage open."""
    session.restart()
    yield
    session.restart()


SEEDED = """
import omni.replicator.core as rep

rep.set_global_seed(5)
product = rep.create.render_product(rep.create.camera(), (24, 16))
rep.orchestrator.run_until_complete(num_frames=2)
"""


def test_a_script_that_sets_its_own_seed_is_told_of_where_another_was_asked_for(no_stage, tmp_path, recwarn):
    (tmp_path / "seeded.py").write_text(SEEDED)
    for seed in (None, 5):
        assert len(list(stream.frames(tmp_path / "seeded.py", ["distance_to_camera"], seed=seed))) == 2
    assert not [each for each in recwarn if "global seed" in str(each.message)]
    assert len(list(stream.frames(tmp_path / "seeded.py", ["distance_to_camera"], seed=6))) == 2
    (told,) = [each for each in recwarn if "global seed" in str(each.message)]
    assert "seeded.py sets the global seed 5 itself, so that the seed 6" in str(told.message)


def test_a_job_whose_episodes_have_seeds_is_not_told_of(no_stage, tmp_path, recwarn):
    job = write_job(tmp_path, "BasicWriter", rgb=True)
    keys = ["num_frames=2", "frames_per_episode=1", "path_tracing.every=0", "num_cameras=1"]
    assert len(list(stream.frames(job, ["distance_to_camera"], arguments=keys, seed=6))) == 2
    assert not [each for each in recwarn if "global seed" in str(each.message)]


def test_an_open_stage_is_not_replaced(stage):
    with pytest.raises(GraphError, match="a stage is open"):
        next(stream.frames(SCENE, arguments=["1"]))
    assert stage.GetPrimAtPath("/World")


def test_class_ids_are_those_of_the_dataset_not_of_the_frame():
    rows = np.zeros(3, [("semanticId", np.uint32)])
    rows["semanticId"] = 1, 0, 1
    infos = {"boxes": {"idToLabels": {"0": {"class": "nut"}, "1": {"class": "bolt", "size": "m4"}}}}
    classes = {2: {"class": "gear"}, 3: {"size": "m4", "class": "bolt"}, 7: {"class": "nut"}}
    sample = stream.Sample(0, "Replicator", "/Camera", {"boxes": rows}, infos, classes)
    assert sample.class_ids("boxes").tolist() == [3, 7, 3]


def test_class_ids_without_a_class_table_say_which_setting_takes_it_away(tmp_path):
    setting = 'rep.settings.carb_settings("/usdsdg/labels/stableIds", False)'
    (tmp_path / "unstable.py").write_text(
        TWO_TYPES.replace("replicator.core as rep", f"replicator.core as rep\n{setting}")
    )
    (sample,) = stream.frames(tmp_path / "unstable.py", ["bounding_box_2d_tight"])
    with pytest.raises(AnnotatorError, match=r"in no class table.*stableIds"):
        sample.class_ids("bounding_box_2d_tight")


@in_soak
def test_frames_are_counted_over_the_episodes_of_a_job(tmp_path):
    job = write_job(tmp_path, "BasicWriter", rgb=True)
    keys = ["num_frames=3", "frames_per_episode=1", "path_tracing.every=0", "num_cameras=1"]
    common = {"job": str(job), "annotators": ["distance_to_camera"], "arguments": keys}
    (whole, failure), (odd, _) = streams(tmp_path, common, {**common, "part": [1, 2]})
    assert failure is None
    assert [row[0] for row in whole] == [0, 1, 2]
    assert odd == whole[1::2]


LATE = """
import omni.replicator.core as rep

ball = rep.create.sphere(position=(0, 1, 0), semantics=[("class", "ball")])
late = rep.create.cube(position=(0, -1, 0), semantics=[("class", "after")])
camera = rep.create.camera(position=(6, 0, 0), look_at=(0, 0, 0))
product = rep.create.render_product(camera, (24, 16))
for frame in range(4):
    if frame == 1:
        rep.modify.semantics([("class", "before")], input_prims=late, mode="replace")
    rep.orchestrator.step()
"""


def test_a_class_that_comes_up_before_the_first_frame_of_a_part_has_no_other_ids_there(tmp_path):
    """Else one id would mean two classes in batches of several workers."""
    (tmp_path / "late.py").write_text(LATE)
    common = {"job": str(tmp_path / "late.py"), "annotators": ["semantic_segmentation"]}
    rows = streams(tmp_path, *({**common, "part": [number, 2]} for number in range(2)))
    assert [len(row) for row, _ in rows] == [1, 0]
    for _, failure in rows:
        assert "'before' is not in the class table of this dataset" in failure


def test_annotators_with_parameters_and_ids_of_every_kind_of_rows():
    names = [("semantic_segmentation", {"colorize": True}), "occlusion", "visibility", "bounding_box_2d_tight"]
    (sample,) = stream.frames(SCENE, names, arguments=[1])
    assert sample.arrays["semantic_segmentation"].dtype == np.uint8
    labels = {number: labels["class"] for number, labels in sample.classes.items()}
    boxes = sample.infos["bounding_box_2d_tight"]["primPaths"]
    of_boxes = dict(zip(boxes, (labels[int(each)] for each in sample.class_ids("bounding_box_2d_tight"))))
    seen = sample.infos["visibility"]["primPaths"]
    of_seen = dict(zip(seen, (labels[int(each)] for each in sample.class_ids("visibility"))))
    assert sorted(of_boxes.values()) == ["ball", "cube"]
    assert of_boxes == {path: of_seen[path] for path in of_boxes}
    assert {labels.get(int(each)) for each in sample.class_ids("occlusion")} >= {"ball", "cube"}
    with pytest.raises(KeyError):
        sample.class_ids("semantic_segmentation")


TWO_TYPES = """
import omni.replicator.core as rep

rep.create.cube(position=(0, -2, 0), semantics=[("class", "cube"), ("material", "wood")])
rep.create.sphere(position=(0, 2, 0), semantics=[("class", "ball"), ("material", "steel")])
rep.create.cone(position=(0, 0, 2), semantics=[("material", "glass")])
product = rep.create.render_product(rep.create.camera(position=(12, 0, 2), look_at=(0, 0, 0)), (48, 32))
rep.orchestrator.run_until_complete(num_frames=1)
"""
OF_PRIMS = {
    "class": {"Cube": "cube", "Sphere": "ball"},
    "material": {"Cube": "wood", "Sphere": "steel", "Cone": "glass"},
}


@pytest.mark.parametrize("types", [("class", "material"), ("material", "class")])
def test_annotators_of_several_label_filters_have_a_class_table_each(types, tmp_path):
    """Else ids of one filter are looked up among the classes of another, which has other ids or none."""
    (tmp_path / "two_types.py").write_text(TWO_TYPES)
    first, second = types
    names = [
        ("bounding_box_2d_tight", {"semanticTypes": [first]}),
        ("visibility", {"semanticTypes": [second]}),
        ("bounding_box_3d", {"semanticTypes": [second]}),
        ("bounding_box_2d_loose", {"semanticTypes": [first]}),
    ]
    (sample,) = stream.frames(tmp_path / "two_types.py", names)
    assert sorted(sample.class_tables) == ["bounding_box_3d", "visibility"]
    for name, options in names:
        (kind,) = options["semanticTypes"]
        table = sample.class_tables.get(name, sample.classes)
        prims = [path.rsplit("/", 1)[-1].partition("_")[0] for path in sample.infos[name]["primPaths"]]
        labels = [table[number] for number in sample.class_ids(name).tolist()]
        assert dict(zip(prims, labels)) == {prim: {kind: label} for prim, label in OF_PRIMS[kind].items()}


@pytest.mark.parametrize(
    ("script", "why"),
    [
        ("product = rep.create.render_product(rep.create.camera(), (24, 16))", "nothing in it started a run"),
        ("rep.orchestrator.step()", "there is no render product"),
    ],
)
def test_a_script_that_shows_no_frame_is_told_of(script, why, tmp_path, recwarn):
    (tmp_path / "job.py").write_text(f"import omni.replicator.core as rep\n{script}\n")
    assert not list(stream.frames(tmp_path / "job.py", ["distance_to_camera"]))
    (told,) = [each for each in recwarn if "has shown no frame" in str(each.message)]
    assert why in str(told.message)
    assert told.filename == __file__


def test_a_part_that_is_empty_is_not_told_of(tmp_path, recwarn):
    (tmp_path / "plain.py").write_text(PLAIN.replace("int(sys.argv[1])", "2"))
    assert not list(stream.frames(tmp_path / "plain.py", ["distance_to_camera"], part=(2, 3)))
    assert not [each for each in recwarn if "has shown no frame" in str(each.message)]


@pytest.mark.parametrize(
    ("options", "what"), [({"annotators": "rgb"}, "annotators"), ({"arguments": "12"}, "arguments")]
)
def test_one_text_in_place_of_a_list_is_refused(options, what):
    with pytest.raises(ArgumentError, match=f"{what} is the text"):
        next(stream.frames(SCENE, **options))


def test_what_is_no_annotator_is_refused_before_the_job_runs():
    with pytest.raises(ArgumentError, match="pairs of a name"):
        next(stream.frames(SCENE, [7]))  # pyright: ignore[reportArgumentType]


def test_the_seed_of_a_run_is_the_argument_s_then_the_configuration_s(tmp_path):
    job = write_job(tmp_path, "BasicWriter", rgb=True)
    assert stream.Source(job).seed_of_run == 3
    assert stream.Source(job, ["seed=5"]).seed_of_run == 5
    assert stream.Source(job, ["seed=5"], 7).seed_of_run == 7
    assert [stream.Source(SCENE).seed_of_run, stream.Source(SCENE, ["1"], 7).seed_of_run] == [0, 7]

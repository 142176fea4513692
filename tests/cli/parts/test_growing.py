"""`--resume` with more frames: what the commands take for the number of frames, and where a dataset cannot grow."""

import pytest
import yaml

from tests.cli.datasets import FRAMES, ROOT, content, generate, merge, run, write_job
from tests.sampled_cases import in_soak
from usdsdg.scenarios import earlier_runs
from usdsdg.scenarios.jobs import load_job
from usdsdg.writers.journal.growth import more_frames_of_option
from usdsdg.writers.journal.recipe import GENERATE, RUN, Recipe, Source, source_of

SCRIPT = """
import sys
import omni.replicator.core as rep
cubes = rep.create.cube(count=3, semantics=[("class", "cube")])
camera = rep.create.camera(position=(8, 1, 3), look_at=(0, 0, 0))
with rep.trigger.on_frame():
    with cubes:
        rep.modify.pose(position=rep.distribution.uniform((-2, -2, 0), (2, 2, 2)))
writer = rep.writers.get("CocoWriter")
writer.initialize(output_dir=sys.argv[1])
writer.attach(rep.create.render_product(camera, (48, 32)))
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    done = generate(write_job(folder, "PoseWriter"), folder / "out", fresh=True)
    assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.mark.parametrize("options", [(), pytest.param(("--workers", "2"), marks=in_soak)], ids=["alone", "workers"])
def test_a_job_with_more_frames_is_that_of_all_frames(whole, options, tmp_path):
    job, out = write_job(tmp_path, "PoseWriter"), tmp_path / "out"
    text = job.read_text()
    job.write_text(text.replace(f"num_frames: {FRAMES}", "num_frames: 2"))
    done = generate(job, out, *options)
    assert done.returncode == 0, done.stderr
    job.write_text(text)
    refused = generate(job, out)
    assert refused.returncode == 1
    assert "Only the number of frames is larger: --resume makes those that are missing" in refused.stderr
    done = generate(job, out, "--resume", *options)
    assert done.returncode == 0, done.stderr
    assert content(out) == content(whole)
    assert run(["-m", "usdsdg", "verify", str(out)]).returncode == 0
    again = run(["-m", "usdsdg", "reproduce", "-q", str(out), "--frames", "1,4"])
    assert again.returncode == 0, again.stdout + again.stderr
    assert "0 different" in again.stdout
    smaller = generate(job, out, "--resume", "--set", "num_frames=3")
    assert smaller.returncode == 1
    assert f"made with num_frames={FRAMES}, now it is num_frames=3" in smaller.stderr
    assert content(out) == content(whole)


def test_a_job_of_which_only_the_first_part_was_joined_is_gone_on_with(whole, tmp_path):
    job, out = write_job(tmp_path, "PoseWriter"), tmp_path / "out"
    assert generate(job, out, "--frames", "0:2").returncode == 0
    joined = merge(out)
    assert joined.returncode == 0, joined.stderr
    done = generate(job, out, "--resume")
    assert done.returncode == 0, done.stderr
    assert content(out) == content(whole)


@pytest.mark.parametrize("options", [(), pytest.param(("--workers", "2"), marks=in_soak)], ids=["alone", "workers"])
def test_the_frames_of_a_script_that_starts_no_run_are_added(options, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)

    def made(name, *options):
        return run(["-m", "usdsdg", "run", "-q", "--device", "cpu", *options, str(script), str(tmp_path / name)])

    for name, given in (("whole", ("--frames", "5")), ("out", ("--frames", "1"))):
        done = made(name, *given)
        assert done.returncode == 0, done.stderr
    done = made("out", "--resume", "--frames", "5", *options)
    assert done.returncode == 0, done.stderr
    assert content(tmp_path / "out") == content(tmp_path / "whole")
    smaller = made("out", "--resume", "--frames", "4")
    assert smaller.returncode == 1
    assert "--resume adds frames, but removes none" in smaller.stderr


def obstacle(tmp_path, job, earlier, wanted, **values):
    """Return what keeps a configuration with some overrides from growing to one with others."""
    file = tmp_path / f"{job}.yaml"
    file.write_text(yaml.safe_dump(yaml.safe_load((ROOT / f"configs/{job}.yaml").read_text()) | values))
    now, before = (Recipe(GENERATE, source_of(file), arguments=each, device="cpu") for each in (wanted, earlier))
    return earlier_runs.of_job(file, *load_job(file, wanted))(now, before, tmp_path)


@pytest.mark.parametrize(
    ("earlier", "wanted", "expected"),
    [
        (["num_frames=40"], ["num_frames=60"], ""),
        (["num_frames=40", "output_dir=a"], ["output_dir=b", "num_frames=60"], ""),
        (["num_frames=3"], ["num_frames=3", "min_pixels=9"], None),
        (["num_frames=3"], ["num_frames=5", "min_pixels=9"], None),
        (["num_frames=3", "seed=1"], ["num_frames=5", "seed=2"], None),
        (["num_frames=5"], ["num_frames=3"], "removes none"),
    ],
)
def test_a_job_grows_where_nothing_but_the_number_differs(earlier, wanted, expected, tmp_path):
    said = obstacle(tmp_path, "detection", earlier, wanted, objects={"per_image": [1, 1]})
    assert said == expected or (said and expected and expected in said)


@pytest.mark.parametrize(
    ("job", "earlier", "wanted", "expected"),
    [
        ("bin_picking", ["drops=1"], ["drops=2"], "seed of its own"),
        ("bin_picking", ["drops=2"], ["drops=3"], ""),
        ("bin_picking", ["frames_per_drop=2"], ["frames_per_drop=3"], None),
        ("object_based", ["frames_per_episode=5", "num_frames=5"], ["frames_per_episode=5", "num_frames=6"], "seed of"),
        ("object_based", ["frames_per_episode=5", "num_frames=6"], ["frames_per_episode=5", "num_frames=11"], ""),
        ("object_based", ["num_frames=5"], ["num_frames=6"], ""),
        ("detection", ["num_frames=1"], ["num_frames=200"], "copies"),
    ],
)
def test_draws_that_depend_on_the_number_of_frames_are_told(job, earlier, wanted, expected, tmp_path):
    said = obstacle(tmp_path, job, earlier, wanted)
    assert said == expected or (said and expected and expected in said)


def test_an_edited_configuration_is_compared_with_the_copy_beside_the_data(tmp_path):
    file = tmp_path / "job.yaml"
    text = (ROOT / "configs/object_based.yaml").read_text()
    file.write_text(f"{text}\n# as it was\n")
    before = Recipe(GENERATE, source_of(file), arguments=["num_frames=2"], device="cpu")
    Source.read(file).keep(tmp_path)
    file.write_text(text)
    now = Recipe(GENERATE, source_of(file), arguments=["num_frames=3"], device="cpu")
    compare = earlier_runs.of_job(file, *load_job(file, ["num_frames=3"]))
    assert compare(now, before, tmp_path) == ""
    (tmp_path / ".usdsdg/source/job.yaml").unlink()
    assert compare(now, before, tmp_path) is None


@pytest.mark.parametrize(
    ("wanted", "earlier", "expected"),
    [
        (["num_frames=5"], ["num_frames=3"], ""),
        (["num_frames=5"], [], ""),
        (["num_frames=5", "seed=2"], ["num_frames=3"], None),
        ([], ["num_frames=3"], None),
        (["num_frames=5"], ["num_frames=7"], "removes none"),
    ],
)
def test_a_saved_stage_grows_by_its_override(wanted, earlier, expected, tmp_path):
    source = {"name": "a.usd", "sha256": "1"}
    now, before = (Recipe(GENERATE, source, arguments=each, device="cpu", frames=3) for each in (wanted, earlier))
    said = earlier_runs.of_stage(now, before, tmp_path)
    assert said == expected or (said and expected and expected in said)


def test_arguments_of_a_script_are_not_taken_for_its_number_of_frames(tmp_path):
    source = {"name": "a.py", "sha256": "1"}
    now, before = (Recipe(RUN, source, arguments=[each], device="cpu") for each in ("5", "3"))
    assert more_frames_of_option(now, before, tmp_path) is None

"""`usdsdg run` with Replicator YAML files."""

import re
import textwrap

import pytest

from tests.scripts.conftest import usdsdg

SCENE = """
    cube:
      create.cube:
        semantics: [["class", "cube"]]
    camera:
      create.camera:
        position: [5, 0, 0]
        look_at: [0, 0, 0]
    render_product:
      create.render_product:
        camera: camera
        resolution: [16, 12]
    writer:
      writers.get:
        name: "BasicWriter"
        init_params:
          output_dir: "OUT"
          bounding_box_2d_tight: True
        render_products: render_product
    trigger:
      TRIGGER
    with_trigger:
      with.trigger:
        with.cube:
          modify.pose:
            position:
              distribution.uniform:
                lower: [0, -1, -1]
                upper: [0, 1, 1]
    """


def run(folder, trigger, *options, expect=0, quiet=("--quiet",)):
    text = textwrap.dedent(SCENE).replace("OUT", str(folder / "out")).replace("TRIGGER", trigger)
    (folder / "scene.yaml").write_text(text)
    done = usdsdg("run", *quiet, "--allow-outside", *options, "scene.yaml", cwd=folder, expect=expect)
    return done, sorted(path.name for path in (folder / "out").glob("bounding_box_2d_tight_*.npy"))


def test_a_file_runs_until_its_triggers_have_run_out(tmp_path):
    _, files = run(tmp_path, "trigger.on_frame: {max_execs: 3}", "--save-stage", "last.usda")
    assert len({(tmp_path / "out" / name).read_bytes() for name in files}) == len(files) == 3
    assert 'usdsdg:line = "scene.yaml:' in (tmp_path / "last.usda").read_text()


def test_the_last_line_of_progress_counts_the_captured_frames(tmp_path):
    done, files = run(tmp_path, "trigger.on_frame: {max_execs: 3}", quiet=())
    counts = [line for line in done.stderr.splitlines() if line.startswith("[usdsdg] frames captured: ")]
    assert counts[-1].startswith(f"[usdsdg] frames captured: {len(files)}/{len(files)}")


def test_the_timeline_plays_for_triggers_by_time(tmp_path):
    _, files = run(tmp_path, "trigger.on_time: {interval: 0.05, max_execs: 2}")
    # Of two intervals of three frames, which the preview and the first firing draw.
    assert len({(tmp_path / "out" / name).read_bytes() for name in files}) == 2
    numbered = [f"{interval}_{frame:04}" for interval in range(2) for frame in range(3)]
    assert files == [f"bounding_box_2d_tight_{number}.npy" for number in numbered]


def test_a_file_whose_run_would_not_end_is_refused(tmp_path):
    done, files = run(tmp_path, "trigger.on_frame: {interval: 1}", expect=1)
    assert "no trigger has max_execs" in done.stderr
    assert files == []


@pytest.mark.parametrize(
    ("trigger", "words"),
    [
        ("trigger.on_fram: null", "line 21: there is no function trigger.on_fram .*; did you mean 'on_frame'"),
        ("trigger.on_frame: {max_execs: 2, intervall: 3}", "line 21: .*'intervall'; did you mean 'interval'"),
    ],
)
def test_mistakes_are_reported_without_a_traceback(tmp_path, trigger, words):
    done, _ = run(tmp_path, trigger, expect=1)
    assert re.search(words, done.stderr)
    assert "Traceback" not in done.stderr


def test_a_file_takes_no_arguments(tmp_path):
    (tmp_path / "scene.yaml").write_text("a: 1\n")
    assert "takes no arguments: 1 2" in usdsdg("run", "scene.yaml", "1", "2", cwd=tmp_path, expect=1).stderr

"""Options that all commands refuse before any work, and the texts of their help."""

import importlib.util
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import usdsdg as rep
from tests import forked
from tests.scripts.conftest import ROOT, usdsdg
from usdsdg.cli.app import app
from usdsdg.cli.options.optional_values import completed
from usdsdg.cli.options.output_path import output_path
from usdsdg.errors import AssetUnreadable, OutputNotWritable
from usdsdg.stage import assets, flatten


def output_of(*arguments: str) -> str:
    """The output of a command that succeeds, on one line."""
    result = CliRunner().invoke(app, list(arguments), env={"COLUMNS": "200", "TERM": "dumb"})
    assert result.exit_code == 0, result.output
    return " ".join(result.output.split())


def test_the_version_is_printed():
    assert output_of("--version").strip() == f"usdsdg {rep.__version__}"


@pytest.mark.parametrize(
    ("command", "default"),
    [
        ("run", "(USDSDG_ASSETS_ROOT, else demo assets)"),
        ("simulate", "cpu"),
        ("generate", "(the config's); x>=0"),
        ("inspect", "(FOLDER/inspect.html)"),
        ("render", "64; 1<=x<=1048576"),
        ("convert", "keep"),
        ("new", "(detection.yaml, bin_picking.yaml or script.py)"),
    ],
)
def test_the_help_names_defaults(command, default):
    assert f"[default: {default}]" in output_of(command, "--help")


def test_the_help_of_run_says_which_options_belong_to_the_script():
    assert "Options of usdsdg come before SCRIPT" in output_of("run", "--help")


@pytest.mark.parametrize("command", ["run", "generate"])
def test_a_stage_cannot_be_saved_as_an_image(tmp_path, command):
    (tmp_path / "script.py").write_text("print('started')")
    what = "script.py" if command == "run" else str(ROOT / "configs" / "object_based.yaml")
    done = usdsdg(command, "--quiet", "--save-stage", "x.png", what, cwd=tmp_path, expect=1)
    assert "error: cannot save a stage as 'x.png': use one of .usd, .usda, .usdc" in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize(
    "arguments",
    [
        ("generate", "--device", "abacus", str(ROOT / "configs" / "object_based.yaml")),
        ("generate", "--physics-device", "abacus", str(ROOT / "configs" / "object_based.yaml")),
        ("simulate", "--device", "abacus", "in.usda", "out.usda"),
        ("run", "--device", "abacus", "in.usda"),
        ("run", "--physics-device", "abacus", "in.usda"),
    ],
)
def test_a_device_that_does_not_exist_is_refused_before_any_work(tmp_path, arguments):
    (tmp_path / "in.usda").write_text("#usda 1.0\n")
    done = usdsdg(*arguments, cwd=tmp_path, expect=1)
    lines = done.stderr.splitlines()
    assert len(lines) == 1
    assert "'abacus'" in lines[0]
    assert "Devices here: cpu" in lines[0]


def test_frames_that_a_job_does_not_have_are_refused_and_an_earlier_run_stays(tmp_path):
    (tmp_path / "job.yaml").write_text("{job: detection, num_frames: 3, output_dir: out}")
    (tmp_path / "out").mkdir()
    (tmp_path / "out/kept.txt").touch()
    done = usdsdg("generate", "job.yaml", "--frames", "3:9", "--overwrite", cwd=tmp_path, expect=1)
    assert "--frames 3:9: the run has 3 frames, counted from 0; give some of them" in done.stderr
    assert (tmp_path / "out/kept.txt").exists()


@pytest.mark.parametrize("root", ["", "nowhere", "in.usda"])
def test_an_assets_root_that_is_no_folder_is_refused_before_any_work(tmp_path, monkeypatch, root):
    """As of a variable that is not set; stand-ins for the assets would be made without a word."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.usda").write_text("#usda 1.0\n")
    result = CliRunner().invoke(app, ["render", "in.usda", "out", "--device", "cpu", f"--assets-root={root}"])
    assert result.exit_code == 1
    assert f"error: --assets-root {root!r} is no folder" in result.output
    assert not (tmp_path / "out").exists()


def test_a_tilde_in_quotes_is_the_home_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert output_path(Path("~/a")) == tmp_path / "a"
    assert output_path(Path("~nobody-of-this-name/a")) == Path("~nobody-of-this-name/a")
    assert output_path(Path("a/~")) == Path("a/~")


@pytest.mark.parametrize("url", ["s3://bucket/a.usd", "https://host/a.usd", "omniverse://localhost/a.usd"])
def test_a_url_is_no_path_to_write_to(url):
    """It was written to a folder called `s3:`."""
    with pytest.raises(OutputNotWritable, match=f"^{url} is a URL"):
        output_path(Path(url))
    assert output_path(Path("a:b/c")) == Path("a:b/c")


def test_an_empty_output_is_not_this_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.usda").write_text("#usda 1.0\n")
    result = CliRunner().invoke(app, ["render", "in.usda", "", "--device", "cpu"])
    assert result.exit_code == 1
    assert "error: OUTPUT is empty" in result.output


def test_a_time_code_that_has_no_time_stamp_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.usda").write_text("#usda 1.0\n")
    result = CliRunner().invoke(app, ["render", "in.usda", "out", "--device", "cpu", "--time", "1e308"])
    assert result.exit_code == 1
    assert "error: --time 1e+308 is more than 1e+12 s from 0" in result.output


@pytest.mark.parametrize(
    ("options", "said"),
    [(["--ray"], "--ray needs Ray: pip install"), (["--gpus-per-worker", "2"], "--gpus-per-worker is of the actors")],
)
def test_an_earlier_run_stays_where_options_cannot_work(tmp_path, monkeypatch, options, said):
    """It was removed before Ray was looked for."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    (tmp_path / "job.yaml").write_text("{job: detection, num_frames: 3, output_dir: out, formats: {yolo: {}}}")
    (tmp_path / "out/yolo").mkdir(parents=True)
    (tmp_path / "out/yolo/kept.txt").touch()
    arguments = completed(["generate", "job.yaml", "--device", "cpu", "--overwrite", *options])
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 1
    assert said in result.output
    assert [each.name for each in (tmp_path / "out/yolo").iterdir()] == ["kept.txt"]


def test_paths_of_stages_that_are_no_utf8_are_named(tmp_path):
    """USD takes no others; the name of the file was a traceback."""
    with pytest.raises(AssetUnreadable, match=r"'scene\\udcff.usda' is not UTF-8"):
        assets.locate("scene\udcff.usda")
    with pytest.raises(OutputNotWritable, match=r"saved\\udcff.usda' is not UTF-8"):
        flatten.check_writable(tmp_path / "saved\udcff.usda")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps a folder that a process is in")
@pytest.mark.parametrize("command", ["run", "generate"])
def test_a_working_folder_that_was_removed_is_told(tmp_path, command):
    (tmp_path / "gone").mkdir()
    what = {"run": "script.py", "generate": "job.yaml"}[command]
    (tmp_path / what).write_text("" if command == "run" else "job: detection\n")
    program = (
        "import os, sys; os.rmdir(os.getcwd())\n"
        f"sys.argv = ['usdsdg', {command!r}, {str(tmp_path / what)!r}]\n"
        "from usdsdg.cli.program import main; main()"
    )
    done = forked.run(["-c", program], cwd=tmp_path / "gone")
    assert done.returncode == 1
    assert done.stderr == "error: the working folder of this shell was removed; change to one that is there (cd)\n"

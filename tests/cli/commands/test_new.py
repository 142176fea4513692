"""`usdsdg new`: what it writes is read without a problem, and is never written over something else."""

import pytest
import yaml
from click.testing import CliRunner
from jsonschema import Draft202012Validator

from tests import forked
from usdsdg.cli.app import app
from usdsdg.cli.commands.new import SCHEMA, Kind, write_starting_point
from usdsdg.errors import OutputNotWritable
from usdsdg.scenarios.jobs import load_job


@pytest.mark.parametrize("kind", [Kind.DETECTION, Kind.BIN_PICKING])
def test_a_configuration_is_read_and_names_the_schema_beside_it(kind, tmp_path):
    path = tmp_path / "jobs" / "mine.yaml"
    assert write_starting_point(kind, path) == [str(path), f"next: usdsdg generate {path}"]
    _, config = load_job(path)
    assert config.job == kind.value.replace("-", "_")
    assert path.read_text().startswith(f"# yaml-language-server: $schema={SCHEMA}\n")
    schema = yaml.safe_load((path.parent / SCHEMA).read_text())
    assert list(Draft202012Validator(schema).iter_errors(yaml.safe_load(path.read_text()))) == []


def test_a_script_runs_as_it_is(tmp_path):
    path = tmp_path / "first script.py"
    assert write_starting_point(Kind.SCRIPT, path) == [str(path), f"next: usdsdg run '{path}'"]
    text = path.read_text().replace("(320, 240)", "(32, 24)").replace("num_frames=10", "num_frames=2")
    path.write_text(text.replace('"_out_script"', repr(str(tmp_path / "out"))))
    done = forked.run([str(path)], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "warning" not in done.stderr.lower()
    assert len(list((tmp_path / "out").glob("rgb_*.png"))) == 2


def test_no_file_is_replaced_and_suffixes_are_those_of_the_kind(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("mine")
    with pytest.raises(OutputNotWritable, match="exists and is not replaced"):
        write_starting_point(Kind.DETECTION, path)
    assert path.read_text() == "mine"
    with pytest.raises(OutputNotWritable, match=r"a script is a \.py file"):
        write_starting_point(Kind.SCRIPT, tmp_path / "b.yaml")
    with pytest.raises(OutputNotWritable, match="cannot be written"):
        write_starting_point(Kind.SCRIPT, path / "b.py")


def test_a_full_disk_leaves_nothing_in_the_way_of_the_next_try(tmp_path):
    resource = pytest.importorskip("resource")
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    for most in (0, 1000, 8000):  # no byte, less than the configuration, and less than the schema
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, limit[1]))
        try:
            with pytest.raises(OutputNotWritable, match="cannot be written: the file would be larger"):
                write_starting_point(Kind.DETECTION, tmp_path / "a.yaml")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        assert list(tmp_path.iterdir()) == []
    write_starting_point(Kind.DETECTION, tmp_path / "a.yaml")
    assert load_job(tmp_path / "a.yaml")[1].job == "detection"


def test_a_job_may_be_called_as_in_configurations(tmp_path):
    done = CliRunner().invoke(app, ["new", "bin_picking", str(tmp_path / "bin.yaml")])
    assert done.exit_code == 0, done.output
    assert load_job(tmp_path / "bin.yaml")[1].job == "bin_picking"

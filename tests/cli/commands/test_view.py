"""What `usdsdg view` refuses before it serves anything."""

import pytest
from click.testing import CliRunner

from usdsdg.cli.app import app
from usdsdg.session import session

pytest.importorskip("uvicorn")


def refused(*arguments) -> str:
    try:
        done = CliRunner().invoke(app, ["view", *map(str, arguments)])
    finally:
        session.restart()
    assert done.exit_code == 1, done.output
    assert "Traceback" not in done.stderr
    assert "http://" not in done.stdout
    return done.stderr


def test_a_source_that_is_not_there_is_named(tmp_path):
    assert f"error: there is no {tmp_path / 'none.usd'}" in refused(tmp_path / "none.usd")


def test_a_folder_without_a_dataset_is_said(tmp_path):
    assert "is empty" in refused(tmp_path)


def test_a_file_of_another_kind_is_said(tmp_path):
    (tmp_path / "notes.txt").write_text("x")
    assert "notes.txt is no job" in refused(tmp_path / "notes.txt")


def test_a_stage_takes_no_arguments(tmp_path):
    (tmp_path / "stage.usda").write_text("#usda 1.0\n")
    assert "takes no arguments: width=3" in refused(tmp_path / "stage.usda", "width=3")


def test_a_damaged_stage_is_one_line(tmp_path):
    (tmp_path / "stage.usda").write_text("#usda 1.0\ndef {")
    assert "stage.usda cannot be opened as a stage" in refused(tmp_path / "stage.usda")


def test_help_has_an_example():
    assert "usdsdg view scene.usd" in CliRunner().invoke(app, ["view", "--help"]).stdout

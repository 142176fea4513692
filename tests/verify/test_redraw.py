"""`usdsdg verify --render`: faults above the record, which files and record agree about, are found."""

import shutil

import pytest
from typer.testing import CliRunner

from tests.verify import datasets, faults_above
from usdsdg.cli.commands import app
from usdsdg.session import session
from usdsdg.verify import verify


@pytest.fixture(autouse=True)
def restarted():
    yield
    session.restart()


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    return datasets.make(tmp_path_factory.mktemp("rendered"), ("basic_ids", "pose"), frames=3)


@pytest.mark.parametrize("name", ["basic_ids", "pose"])
def test_frames_render_again_as_they_were(clean, name):
    report = verify(clean / name, render=3)
    assert report.faults == []
    assert report.notes == []
    assert report.rendered == 3


@pytest.mark.parametrize("kind", faults_above.KINDS, ids=[kind.name for kind in faults_above.KINDS])
def test_a_fault_above_the_record_is_found(tmp_path, kind):
    with faults_above.patched(kind):
        folder = datasets.make(tmp_path, ("basic",), frames=4, edit=kind.edit) / "basic"
    assert any(fault.file.startswith(".usdsdg/frames") for fault in verify(folder, render=4).faults)


def test_frames_are_chosen_by_number(clean):
    done = CliRunner().invoke(app, ["verify", str(clean / "pose"), "--frames", "0,2"])
    assert done.exit_code == 0
    assert "2 rendered again" in done.output
    assert "expected" not in done.output
    wrong = CliRunner().invoke(app, ["verify", str(clean / "pose"), "--frames", "first"])
    assert wrong.exit_code == 1


def test_a_dataset_without_its_stage_says_so(clean, tmp_path):
    folder = shutil.copytree(clean / "pose", tmp_path / "pose")
    shutil.rmtree(folder / ".usdsdg" / "stages")
    report = verify(folder, render=3)
    assert report.rendered == 0
    assert any("is missing" in fault.what and "stages" in fault.file for fault in report.faults)

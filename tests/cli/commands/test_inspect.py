"""`usdsdg inspect`, and pages at the end of other commands."""

import io

import pytest
from click.testing import CliRunner

from tests.inspect.datasets import pose_object, write_pose
from tests.scripts.conftest import usdsdg
from usdsdg.cli.app import app
from usdsdg.cli.commands.inspect import show_written
from usdsdg.errors import DatasetError
from usdsdg.session import progress
from usdsdg.session.session import current

MUG = pose_object(None, "mug", [0.0, 0.0, -2.0], [0.2] * 3)
SCRIPT = """
import omni.replicator.core as rep
camera = rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0))
rep.create.cube(semantics=[("class", "cube")])
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir={folder!r}, rgb=True, bounding_box_2d_tight=True)
writer.attach(rep.create.render_product(camera, (64, 48)))
rep.orchestrator.run_until_complete(num_frames=2)
"""


def test_problems_are_lines_and_the_page_is_the_output(tmp_path):
    for number in range(3):
        write_pose(tmp_path, number, [MUG])
    (tmp_path / "000001.json").write_text("{")
    (tmp_path / "000002.png").unlink()
    done = CliRunner().invoke(app, ["inspect", str(tmp_path)])
    assert done.exit_code == 0
    assert done.stdout == f"{tmp_path / 'inspect.html'}\n"
    told = done.stderr.splitlines()
    assert len(told) == 2
    assert told[0].startswith("unreadable file: 000001.json: is not valid JSON at line 1")
    assert told[1] == "labels without picture: 000002.json: there is no picture of it"


def test_an_empty_folder_is_one_line(tmp_path):
    done = CliRunner().invoke(app, ["inspect", str(tmp_path)])
    assert done.exit_code == 1
    assert done.stderr == f"error: {tmp_path} is empty; give the folder that a writer wrote to (its output_dir)\n"


def test_a_script_ends_with_a_page(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(folder=str(tmp_path / "out put")))
    # In a process of its own, since the conditions of a script's run are those of its process.
    done = usdsdg("run", "--quiet", "--inspect", str(script), cwd=tmp_path)
    assert done.stdout.splitlines()[-1] == str(tmp_path / "out put" / "inspect.html")
    assert "cube" in (tmp_path / "out put" / "inspect.html").read_text(encoding="utf-8")


@pytest.fixture
def written():
    folders, before = current().written_folders, current().reporter
    folders.clear()
    yield folders
    progress.use(before)
    folders.clear()


def said() -> list[str]:
    """Return what is reported at the end of a command."""
    lines = io.StringIO()
    progress.use(progress.LineReporter(lines))
    show_written(inspect=False)
    return lines.getvalue().splitlines()


def commands() -> list[str]:
    """Return the commands that are named at the end, without what they do."""
    return [line.removeprefix("[usdsdg] ").removeprefix("next: ").partition("   (")[0].strip() for line in said()]


def both(folder) -> list[str]:
    return [f"usdsdg inspect {folder}", f"usdsdg verify {folder}"]


def test_the_commands_are_named_for_what_was_written(written, tmp_path, monkeypatch, capsys):
    for name in ("a b", "c"):
        write_pose(tmp_path / "all" / name, 0, [MUG])
        written[str(tmp_path / "all" / name)] = None
    # One command for all datasets that are in a folder of their own.
    assert said()[0].startswith("[usdsdg] next: ")
    assert commands() == both(tmp_path / "all")
    write_pose(tmp_path / "all" / "older", 0, [MUG])
    assert commands() == [*both(f"'{tmp_path / 'all' / 'a b'}'"), *both(tmp_path / "all" / "c")]
    monkeypatch.setattr("usdsdg._STARTED_IN", str(tmp_path))  # where the commands will be typed
    assert commands() == [*both("'all/a b'"), *both("all/c")]
    assert capsys.readouterr().out == ""  # which has results alone


def test_folders_that_were_removed_are_not_named(written, tmp_path):
    for name in ("a", "b"):
        written[str(tmp_path / "gone" / name)] = None
    assert said() == []


def test_the_commands_are_not_named_where_progress_is_not_shown(written, tmp_path, capsys):
    write_pose(tmp_path / "a", 0, [MUG])
    written[str(tmp_path / "a")] = None
    progress.use_default(quiet=True)
    show_written(inspect=False)
    assert capsys.readouterr() == ("", "")


def test_pages_are_made_where_something_can_be_shown(written, tmp_path, capsys):
    with pytest.raises(DatasetError, match="no files were written"):
        show_written(inspect=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("a format of one's own")
    written[str(tmp_path / "other")] = None
    with pytest.raises(DatasetError, match="is a dataset that can be shown"):
        show_written(inspect=True)
    write_pose(tmp_path / "poses", 0, [MUG])
    written[str(tmp_path / "poses")] = None
    (tmp_path / "elsewhere").mkdir()
    show_written(inspect=True)
    printed = capsys.readouterr()
    assert printed.out == f"{tmp_path / 'poses' / 'inspect.html'}\n"
    assert printed.err.startswith("warning: nothing in ")

"""Files that are given to the wrong command are errors that name the right one."""

import shutil

import pytest

from tests.scripts.conftest import ROOT, usdsdg
from usdsdg.cli.options.file_kinds import FileKind, check_kind
from usdsdg.errors import ConfigError

FILES = {
    "script.py": ("print(1)", FileKind.SCRIPT, "`usdsdg run "),
    "scene.yaml": ("cube:\n  create.cube: {}\n", FileKind.REPLICATOR_YAML, "`usdsdg run "),
    "up.yml": ("settings.set_stage_up_axis: {up_axis: Z}\n", FileKind.REPLICATOR_YAML, "`usdsdg run "),
    "job.yaml": ("num_frames: 3\n", FileKind.CONFIGURATION, "`usdsdg generate "),
    "job.json": ('{"num_frames": 3}', FileKind.CONFIGURATION, "`usdsdg generate "),
    "scene.usda": ("#usda 1.0\n", FileKind.STAGE, "`usdsdg render "),
}


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_accepted_by_its_own_command_and_refused_by_others_with_its_name(name, tmp_path):
    text, kind, command = FILES[name]
    (tmp_path / name).write_text(text)
    check_kind(tmp_path / name, kind)
    others = set(FileKind) - {kind}
    with pytest.raises(ConfigError, match=command):
        check_kind(tmp_path / name, *others)


@pytest.mark.parametrize("text", ["- 1\n", "what: ever\n", "a: [", "", "&a [*a]"])
def test_files_of_unknown_kinds_are_left_to_their_reader(text, tmp_path):
    (tmp_path / "file.yaml").write_text(text)
    check_kind(tmp_path / "file.yaml")
    check_kind(tmp_path / "missing.yaml")


@pytest.mark.parametrize(
    ("arguments", "command"),
    [
        (("run", "job.yaml"), "usdsdg generate"),
        (("run", "scene.usda"), "usdsdg render"),
        (("generate", "scene.yaml"), "usdsdg run"),
        (("generate", "script.py"), "usdsdg run"),
        (("render", "job.yaml", "out"), "usdsdg generate"),
        (("simulate", "scene.yaml", "out.usda"), "usdsdg run"),
    ],
)
def test_commands_name_the_command_that_takes_the_file(arguments, command, tmp_path):
    for name, (text, _, _) in FILES.items():
        (tmp_path / name).write_text(text)
    done = usdsdg(*arguments, cwd=tmp_path, expect=1)
    assert done.stderr.startswith(f"error: {arguments[1]} is ")
    assert f"`{command} {arguments[1]}" in done.stderr


@pytest.mark.parametrize("name", ["notes.txt", "script.py.bak", "list.json"])
def test_a_file_that_is_no_script_is_not_run_as_one(name, tmp_path):
    (tmp_path / name).write_text("print('executed')")
    done = usdsdg("run", name, cwd=tmp_path, expect=1)
    assert done.stdout == ""
    assert done.stderr.startswith(f"error: {name} is neither a Python script (.py) nor a Replicator YAML file")


@pytest.mark.parametrize("name", ["script", "script.PY"])
def test_a_file_without_a_suffix_may_be_a_script(name, tmp_path):
    (tmp_path / name).write_text("print('executed')")
    assert usdsdg("run", "--quiet", name, cwd=tmp_path).stdout == "executed\n"


@pytest.mark.parametrize("config", sorted((ROOT / "configs").iterdir()), ids=lambda path: path.name)
def test_our_own_configurations_are_recognized(config, tmp_path):
    check_kind(shutil.copy(config, tmp_path / config.name), FileKind.CONFIGURATION)


def test_a_script_that_is_a_link_to_nothing_is_named_with_what_it_leads_to(tmp_path):
    (tmp_path / "script.py").symlink_to("elsewhere.py")
    done = usdsdg("run", "script.py", cwd=tmp_path, expect=1)
    assert done.stderr == "error: script.py is a link to elsewhere.py, which is not there\n"

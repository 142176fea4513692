"""Maps from usdsdg.toml."""

from pathlib import Path

import pytest

from usdsdg.cli.script.config_file import maps_of_files
from usdsdg.errors import ConfigError


@pytest.fixture(autouse=True)
def _own_folders(tmp_path, monkeypatch):
    (tmp_path / "work").mkdir()
    (tmp_path / "scripts").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


def read(tmp_path, **options):
    return {each.prefix: each.folder for each in maps_of_files(tmp_path / "scripts" / "a.py", **options)}


def test_folders_are_relative_to_the_file_that_names_them(tmp_path):
    (tmp_path / "scripts" / "props").mkdir()
    (tmp_path / "scripts" / "usdsdg.toml").write_text('[map]\n"omniverse://host/Projects" = "props"\n')
    assert read(tmp_path) == {"omniverse://host/Projects": str(tmp_path / "scripts" / "props")}


def test_the_working_folder_comes_before_the_scripts_and_the_users(tmp_path):
    (tmp_path / "config" / "usdsdg").mkdir(parents=True)
    (tmp_path / "work" / "usdsdg.toml").write_text(f'[map]\na = "{tmp_path}/work"\n')
    (tmp_path / "scripts" / "usdsdg.toml").write_text(f'[map]\na = "{tmp_path}/scripts"\nb = "{tmp_path}/scripts"\n')
    (tmp_path / "config" / "usdsdg" / "config.toml").write_text(f'[map]\nb = "/gone"\nc = "{tmp_path}/config"\n')
    assert read(tmp_path) == {"a": f"{tmp_path}/work", "b": f"{tmp_path}/scripts", "c": f"{tmp_path}/config"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("map = 3", "expected a table"),
        ("[maps]\na = 'b'", "unknown key 'maps'"),
        ("[map]\na = 3", "expected a folder"),
        ("[map]\na = 'gone'", "which is not a folder"),
        ("[map", "cannot be read"),
    ],
)
def test_mistakes_name_the_file(tmp_path, text, message):
    (tmp_path / "work" / "usdsdg.toml").write_text(text)
    with pytest.raises(ConfigError, match=message) as failure:
        read(tmp_path)
    assert "usdsdg.toml" in str(failure.value)


def no_home():
    raise RuntimeError("Could not determine home directory.")


def test_the_file_of_a_user_without_a_home_or_of_a_home_that_cannot_be_read_is_left_out(tmp_path, monkeypatch):
    (tmp_path / "work" / "usdsdg.toml").write_text(f'[map]\na = "{tmp_path}/work"\n')
    monkeypatch.setenv("XDG_CONFIG_HOME", "/" + "x" * 300)  # an error of the system, as of a folder of another user
    assert read(tmp_path) == {"a": f"{tmp_path}/work"}
    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setattr(Path, "home", no_home)
    assert read(tmp_path) == {"a": f"{tmp_path}/work"}

"""Detect files that were given to the wrong command, and name the command that takes them."""

import difflib
import os
from enum import Enum
from pathlib import Path
from typing import Any

from usdsdg.errors import ConfigError
from usdsdg.stage.assets.mesh_files import MESHES


class FileKind(Enum):
    """Kinds of input files; the values say which command takes them."""

    SCRIPT = "a script, which `usdsdg run {}` runs"
    REPLICATOR_YAML = "a Replicator YAML file, which `usdsdg run {}` runs"
    CONFIGURATION = "a configuration of a scenario, which `usdsdg generate {}` runs"
    STAGE = "a stage, which `usdsdg render {} FOLDER` renders; `usdsdg generate {}` runs a graph that was saved in it"


SCRIPT, YAML = ".py", (".yaml", ".yml")  # suffixes of what `usdsdg run` runs
_BY_SUFFIX = {SCRIPT: FileKind.SCRIPT, **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz", *MESHES), FileKind.STAGE)}


def check_kind(file: Path, *accepted: FileKind) -> None:
    """Check that a file is of one of the `accepted` kinds; missing files and unknown kinds pass.

    Raises:
        ConfigError: another command takes the file; the message names it.
    """
    kind = kind_of(file) if file.is_file() else None
    if kind is not None and kind not in accepted:
        raise ConfigError(f"{file} is {kind.value.format(file, file)}")


def check_script(file: Path) -> None:
    """Check that a file can be run: a script, or a Replicator YAML file; one without a suffix may be a script.

    Raises:
        ConfigError: it is of another kind; the message names the command that takes it, if there is one.
    """
    check_kind(file, FileKind.SCRIPT, FileKind.REPLICATOR_YAML)
    if file.suffix and file.suffix.lower() not in (SCRIPT, *YAML):
        raise ConfigError(
            f"{file} is neither a Python script ({SCRIPT}) nor a Replicator YAML file ({', '.join(YAML)}); give one of "
            "these, or rename it if it is one"
        )


def command_of(name: str) -> str:
    """Return a sentence that names the command for a file or folder, as the name of which a word is taken; or ""."""
    place = Path(name)
    if place.is_dir():
        return f"{name} is a folder; `usdsdg inspect {name}` shows the dataset in it"
    kind = kind_of(place) if place.is_file() else None
    return f"{name} is {kind.value.format(name, name)}" if kind is not None else ""


def no_file(file: Path) -> str:
    """Return the message about a file that is missing, with similar names in its folder."""
    if file.is_dir():
        return f"{file} is a folder; give a file"
    if file.exists():
        return f"{file} is a pipe or device; give a file"
    if file.is_symlink():
        return f"{file} is a link to {os.readlink(file)}, which is not there"
    there = [each.name for each in file.parent.iterdir() if each.is_file()] if file.parent.is_dir() else []
    near = difflib.get_close_matches(file.name, there, n=2)
    hint = f"did you mean {' or '.join(str(file.with_name(name)) for name in near)}?" if near else "give its path"
    return f"there is no file {file}; {hint}"


def kind_of(file: Path) -> FileKind | None:
    """Return the kind of a file, from its suffix or its keys; None if it is not known or cannot be read."""
    if file.suffix.lower() in (*YAML, ".json"):
        return _kind_of_values(file)
    return _BY_SUFFIX.get(file.suffix.lower())


def _kind_of_values(file: Path) -> FileKind | None:
    import yaml

    from usdsdg.arguments.yaml_bounds import TooLarge, read_bounded
    from usdsdg.arguments.yaml_numbers import NumbersLoader
    from usdsdg.scenarios.object_based.config import ObjectBasedConfig

    try:
        values = yaml.load(read_bounded(file), Loader=NumbersLoader)
    except (OSError, ValueError, TooLarge, yaml.YAMLError, RecursionError):
        return None  # the reader of the file reports what is wrong
    if not isinstance(values, dict):
        return None
    if "job" in values or not ObjectBasedConfig.model_fields.keys().isdisjoint(values):
        return FileKind.CONFIGURATION
    has_calls = any(_is_call(key) for group in (values, *values.values()) for key in _keys(group))
    return FileKind.REPLICATOR_YAML if has_calls else None


def _keys(group: Any) -> list[Any]:
    return list(group) if isinstance(group, dict) else []


def _is_call(key: Any) -> bool:
    return isinstance(key, str) and "." in key

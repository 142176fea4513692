"""Read configuration files: YAML or JSON with the line of every key, then overrides, then validation."""

import contextlib
import json
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from usdsdg.arguments.values import shown
from usdsdg.arguments.yaml_bounds import check_yaml, load_json, read_bounded
from usdsdg.arguments.yaml_numbers import NumbersLoader
from usdsdg.errors import ConfigError
from usdsdg.scenarios.config_errors import KeyPath, Problem, dotted, problems_of, suggestion
from usdsdg.stage.assets.url import is_utf8

Model = TypeVar("Model", bound=BaseModel)
SUFFIXES = (".yaml", ".yml", ".json")
_TO_START = "; `usdsdg new detection` writes a configuration to start from"
_OVERRIDE = "override "
MAX_PROBLEMS = 30  # in a message


@dataclass
class _Source:
    """Values and the origin of each: a line of the file, or an override."""

    values: dict[str, Any]
    origins: dict[KeyPath, str] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def origin(self, key_path: KeyPath) -> str:
        """Return the origin of a key, or of the nearest one above it that has one, and overrides below it; or ""."""
        depth = len(key_path)
        below = [
            origin
            for known, origin in self.origins.items()
            if len(known) > depth and known[:depth] == key_path and origin.startswith(_OVERRIDE)
        ]
        while key_path and key_path not in self.origins:
            key_path = key_path[:-1]
        return " with ".join(filter(None, [self.origins.get(key_path, ""), *below]))


def read_config(path: str | os.PathLike[str], overrides: Sequence[str], model: type[Model]) -> Model:
    """Read a file, apply overrides (`path_tracing.spp=16`, `resolution.0=320`) and validate the result as a `model`.

    Raises:
        ConfigError: with every problem found, each with its line, its key and the expected values.
    """
    file = Path(path)
    source = _read(file, overrides)
    config = None
    try:
        # Validation crashes at halves of characters, which escapes such as "\\udcff" make.
        if halves := list(_halves(source.values, ())):
            source.problems += halves
        else:
            config = model.model_validate(source.values)
    except ValidationError as error:
        source.problems += problems_of(error, model)
    if config is None or source.problems:
        raise ConfigError(_message(file, source))
    return config


def read_values(path: str | os.PathLike[str], overrides: Sequence[str]) -> dict[str, Any]:
    """Return the values of a file with its overrides, as they are written.

    Raises:
        ConfigError: the file is missing or unreadable.
    """
    return _read(Path(path), overrides).values


def _read(file: Path, overrides: Sequence[str]) -> _Source:
    source = _parse(file)
    for override in overrides:
        _override(source, override)
    return source


def _message(file: Path, source: _Source) -> str:
    count = len(source.problems)
    source.problems.sort(key=lambda problem: _line(problem.origin or source.origin(problem.key_path)))
    lines = [f"{file} has {count} problem{'s' if count > 1 else ''}:"]
    for problem in source.problems[:MAX_PROBLEMS]:
        origin = problem.origin or source.origin(problem.key_path)
        beside = _beside(file, source, problem.key_path)
        text = f"{problem.text.removesuffix('.')}{beside}" if beside else problem.text
        lines.append(f"  {origin}{': ' if origin else ''}{text}")
    if count > MAX_PROBLEMS:
        lines.append(f"  and {count - MAX_PROBLEMS} more")
    return "\n".join(lines)


def _beside(file: Path, source: _Source, key_path: KeyPath) -> str:
    """Return "; ..." with the paths at or below a key that lie beside the file and not where they are looked for."""
    value: Any = source.values
    for key in key_path:
        try:
            value = value[key]
        except (KeyError, IndexError, TypeError):
            return ""
    given = value.values() if isinstance(value, dict) and key_path else [value]
    paths = [each.partition("#")[0] for each in given if isinstance(each, str)]  # file#camera, of calibrations
    found = [each for each in paths if each and not os.path.exists(each) and os.path.exists(file.parent / each)]
    if not found:
        return ""
    there = ", ".join(os.path.relpath(file.parent / each) for each in found)
    return f"; paths are relative to the working directory, and beside the configuration lies one: give {there}"


def _line(origin: str) -> int:
    """Sort key of problems: their line in the file; overrides and missing keys come last."""
    number = origin.removeprefix("line ").partition(" ")[0]
    return int(number) if number.isdigit() else 1 << 30


def _parse(file: Path) -> _Source:
    if file.suffix.lower() not in SUFFIXES:
        raise ConfigError(f"{file}: a configuration is a .yaml, .yml or .json file")
    try:
        text = read_bounded(file)
    except FileNotFoundError:
        raise ConfigError(_missing(file)) from None
    except UnicodeDecodeError as error:
        raise ConfigError(f"{file} cannot be read: it is not in UTF-8 ({error}). Save it as UTF-8.") from error
    except OSError as error:
        raise ConfigError(f"{file} cannot be read: {error}") from error
    try:
        values = _parse_json(file, text) if file.suffix.lower() == ".json" else _parse_yaml(file, text)
    except RecursionError:
        raise ConfigError(f"{file}: its mappings and lists are nested too deeply to be read") from None
    if not isinstance(values, dict):
        raise ConfigError(f"{file}: expected a mapping of keys to values, found {type(values).__name__}")
    source = _Source(values)
    # JSON indented with tabs is not YAML; its problems are reported without their lines.
    with contextlib.suppress(yaml.YAMLError):
        _note_lines(yaml.compose(text, Loader=NumbersLoader), (), source)
    return source


def _load_yaml(text: str) -> Any:
    """Return the values of a YAML text.

    Raises:
        yaml.MarkedYAMLError: it is not valid YAML, or a part of it contains itself through an anchor.
    """
    _refuse_cycles(yaml.compose(text, Loader=NumbersLoader), ())
    return yaml.load(text, Loader=NumbersLoader)


def _refuse_cycles(node: yaml.Node | None, ancestors: tuple[yaml.Node, ...]) -> None:
    if node is None or isinstance(node, yaml.ScalarNode):
        return
    if node in ancestors:
        raise yaml.MarkedYAMLError(problem="it contains itself through its anchor", problem_mark=node.start_mark)
    children = node.value if isinstance(node, yaml.SequenceNode) else [part for pair in node.value for part in pair]
    for part in children:
        _refuse_cycles(part, (*ancestors, node))


def _missing(file: Path) -> str:
    folder = file.parent
    if not folder.is_dir():
        return f"{file}: there is no folder {folder}{_TO_START}"
    if file.is_symlink():
        return f"{file} is a link to {os.readlink(file)}, which is not there"
    found = sorted(entry.name for entry in folder.iterdir() if entry.suffix.lower() in SUFFIXES)
    near = suggestion(file.name, found) or (f"; {folder} has {', '.join(found[:8])}" if found else _TO_START)
    return f"there is no file {file}{near}"


def _parse_json(file: Path, text: str) -> Any:
    try:
        return load_json(text, str(file))
    except json.JSONDecodeError as error:
        raise ConfigError(f"{file}, line {error.lineno}: not valid JSON: {error.msg}") from None


def _parse_yaml(file: Path, text: str) -> Any:
    try:
        return _load_yaml(text) or {}
    except yaml.MarkedYAMLError as error:
        problem = str(error.problem or error.context)
        is_no_key = "expected ':'" in problem  # which is noticed on the line after it
        mark = error.context_mark if is_no_key and error.context_mark else error.problem_mark
        line = mark.line + 1 if mark else 1
        remedy = "; a key is followed by a colon and a space" if is_no_key else ""
        remedy = "; indent with spaces instead of tabs" if r"'\t'" in problem else remedy
        raise ConfigError(f"{file}, line {line}: not valid YAML: {problem}{remedy}") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{file}: not valid YAML: {error}") from None


def _halves(value: Any, key_path: KeyPath) -> Iterator[Problem]:
    """Yield a problem for each text or key of a mapping with halves of characters, which are no UTF-8."""
    if isinstance(value, str) and not is_utf8(value):
        yield Problem(key_path, f"{dotted(key_path)}: it is not UTF-8 text")
    elif isinstance(value, dict):
        for key, below in value.items():
            if isinstance(key, str) and not is_utf8(key):
                yield Problem(key_path, f"{dotted((*key_path, ascii(key)))}: the key is not UTF-8 text")
            else:
                yield from _halves(below, (*key_path, key))
    elif isinstance(value, list):
        for index, below in enumerate(value):
            yield from _halves(below, (*key_path, index))


def _note_lines(node: yaml.Node | None, key_path: KeyPath, source: _Source) -> None:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            below = (*key_path, key.value)
            line = f"line {key.start_mark.line + 1}"
            if below in source.origins:
                source.problems.append(
                    Problem(below, f"{key.value}: given twice (also on {source.origins[below]})", line)
                )
            source.origins[below] = line
            _note_lines(value, below, source)
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            source.origins[(*key_path, index)] = f"line {value.start_mark.line + 1}"
            _note_lines(value, (*key_path, index), source)


def _override(source: _Source, override: str) -> None:
    """Apply one override "a.b.0.c=value"; the key may also be written `a.b[0].c`."""
    key, equals, text = override.partition("=")
    origin = f"{_OVERRIDE}{shown(override)}"
    key_path: KeyPath = tuple(
        int(part) if part.isdecimal() else part for part in re.split(r"[.\[\]]+", key.strip().rstrip("]")) if part
    )
    if not equals or not key_path:
        source.problems.append(Problem((), "expected key=value, for example num_frames=3", origin))
        return
    try:
        override.encode()  # bytes of the command line that are no UTF-8 are lone surrogates here
        check_yaml(text, origin)
        value = text if _has_comment(text) else _load_yaml(text)
    except UnicodeEncodeError:
        source.problems.append(Problem(key_path, "it is not UTF-8 text", origin))
        return
    except yaml.YAMLError:
        value = text
    except ConfigError as too_large:
        source.problems.append(Problem(key_path, str(too_large), origin))
        return
    error = _assign(source.values, key_path, value)
    if error:
        source.problems.append(Problem(key_path, error, origin))
        return
    for stale in [known for known in source.origins if known[: len(key_path)] == key_path]:
        del source.origins[stale]
    source.origins[key_path] = origin


def _has_comment(text: str) -> bool:
    """Return whether YAML takes a part of the text for a comment: of an override every character is meant.

    Raises:
        yaml.YAMLError: it is not valid YAML.
    """
    end = 0
    for token in yaml.scan(text, Loader=NumbersLoader):
        if "#" in text[end : token.start_mark.index]:
            return True
        end = max(end, token.end_mark.index)
    return "#" in text[end:]


def _assign(values: Any, key_path: KeyPath, value: Any) -> str | None:
    """Set `value` at `key_path`, adding mappings where needed; return what is wrong, or None."""
    for depth, part in enumerate(key_path):
        last = depth == len(key_path) - 1
        where = ".".join(str(step) for step in key_path[:depth]) or "the configuration"
        if isinstance(values, list):
            if not isinstance(part, int) or part >= len(values):
                return f"{where} has entries 0 to {len(values) - 1}, no {part}"
        elif isinstance(values, dict):
            part = str(part)
            if not last:
                values.setdefault(part, {})
        else:
            return f"{where} is {values!r}, which has nothing below it"
        # `part` is a number for a list and text for a dict.
        if last:
            values[part] = value  # pyright: ignore[reportArgumentType, reportCallIssue]
        else:
            values = values[part]  # pyright: ignore[reportArgumentType, reportCallIssue]
    return None

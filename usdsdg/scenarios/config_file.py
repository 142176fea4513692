"""Configuration files: YAML or JSON to plain values with the line of every key, and overrides on top."""

from __future__ import annotations

import contextlib
import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from usdsdg.arguments.yaml_numbers import NumbersLoader
from usdsdg.errors import ConfigError
from usdsdg.scenarios.config_problems import Place, Problem, problems_of, suggestion

Model = TypeVar("Model", bound=BaseModel)
SUFFIXES = (".yaml", ".yml", ".json")


@dataclass
class _Source:
    """Values with where they came from: a line of the file, or an override."""

    values: dict[str, Any]
    origins: dict[Place, str] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def origin(self, place: Place) -> str:
        """Of the place itself, or of the nearest part around it that was written down."""
        while place and place not in self.origins:
            place = place[:-1]
        return self.origins.get(place, "")


def read_config(path: str | os.PathLike[str], overrides: Sequence[str], model: type[Model]) -> Model:
    """A validated `model` from a file and "key=value" overrides.

    Raises:
        ConfigError: with every problem found, each with its key, place, and what would have worked.
    """
    file = Path(path)
    source = _parse(file)
    for override in overrides:
        _override(source, override)
    made = None
    try:
        made = model.model_validate(source.values)
    except ValidationError as error:
        source.problems += problems_of(error, model)
    if made is None or source.problems:
        raise ConfigError(_message(file, source))
    return made


def _message(file: Path, source: _Source) -> str:
    count = len(source.problems)
    source.problems.sort(key=lambda problem: _line(problem.origin or source.origin(problem.place)))
    lines = [f"{file} has {count} problem{'s' if count > 1 else ''}:"]
    for problem in source.problems:
        origin = problem.origin or source.origin(problem.place)
        lines.append(f"  {origin}{': ' if origin else ''}{problem.text}")
    return "\n".join(lines)


def _line(origin: str) -> int:
    """Problems are told in the order of the file; overrides and missing keys come last."""
    number = origin.removeprefix("line ")
    return int(number) if number.isdigit() else 1 << 30


def _parse(file: Path) -> _Source:
    if file.suffix.lower() not in SUFFIXES:
        raise ConfigError(f"{file}: a configuration is a .yaml, .yml or .json file")
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ConfigError(_missing(file)) from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{file} cannot be read: {error}") from error
    try:
        values = _parse_json(file, text) if file.suffix.lower() == ".json" else _parse_yaml(file, text)
    except RecursionError:
        raise ConfigError(f"{file}: its mappings and lists are nested too deeply to be read") from None
    if not isinstance(values, dict):
        raise ConfigError(f"{file}: expected a mapping of keys to values, found {type(values).__name__}")
    source = _Source(values)
    # JSON indented with tabs is no YAML: problems are then told without their lines.
    with contextlib.suppress(yaml.YAMLError):
        _note_lines(yaml.compose(text, Loader=NumbersLoader), (), source)
    return source


def _load_yaml(text: str) -> Any:
    """The values of a YAML text.

    Raises:
        yaml.MarkedYAMLError: it is no YAML, or a part of it contains itself through an anchor.
    """
    _refuse_cycles(yaml.compose(text, Loader=NumbersLoader), ())
    return yaml.load(text, Loader=NumbersLoader)


def _refuse_cycles(node: yaml.Node | None, around: tuple[yaml.Node, ...]) -> None:
    if node is None or isinstance(node, yaml.ScalarNode):
        return
    if node in around:
        raise yaml.MarkedYAMLError(problem="it contains itself through its anchor", problem_mark=node.start_mark)
    below = node.value if isinstance(node, yaml.SequenceNode) else [part for pair in node.value for part in pair]
    for part in below:
        _refuse_cycles(part, (*around, node))


def _missing(file: Path) -> str:
    folder = file.parent
    if not folder.is_dir():
        return f"{file}: there is no folder {folder}"
    found = sorted(entry.name for entry in folder.iterdir() if entry.suffix.lower() in SUFFIXES)
    near = suggestion(file.name, found) or (f"; {folder} has {', '.join(found[:8])}" if found else "")
    return f"there is no file {file}{near}"


def _parse_json(file: Path, text: str) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise ConfigError(f"{file}, line {error.lineno}: not valid JSON: {error.msg}") from None


def _parse_yaml(file: Path, text: str) -> Any:
    try:
        return _load_yaml(text) or {}
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise ConfigError(f"{file}, line {line}: not valid YAML: {error.problem or error.context}") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{file}: not valid YAML: {error}") from None


def _note_lines(node: yaml.Node | None, place: Place, source: _Source) -> None:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            below = (*place, key.value)
            line = f"line {key.start_mark.line + 1}"
            if below in source.origins:
                source.problems.append(
                    Problem(below, f"{key.value}: given twice (also on {source.origins[below]})", line)
                )
            source.origins[below] = line
            _note_lines(value, below, source)
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            source.origins[(*place, index)] = f"line {value.start_mark.line + 1}"
            _note_lines(value, (*place, index), source)


def _override(source: _Source, override: str) -> None:
    """Apply one "a.b.0.c=value"; `a.b[0].c` is understood as well."""
    key, equals, text = override.partition("=")
    origin = f"override {override!r}"
    place: Place = tuple(
        int(part) if part.isdigit() else part for part in re.split(r"[.\[\]]+", key.strip().rstrip("]")) if part
    )
    if not equals or not place:
        source.problems.append(Problem((), "expected key=value, for example num_frames=3", origin))
        return
    try:
        value = _load_yaml(text)
    except yaml.YAMLError:
        value = text
    trouble = _assign(source.values, place, value)
    if trouble:
        source.problems.append(Problem(place, trouble, origin))
        return
    for stale in [known for known in source.origins if known[: len(place)] == place]:
        del source.origins[stale]
    source.origins[place] = origin


def _assign(values: Any, place: Place, value: Any) -> str | None:
    """Put `value` at `place`, making mappings on the way; returns what is wrong when that cannot be."""
    for depth, part in enumerate(place):
        last = depth == len(place) - 1
        where = ".".join(str(step) for step in place[:depth]) or "the configuration"
        if isinstance(values, list):
            if not isinstance(part, int) or part >= len(values):
                return f"{where} has entries 0 to {len(values) - 1}, no {part}"
        elif isinstance(values, dict):
            part = str(part)
            if not last:
                values.setdefault(part, {})
        else:
            return f"{where} is {values!r}, which has nothing below it"
        if last:
            values[part] = value
        else:
            values = values[part]
    return None

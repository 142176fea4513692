"""What is wrong with a configuration, in words that say what would have worked."""

from __future__ import annotations

import difflib
import types
import typing
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

Place = tuple[str | int, ...]


# Pydantic's error types in the words of a configuration file.
_KINDS = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "bool_type": "true or false",
    "string_type": "text",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "list_type": "a list",
    "tuple_type": "a list",
}


@dataclass(frozen=True)
class Problem:
    """One thing wrong at a place; `origin` overrides the line that the place has in the file."""

    place: Place
    text: str
    origin: str = ""


def problems_of(error: ValidationError, model: type[BaseModel]) -> list[Problem]:
    """Every problem that validation found, in the order of the keys."""
    return [_problem(detail, model) for detail in error.errors(include_url=False)]


def dotted(place: Place) -> str:
    """("labeled_assets_and_properties", 0, "count") as `labeled_assets_and_properties[0].count`."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def suggestion(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(known), n=2, cutoff=0.6)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def _problem(detail: Any, model: type[BaseModel]) -> Problem:
    place: Place = tuple(detail["loc"])
    key = dotted(place)
    if detail["type"] == "extra_forbidden":
        section = _section(model, place[:-1])
        known = list(section.model_fields) if section else []
        hint = suggestion(str(place[-1]), known) or f"; known here: {', '.join(known)}"
        return Problem(place, f"{key}: unknown key{hint}")
    expected = _description(model, place)
    wanted = f"; expected {expected}" if expected else ""
    if detail["type"] == "missing":
        return Problem(place, f"{key}: missing{wanted}")
    if detail["type"] == "value_error":
        prefix = f"{key}: " if key else ""
        return Problem(place, f"{prefix}{detail['ctx']['error']}")
    if detail["type"] in _KINDS:
        return Problem(place, f"{key}: {detail['input']!r} is not {_KINDS[detail['type']]}{wanted}")
    if detail["type"] == "too_long":
        return Problem(place, f"{key}: {detail['input']!r} has too many entries{wanted}")
    said = detail["msg"].removeprefix("Input should be ")
    verb = "must be " if said != detail["msg"] else ""
    return Problem(place, f"{key}: {detail['input']!r}: {verb}{said}{wanted}")


def _section(model: type[BaseModel], place: Place) -> type[BaseModel] | None:
    """The model that describes the mapping at a place."""
    current: Any = model
    for part in place:
        if isinstance(part, int):
            continue
        if not (isinstance(current, type) and issubclass(current, BaseModel)) or part not in current.model_fields:
            return None
        current = _model_in(current.model_fields[str(part)].annotation)
    return current if isinstance(current, type) and issubclass(current, BaseModel) else None


def _model_in(annotation: Any) -> Any:
    """The model inside `list[Model]` or `Model | None`, or the annotation itself."""
    if typing.get_origin(annotation) in (list, tuple, typing.Union, types.UnionType):
        inner = [_model_in(part) for part in typing.get_args(annotation)]
        return next((part for part in inner if isinstance(part, type) and issubclass(part, BaseModel)), annotation)
    return annotation


def _description(model: type[BaseModel], place: Place) -> str:
    """What the nearest described key around a place wants."""
    for end in range(len(place), 0, -1):
        name = place[end - 1]
        section = _section(model, place[: end - 1])
        if isinstance(name, str) and section is not None and name in section.model_fields:
            return section.model_fields[name].description or ""
    return ""

"""Error messages for configurations that fail validation, with the values that would be accepted."""

import difflib
import types
import typing
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from usdsdg.arguments.values import shown

KeyPath = tuple[str | int, ...]

_HINTS = 100  # a search for similar names takes a millisecond

# Options of `usdsdg generate`, which are no keys; --frames is not here, since `frames` is meant for `num_frames`.
_OPTIONS = (
    *("allow_outside", "assets_root", "device", "gpus_per_worker", "inspect", "map", "overwrite", "physics_device"),
    *("quiet", "ray", "rerun", "resume", "save_stage", "semantic_classes", "shard", "threads", "workers"),
)

# Pydantic's error types in the terms of a configuration file.
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
    """One error at a key; `origin` overrides the line that the key has in the file."""

    key_path: KeyPath
    text: str
    origin: str = ""


def problems_of(error: ValidationError, model: type[BaseModel]) -> list[Problem]:
    """Return every problem that validation found, in the order of the keys; the first `_HINTS` suggest names."""
    details = error.errors(include_url=False)
    return [_problem(detail, model, hints=number < _HINTS) for number, detail in enumerate(details)]


def dotted(key_path: KeyPath) -> str:
    """Format ("labeled_assets_and_properties", 0, "count") as `labeled_assets_and_properties[0].count`."""
    text = ""
    for part in key_path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return `; did you mean ...?` with the names nearest to a misspelled one, or ""."""
    near = difflib.get_close_matches(name, list(known), n=2, cutoff=0.6)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def _problem(detail: ErrorDetails, model: type[BaseModel], *, hints: bool) -> Problem:
    key_path: KeyPath = tuple(detail["loc"])
    key = dotted(key_path)
    if detail["type"] == "extra_forbidden":
        if not hints:
            return Problem(key_path, f"{key}: unknown key")
        if len(key_path) == 1 and (option := key.replace("-", "_")) in _OPTIONS:
            flag = f"--{option.replace('_', '-')}"
            return Problem(key_path, f"{key}: unknown key; it is the option {flag} of `usdsdg generate`")
        section = _section(model, key_path[:-1])
        return Problem(key_path, f"{key}: unknown key{_hint(str(key_path[-1]), section, model)}")
    expected = _description(model, key_path)
    wanted = f"; expected {expected}" if expected else ""
    if detail["type"] == "missing":
        return Problem(key_path, f"{key}: missing{wanted}")
    if detail["type"] == "value_error" and "ctx" in detail:
        prefix = f"{key}: " if key else ""
        return Problem(key_path, f"{prefix}{detail['ctx']['error']}")
    if detail["type"] in _KINDS:
        return Problem(key_path, f"{key}: {shown(detail['input'])} is not {_KINDS[detail['type']]}{wanted}")
    if detail["type"] == "too_long":
        return Problem(key_path, f"{key}: {shown(detail['input'])} has too many entries{wanted}")
    requirement = detail["msg"].removeprefix("Input should be ")
    verb = "must be " if requirement != detail["msg"] else ""
    return Problem(key_path, f"{key}: {shown(detail['input'])}: {verb}{requirement}{wanted}")


def _hint(name: str, section: type[BaseModel] | None, model: type[BaseModel]) -> str:
    """Return what may be meant by a key that a section does not have, else the keys that it has."""
    meant = getattr(section, "other_names", {}).get(name)
    if meant:
        return f"; here it is {meant}"
    deeper = _deeper(section, name) if section else []
    if deeper:
        return f"; did you mean {' or '.join(deeper)}?"
    if section is not model and name in model.model_fields:
        return f"; {name} stands at the top of the file"
    known = list(section.model_fields) if section else []
    return suggestion(name, known) or f"; known here: {', '.join(known)}"


def _deeper(section: type[BaseModel], name: str) -> list[str]:
    """Return the dotted keys of the mappings in a section whose last part is `name`."""
    found = []
    for key, field in section.model_fields.items():
        inner = _model_in(field.annotation)
        if isinstance(inner, type) and issubclass(inner, BaseModel) and typing.get_origin(field.annotation) is not list:
            found += [f"{key}.{each}" for each in ([name] if name in inner.model_fields else _deeper(inner, name))]
    return found


def _section(model: type[BaseModel], key_path: KeyPath) -> type[BaseModel] | None:
    """Return the model that describes the mapping at a key path, or None."""
    current: Any = model
    for part in key_path:
        if isinstance(part, int):
            continue
        if not (isinstance(current, type) and issubclass(current, BaseModel)) or part not in current.model_fields:
            return None
        current = _model_in(current.model_fields[str(part)].annotation)
    return current if isinstance(current, type) and issubclass(current, BaseModel) else None


def _model_in(annotation: Any) -> Any:
    """Return the model inside `list[Model]` or `Model | None`, or the annotation itself."""
    if typing.get_origin(annotation) in (list, tuple, typing.Union, types.UnionType):
        inner = [_model_in(part) for part in typing.get_args(annotation)]
        return next((part for part in inner if isinstance(part, type) and issubclass(part, BaseModel)), annotation)
    return annotation


def _description(model: type[BaseModel], key_path: KeyPath) -> str:
    """Return the description of a key, or of the nearest enclosing key that has one."""
    for end in range(len(key_path), 0, -1):
        name = key_path[end - 1]
        section = _section(model, key_path[: end - 1])
        if isinstance(name, str) and section is not None and name in section.model_fields:
            return section.model_fields[name].description or ""
    return ""

"""Options of writers: validation against the names and type hints of `__init__`, and those that several have."""

import functools
import inspect
import math
import os
import types
import typing
from collections.abc import Callable, Collection, Mapping, Sequence
from numbers import Integral, Real
from typing import Any, TypedDict

import numpy as np

from usdsdg.annotators.default_filter import DefaultFilter
from usdsdg.arguments.near_arguments import near_arguments
from usdsdg.errors import WriterArgumentError, WriterError
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend


class CommonOptions(TypedDict, total=False):
    """Options of writers of labels, as `**common: Unpack[CommonOptions]`; each may be None.

    semantic_types, semantic_filter_predicate: labels to use, as types or as a predicate; default "class:*".
    s3_bucket, s3_region, s3_endpoint: write to a bucket, below `output_dir` as a prefix; see `S3Backend`.
    backend: where to write instead of to `output_dir`, or besides.
    """

    semantic_types: list[str] | str | None
    semantic_filter_predicate: str | None
    s3_bucket: str | None
    s3_region: str | None
    s3_endpoint: str | None
    backend: BaseBackend | None


# Type hints as error messages describe them.
_WORDS: dict[Any, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text",
    os.PathLike: "a path",
    type(None): "None",
}


def check_names(
    writer: str, init: Callable[..., None], options: Collection[str], *, place: str = "to initialize(...)"
) -> None:
    """Check the names of `options` against the parameters of a writer's `init`; `place` is where they are given.

    Raises:
        WriterError: an option is unknown, or a required one is missing; the message lists near misses or all options.
    """
    parameters = list(inspect.signature(init).parameters.values())[1:]
    known = [p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    if not any(p.kind is p.VAR_KEYWORD for p in parameters):
        for name in options:
            if name not in known:
                close = near_arguments(name, known)
                hint = f"Did you mean {' or '.join(map(repr, close))}?" if close else f"It has: {', '.join(known)}."
                raise WriterError(f"{writer} has no option {name!r}. {hint if known else 'It has none.'}")
    needed = [p.name for p in parameters if p.name in known and p.default is p.empty]
    if missing := [name for name in needed if name not in options]:
        raise WriterError(f"{writer} needs {', '.join(missing)}: give {'them' if missing[1:] else 'it'} {place}.")


def named_only(initialize: Callable[..., None]) -> Callable[..., None]:
    """Decorate a writer's `initialize`, which takes no positional arguments: its error for them says their names."""

    @functools.wraps(initialize)
    def checked(self: Any, *unnamed: Any, **options: Any) -> None:
        if unnamed:
            names = list(inspect.signature(type(self).__init__).parameters)[1:]
            given = ", ".join(f"{name}={value!r}" for name, value in zip(names, unnamed))
            raise WriterError(
                f"{type(self).__name__}: initialize() takes arguments by name only, as in initialize({given or '...'})."
            )
        initialize(self, **options)

    return checked


def label_params(
    writer: str, semantic_types: Sequence[str] | str | None, semantic_filter_predicate: str | None
) -> dict[str, Any]:
    """Return the init parameters of annotators for the two options that choose labels; default a `DefaultFilter`.

    Raises:
        WriterError: both are given.
    """
    if semantic_types and semantic_filter_predicate:
        raise WriterArgumentError(
            f"{writer}: semantic_types and semantic_filter_predicate exclude each other; give one."
        )
    if semantic_types:
        return {"semanticTypes": semantic_types}
    return {"semanticFilter": semantic_filter_predicate or DefaultFilter()}


def common_labels(writer: str, common: CommonOptions) -> dict[str, Any]:
    """As `label_params`, of common options."""
    return label_params(writer, common.get("semantic_types"), common.get("semantic_filter_predicate"))


def common_backend(writer: str, output_dir: str | os.PathLike | None, common: CommonOptions) -> BaseBackend:
    """As `make_backend`, of common options."""
    bucket, region, endpoint = (common.get(f"s3_{name}") for name in ("bucket", "region", "endpoint"))
    return make_backend(writer, output_dir, common.get("backend"), bucket=bucket, region=region, endpoint_url=endpoint)


def typed(init: Callable[..., None]) -> Callable[..., None]:
    """Decorate a writer's `__init__` so that it rejects unknown options and values that do not match its type hints.

    Boolean options also accept the numbers 0 and 1. Options of an unpacked TypedDict are named one by one in the
    signature.
    """
    hints = typing.get_type_hints(init)
    signature = _named_one_by_one(inspect.signature(init), hints)

    @functools.wraps(init)
    def checked(self: Any, *args: Any, **options: Any) -> None:
        name = type(self).__name__
        positional = list(signature.parameters)[1 : len(args) + 1]
        check_names(name, checked, [*positional, *options])
        _check_types(name, signature.bind(self, *args, **options).arguments, hints)
        init(self, *args, **options)

    checked.__signature__ = signature  # pyright: ignore[reportAttributeAccessIssue]
    return checked


def _named_one_by_one(signature: inspect.Signature, hints: dict[str, Any]) -> inspect.Signature:
    """Return a signature with the options of an unpacked TypedDict as parameters, and add their type hints."""
    parameters = list(signature.parameters.values())
    last = parameters[-1]
    if last.kind is not last.VAR_KEYWORD or typing.get_origin(hints.get(last.name)) is not typing.Unpack:
        return signature
    (unpacked,) = typing.get_args(hints.pop(last.name))
    more = typing.get_type_hints(unpacked)
    hints |= more
    named = [inspect.Parameter(name, last.KEYWORD_ONLY, default=None, annotation=more[name]) for name in more]
    return signature.replace(parameters=[*parameters[:-1], *named])


def _check_types(writer: str, values: Mapping[str, Any], hints: Mapping[str, Any]) -> None:
    for name, value in values.items():
        if name in hints and not _fits(value, hints[name]):
            raise WriterError(f"{writer}: {name} is {value!r}; expected {_described(hints[name])}.")


def _fits(value: Any, hint: Any) -> bool:
    if hint is Any:
        return True
    if _is_union(hint):
        return any(_fits(value, option) for option in typing.get_args(hint))
    if typing.get_origin(hint) is list:
        (item,) = typing.get_args(hint)
        return isinstance(value, (list, tuple)) and all(_fits(each, item) for each in value)
    if hint is bool:
        return isinstance(value, (bool, np.bool_)) or (isinstance(value, Integral) and value in (0, 1))
    if hint in (int, float):
        is_number = isinstance(value, Integral if hint is int else Real) and not isinstance(value, bool)
        return is_number and not math.isnan(value)
    return isinstance(value, hint)


def _described(hint: Any) -> str:
    if _is_union(hint):
        return " or ".join(_described(option) for option in typing.get_args(hint))
    if typing.get_origin(hint) is list:
        return f"a list of {_described(typing.get_args(hint)[0])}"
    return _WORDS.get(hint) or f"a {hint.__name__}"


def _is_union(hint: Any) -> bool:
    return typing.get_origin(hint) in (typing.Union, types.UnionType)

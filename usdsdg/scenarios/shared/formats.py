"""The formats that a job writes: writers by plain names, each in a folder of its own."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import usdsdg as rep
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import UsdsdgError
from usdsdg.scenarios.output_folder import below, with_absolute_output_dir
from usdsdg.writers import Writer
from usdsdg.writers.options import check_names


def writer_names() -> dict[str, str]:
    """Return the names of all writers by their plain names: `yolo` of YoloWriter."""
    return {name.removesuffix("Writer").lower(): name for name in rep.writers.get_writers()}


def format_problems(formats: Mapping[str, Mapping[str, Any] | None]) -> list[str]:
    """Return what is wrong with the names of formats and of their options."""
    problems = [] if formats else [f"no format is named; expected some of {', '.join(sorted(writer_names()))}"]
    for name, options in formats.items():
        kind = _writer_class(name)
        if kind is None:
            near = near_misses(name, [*writer_names(), *writer_names().values()])
            hint = f" (did you mean {' or '.join(near)}?)" if near else ""
            problems.append(f"{name} is no format; expected some of {', '.join(sorted(writer_names()))}{hint}")
            continue
        try:
            own = {"output_dir"} & inspect.signature(kind.__init__).parameters.keys()
            place = f"as an option: formats: {{{name}: {{option: value}}}}"
            check_names(kind.__name__, kind.__init__, {*(options or {}), *own}, place=place)
        except UsdsdgError as error:
            problems.append(str(error))
    return problems


def make_writers(
    output_dir: str, formats: Mapping[str, Mapping[str, Any] | None], common: Mapping[str, Any]
) -> list[tuple[str, Writer]]:
    """Return the initialized writers of some formats by name, not attached yet, each with a folder of its own.

    common: options that writers get which have them, unless the format's own options say otherwise.

    Raises:
        WriterError: an option has a wrong value, or a folder cannot be written to.
    """
    writers = []
    for name, options in formats.items():
        kind = _writer_class(name)
        assert kind is not None  # validated
        known = inspect.signature(kind.__init__).parameters
        arguments = {key: value for key, value in common.items() if key in known} | dict(options or {})
        if "output_dir" in known:
            arguments.setdefault("output_dir", below(output_dir, name.removesuffix("Writer").lower()))
        writers.append((name, rep.writers.get(kind.__name__, init_params=with_absolute_output_dir(arguments))))
    return writers


def folders(writers: list[tuple[str, Writer]]) -> list[str]:
    """Return the folders, or URLs, that writers write to."""
    found = [getattr(writer.backend, "output_dir", None) for _, writer in writers]
    return [str(each) for each in found if each]


def _writer_class(name: str) -> type[Writer] | None:
    return rep.writers.get_writers().get(writer_names().get(name.lower(), name))

"""The options of commands that report on datasets, and what these print."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

import click

from usdsdg.cli.options.values import WholeRange
from usdsdg.cli.output import print_lines

json_option = click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")


class _Report(Protocol):
    def lines(self, most: int) -> Iterable[str]: ...

    def values(self) -> dict[str, Any]: ...


def limit_option(of_what: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return the option `--limit`, of at most so many lines."""
    return click.option(
        "--limit",
        type=WholeRange(min=1),
        default=200,
        help=f"Print at most this many {of_what}.",
        show_default=True,
    )


def print_reports(
    folder: str, reports: Sequence[_Report], *, as_json: bool, limit: int, failed: Sequence[str] = ()
) -> None:
    """Print the reports on the datasets in a folder: lines, or JSON, of one dataset without a list around it.

    failed: names of datasets, with a report or without one, that the command could not work on.
    """
    if as_json:
        values = [each.values() for each in reports]
        is_clean = not failed and all(each["clean"] for each in values)
        several = {"folder": folder, "clean": is_clean, "datasets": values}
        several |= {"failed": list(failed)} if failed else {}
        is_one = len(values) == 1 and set(failed) <= {values[0]["folder"]}
        print_lines([json.dumps(values[0] if is_one else several, indent=1)])
    else:
        print_lines(line for each in reports for line in each.lines(limit))

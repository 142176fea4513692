"""`usdsdg inspect DIR`: make an HTML page that shows a dataset; also at the end of other commands."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.command_context import command_context
from usdsdg.errors import DatasetError

# Problems that are printed; the page has all.
_PRINTED = 20

Inspect = Annotated[bool, typer.Option("--inspect", help="Make a page of the dataset at the end, as usdsdg inspect.")]


def inspect(
    folder: Annotated[
        str, typer.Argument(help="A dataset in any format that usdsdg writes, or a folder or URL of several.")
    ],
    output: Annotated[Path | None, typer.Option(help="File of the page.", show_default="FOLDER/inspect.html")] = None,
) -> None:
    """Make one self-contained HTML page: images with their labels drawn over them, counts and histograms.

    Prints a line for each problem, such as an image without labels.
    """
    with command_context(quiet=True):
        _make_page(folder, output)


def _make_page(folder: str, output: Path | None = None) -> None:
    from usdsdg.datasets.on_disk import RECORDS, on_disk
    from usdsdg.inspect import inspect as make_page

    problems: list[str] = []
    with on_disk(folder) as dataset:
        dataset.fetch(lambda name: not name.startswith(RECORDS))
        page: Path | str = make_page(
            dataset.path,
            output,
            name=dataset.name if dataset.is_copy else None,
            report=lambda problem: problems.append(f"{problem.kind}: {problem.text}"),
        )
        if output is None:
            page = dataset.keep(page)
    for problem in problems[:_PRINTED]:
        print(problem, file=sys.stderr)
    if len(problems) > _PRINTED:
        print(f"... and {len(problems) - _PRINTED} more problems, on the page", file=sys.stderr)
    print(page)


def show_written(*, inspect: bool) -> None:
    """Make pages of the datasets that this process has written, or name the command that does.

    Raises:
        DatasetError: pages are asked for, and there is nothing to show.
    """
    from usdsdg.session.session import current

    folders = _tops([Path(each) for each in current().written_folders])
    if not inspect:
        for folder in folders:
            print(f"to look at it: usdsdg inspect {shlex.quote(str(folder))}")
        return
    failures = []
    for folder in folders:
        try:
            _make_page(str(folder))
        except DatasetError as error:
            failures.append(str(error))
    if len(failures) == len(folders):
        raise DatasetError("; ".join(failures) or "--inspect: no files were written to a folder")
    for failure in failures:
        print(f"warning: {failure}", file=sys.stderr)


def _tops(folders: list[Path]) -> list[Path]:
    """Return folders without those inside of others; instead of all folders in one, that one."""
    outer = [each for each in folders if not any(other in each.parents for other in folders)]
    parents = {each.parent for each in outer}
    if len(outer) > 1 and len(parents) == 1:
        (parent,) = parents
        if {each for each in parent.iterdir() if each.is_dir()} == set(outer):
            return [parent]
    return outer

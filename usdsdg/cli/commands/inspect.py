"""`usdsdg inspect DIR`: make an HTML page that shows a dataset; also at the end of other commands."""

import sys
from pathlib import Path

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import command_context
from usdsdg.cli.options.output_path import output_path
from usdsdg.cli.options.values import PATH, PLACE
from usdsdg.errors import DatasetError, counted
from usdsdg.session.next_commands import next_commands, written_datasets
from usdsdg.session.progress import say

# Problems that are printed; the page has all.
_PRINTED = 20

inspect_option = click.option(
    "--inspect", is_flag=True, help="Make a page of the dataset at the end, as usdsdg inspect."
)


@click.command(cls=Command, epilog=epilog("inspect"))
@argument("folder", type=PLACE, help="A dataset in any format that usdsdg writes, or a folder or URL of several.")
@click.option("--output", type=PATH, help="File of the page.", show_default="FOLDER/inspect.html")
def inspect(folder: str, output: Path | None) -> None:
    """Make one self-contained HTML page: images with their labels drawn over them, counts and histograms.

    Prints a line for each problem, such as an image without labels.
    """
    with command_context(quiet=True, keeps_files=False):
        _make_page(folder, output and output_path(output))


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
        print(f"... and {counted(len(problems) - _PRINTED, 'more problem')}, on the page", file=sys.stderr)
    print(page)


def show_written(*, inspect: bool) -> None:
    """Make pages of the datasets that this process has written, or name the commands that look at them.

    Raises:
        DatasetError: pages are asked for, and there is nothing to show.
    """
    folders = written_datasets()
    if not inspect:
        for line in next_commands(folders):
            say(line)
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

"""`usdsdg inspect DIR`: make an HTML page that shows a dataset."""

from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.command_context import command_context


def inspect(
    folder: Annotated[Path, typer.Argument(help="A dataset of PoseWriter or BasicWriter.")],
    output: Annotated[Path | None, typer.Option(help="File of the page.", show_default="FOLDER/inspect.html")] = None,
) -> None:
    """Make one self-contained HTML page: images with their labels drawn over them, counts and histograms."""
    with command_context(quiet=True):
        from usdsdg.inspect import inspect as make_page

        print(make_page(folder, output))

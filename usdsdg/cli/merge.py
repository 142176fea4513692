"""`usdsdg merge DIR`: join the parts of a dataset that several processes have made."""

from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.command_context import Quiet, command_context


def merge(
    folder: Annotated[Path, typer.Argument(help="The output folder of `--frames A:B` or `--shard i/n`.")],
    quiet: Quiet = False,
) -> None:
    """Join the parts of a dataset, and write its files about all frames.

    The result has the bytes that one process writes. Frames that are missing, or there twice, are an error.
    """
    with command_context(quiet=quiet):
        from usdsdg.writers.parts import join_parts

        print(f"{join_parts(folder)} frames joined in {folder}")

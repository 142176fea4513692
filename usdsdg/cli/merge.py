"""`usdsdg merge DIR`: join the parts of a dataset that several processes have made."""

from typing import Annotated

import typer

from usdsdg.cli.command_context import Quiet, command_context


def merge(
    place: Annotated[
        str, typer.Argument(metavar="DIR", help="The output folder or URL of `--frames A:B` or `--shard i/n`.")
    ],
    quiet: Quiet = False,
) -> None:
    """Join the parts of a dataset, and write its files about all frames.

    The result has the bytes that one process writes. Frames that are missing, or there twice, are an error.
    """
    with command_context(quiet=quiet):
        from usdsdg.writers.journal.place import place_of
        from usdsdg.writers.parts import join_parts

        print(f"{join_parts(place_of(place))} frames joined in {place}")

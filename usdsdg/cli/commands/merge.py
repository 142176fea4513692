"""`usdsdg merge DIR`: join the parts of a dataset that several processes have made."""

from pathlib import Path

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import command_context, quiet_option
from usdsdg.cli.options.values import PLACE
from usdsdg.errors import counted


@click.command(cls=Command, epilog=epilog("merge"))
@argument(
    "place",
    type=PLACE,
    metavar="DIR",
    help="The folder or URL of `--frames A:B` or `--shard i/n`, or a folder of several.",
)
@quiet_option
def merge(place: str, quiet: bool) -> None:
    """Join the parts of a dataset, and write its files about all frames.

    The result has the bytes that one process writes. Frames that are missing, or there twice, are an error.
    """
    with command_context(quiet=quiet):
        from usdsdg.writers.journal.place import place_of
        from usdsdg.writers.parts import join_parts

        for each in _datasets(place):
            print(f"{counted(join_parts(place_of(each)), 'frame')} joined in {each}")


def _datasets(place: str) -> list[str]:
    """Return the datasets in a folder that have parts, as where a job has written several formats; of a URL itself."""
    from usdsdg.stores.addresses import is_url
    from usdsdg.writers.journal.place import JOINED, PARTS
    from usdsdg.writers.journal.recipe import FILE

    if is_url(place) or Path(place, FILE).is_file():
        return [place]
    inside = sorted(each.parents[1] for each in Path(place).glob(f"*/{FILE}"))
    # Where none has parts, each says why.
    in_parts = [each for each in inside if any((each / name).is_dir() for name in (PARTS, JOINED))] or inside
    return [str(each) for each in in_parts] or [place]

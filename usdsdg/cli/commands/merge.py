"""`usdsdg merge DIR`: join the parts of a dataset that several processes have made."""

import os
from pathlib import Path

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.datasets_in import datasets_in
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import command_context, quiet_option
from usdsdg.cli.options.values import PLACE
from usdsdg.errors import counted


@click.command(cls=Command, epilog=epilog("merge"))
@argument(
    "place",
    type=PLACE,
    metavar="DIR",
    help="The folder or URL of `--frames A:B` or `--shard i/n`, or one with several below it.",
)
@quiet_option
def merge(place: str, quiet: bool) -> None:
    """Join the parts of a dataset, and write its files about all frames.

    The result has the bytes that one process writes. Frames that are missing before others, or there twice, are an
    error; --resume makes those after the last. Datasets of a folder are found at any depth, but none within another
    dataset.
    """
    with command_context(quiet=quiet):
        from usdsdg.writers.journal.places.place import place_of
        from usdsdg.writers.parts import join_parts

        for each in datasets_to_join(place):
            print(f"{counted(join_parts(place_of(each)), 'frame')} joined in {each}")


def datasets_to_join(place: str) -> list[str]:
    """Return the datasets in a folder that have parts; where none has any, all of them, of which each says why."""
    from usdsdg.datasets.folder import check_folder
    from usdsdg.stores.addresses import is_url
    from usdsdg.writers.journal.places.place import JOINED, PARTS

    if not is_url(place):
        check_folder(Path(place))
    found = datasets_in(place)
    return [each for each in found if any(_has(each, name) for name in (PARTS, JOINED))] or found


def _has(place: str, folder: str) -> bool:
    """Return whether a folder is there in the place of a dataset."""
    from usdsdg.stores import open_store
    from usdsdg.stores.addresses import is_url

    if is_url(place):
        return any(True for _ in open_store(place).list(folder))
    return os.path.isdir(Path(place, folder))

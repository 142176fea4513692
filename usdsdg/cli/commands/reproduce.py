"""`usdsdg reproduce DIR`: make frames of a dataset again from its recipe, and compare their files."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click
from click.exceptions import Exit

from usdsdg.cli import made_again
from usdsdg.cli.command import Command, argument
from usdsdg.cli.datasets_in import datasets_in
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.again_options import How, again_options
from usdsdg.cli.options.command_context import assets_root_option, command_context, device_option, quiet_option
from usdsdg.cli.options.thread_limit import threads_option
from usdsdg.cli.options.values import PLACE
from usdsdg.errors import DatasetError, UsdsdgError, counted
from usdsdg.session.endings.failures import tell
from usdsdg.stage.semantics.semantic_classes import BESIDE

if TYPE_CHECKING:
    from usdsdg.datasets.on_disk import OnDisk
    from usdsdg.verify.reproduced import Comparison
    from usdsdg.writers.journal.portion import Portion


@click.command(cls=Command, epilog=epilog("reproduce"))
@argument("folder", type=PLACE, help="A folder or URL with a recipe (.usdsdg/recipe.json), or one with several.")
@click.option("--frames", help="The frames to make again, as 0:10 or 3,7.", show_default="all")
@again_options
@assets_root_option
@device_option
@threads_option
@quiet_option
def reproduce(
    folder: str,
    frames: str | None,
    how: How,
    assets_root: str | None,
    device: str | None,
    threads: int | None,
    quiet: bool,
) -> None:
    """Make frames of a dataset again, in a temporary folder, and compare their files with those of the dataset.

    On the same versions and kind of device every byte is compared, else pictures, arrays and numbers are, within a
    tolerance. Prints a line for each file that differs, and one for each dataset; the exit code is 1 if a file differs,
    or the script fails. Other datasets of a folder are compared then all the same. The dataset is kept as it is: what a
    script does to its output folder itself, such as shutil.rmtree, is left out or refused.
    """
    with command_context(assets_root=assets_root, device=device, threads=threads, quiet=quiet, keeps_files=False):
        from usdsdg.session import session
        from usdsdg.writers.journal.portion import Portion

        portion = Portion.of_numbers(frames) if frames is not None else None
        differs, names = False, datasets_in(folder)
        failed: list[str] = []  # datasets that cannot be made again
        with ExitStack() as opened:
            datasets = _open(names, opened, failed)
            for number, group in enumerate(made_again.of_one_run(datasets)):
                if number:
                    session.restart()
                with made_again.failing_alone(group, failed):
                    failure, results = _reproduce(group, portion, how)
                    for name, count, result in results:
                        _print(result, name, count)
                        differs |= bool(result.faults)
                    if failure:
                        tell(DatasetError(f"{failure}, so not all frames may have been compared"))
                        differs = True
    if failed and len(names) > 1:
        print(f"error: not compared, for the reasons above: {', '.join(failed)}", file=sys.stderr)
    if failed or differs:
        raise Exit(1)


def _open(names: Sequence[str], opened: ExitStack, failed: list[str]) -> list[OnDisk]:
    """Return the datasets that have a recipe; tell of the others, and add their names to `failed`."""
    from usdsdg.datasets.on_disk import RECORDS, on_disk

    datasets = []
    for name in names:
        try:
            with ExitStack() as own:  # which lets an error name the URL of the dataset
                each = own.enter_context(on_disk(name))
                each.fetch(lambda file: file.startswith(f"{BESIDE}/") and not file.startswith(RECORDS))
                made_again.recipe_of(each.path)
                opened.push(own.pop_all())
        except UsdsdgError as error:
            tell(error)
            failed.append(name)
        else:
            datasets.append(each)
    return datasets


def _reproduce(
    datasets: list[OnDisk], portion: Portion | None, how: How
) -> tuple[str, list[tuple[str, int | None, Comparison]]]:
    """Make the frames of a portion of datasets of one recipe again, None: all, and compare each that has some of them.

    Returns what to say of a script that failed, else "", and of each dataset the name, how many of the frames it has
    where they were chosen one by one, and what came of it.
    """
    from usdsdg.verify.frame_numbers import check_portion, frames_of
    from usdsdg.verify.reproduced import Comparison, changed_assets, compare, counterpart, files_of

    folder = datasets[0].path
    recipe = made_again.recipe_of(folder)
    counts: dict[str, int | None] = {each.name: None for each in datasets}
    if portion is not None:
        check_portion([each.path for each in datasets], portion)
        found = {each.name: sum(map(portion.has, frames_of(each.path))) for each in datasets}
        counts = {name: count if portion.numbers is not None else None for name, count in found.items() if count}
    file = made_again.source_of(folder, recipe, how.source)
    differences = made_again.differences(recipe)
    for said in differences:
        print(f"note: made with {said}", file=sys.stderr)
    with made_again.scratch_folder("reproduce") as scratch:
        failure = made_again.make([each.path for each in datasets], recipe, file, scratch, portion, how)
        folders = made_again.folders_in(scratch)
        results = []
        for each in (each for each in datasets if each.name in counts):
            made, files = counterpart(each.path, folders), files_of(each.path, portion)
            if made is None and files:
                raise DatasetError(f"{each.path}: no file of it was made again by {failure or file}")
            for name in changed_assets(each.path, made) if made is not None else ():
                print(f"note: the asset {name} has other content than when {each.name} was made", file=sys.stderr)
            each.fetch(files.__contains__)
            result = compare(each.path, made, portion, exact=not differences) if made is not None else Comparison()
            results.append((each.name, counts[each.name], result))
        return failure, results


def _print(result: Comparison, folder: str, frames: int | None) -> None:
    for fault in result.faults:
        print(fault.line())
    if result.unknown:
        unknown = counted(len(result.unknown), "file has", "files have")
        print(f"note: {unknown} other bytes and no tolerance, such as {result.unknown[0]}")
    close = f", {result.close} within the tolerance" if result.close else ""
    which = f"{counted(frames, 'frame')} of " if frames is not None else ""
    print(f"{which}{folder}: {counted(result.equal, 'file')} equal{close}, {len(result.faults)} different")

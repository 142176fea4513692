"""`usdsdg repair DIR`: make the damaged and missing files of a dataset again, and no others."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.exceptions import Exit

from usdsdg.cli import made_again
from usdsdg.cli.command import Command, argument
from usdsdg.cli.datasets_in import datasets_in
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.again_options import How, again_options
from usdsdg.cli.options.command_context import assets_root_option, command_context, device_option, quiet_option
from usdsdg.cli.options.report_options import json_option, limit_option, print_reports
from usdsdg.cli.options.thread_limit import threads_option
from usdsdg.cli.options.values import PLACE
from usdsdg.errors import DatasetError, UsdsdgError
from usdsdg.session.endings.failures import tell

if TYPE_CHECKING:
    from usdsdg.repair.summary import Summary
    from usdsdg.writers.journal.portion import Portion
    from usdsdg.writers.journal.recipe import Recipe


@click.command(cls=Command, epilog=epilog("repair"))
@argument("folder", type=PLACE, help="A folder or URL with a recipe (.usdsdg/recipe.json), or one with several.")
@click.option("--dry-run", is_flag=True, help="Only say what is damaged, and which frames would be made.")
@again_options
@click.option("--anyway", is_flag=True, help="Also try with other versions, or on another kind of device.")
@json_option
@limit_option("files of a dataset that are left damaged")
@assets_root_option
@device_option
@threads_option
@quiet_option
def repair(
    folder: str,
    dry_run: bool,
    how: How,
    anyway: bool,
    as_json: bool,
    limit: int,
    assets_root: str | None,
    device: str | None,
    threads: int | None,
    quiet: bool,
) -> None:
    """Make the damaged and missing files of a dataset again, and leave all others as they are.

    The frames of these files are made in a temporary folder, files about all frames of the records beside the data. A
    file takes the place of a damaged one only if it has the bytes that the run wrote, by the SHA-256 in the journal.

    Prints a line for each file that is left damaged, with the reason, or that no run wrote, and one for each dataset;
    the exit code is 1 if there are any, or a script fails. Other datasets of a folder are repaired then all the same.
    Interrupted, it keeps what it has repaired, and the next repair makes the rest.
    """
    quiet = quiet or as_json
    with command_context(assets_root=assets_root, device=device, threads=threads, quiet=quiet, keeps_files=False):
        summaries: list[Summary] = []
        with ExitStack() as opened:
            names = datasets_in(folder)
            failed = _claim(names, summaries, opened, is_dry=dry_run)
            try:
                failed += _repair_all(summaries, how, is_dry=dry_run, is_tried=anyway)
            except KeyboardInterrupt:
                limit = 0  # the files that are left may be many, and the next repair makes them
                raise
            finally:
                print_reports(folder, summaries, as_json=as_json, limit=limit, failed=failed)
    if failed and len(names) > 1:
        print(f"error: not repaired, for the reasons above: {', '.join(failed)}", file=sys.stderr)
    if failed or not (dry_run or all(each.is_clean for each in summaries)):
        raise Exit(1)


def _claim(names: Sequence[str], summaries: list[Summary], opened: ExitStack, *, is_dry: bool) -> list[str]:
    """Lock the datasets of a folder and find what is damaged; return which of several cannot be repaired."""
    from usdsdg.repair.claim import claimed

    failed = []
    for name in names:
        try:
            summaries.append(opened.enter_context(claimed(name, is_dry=is_dry)))
        except UsdsdgError as error:
            if len(names) == 1:
                raise
            tell(error)
            failed.append(name)
    return failed


def _repair_all(summaries: Sequence[Summary], how: How, *, is_dry: bool, is_tried: bool) -> list[str]:
    """Repair datasets, those of one run at once; return those of which frames could not be made.

    is_tried: also with other versions, or on another kind of device.
    """
    from usdsdg.session import session

    failed: list[str] = []
    groups = [group for group in made_again.of_one_run(summaries) if any(each.repair.left for each in group)]
    for number, group in enumerate(groups):
        if number:
            session.restart()
        with made_again.failing_alone(group, failed):
            _repair(group, how, is_dry=is_dry, is_tried=is_tried)
    return failed


def _repair(group: Sequence[Summary], how: How, *, is_dry: bool, is_tried: bool) -> None:
    """Repair the datasets of one run, of which some may be whole.

    Raises:
        UsdsdgError: frames cannot be made, or their script failed; what it had made until then is taken.
    """
    if not is_dry:
        _take_sources(group, how.source)
        _make_of_spools(group)  # which takes no frames, and so also where these cannot be made
    if not any(each.plan.needs_frames for each in group):
        _end(group)
        return
    recipe = made_again.recipe_of(group[0].path)
    whole = next((each.path for each in group if not each.plan.source), group[0].path)
    file = made_again.source_of(whole, recipe, how.source)
    if (said := made_again.differences(recipe)) and not is_tried:
        raise DatasetError(
            f"{group[0].name} was made with {'; '.join(said)}, and other versions and devices give other bytes. "
            "Install those versions, or choose that device with --device; --anyway tries, and keeps what has the same "
            "bytes."
        )
    if is_dry:
        return
    from usdsdg.repair.plan import joined
    from usdsdg.session import session

    portion = joined([each.plan for each in group])
    failure = _make_frames(group, recipe, file, how, portion)
    if portion is not None and any(each.repair.shared for each in group):
        for each in group:
            each.plan.whole += each.repair.shared
        name = next(name for each in group for name in each.plan.whole)
        print(
            f"note: all frames are made again for {name}, which the first and the last one do not make", file=sys.stderr
        )
        session.restart()
        failure = _make_frames(group, recipe, file, how, None)
    _make_of_spools(group)  # once more, where pictures were damaged of which videos are made
    if failure:
        raise DatasetError(f"{failure}; the files that it had made until then are taken")
    _end(group)


def _end(group: Sequence[Summary]) -> None:
    for each in group:
        each.is_ended = True


def _make_frames(group: Sequence[Summary], recipe: Recipe, file: Path, how: How, portion: Portion | None) -> str:
    """Make the frames of a portion of datasets of one run again, None: all, and take the files that are equal.

    Returns what `made_again.make` returns.
    """
    with made_again.scratch_folder("repair") as scratch:
        try:
            failure = made_again.make([each.path for each in group], recipe, file, scratch, portion, how)
        finally:  # also what was made before Ctrl-C, so that the next repair goes on from there
            for each in group:
                each.repair.take(made_again.folders_in(scratch))
        for each in group:
            _take_shards(each, scratch, portion)
            _note_assets(each, scratch)
    return failure


def _take_sources(group: Sequence[Summary], given: Path | None) -> None:
    """Put copies of the script or configuration back: from another dataset of the run, or as given."""
    for each in group:
        if name := each.plan.source:
            others = [other.path / name for other in group]
            each.repair.take_file(name, others if given is None else [given, *others])
            each.repair.explain([name], "give the file that made the dataset with --source")


def _make_of_spools(group: Sequence[Summary]) -> None:
    """Make files about all frames of the records beside the data."""
    from usdsdg.repair import spooled
    from usdsdg.stores.temporary import TemporaryFolder

    for each in group:
        spools = [spool for name, spool in each.plan.spools.items() if name in each.repair.left]
        if spools:
            with TemporaryFolder("repair") as made:
                why = spooled.write(each.path, spools, made.resolve())
                each.repair.take([made])
            each.repair.explain(each.plan.spools, why)


def _take_shards(summary: Summary, scratch: Path, portion: Portion | None) -> None:
    """Make the shards of which the samples were made again; of all frames the run has made them itself."""
    if portion is None:
        return
    from usdsdg.repair.plan import sharded
    from usdsdg.writers.journal.places.place import PARTS
    from usdsdg.writers.journal.spool_hashes import AGGREGATES

    shards = sharded(summary.repair.damage)
    for number, folder in enumerate(made_again.folders_in(scratch)):
        made = scratch / f"shards-{number}"
        shards.write(folder / PARTS / portion.name / AGGREGATES, made)
        summary.repair.take([made])


def _note_assets(summary: Summary, scratch: Path) -> None:
    """Name assets that have other content than when the dataset was made, where files are left."""
    from usdsdg.verify.reproduced import changed_assets

    for folder in made_again.folders_in(scratch) if summary.repair.left else ():
        for name in changed_assets(summary.path, folder):
            summary.notes.append(f"the asset {name} has other content than when {summary.name} was made")

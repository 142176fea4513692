"""`usdsdg reproduce DIR`: make frames of a dataset again from its recipe, and compare their files."""

from __future__ import annotations

import json
import runpy
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.exceptions import Exit

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import (
    assets_root_option,
    command_context,
    device_option,
    finish_files,
    fix_classes,
    quiet_option,
    seed_everything,
)
from usdsdg.cli.options.thread_limit import threads_option
from usdsdg.cli.options.values import PATH, PLACE
from usdsdg.cli.script.interpreter import interpreter_restored
from usdsdg.errors import BadValue, DatasetError, counted
from usdsdg.stage.semantics.semantic_classes import BESIDE

if TYPE_CHECKING:
    from usdsdg.datasets.on_disk import OnDisk
    from usdsdg.verify.reproduced import Comparison
    from usdsdg.writers.journal.portion import Portion
    from usdsdg.writers.journal.recipe import Recipe


@click.command(cls=Command, epilog=epilog("reproduce"))
@argument("folder", type=PLACE, help="A folder or URL with a recipe (.usdsdg/recipe.json), or a folder of several.")
@click.option("--frames", help="The frames to make again, as 0:10 or 3,7.", show_default="all")
@click.option("--source", type=PATH, help="The script or configuration.", show_default="the copy beside the data")
@click.option("--stage", type=PATH, help="The stage that --stage of the run named.")
@assets_root_option
@device_option
@threads_option
@quiet_option
def reproduce(
    folder: str,
    frames: str | None,
    source: Path | None,
    stage: Path | None,
    assets_root: str | None,
    device: str | None,
    threads: int | None,
    quiet: bool,
) -> None:
    """Make frames of a dataset again, in a temporary folder, and compare their files with those of the dataset.

    On the same versions and kind of device every byte is compared, else pictures, arrays and numbers are, within a
    tolerance. Prints a line for each file that differs, and one for each dataset; the exit code is 1 if a file differs.
    The dataset is kept as it is: what a script does to its output folder itself, such as shutil.rmtree, is left out or
    refused.
    """
    with command_context(assets_root=assets_root, device=device, threads=threads, quiet=quiet, keeps_files=False):
        from usdsdg.datasets.on_disk import RECORDS, on_disk
        from usdsdg.session import session
        from usdsdg.writers.journal.portion import Portion

        portion = Portion.of_numbers(frames) if frames is not None else None
        differs = False
        with ExitStack() as opened:
            datasets = [opened.enter_context(on_disk(each)) for each in _datasets(folder)]
            for each in datasets:
                each.fetch(lambda name: name.startswith(f"{BESIDE}/") and not name.startswith(RECORDS))
            for number, group in enumerate(_of_one_run(datasets)):
                if number:
                    session.restart()
                for name, count, result in _reproduce(group, portion, source, stage):
                    _print(result, name, count)
                    differs |= bool(result.faults)
    if differs:
        raise Exit(1)


def _datasets(place: str) -> list[str]:
    """Return the datasets in a folder, as where a job has written several formats; of a URL itself."""
    from usdsdg.writers.journal.recipe import FILE

    if Path(place, FILE).is_file():
        return [place]
    return sorted(str(each.parents[1]) for each in Path(place).glob(f"*/{FILE}")) or [place]


def _of_one_run(datasets: list[OnDisk]) -> Iterator[list[OnDisk]]:
    """Yield the datasets in groups that have one recipe, and are made by one run."""
    from usdsdg.writers.journal.recipe import IDENTITY

    groups: dict[str, list[OnDisk]] = {}
    for each in datasets:
        values = _recipe_of(each.path).values()
        groups.setdefault(json.dumps([values[name] for name in IDENTITY]), []).append(each)
    yield from groups.values()


def _reproduce(
    datasets: list[OnDisk], portion: Portion | None, source: Path | None, stage: Path | None
) -> list[tuple[str, int | None, Comparison]]:
    """Make the frames of a portion of datasets of one recipe again, None: all, and compare each that has some of them.

    Returns the name of each, how many of the frames it has where they were chosen one by one, and what came of it.
    """
    from usdsdg.cli.script.kept_datasets import read_only
    from usdsdg.session.session import current
    from usdsdg.verify.frame_numbers import check_portion, frames_of
    from usdsdg.verify.reproduced import Comparison, changed_assets, compare, counterpart, files_of
    from usdsdg.writers.aggregates import finish_run
    from usdsdg.writers.journal.folders import Mode
    from usdsdg.writers.journal.recipe import GENERATE

    folder = datasets[0].path
    recipe = _recipe_of(folder)
    counts: dict[str, int | None] = {each.name: None for each in datasets}
    if portion is not None:
        check_portion([each.path for each in datasets], portion)
        found = {each.name: sum(map(portion.has, frames_of(each.path))) for each in datasets}
        counts = {name: count if portion.numbers is not None else None for name, count in found.items() if count}
    file = _source_of(folder, recipe, source)
    differences = _now(recipe).differences({**recipe.values(), "classes": None})
    for said in differences:
        print(f"note: made with {said.replace(' there', '')}", file=sys.stderr)
    run = current().run
    with tempfile.TemporaryDirectory(prefix="usdsdg-reproduce-") as scratch, _dropped_on_failure():
        run.scratch = Path(scratch).resolve()
        run.begin(_now(recipe), Mode.OVERWRITE, portion, file)
        shown = sys.stderr if recipe.command != GENERATE else StringIO()  # which names its folder
        with ExitStack() as kept:
            kept.enter_context(redirect_stdout(shown))
            for each in datasets:
                kept.enter_context(read_only(each.path))
            kept.enter_context(interpreter_restored())
            _make(recipe, file, folder, stage, run.scratch)
            finish_files()
        finish_run(complete=True)
        results = []
        for each in (each for each in datasets if each.name in counts):
            made, files = counterpart(each.path, [folder.path for folder in run.folders]), files_of(each.path, portion)
            if made is None and files:
                raise DatasetError(f"{each.path}: no file of it was made again by {file}")
            for name in changed_assets(each.path, made) if made is not None else ():
                print(f"note: the asset {name} has other content than when {each.name} was made", file=sys.stderr)
            each.fetch(files.__contains__)
            result = compare(each.path, made, portion, exact=not differences) if made is not None else Comparison()
            results.append((each.name, counts[each.name], result))
        return results


@contextmanager
def _dropped_on_failure() -> Iterator[None]:
    """Where what makes the frames fails or is interrupted, drop the files that wait: their folder goes."""
    from usdsdg.session.session import current

    try:
        yield
    except BaseException:
        current().io_queue.stop()
        current().run.release()
        raise


def _recipe_of(folder: Path) -> Recipe:
    from usdsdg.writers.journal import recipe

    values = recipe.read(folder)
    if values is None:
        raise DatasetError(f"{folder} has no recipe ({recipe.FILE}), so it is not known how it was made")
    return recipe.Recipe.of_values(values, folder)


def _source_of(folder: Path, recipe: Recipe, given: Path | None) -> Path:
    from usdsdg.writers.journal.recipe import SOURCE, source_of

    file = given if given is not None else folder / SOURCE / recipe.source["name"]
    if not file.is_file():
        remedy = "" if given is not None else "; give the file that made it with --source"
        raise DatasetError(f"there is no {file}{remedy}")
    if source_of(file)["sha256"] != recipe.source["sha256"]:
        raise DatasetError(f"{file} is not the file that made {folder}: its SHA-256 is not that of the recipe")
    return file.absolute()


def _now(recipe: Recipe) -> Recipe:
    """Return the recipe as this machine makes it: with its own versions and kind of device."""
    from dataclasses import replace

    from usdsdg.session import engines
    from usdsdg.writers.journal.recipe import installed

    return replace(recipe, versions=installed(), device=engines.renderer_device_kind(), classes=None)


def _make(recipe: Recipe, file: Path, folder: Path, stage: Path | None, scratch: Path) -> None:
    """Run the configuration or script as the recipe says."""
    from usdsdg.graph.sampling import set_global_seed
    from usdsdg.writers.journal.recipe import GENERATE, RUN, SEED_SETTING

    arguments = [_argument(each, scratch) for each in recipe.arguments]
    if recipe.classes is not None:
        fix_classes(str(folder))
    if recipe.command == GENERATE:
        _generate(file, arguments)
    elif recipe.command == RUN:
        _run(file, arguments, recipe, stage)
    else:
        if (seed := recipe.settings.get(SEED_SETTING)) is not None:
            set_global_seed(seed)  # which was drawn, if the script sets none
        sys.argv = [str(file), *arguments]
        sys.path.insert(0, str(file.parent))
        runpy.run_path(str(file), run_name="__main__")


def _argument(recorded: str, scratch: Path) -> str:
    """Return an argument with the folders of this machine."""
    from usdsdg.stage.assets import assets_root
    from usdsdg.stage.assets.anchors import ASSETS
    from usdsdg.writers.journal.recipe import OUTPUT

    placed = recorded.replace(OUTPUT, str(scratch / "out"))
    return placed.replace(ASSETS, assets_root()) if ASSETS in placed else placed


def _generate(file: Path, overrides: list[str]) -> None:
    from usdsdg.scenarios import jobs, saved_pipeline

    if file.suffix.lower() in saved_pipeline.SUFFIXES:
        # Everything goes to a temporary folder.
        saved_pipeline.run(file, saved_pipeline.Overrides.parse(overrides), allow_outside=True)
        return
    job, values = jobs.load_job(file, overrides)
    seed_everything(values.seed)
    job.run(values)


def _run(file: Path, arguments: list[str], recipe: Recipe, stage: Path | None) -> None:
    from usdsdg.cli.commands.run import execute_script
    from usdsdg.cli.script.conditions import Conditions

    wanted: Any = recipe.options.get("stage")
    if wanted is not None and (stage is None or stage.name != wanted):
        raise BadValue(f"the run had --stage {wanted}: say where that file is with --stage")
    try:
        conditions = Conditions.of_facts(recipe.options, stage)
    except (ValueError, TypeError) as error:
        raise DatasetError(f"the recipe has options that `usdsdg run` does not have: {error}") from None
    seed_everything(recipe.seed or 0)
    conditions.apply(file)
    execute_script(file, arguments, conditions.frames, allow_outside=True)


def _print(result: Comparison, folder: str, frames: int | None) -> None:
    for fault in result.faults:
        print(fault.line())
    if result.unknown:
        unknown = counted(len(result.unknown), "file has", "files have")
        print(f"note: {unknown} other bytes and no tolerance, such as {result.unknown[0]}")
    close = f", {result.close} within the tolerance" if result.close else ""
    which = f"{counted(frames, 'frame')} of " if frames is not None else ""
    print(f"{which}{folder}: {counted(result.equal, 'file')} equal{close}, {len(result.faults)} different")

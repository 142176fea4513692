"""Frames of a dataset that are made again from the recipe beside it, in a temporary folder."""

from __future__ import annotations

import json
import runpy
import sys
import traceback
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, chdir, contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from click.exceptions import Exit

from usdsdg.cli.options.again_options import How
from usdsdg.cli.options.command_context import as_usdsdg_error, finish_files, fix_classes, seed_everything
from usdsdg.cli.options.map_option import use_maps
from usdsdg.cli.script.execution import exit_of
from usdsdg.cli.script.interpreter import interpreter_restored
from usdsdg.errors import BadValue, DatasetError
from usdsdg.session.endings.failures import tell
from usdsdg.stage.semantics.semantic_classes import BESIDE

if TYPE_CHECKING:
    from usdsdg.writers.journal.portion import Portion
    from usdsdg.writers.journal.recipe import Recipe


class _Dataset(Protocol):
    @property
    def path(self) -> Path: ...


class _Named(Protocol):
    @property
    def name(self) -> str: ...

    def named(self, text: str) -> str: ...


Dataset = TypeVar("Dataset", bound=_Dataset)


def of_one_run(datasets: Iterable[Dataset]) -> Iterator[list[Dataset]]:
    """Yield the datasets in groups that have one recipe, and are made by one run."""
    from usdsdg.writers.journal.recipe import IDENTITY

    groups: dict[str, list[Dataset]] = {}
    for each in datasets:
        values = recipe_of(each.path).values()
        groups.setdefault(json.dumps([values[name] for name in IDENTITY]), []).append(each)
    yield from groups.values()


@contextmanager
def scratch_folder(kind: str) -> Iterator[Path]:
    """Give a temporary folder, below which all files of the run of this process go, wherever they would go."""
    from usdsdg.session.session import current
    from usdsdg.stores.temporary import TemporaryFolder

    with TemporaryFolder(kind) as scratch:
        current().run.scratch = scratch.resolve()
        yield current().run.scratch


@contextmanager
def failing_alone(group: Sequence[_Named], failed: list[str]) -> Iterator[None]:
    """Run the body, which makes datasets of one run again; if it fails, print why and add their names to `failed`.

    An exception that is neither usdsdg's nor pxr's is printed with its traceback. `Exit` ends the command.
    """
    try:
        yield
    except Exit:
        raise
    except Exception as error:  # noqa: BLE001 - whatever it is, the datasets of other runs do not depend on it
        known = as_usdsdg_error(error)
        if known is None:
            traceback.print_exception(error)
        else:
            for each in group:
                known.args = tuple(map(each.named, map(str, known.args)))
            tell(known)
        failed += [each.name for each in group]


def folders_in(scratch: Path) -> list[Path]:
    """Return the folders of datasets that were made, or begun, in a scratch folder."""
    return sorted(each.parent for each in scratch.rglob(BESIDE))


def make(datasets: Sequence[Path], recipe: Recipe, file: Path, scratch: Path, portion: Portion | None, how: How) -> str:
    """Make the frames of a portion again, None: all, of datasets of one recipe, in a scratch folder.

    file: the source of the recipe.

    Returns what to say of a script that failed, or ended with an exit code of its own, once the files are written of
    the frames that it has made until then; "" where it came to its end.

    Raises:
        DatasetError: the recipe is not one of this version. UsdsdgError: what the frames are made by has failed.
    """
    from usdsdg.cli.script.kept_datasets import read_only
    from usdsdg.session.session import current
    from usdsdg.writers.aggregates import finish_run
    from usdsdg.writers.journal.earlier_run import Mode
    from usdsdg.writers.journal.recipe import GENERATE

    with _dropped_on_failure():
        current().run.begin(_now(recipe), Mode.OVERWRITE, portion, file)
        shown = sys.stderr if recipe.command != GENERATE else StringIO()  # which names its folder
        with ExitStack() as kept:
            kept.enter_context(chdir(Path.cwd()))  # which the script may leave, and the datasets are named from
            kept.enter_context(redirect_stdout(shown))
            for each in datasets:
                kept.enter_context(read_only(each))
            kept.enter_context(interpreter_restored())
            try:
                _make(recipe, file, scratch, how)
                failure = ""
            except Exit as ended:  # only of this script: other datasets have others
                failure = f"{file} ended with exit code {ended.exit_code}"
            finish_files()
        finish_run(complete=not failure)
        current().io_queue.forget_at_exit()  # the folder is gone then
    return failure


def differences(recipe: Recipe) -> list[str]:
    """Return in what this machine differs from the one that made a dataset: versions, and kind of device."""
    differing = _now(recipe).differences({**recipe.values(), "classes": None})
    return [said.replace(" there", "") for said in differing]


@contextmanager
def _dropped_on_failure() -> Iterator[None]:
    """Where what makes the frames fails or is interrupted, drop the files that wait: their folder goes."""
    from usdsdg.session.session import current

    try:
        yield
    except BaseException:
        current().io_queue.stop()
        current().io_queue.forget_at_exit()
        current().run.release()
        raise


def recipe_of(folder: Path) -> Recipe:
    """Return the recipe of a dataset.

    Raises:
        DatasetError: there is none, or it is not one of this version. WriterError: it is damaged.
    """
    from usdsdg.datasets.folder import check_folder
    from usdsdg.writers.journal import recipe

    values = recipe.read(folder, remedy=recipe.PUT_BACK)
    if values is None:
        check_folder(folder)
        raise DatasetError(f"{folder} has no recipe ({recipe.FILE}), so it is not known how it was made")
    return recipe.Recipe.of_values(values, folder)


def source_of(folder: Path, recipe: Recipe, given: Path | None) -> Path:
    """Return the script or configuration of a recipe: the copy beside the data, or the file that the user has given.

    Raises:
        DatasetError: there is none, or it is not the one that made the dataset.
    """
    from usdsdg.writers.journal import recipe as recipe_file

    file = given if given is not None else folder / recipe_file.SOURCE / recipe.source["name"]
    remedy = "" if given is not None else "; give the file that made it with --source"
    if not file.is_file():
        raise DatasetError(f"there is no {file}{remedy}")
    if recipe_file.source_of(file)["sha256"] != recipe.source["sha256"]:
        what = f"{file} is not the file that made {folder}: its SHA-256 is not that of the recipe"
        raise DatasetError(f"{what}{remedy}")
    return file.absolute()


def _now(recipe: Recipe) -> Recipe:
    """Return the recipe as this machine makes it: with its own versions and kind of device."""
    from dataclasses import replace

    from usdsdg.session import devices
    from usdsdg.writers.journal.recipe import installed

    return replace(recipe, versions=installed(), device=devices.renderer_device_kind(), classes=None)


def _make(recipe: Recipe, file: Path, scratch: Path, how: How) -> None:
    """Run the configuration or script as the recipe says; what that of another recipe has set is undone."""
    from usdsdg import errors
    from usdsdg.graph.sampling import set_global_seed
    from usdsdg.session import devices
    from usdsdg.session.session import current
    from usdsdg.stage import assets
    from usdsdg.writers.journal.recipe import CLASSES_SETTING, GENERATE, PHYSICS_DEVICE, RUN, SEED_SETTING

    devices.use_device(current().engines.device, physics=str(recipe.options.get(PHYSICS_DEVICE, "cpu")))
    assets.set_maps([assets.PathMap.parse(each) for each in how.maps])
    assets.set_on_missing(assets.OnMissing.RAISE)
    errors.set_lenient(False)
    arguments = [_argument(each, scratch) for each in recipe.arguments]
    classes = recipe.settings.get(CLASSES_SETTING)
    if recipe.classes is not None and not isinstance(classes, str):  # what is run names a file, and sets it again
        fix_classes(classes)
    if recipe.command == GENERATE:
        use_maps(how.maps, file)
        _generate(file, arguments)
    elif recipe.command == RUN:
        _run(file, arguments, recipe, how)
    else:
        if (seed := recipe.settings.get(SEED_SETTING)) is not None:
            set_global_seed(seed)  # which was drawn, if the script sets none
        sys.argv = [str(file), *arguments]
        sys.path.insert(0, str(file.parent))
        with exit_of(file):
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


def _run(file: Path, arguments: list[str], recipe: Recipe, how: How) -> None:
    from usdsdg.cli.commands.run import execute_script
    from usdsdg.cli.script.conditions import Conditions

    wanted: Any = recipe.options.get("stage")
    if wanted is not None and (how.stage is None or how.stage.name != wanted):
        raise BadValue(f"the run had --stage {wanted}: say where that file is with --stage")
    try:
        conditions = Conditions.of_facts(recipe.options, how.stage, how.maps)
    except (ValueError, TypeError) as error:
        raise DatasetError(f"the recipe has options that `usdsdg run` does not have: {error}") from None
    seed_everything(recipe.seed or 0)
    conditions.apply(file)
    execute_script(file, arguments, conditions.frames, allow_outside=True)

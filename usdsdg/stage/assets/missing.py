"""What becomes of an asset that is missing: an error at once, an error for all of them, a stand-in, or nothing."""

from __future__ import annotations

import enum
import os
from typing import NamedTuple

from pxr import Usd

from usdsdg import errors
from usdsdg.stage.assets import dependencies, lookup, mesh_files, stand_ins
from usdsdg.stage.assets.file_checks import not_a_file_of_its_own
from usdsdg.stage.assets.lost_variants import LostVariants


class MissingAssets(errors.AssetNotFound):
    """Assets that a run needs are missing; the message lists all of them."""


class OnMissing(enum.Enum):
    """What `resolve` does where there is no file."""

    RAISE = "raise"  # at once
    ERROR = "error"  # give an empty prim; `check_missing` raises an error that lists all
    STAND_IN = "stand-in"  # give a labeled box of the asset's name
    SKIP = "skip"  # give an empty prim


class MissingAsset(NamedTuple):
    """An asset that was looked up and not found."""

    asset: str  # URL or path as the script gave it
    why: str  # where it was looked for
    line: str  # script line that needs it; "" if unknown


_MATERIAL_X = ".mtlx"
_NEEDS_PLUGIN = (
    "MaterialX files are read by OpenUSD's plugin for them, which the package usd-core does not have, so the materials "
    "in it are missing. Make a USD file of the stage with a build of OpenUSD that has it, by usdcat --flatten."
)

_on_missing = OnMissing.RAISE
_is_chosen = True
_missing: dict[str, MissingAsset] = {}


def set_on_missing(choice: OnMissing, *, is_chosen: bool = True) -> None:
    """Choose what becomes of missing assets from now on, and forget those of the past.

    is_chosen: whether the user could choose otherwise, which messages say then.
    """
    global _on_missing, _is_chosen
    _on_missing, _is_chosen = choice, is_chosen
    _missing.clear()


def get_on_missing() -> OnMissing:
    """Return what becomes of missing assets."""
    return _on_missing


def missing_assets() -> list[MissingAsset]:
    """Return what has been missing so far and has no stand-in, in the order of the look-ups."""
    return list(_missing.values())


def resolve(asset: str | os.PathLike[str], *, labeled: bool = False) -> str:
    """Return the file that a URL or path refers to, as `locate` does; of a mesh file the USD file made of it.

    labeled: a mesh file gets its name as its class.

    Where there is none it returns a stand-in, or an empty file of the same kind, if `set_on_missing` says so. There is
    none for files of unknown kinds: these raise, and are listed later as well. For folders see `instead_of_folder`.

    Raises:
        AssetNotFound, AssetError, Unsupported: as `locate`, or a mesh cannot be converted.
    """
    return mesh_files.as_usd(located(asset), labeled=labeled)


def located(asset: str | os.PathLike[str]) -> str:
    """Return the file that a URL or path refers to, or what takes its place; a mesh file as it is."""
    try:
        return lookup.locate(asset)
    except (errors.AssetError, errors.Unsupported) as error:
        if _on_missing is OnMissing.RAISE:
            raise
        text = os.fspath(asset).strip()
        instead = stand_ins.instead_of(text, empty=_on_missing is not OnMissing.STAND_IN)
        if _on_missing is OnMissing.ERROR or instead is None:
            note_missing(text, where_looked(error))
        if instead is None:
            raise
        _tell_of_stand_in(text, error)
        return instead


def instead_of_folder(folder: str, error: errors.AssetError | errors.Unsupported) -> str:
    """Return the one file that takes the place of those in a missing folder of USD files.

    Raises:
        AssetError, Unsupported: `error`, that of the look-up, where missing assets have no stand-ins.
    """
    text = folder.strip()
    if _on_missing is OnMissing.ERROR:
        note_missing(text, where_looked(error))
    instead = None
    if text and _on_missing in (OnMissing.STAND_IN, OnMissing.SKIP):
        name = text.replace("\\", "/").rstrip("/")
        instead = stand_ins.instead_of(f"{name}.usd", empty=_on_missing is OnMissing.SKIP)
    if instead is None:
        raise error
    _tell_of_stand_in(text, error)
    return instead


def _tell_of_stand_in(asset: str, error: errors.AssetError | errors.Unsupported) -> None:
    if _on_missing is OnMissing.STAND_IN:
        errors.warn_once(f"a stand-in replaces {asset}, which is missing: {where_looked(error)}")
    elif _on_missing is OnMissing.SKIP:
        errors.warn_once(f"{asset} is left out, since it is missing: {where_looked(error)}")


def where_looked(error: errors.AssetError | errors.Unsupported) -> str:
    """Return where an asset was looked for, by the error of its look-up."""
    return "; ".join(error.looked_for) or str(error)


def note_missing(asset: str, why: str) -> None:
    """Record an asset as missing, for `check_missing`."""
    _missing.setdefault(asset, MissingAsset(asset, why, errors.outside_line()))


def check_missing(stage: Usd.Stage) -> None:
    """Report the references of a stage that do not open, after pointing those elsewhere that are found there.

    What the stage's own layers refer to is an error where `resolve` reports its errors here; the rest are warnings, and
    so are circles of references, and selected variants that do not exist.

    Raises:
        MissingAssets: something is missing; the message lists all with where they were looked for.
    """
    dependencies.redirect(stage)
    own = {layer.identifier for layer in stage.GetLayerStack()}
    unopened: dict[str, list[dependencies.MissingDependency]] = {}
    for each in dependencies.missing_dependencies(stage):
        if _on_missing is OnMissing.ERROR and each.layer in own and "<" not in each.asset_path:
            note_missing(each.asset_path, f"{each.where} refers to it: {_why(each)}")
        else:
            unopened.setdefault(each.asset_path, []).append(each)
    for asset, (first, *others) in unopened.items():
        where = f"{first.where} and {errors.counted(len(others), 'other')} refer" if others else f"{first.where} refers"
        errors.warn_once(
            f"{where} to {asset}, which cannot be opened: {_why(first)}", key=f"{first.where} refers to {asset}"
        )
    for message in (*dependencies.cycles(stage), *LostVariants.messages(stage)):
        errors.warn_once(message)
    raise_missing()


def _why(each: dependencies.MissingDependency) -> str:
    """Return why a reference does not open."""
    if each.asset_path.split("<")[0].endswith(_MATERIAL_X):
        return _NEEDS_PLUGIN
    pointer = not_a_file_of_its_own(each.asset_path)
    return f"it {pointer}." if pointer else each.why


def raise_missing() -> None:
    """Raise an error that lists the missing assets, if there are any.

    Raises:
        MissingAssets: as it says.
    """
    if _missing:
        raise MissingAssets(listed(missing_assets()))


def listed(missing: list[MissingAsset]) -> str:
    """Return the message of an error for all missing assets: one paragraph each, then the remedy."""
    count = f"{len(missing)} assets are" if len(missing) > 1 else "an asset is"
    lines = [f"  {each.asset}{f' ({each.line})' if each.line else ''}\n      {each.why}" for each in missing]
    return "\n".join([f"{count} missing:", *lines, f"{_PLACES}{_WITHOUT if _is_chosen else _AS_THEN}"])


_PLACES = "Say where they are with --map PREFIX=FOLDER or --assets-root"
_WITHOUT = (
    ", or run without them: --missing-assets stand-in puts labeled boxes in their place, --missing-assets skip nothing."
)
_AS_THEN = "; without them, frames would be others than the run has made."

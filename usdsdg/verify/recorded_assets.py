"""The assets of a recorded stage on this machine, which may not be the one that recorded it."""

from __future__ import annotations

from collections import defaultdict
from contextlib import suppress
from functools import cache
from pathlib import Path

from pxr import Ar, Sdf, UsdUtils

from usdsdg.errors import AssetNotFound, DatasetError, UsdsdgError
from usdsdg.stage import assets
from usdsdg.stage.assets import anchors
from usdsdg.stores.whole_file import facts_of
from usdsdg.writers.journal import recipe

_REMEDY = (
    "Give the assets root with --assets-root, or go to the folder in which the dataset was made, where scripts name "
    "files from there."
)


class RecordedAssets:
    """Finds what the stages of a dataset refer to, and holds it against the hashes of the recipe."""

    def __init__(self, folder: Path) -> None:
        """folder: that of the dataset."""
        self._parents = [str(each) for each in folder.absolute().parents]
        values = None
        with suppress(UsdsdgError):  # other checks name a damaged one
            values = recipe.read(folder)
        self._hashes = hashes_of(values)
        self._hash = cache(_hash)

    def here(self, content: bytes, name: str) -> bytes:
        """Return the text of a layer of a record, with the paths of this machine.

        name: of the layer, for errors.

        Raises:
            AssetNotFound: the dataset was made with a file that is not on this machine. DatasetError: it is another
                here, or the text is damaged.
        """
        if not any(each.encode() in content for each in anchors.NAMES):
            return content
        layer = Sdf.Layer.CreateAnonymous(name)
        if not layer.ImportFromString(content.decode()):
            raise DatasetError(f"{name} is no text of USD")
        problems: list[UsdsdgError] = []

        def found(path: str) -> str:
            try:
                return self._file_of(path) if anchors.is_portable(path) else path
            except UsdsdgError as error:
                problems.append(error)
                return path

        UsdUtils.ModifyAssetPaths(layer, found)
        if problems:
            raise problems[0]
        return layer.ExportToString().encode()

    def changed(self) -> list[str]:
        """Return the names of assets that this machine's assets root has with other content than the dataset's."""
        changed = []
        for name, hashes in self._hashes.items():
            file = Path(anchors.candidates(f"{anchors.ASSETS}{name}", ())[0]) if name.startswith("/") else None
            if file is not None and file.is_file() and self._hash(str(file)) not in hashes:
                changed.append(name)
        return changed

    def _file_of(self, path: str) -> str:
        outer = Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path
        at_root = outer.startswith(f"{anchors.ASSETS}/")
        hashes = self._hashes.get(outer.removeprefix(anchors.ASSETS) if at_root else Path(outer).name)
        possible = anchors.candidates(path, self._parents)
        there = [file for each in possible if (file := assets.locate_or_none(each)) is not None]
        if hashes is None:  # it was missing when the dataset was made, or there is no recipe
            return (there or possible)[0]
        for file in there:
            outer = Ar.SplitPackageRelativePathOuter(file)[0] if Ar.IsPackageRelativePath(file) else file
            if self._hash(outer) in hashes:
                return file
        if there:
            raise DatasetError(f"{there[0]} is another file than that of the dataset, {path}. {_REMEDY}")
        raise AssetNotFound(f"{path} is not on this machine. {_REMEDY}")


def hashes_of(values: dict | None) -> dict[str, set[str]]:
    """Return the SHA-256 of each asset of a recipe, by its name; files outside of the root may share one."""
    found: dict[str, set[str]] = defaultdict(set)
    listed = (values or {}).get("assets")
    for each in listed if isinstance(listed, list) else ():
        if isinstance(each, dict) and isinstance(each.get("name"), str):
            found[each["name"]].add(str(each.get("sha256")))
    return dict(found)


def _hash(file: str) -> str:
    try:
        return facts_of(Path(file))[1]
    except OSError:
        return ""

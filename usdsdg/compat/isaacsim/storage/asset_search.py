"""Files below a folder of assets, and what USD files refer to."""

from __future__ import annotations

import asyncio
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from pxr import Sdf, Usd, UsdUtils

from usdsdg.compat.isaacsim.storage.asset_paths import (
    is_absolute_path,
    is_path_external,
    is_valid_usd_file,
    path_join,
)
from usdsdg.compat.omni import client
from usdsdg.errors import warn_once
from usdsdg.session.stage_context import assets_root
from usdsdg.stage import assets


# --- files ---
async def path_exists(path: str) -> bool:
    """Return whether there is a file or a folder at a path or URL."""
    return _exists(path)


def find_files_recursive(
    abs_path: Iterable[str] | str, filter_fn: Callable[[str], bool] = lambda name: True
) -> list[str]:
    """Return the files below folders whose name `filter_fn` accepts; a path without entries has none."""
    folders = [abs_path] if isinstance(abs_path, str) else abs_path
    return [path for folder in folders for path, name in _files_below(folder, None) if filter_fn(name)]


def find_filtered_files(
    abs_paths: Iterable[str],
    max_depth: int | None = None,
    filepath_excludes: Iterable[str] | None = None,
    filter_patterns: Iterable[str] | None = None,
    match_all: bool = False,
) -> set[str]:
    """Return the USD files at and below paths or URLs.

    Args:
        abs_paths: Folders, or files themselves.
        max_depth: How many folders deep to look: 0 is the folder itself, None has no end.
        filepath_excludes: Texts that a path must not hold.
        filter_patterns: Regular expressions, which are searched for in the whole path.
        match_all: Whether all of them are to be found, and not any.

    A warning names paths at which there is nothing, and patterns that are no regular expressions, which are left out.
    """
    filters, excludes, wanted = list(filter_patterns or ()), list(filepath_excludes or ()), all if match_all else any
    patterns = _compiled(filters)
    found = (path for root in abs_paths for path in _files_at(root, max_depth) if is_valid_usd_file(path, excludes))
    return {path for path in found if not filters or wanted(pattern.search(path) for pattern in patterns)}


async def find_filtered_files_async(
    root_path: str,
    filter_patterns: Iterable[str] | None = None,
    match_all: bool = False,
    filepath_excludes: Iterable[str] | None = None,
    max_depth: int | None = None,
) -> set[str]:
    """Run `find_filtered_files` in a coroutine, for one folder."""
    await asyncio.sleep(0)
    return find_filtered_files([root_path], max_depth, filepath_excludes, filter_patterns, match_all)


def resolve_asset_path(original_path: str) -> str | None:
    """Return a path at which there is something: the given one, or that below the assets root; None for neither."""
    below = path_join(assets_root(), original_path.lstrip("/"))
    return next((path for path in (original_path, below) if _exists(path)), None)


async def resolve_asset_path_async(original_path: str) -> str | None:
    """Run `resolve_asset_path` in a coroutine."""
    return resolve_asset_path(original_path)


# --- references ---
def get_stage_references(stage_path: str, resolve_relatives: bool = True) -> list[str]:
    """Return what the layers of a stage refer to, each path once, in order: layers, textures, other assets.

    Paths are as they are written; with `resolve_relatives=False` the files of the layers themselves are returned.

    Raises:
        AssetNotFound: there is no such file.
    """
    layers, _, _ = UsdUtils.ComputeAllDependencies(Sdf.AssetPath(assets.resolve(stage_path)))
    if not resolve_relatives:
        return sorted({layer.realPath or layer.identifier for layer in layers})
    return sorted({path for layer in layers for path in _written_paths(layer)})


async def find_absolute_paths_in_usds(base_path: str) -> dict[str, list[str]]:
    """Return the absolute paths and URLs that USD files below a folder refer to, by file."""
    return _references_below(base_path, get_stage_references, is_absolute_path)


async def find_external_references(base_path: str) -> dict[str, list[str]]:
    """Return the layers of USD files below a folder that are outside of it, by file."""
    return _references_below(
        base_path,
        lambda path: get_stage_references(path, resolve_relatives=False),
        lambda path: is_path_external(path, base_path),
    )


async def count_asset_references(base_path: str) -> dict[str, int]:
    """Return how many USD files below a folder use each file there, themselves included, in ascending order."""
    files = find_files_recursive(base_path)
    counts = Counter(dict.fromkeys(files, 0))
    for path in filter(_is_usd, files):
        layers, others, _ = UsdUtils.ComputeAllDependencies(Sdf.AssetPath(path))
        counts.update(used for used in {*(layer.realPath for layer in layers), *others} if used in counts)
    return dict(sorted(counts.items(), key=lambda item: item[1]))


def layer_has_missing_references(layer_identifier: str) -> bool:
    """Return whether a layer cannot be opened, or one that it refers to, at any depth."""
    waiting, seen = [layer_identifier], set()
    while waiting:
        identifier = waiting.pop()
        if identifier in seen:
            continue
        seen.add(identifier)
        layer = Sdf.Layer.FindOrOpen(identifier)
        if layer is None:
            return True
        waiting += [layer.ComputeAbsolutePath(path) for path in layer.GetCompositionAssetDependencies() if path]
    return False


def prim_spec_has_missing_references(prim_spec: Sdf.PrimSpec) -> bool:
    """Return whether a USD file that a spec references, or one behind it, is missing."""
    items = prim_spec.referenceList.GetAddedOrExplicitItems()
    return any(
        layer_has_missing_references(prim_spec.layer.ComputeAbsolutePath(item.assetPath))
        for item in items
        if item.assetPath and _is_usd(item.assetPath)
    )


def prim_has_missing_references(prim: Usd.Prim) -> bool:
    """Return whether a USD file that a prim references, or one behind it, is missing."""
    return any(map(prim_spec_has_missing_references, prim.GetPrimStack()))


def _compiled(filters: Iterable[str]) -> list[re.Pattern[str]]:
    patterns: list[re.Pattern[str]] = []
    for each in filters:
        try:
            patterns.append(re.compile(each))
        except re.error as error:
            warn_once(f"find_filtered_files: {each!r} is no regular expression, and is left out: {error}")
    return patterns


def _exists(path: str) -> bool:
    return client.stat(path)[0] is client.Result.OK


def _is_usd(path: str) -> bool:
    return is_valid_usd_file(path, ())


def _files_at(path: str, max_depth: int | None) -> Iterator[str]:
    result, entry = client.stat(path)
    if entry is None:
        warn_once(f"find_filtered_files: there is neither a file nor a folder at {path!r}: {result.name}")
    elif entry.flags & client.ItemFlags.CAN_HAVE_CHILDREN:
        yield from (file for file, _ in _files_below(path, max_depth))
    else:
        yield path


def _files_below(folder: str, max_depth: int | None) -> Iterator[tuple[str, str]]:
    """Yield paths of files and their names, those of a folder before those of the folders in it."""
    folders: list[str] = []
    for entry in client.list(folder)[1]:
        path = path_join(folder, entry.relative_path)
        if entry.flags & client.ItemFlags.CAN_HAVE_CHILDREN:
            folders.append(path)
        else:
            yield path, entry.relative_path
    if max_depth != 0:
        for each in folders:
            yield from _files_below(each, None if max_depth is None else max_depth - 1)


def _written_paths(layer: Sdf.Layer) -> list[str]:
    """Return the asset paths of a layer; it is a copy that is walked through, since the walk would write."""
    paths: list[str] = []
    copy = Sdf.Layer.CreateAnonymous()
    copy.TransferContent(layer)
    UsdUtils.ModifyAssetPaths(copy, lambda path: paths.append(path) or path)
    return paths


def _references_below(
    base_path: str, references: Callable[[str], list[str]], accepted: Callable[[str], bool]
) -> dict[str, list[str]]:
    found = {path: list(filter(accepted, references(path))) for path in find_files_recursive(base_path, _is_usd)}
    return {path: paths for path, paths in found.items() if paths}

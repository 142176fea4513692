"""Asset URLs to files: one assets root, and what to say when a file is not there."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

from pxr import Ar, Usd

from usdsdg import errors

ROOT_VARIABLE = "USDSDG_ASSETS_ROOT"

# Folders at the top of an assets root; a URL of another asset server is cut at one of these.
TOP_FOLDERS = ("Isaac", "NVIDIA")

_HOW_TO_SET = f"Set another root with --assets-root or {ROOT_VARIABLE}."

_root: str | None = None
_fallback: Callable[[], str | os.PathLike[str]] | None = None


class MissingDependency(NamedTuple):
    """A reference, payload or sublayer of an open stage that does not resolve."""

    where: str  # prim path, or identifier of the layer that lists the sublayer
    asset_path: str
    why: str  # what USD said


def assets_root() -> str:
    """Folder that holds `Isaac` and `NVIDIA`: the one set, else the environment's, else the stand-ins.

    Raises:
        AssetNotFound: the folder does not exist, or there is neither a root nor a built-in one.
    """
    configured = _root or os.environ.get(ROOT_VARIABLE)
    if configured:
        folder = Path(configured).expanduser().absolute()
        if not folder.is_dir():
            raise errors.AssetNotFound(f"the assets root {folder} is not a folder. {_HOW_TO_SET}")
        return str(folder)
    if _fallback is None:
        raise errors.AssetNotFound(f"no assets root is set. Set one with --assets-root or {ROOT_VARIABLE}.")
    folder = str(_fallback())
    errors.warn_once(
        f"no assets root is set: simple stand-ins made by code, in {folder}, replace the real assets. "
        f"{_HOW_TO_SET}",
        key="assets.fallback",
    )
    return folder


def set_assets_root(path: str | os.PathLike[str] | None) -> None:
    """Use `path` as the assets root; None goes back to the environment or the built-in stand-ins."""
    global _root
    _root = None if path is None else os.fspath(path)


def set_fallback_root(make: Callable[[], str | os.PathLike[str]] | None) -> None:
    """Register who provides the stand-in assets when no root is set; called once one is needed."""
    global _fallback
    _fallback = make


def resolve(url: str | os.PathLike[str]) -> str:
    """Absolute path of the file that `url` means.

    An existing absolute path is itself. `/Isaac/...`, `/NVIDIA/...` and paths relative to neither the working
    folder are looked up under the assets root, and so is the part of an `omniverse://` or `http(s)://` URL
    from `/Isaac` or `/NVIDIA` on.

    Raises:
        AssetNotFound: no such file; names the root and similar names.
        AssetError: an `omniverse://` URL that is not mirrored under the root.
        Unsupported: an `http(s)://` URL that is not mirrored under the root.
    """
    text = os.fspath(url).strip()
    if not text:
        raise errors.AssetNotFound("an empty string was given as the URL of an asset")
    scheme = text.split("://", 1)[0].lower() if "://" in text else ""
    if scheme and scheme != "file":
        return _resolve_remote(text, scheme)
    path = unquote(urlsplit(text).path) if scheme else os.path.expanduser(text)
    if _exists(os.path.abspath(path)):
        return os.path.abspath(path)
    if not os.path.isabs(path) or path.lstrip("/").split("/", 1)[0] in TOP_FOLDERS:
        path = os.path.join(assets_root(), path.lstrip("/"))
        if _exists(path):
            return path
    raise errors.AssetNotFound(_not_found(text, path))


def missing_dependencies(stage: Usd.Stage) -> list[MissingDependency]:
    """Every reference, payload and sublayer in use that USD could not open, in the order USD met them."""
    found = dict.fromkeys(_read_error(str(error)) for error in stage.GetCompositionErrors())
    return [dependency for dependency in found if dependency is not None]


def _resolve_remote(url: str, scheme: str) -> str:
    for mirrored in _mirrored(urlsplit(url).path):
        if _exists(mirrored):
            return mirrored
    remedy = f"Copy it under the assets root ({assets_root()}) with the same path from /Isaac or /NVIDIA on."
    if scheme == "omniverse":
        raise errors.AssetError(f"{url} lies on an Omniverse server, which usdsdg does not talk to. {remedy}")
    raise errors.Unsupported(f"{url} is remote, and usdsdg reads local files only. {remedy}")


def _mirrored(path: str) -> Iterator[str]:
    """Where a remote file would lie under the root. A server's own folders may be called Isaac too."""
    for top in re.finditer(f"/({'|'.join(TOP_FOLDERS)})(?=/)", unquote(path)):
        yield os.path.join(assets_root(), unquote(path)[top.start() + 1 :])


def _exists(path: str) -> bool:
    file = Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path
    return os.path.exists(file)


def _not_found(url: str, path: str) -> str:
    root = _root or os.environ.get(ROOT_VARIABLE) or "none set"
    folder = Path(path).parent
    while not folder.is_dir():
        folder = folder.parent
    missing = Path(path).relative_to(folder).parts[0]
    names = sorted(entry.name for entry in folder.iterdir() if not entry.name.startswith("."))
    near = difflib.get_close_matches(missing, names, n=4, cutoff=0.5)
    hint = (
        f"similar names there: {', '.join(near)}"
        if near
        else f"{folder} has {', '.join(names[:8]) or 'nothing'}"
    )
    return f"no file for {url}: {folder} has no {missing} (assets root: {root}); {hint}. {_HOW_TO_SET}"


def _read_error(text: str) -> MissingDependency | None:
    """USD gives composition errors as sentences only: ... @asset@ ... @layer@<prim>."""
    if not re.search(r"Could not (open asset|load sublayer)|Unresolved .* prim path", text):
        return None
    assets = re.findall(r"@([^@]*)@(?:<([^>]*)>)?", text)
    asset_path = assets[0][0] + (f"<{assets[0][1]}>" if assets[0][1] else "")
    layer, prim = assets[-1]
    return MissingDependency(prim or layer, asset_path, text.strip())

"""Resolution of asset URLs to files below an assets root, with errors that name what is missing."""

import difflib
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

from pxr import Ar, Pcp, Usd

from usdsdg import errors

ROOT_VARIABLE = "USDSDG_ASSETS_ROOT"

# Folders at the top of an assets root; of the URL of an asset server, the part from one of these on is used.
TOP_FOLDERS = ("Isaac", "NVIDIA")

_HOW_TO_SET = (
    f"Set the root with {ROOT_VARIABLE}, with --assets-root on the command line, "
    "or in Python with usdsdg.stage.assets.set_assets_root(folder)."
)

_ABSOLUTE_PATHS = (
    f"Of absolute paths, those under /{' and /'.join(TOP_FOLDERS)} are looked up under the assets root as well."
)

_RELATIVE_PATHS = f"Relative paths are looked up under the assets root as well; {ROOT_VARIABLE} sets none."

_UNRESOLVED = (Pcp.ErrorInvalidAssetPath, Pcp.ErrorInvalidSublayerPath, Pcp.ErrorUnresolvedPrimPath)

_root: str | None = None
_fallback: Callable[[], str | os.PathLike[str]] | None = None


class MissingDependency(NamedTuple):
    """A reference, payload or sublayer of an open stage that does not resolve."""

    where: str  # prim path, or identifier of the layer that lists the sublayer
    asset_path: str
    why: str  # USD's message


def assets_root() -> str:
    """Return the folder that holds `Isaac` and `NVIDIA`: the one set, else the environment's, else the stand-ins.

    Raises:
        AssetNotFound: the folder does not exist, or neither a root nor stand-ins are available.
    """
    if configured := _configured_root():
        folder = os.path.abspath(os.path.expanduser(configured))
        if not os.path.isdir(folder):
            raise errors.AssetNotFound(f"the assets root {folder} is not a folder. {_HOW_TO_SET}")
        return folder
    if _fallback is None:
        raise errors.AssetNotFound(f"no assets root is set. {_HOW_TO_SET}")
    folder = os.fspath(_fallback())
    errors.warn_once(
        f"no assets root is set: simple stand-ins made by code, in {folder}, replace the real assets. {_HOW_TO_SET}",
        key="assets.fallback",
    )
    return folder


def set_assets_root(path: str | os.PathLike[str] | None) -> None:
    """Set the assets root; None returns to the environment variable or the built-in stand-ins."""
    global _root
    _root = None if path is None else os.fspath(path)


def set_fallback_root(make: Callable[[], str | os.PathLike[str]] | None) -> None:
    """Register the function that makes stand-in assets and returns their folder; called if no root is set."""
    global _fallback
    _fallback = make


def resolve(url: str | os.PathLike[str]) -> str:
    """Return the absolute path of the file that a URL or path refers to.

    An existing file is returned as it is. `/Isaac/...`, `/NVIDIA/...` and relative paths are looked up under the assets
    root, and so is the part of an `omniverse://` or `http(s)://` URL from `/Isaac` or `/NVIDIA` on.

    Raises:
        AssetNotFound: no such file; names the root and similar names.
        AssetError: an `omniverse://` URL without a copy under the root.
        Unsupported: an `http(s)://` or other URL without a copy under the root.
    """
    text = os.fspath(url).strip()
    if not text:
        raise errors.AssetNotFound("an empty string was given as the URL of an asset")
    scheme = text.split("://", 1)[0].lower() if "://" in text else ""
    if scheme and scheme != "file":
        return _resolve_remote(text, scheme)
    path = unquote(urlsplit(text).path) if scheme else os.path.expanduser(text)
    here = os.path.abspath(path)
    if _exists(here):
        return here
    relative = not os.path.isabs(path)
    if path.lstrip("/").split("/", 1)[0] not in TOP_FOLDERS:
        if not relative:
            raise errors.AssetNotFound(f"no file for {text}: {_missing_part(here)}. {_ABSOLUTE_PATHS}")
        if not _configured_root():
            raise errors.AssetNotFound(f"no file for {text}: {_missing_part(here)}. {_RELATIVE_PATHS}")
    there = os.path.join(assets_root(), path.lstrip("/"))
    if _exists(there):
        return there
    problems = [*([_missing_part(here)] if relative else []), _missing_part(there, listing=True)]
    raise errors.AssetNotFound(f"no file for {text}: {'; '.join(problems)}. Assets root{_known_root()}. {_HOW_TO_SET}")


def missing_dependencies(stage: Usd.Stage) -> list[MissingDependency]:
    """Return all references, payloads and sublayers in use that USD could not open, in composition order."""
    found = {}
    for error in stage.GetCompositionErrors():
        prim = stage.GetPrimAtPath(error.rootSite.path)
        if isinstance(error, _UNRESOLVED) and prim and prim.IsActive():
            why = " ".join(str(error).split())
            found[_parsed(error, why)] = None
    return list(found)


def _resolve_remote(url: str, scheme: str) -> str:
    path = unquote(urlsplit(url).path)
    # A server's own folders may be called Isaac too, so every occurrence is tried.
    for top in re.finditer(f"/({'|'.join(TOP_FOLDERS)})(?=/)", path):
        local = os.path.join(assets_root(), path[top.start() + 1 :])
        if _exists(local):
            return local
    remedy = f"Copy it under the assets root{_known_root()}, with the same path from /Isaac or /NVIDIA on."
    if scheme == "omniverse":
        raise errors.AssetError(f"{url} lies on an Omniverse server, which usdsdg does not talk to. {remedy}")
    raise errors.Unsupported(f"{url} is remote, and usdsdg reads local files only. {remedy}")


def _exists(path: str) -> bool:
    return os.path.exists(Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path)


def _configured_root() -> str | None:
    return _root or os.environ.get(ROOT_VARIABLE)


def _known_root() -> str:
    configured = _configured_root()
    return f" ({configured})" if configured else " (none is set)"


def _missing_part(path: str, *, listing: bool = False) -> str:
    """Describe the deepest existing folder of `path`, with similar names in it or, with `listing`, all names."""
    folder = Path(path).parent
    while not folder.is_dir():
        folder = folder.parent
    missing = Path(path).relative_to(folder).parts[0]
    names = sorted(entry.name for entry in folder.iterdir() if not entry.name.startswith("."))
    near = difflib.get_close_matches(missing, names, n=4, cutoff=0.5)
    others = f" (it has {', '.join(names[:8]) or 'nothing'})" if listing else ""
    hint = f" (did you mean {' or '.join(near)}?)" if near else others
    return f"{folder} has no {missing}{hint}"


def _parsed(error: Pcp.ErrorBase, why: str) -> MissingDependency:
    """Parse a composition error, whose paths pxr gives as text only: ... @asset@<prim> ... @layer@."""
    mentioned = re.findall(r"@([^@]+)@(?:<([^>]*)>)?", why)
    asset_path, prim = mentioned[0]
    where = mentioned[-1][0] if isinstance(error, Pcp.ErrorInvalidSublayerPath) else str(error.rootSite.path)
    return MissingDependency(where, f"{asset_path}<{prim}>" if prim else asset_path, why)

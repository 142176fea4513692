"""Look-up of an asset: from its URL or path to the file on this machine, with errors that name what is missing."""

import contextlib
import difflib
import os
from pathlib import Path
from urllib.parse import unquote, urlsplit

from pxr import Ar

from usdsdg import errors
from usdsdg.stage.assets import anchors, fetching, maps, root, search_paths, url

_ABSOLUTE_PATHS = (
    f"Of absolute paths, those under /{' and /'.join(url.TOP_FOLDERS)} are looked up under the assets root as well."
)

_RELATIVE_PATHS = f"Relative paths are looked up under the assets root as well; {root.ROOT_VARIABLE} sets none."


def locate(asset: str | os.PathLike[str]) -> str:
    """Return the absolute path of the file that a URL or path refers to.

    What a map stands for comes first. An existing file is returned as it is, also one below a folder `C:` of the
    working folder, where Python's own functions find a path with a drive. Relative paths are looked up in the folders
    of `add_search_path`, then, as `/Isaac/...` and `/NVIDIA/...`, under the assets root, and so is the part of a URL or
    of a path with a drive from `/Isaac` or `/NVIDIA` on. Other URLs of servers and buckets are fetched; see `fetching`.

    Raises:
        AssetNotFound: no such file; names the root and similar names.
        AssetError: an `omniverse://` URL without a copy on this machine.
        AssetError: a URL of a server or bucket that does not answer.
        AssetUnreadable: it is not text of UTF-8.
        Unsupported: an `http(s)://` or other URL without a copy on this machine, which is not fetched.
    """
    text = os.fspath(asset).strip()
    if not text:
        raise errors.AssetNotFound("an empty string was given as the URL of an asset")
    url.check_name(text)
    mapped = maps.candidates(text)
    for candidate in mapped:
        if exists(candidate):
            return candidate
    problems = [missing_part(candidate) for candidate in mapped[:1]]
    if url.has_drive(text) and exists(text):
        return os.path.abspath(text)
    if url.is_remote(text):
        return _locate_remote(text, problems)
    path = unquote(urlsplit(text).path) if url.scheme_of(text) else os.path.expanduser(text)
    return _locate_here(text, path, problems)


def locate_or_none(asset: str | os.PathLike[str]) -> str | None:
    """As `locate`, but return None where there is no such file on this machine, or none that is read."""
    with contextlib.suppress(errors.AssetError, errors.Unsupported):
        return locate(asset)
    return None


def _locate_here(text: str, path: str, problems: list[str]) -> str:
    here, relative = os.path.abspath(path), not os.path.isabs(path)
    if exists(here) or _mirrored(here):
        if relative:
            anchors.note_working_folder()
        elif text.startswith("~"):
            anchors.note_home()
        return here
    for candidate in search_paths.candidates(path) if relative else ():
        if exists(candidate):
            return candidate
    if path.lstrip("/").split("/", 1)[0] not in url.TOP_FOLDERS:
        if not relative:
            raise _not_found(text, [*problems, missing_part(here)], _ABSOLUTE_PATHS)
        if not root.configured_root():
            raise _not_found(text, [*problems, missing_part(here)], _RELATIVE_PATHS)
    there = os.path.join(root.assets_root(), path.lstrip("/"))
    if exists(there) or _mirrored(there):
        return there
    problems = [*problems, *([missing_part(here)] if relative else []), _missing_in_root(there)]
    raise _not_found(text, problems, f"Assets root{_known_root()}. {root.HOW_TO_SET}")


def _not_found(text: str, problems: list[str], remedy: str) -> errors.AssetNotFound:
    error = errors.AssetNotFound(f"no file for {text}: {'; '.join(problems)}. {remedy}")
    error.looked_for = problems
    return error


def _locate_remote(text: str, mapped: list[str]) -> str:
    problems = mapped
    for path in paths_under_root(text):
        local = os.path.join(root.assets_root(), path)
        if exists(local) or _mirrored(local):
            return local
        problems = [*problems, _missing_in_root(local)]
    if not mapped and (local := fetching.fetched(text)):
        return local
    error = _not_here(text, f" ({'; '.join(problems)})" if problems else "")
    error.looked_for = problems or ["no map names it, and it has no /Isaac or /NVIDIA to look up under the assets root"]
    raise error


def _not_here(text: str, looked: str) -> errors.AssetError | errors.Unsupported:
    remedy = (
        f"Copy it under the assets root{_known_root()}, with the same path from /Isaac or /NVIDIA on, "
        f"or map its folder with {maps.how_to_map()}."
    )
    scheme = url.scheme_of(text)
    if scheme == "omniverse":
        return errors.AssetError(f"{text} lies on an Omniverse server, which usdsdg does not talk to{looked}. {remedy}")
    if not scheme:
        return errors.AssetNotFound(f"no file for {text}, which names a drive of another machine{looked}. {remedy}")
    return errors.Unsupported(f"{text} is remote, and usdsdg reads local files only{looked}. {remedy}")


def paths_under_root(text: str) -> list[str]:
    """Return where a remote asset may be under the assets root, as relative paths, most likely first."""
    whole, mirror = url.normalized(text), root.root_mirror()
    path = url.path_of(whole) if url.scheme_of(whole) else whole[2:]
    found = url.below_top_folders(path)
    if mirror and whole.startswith(base := url.normalized(mirror.url) + "/"):
        found.insert(0, unquote(whole[len(base) :].partition("?")[0]))
    return list(dict.fromkeys(found))


def _mirrored(path: str) -> bool:
    """Whether a path is in the mirror of the assets root and its file has come now."""
    mirror = root.root_mirror()
    if mirror is None or not path.startswith(mirror.folder + os.sep):
        return False
    outer = Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path
    return mirror.fetch(os.path.relpath(outer, mirror.folder).replace(os.sep, "/"))


def exists(path: str) -> bool:
    """Whether there is a file or folder, of a file in a .usdz whether there is the package."""
    return os.path.exists(Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path)


def _known_root() -> str:
    configured = root.configured_root()
    return f" ({configured})" if configured else " (none is set)"


def _missing_in_root(path: str) -> str:
    if mirror := root.root_mirror():
        return f"{mirror.url} has no {os.path.relpath(path, mirror.folder)}"
    return missing_part(path, listing=True)


def missing_part(path: str, *, listing: bool = False) -> str:
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

"""`omni.client`: files and folders by URL or path; those of this machine, of the assets root, and of what is mapped."""

from __future__ import annotations

import enum
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import ParamSpec, TypeVar
from urllib.parse import urljoin, urlsplit

from usdsdg.errors import AssetError, AssetNotFound, Unsupported
from usdsdg.stage import assets

P = ParamSpec("P")
T = TypeVar("T")


class Result(enum.Enum):
    """How a call ended."""

    OK = 0
    OK_LATEST = 1
    OK_NOT_YET_FOUND = 2
    ERROR = 3
    ERROR_CONNECTION = 4
    ERROR_NOT_SUPPORTED = 5
    ERROR_ACCESS_DENIED = 6
    ERROR_NOT_FOUND = 7
    ERROR_ALREADY_EXISTS = 8
    ERROR_SOURCE_NOT_FOUND = 9
    ERROR_FOLDER_NOT_EMPTY = 10


class ItemFlags(enum.IntFlag):
    """What an entry is and what can be done with it."""

    READABLE_FILE = 1
    WRITEABLE_FILE = 2
    CAN_HAVE_CHILDREN = 4
    DOES_NOT_HAVE_CHILDREN = 8
    IS_MOUNT = 16


class AccessFlags(enum.IntFlag):
    """What a user may do with an entry."""

    READ = 1
    WRITE = 2
    ADMIN = 4


class CopyBehavior(enum.Enum):
    """What a copy does where the destination exists."""

    ERROR_IF_EXISTS = 0
    OVERWRITE = 1


@dataclass(frozen=True)
class ListEntry:
    """An entry of a folder; `relative_path` is its name there, "" for `stat`."""

    relative_path: str
    flags: ItemFlags
    access: AccessFlags
    size: int  # bytes; 0 of a folder
    modified_time: datetime
    created_time: datetime
    version: str = ""
    hash: str = ""
    created_by: str = ""
    modified_by: str = ""


def list(url: str) -> tuple[Result, tuple[ListEntry, ...]]:
    """Return the entries of a folder, sorted by name."""
    result, folder = _located(url)
    if folder is None:
        return result, ()
    if not os.path.isdir(folder):
        return Result.ERROR_NOT_SUPPORTED, ()
    return Result.OK, tuple(_entry(each, each.name) for each in sorted(Path(folder).iterdir()))


def stat(url: str) -> tuple[Result, ListEntry | None]:
    """Return the entry of a file or folder; None where there is none."""
    result, path = _located(url)
    return (result, None) if path is None else (Result.OK, _entry(Path(path), ""))


def read_file(url: str) -> tuple[Result, str, memoryview]:
    """Return the result, the version (always empty) and the bytes of a file."""
    result, path = _located(url)
    if path is None:
        return result, "", memoryview(b"")
    if not os.path.isfile(path):
        return Result.ERROR_NOT_SUPPORTED, "", memoryview(b"")
    return Result.OK, "", memoryview(Path(path).read_bytes())


def write_file(url: str, content: bytes | memoryview, message: str = "") -> Result:
    """Write a file of this machine, and the folders it needs.

    Raises:
        Unsupported: the URL is not of this machine.
    """
    file = _here(url)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(bytes(content))
    except PermissionError:
        return Result.ERROR_ACCESS_DENIED
    return Result.OK


def create_folder(url: str) -> Result:
    """Make a folder of this machine, and its parents.

    Raises:
        Unsupported: the URL is not of this machine.
    """
    folder = _here(url)
    if folder.exists():
        return Result.ERROR_ALREADY_EXISTS
    try:
        folder.mkdir(parents=True)
    except PermissionError:
        return Result.ERROR_ACCESS_DENIED
    return Result.OK


def copy(
    src_url: str, dst_url: str, behavior: CopyBehavior = CopyBehavior.ERROR_IF_EXISTS, message: str = ""
) -> Result:
    """Copy a file or folder to this machine.

    Raises:
        Unsupported: the destination is not of this machine.
    """
    result, source = _located(src_url)
    if source is None:
        return Result.ERROR_SOURCE_NOT_FOUND if result is Result.ERROR_NOT_FOUND else result
    target = _here(dst_url)
    if target.exists() and behavior is not CopyBehavior.OVERWRITE:
        return Result.ERROR_ALREADY_EXISTS
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if os.path.isdir(source):
            shutil.copytree(source, target, dirs_exist_ok=True)
        else:
            shutil.copyfile(source, target)
    except PermissionError:
        return Result.ERROR_ACCESS_DENIED
    return Result.OK


def delete(url: str) -> Result:
    """Delete a file, or a folder with all that is in it, of this machine.

    Raises:
        Unsupported: the URL is not of this machine.
    """
    path = _here(url)
    if not path.exists():
        return Result.ERROR_NOT_FOUND
    try:
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    except PermissionError:
        return Result.ERROR_ACCESS_DENIED
    return Result.OK


def get_local_file(url: str, download: bool = True) -> tuple[Result, str]:
    """Return the path of a file on this machine, "" where there is none."""
    result, path = _located(url)
    return result, path or ""


def combine_urls(base_url: str, relative_url: str) -> str:
    """Return a URL or path relative to the folder of another."""
    if urlsplit(base_url).scheme:
        return urljoin(base_url, relative_url)
    return os.path.normpath(os.path.join(os.path.dirname(base_url), relative_url)).replace("\\", "/")


@dataclass(frozen=True)
class Url:
    """The parts of a URL; None for those that it has not."""

    scheme: str | None = None
    user: str | None = None
    host: str | None = None
    port: str | None = None
    path: str | None = None
    query: str | None = None
    fragment: str | None = None
    is_raw: bool = False


def break_url(url: str) -> Url:
    """Return the parts of a URL, of a path the path alone."""
    parts = urlsplit(url.replace("\\", "/"))
    if len(parts.scheme) < 2:  # "" or the letter of a drive
        return Url(path=url or None)
    user, _, place = parts.netloc.rpartition("@")
    host, _, port = place.partition(":") if not place.startswith("[") else (place, "", "")
    return Url(
        parts.scheme, user or None, host or None, port or None, parts.path or None, parts.query or None,
        parts.fragment or None,
    )  # fmt: skip


def make_url(
    scheme: str | None = None,
    user: str | None = None,
    host: str | None = None,
    port: str | None = None,
    path: str | None = None,
    query: str | None = None,
    fragment: str | None = None,
) -> str:
    """Return the URL of parts, or a path, as `break_url` takes them apart."""
    start = f"{scheme}://" if scheme else ""
    place = f"{f'{user}@' if user else ''}{host or ''}{f':{port}' if port else ''}"
    separator = "/" if place and path and not path.startswith("/") else ""
    return f"{start}{place}{separator}{path or ''}{f'?{query}' if query else ''}{f'#{fragment}' if fragment else ''}"


def make_file_url_if_possible(path: str) -> str:
    """Return the file:// URL of an absolute path, a URL as it is."""
    return Path(path).as_uri() if os.path.isabs(path) else path


def normalize_url(url: str) -> str:
    """Return a URL or path without "." and "..", with forward slashes."""
    scheme, separator, path = url.replace("\\", "/").rpartition("://")
    return scheme + separator + os.path.normpath(path).replace("\\", "/")


def add_default_search_path(search_path: str) -> None:
    """Look for relative paths in this folder too, also for those that stages refer to."""
    assets.add_search_path(search_path)


def remove_default_search_path(search_path: str) -> None:
    """Take a folder back that was added."""
    assets.remove_search_path(search_path)


def initialize(version: int = 0) -> bool:
    """Return True: there is no server to connect to."""
    return True


def shutdown() -> None:
    """Do nothing: there is no connection to end."""


def set_hang_detection_time_ms(time: int) -> None:
    """Do nothing: no call waits for a server."""


def _awaited(call: Callable[P, T]) -> Callable[P, T]:
    async def wait(*args: P.args, **kwargs: P.kwargs) -> T:
        return call(*args, **kwargs)

    wait.__name__, wait.__doc__ = f"{call.__name__}_async", call.__doc__
    return wait  # type: ignore[return-value]


list_async, stat_async = _awaited(list), _awaited(stat)
read_file_async, write_file_async = _awaited(read_file), _awaited(write_file)
copy_async, create_folder_async, delete_async = _awaited(copy), _awaited(create_folder), _awaited(delete)


def _located(url: str) -> tuple[Result, str | None]:
    """Return the path of an existing file or folder, or None with the reason."""
    try:
        return Result.OK, assets.locate(url)
    except AssetNotFound:
        return Result.ERROR_NOT_FOUND, None
    except (AssetError, Unsupported):
        # A server, of which there is no copy on this machine.
        return Result.ERROR_CONNECTION, None


def _here(url: str) -> Path:
    """Return the path that is written to."""
    if assets.is_remote(url):
        raise Unsupported(f"omni.client: {url} is not on this machine; write to a path, or to a file:// URL")
    return Path(urlsplit(url).path if assets.scheme_of(url) else url)


def _entry(path: Path, name: str) -> ListEntry:
    found = path.stat()
    writable = os.access(path, os.W_OK)
    if path.is_dir():
        flags = ItemFlags.CAN_HAVE_CHILDREN
    else:
        flags = ItemFlags.READABLE_FILE | ItemFlags.DOES_NOT_HAVE_CHILDREN
        flags |= ItemFlags.WRITEABLE_FILE if writable else ItemFlags(0)
    return ListEntry(
        name,
        flags,
        AccessFlags.READ | AccessFlags.WRITE if writable else AccessFlags.READ,
        0 if path.is_dir() else found.st_size,
        datetime.fromtimestamp(found.st_mtime),
        datetime.fromtimestamp(found.st_ctime),
    )

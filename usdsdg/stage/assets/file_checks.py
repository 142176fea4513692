"""Checks of files before they are read: that they are files, and that packages are as they were made."""

from __future__ import annotations

import os
import stat
import struct
import zipfile
from functools import lru_cache

import numpy as np
from pxr import Sdf

from usdsdg.errors import AssetUnreadable

PACKAGE = ".usdz"
_CRATES, _CRATE = (".usd", ".usdc"), b"PXR-USDC"
_TEXT = b"#usda"
_LAYERS = (".usd", ".usda", ".usdc")
_TEXTS, _DEEPEST = (".usd", ".usda"), 4000
_POINTER = b"version https://git-lfs"
_ONLY_POINTS = "only points to a file in Git LFS; get the file itself with git lfs pull"


def check_regular(path: str) -> None:
    """Refuse what never ends or never begins, such as devices and pipes; a file that is missing passes.

    Raises:
        AssetUnreadable: it is no file.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise AssetUnreadable(f"{path} is a device, pipe or socket, not a file, and is not read")


def check_file(path: str) -> None:
    """Check a file of USD: that it is one; of a package that its checksums hold, of a crate that it has all sections.

    Raises:
        AssetUnreadable: it is not.
    """
    check_regular(path)
    try:
        _check_content(path)
    except OSError as error:  # this user may not read it, or the disk cannot
        raise AssetUnreadable(f"{path} cannot be read: {error.strerror or error}") from error


def _check_content(path: str) -> None:
    if path.lower().endswith(PACKAGE) and os.path.isfile(path):
        if why := not_a_file_of_its_own(path):
            raise AssetUnreadable(f"{path} {why}")
        if said := _damage(path, *version_of(path)):
            raise AssetUnreadable(f"{path} is damaged: {said}. Copy or export it again.")
    elif path.lower().endswith(_CRATES) and os.path.isfile(path) and not _has_contents(path):
        raise AssetUnreadable(f"{path} cannot be opened as USD: its table of contents is damaged or cut off")
    elif path.lower().endswith(_TEXTS) and os.path.isfile(path):
        _check_nesting(path)


def not_a_file_of_its_own(file: str | os.PathLike[str]) -> str:
    """Return why a file holds nothing: it is empty, or a pointer of Git LFS; "" for others and those in a package."""
    try:
        with open(file, "rb") as stream:
            start = stream.read(len(_POINTER))
    except OSError:
        return ""
    if not start:
        return "is an empty file"
    return _ONLY_POINTS if start == _POINTER else ""


def why_no_layer(path: str) -> str:
    """Return why USD opens a file as no layer, where it tells no reason itself."""
    if not path.lower().endswith(PACKAGE):
        with open(path, "rb") as file:
            return _why_no_usd(file.read(len(_POINTER)))
    with zipfile.ZipFile(path) as package:
        first = next(iter(package.namelist()), None)
        if first is None:
            return "it is a package without files"
        if not first.lower().endswith(_LAYERS):
            return f"it is a package of which the first file, {first}, is no USD file"
        with package.open(first) as file:
            return f"{first} in it is no layer: {_why_no_usd(file.read(len(_POINTER)))}"


def _why_no_usd(start: bytes) -> str:
    """Return why a file that begins so is no USD file."""
    if not start:
        return "it is empty"
    if start.startswith((_CRATE, _TEXT)):
        return "it is cut off"
    if start == _POINTER:
        return f"it {_ONLY_POINTS}"
    return f"it is no USD file, which begins with {_TEXT.decode()} or {_CRATE.decode()}"


def check_neighbors(layer: Sdf.Layer) -> None:
    """Check the files that a layer names itself: its sublayers, references and payloads, before USD opens them.

    Raises:
        AssetUnreadable: as `check_file`.
    """
    for each in layer.GetCompositionAssetDependencies():
        check_file(layer.ComputeAbsolutePath(each) if each else "")


def version_of(path: str) -> tuple[int, int]:
    """Return what tells versions of a file apart, so that each is read once.

    Raises:
        OSError: there is no such file.
    """
    status = os.stat(path)
    return status.st_mtime_ns, status.st_size


def _check_nesting(path: str) -> None:
    if (depth := _nesting(path, *version_of(path))) > _DEEPEST:
        raise AssetUnreadable(
            f"{path} has prims {depth} deep in each other, at which USD's reader does not end or ends the process; "
            f"{_DEEPEST} are read"
        )


@lru_cache(maxsize=4096)
def _nesting(path: str, modified: int, size: int) -> int:
    """Return how deep the braces of a text are in each other, at most; those in strings count, too."""
    with open(path, "rb") as file:
        if size <= _DEEPEST or (start := file.read(len(_CRATE))) == _CRATE:
            return 0
        data = start + file.read()
    if data.count(b"{") <= _DEEPEST:
        return 0
    letters = np.frombuffer(data, np.uint8)
    return int(np.cumsum((letters == ord("{")).astype(np.int32) - (letters == ord("}"))).max())


def _has_contents(path: str) -> bool:
    """Return whether the table of contents of a crate lies in the file, which USD does not ask before it reads it.

    Other files pass. The table is a count, and for each section a name of 16 bytes, its place and its size.
    """
    with open(path, "rb") as file:
        start = file.read(24)
        if not start.startswith(_CRATE) or len(start) < 24:
            return True
        size, (place,) = os.fstat(file.fileno()).st_size, struct.unpack_from("<q", start, 16)
        if not 0 < place <= size - 8:
            return False
        file.seek(place)
        (sections,) = struct.unpack("<Q", file.read(8))
    return sections <= (size - place - 8) // 32


@lru_cache(maxsize=256)
def _damage(path: str, modified: int, size: int) -> str | None:
    """Return what is wrong with a package; None if nothing is."""
    try:
        with zipfile.ZipFile(path) as package:
            if packed := [each.filename for each in package.infolist() if each.compress_type != zipfile.ZIP_STORED]:
                return f"{packed[0]} in it is compressed, which no package is"
            wrong = package.testzip()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError, EOFError, RuntimeError) as error:
        return str(error)
    return f"the checksum of {wrong} in it does not hold" if wrong else None

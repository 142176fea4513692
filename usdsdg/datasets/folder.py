"""A dataset folder: its files, its records and its tables, each read once; what cannot be read is a fault."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

import numpy as np
from PIL import Image

from usdsdg.datasets.attempt import UNLIKE, UNREADABLE, attempt, fault_of
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.listing import files_below
from usdsdg.errors import DatasetError
from usdsdg.record import CLASSES, FRAMES, frame_record
from usdsdg.record.frame_record import FrameRecord
from usdsdg.writers.backends.disk import known_disk_root

T = TypeVar("T")

_THE_FOLDER = "give the folder that a writer wrote to (its output_dir)"

# What JSON has, in the order in which `isinstance` tells them apart.
_JSON = ((dict, "an object"), (list, "an array"), (str, "a text"), (bool, "true or false"), ((int, float), "a number"))


class Folder:
    """The files of a dataset, and what is recorded about them. Paths are relative, with slashes."""

    def __init__(self, path: Path, *, files: list[str] | None = None, recorded: bool = True) -> None:
        """
        files: those of the dataset; default all in the folder.
        recorded: whether to read the records of frames.

        Raises:
            DatasetError: there is no such folder, or this user may not read it.
        """
        check_folder(path)
        self.path = path
        self.faults: list[Fault] = []
        self.in_hand = ""  # the file that was asked for last
        there = [each.as_posix() for each in files_below(path, self._closed)]
        self.files = there if files is None else files
        self.records = self._records() if recorded else []
        self.record_of = {file: record for record in self.records for file in record.files}
        self.classes: dict[str, Any] | None = self._read(CLASSES, "?", _of_classes) if self.has(CLASSES) else None
        self._json = lru_cache(maxsize=64)(self._read_json)

    def has(self, file: str) -> bool:
        """Return whether a file exists."""
        return os.path.isfile(self.path / file)

    def image(self, file: str, frame: str) -> np.ndarray | None:
        """Return an image, (H, W) or (H, W, C); None if it is broken."""
        return self._read(file, frame, lambda data: np.array(Image.open(io.BytesIO(data))))

    def color(self, file: str, frame: str) -> np.ndarray | None:
        """Return a color image, (H, W, 3 or 4); None, and a fault, if it is broken, gray or has a palette."""
        image = self.image(file, frame)
        if image is None or (image.ndim == 3 and image.shape[2] in (3, 4) and image.dtype == np.uint8):
            return image
        self.faults.append(Fault(file, frame, "is no color image", "8-bit RGB or RGBA", f"{image.dtype} {image.shape}"))
        return None

    def image_size(self, file: str, frame: str) -> tuple[int, int] | None:
        """Return width and height of an image without decoding it; None if it is broken."""
        return self._read(file, frame, lambda data: Image.open(io.BytesIO(data)).size)

    def array(self, file: str, frame: str) -> np.ndarray | None:
        """Return the array of a .npy; None if it is broken."""
        return self._read(file, frame, lambda data: np.load(io.BytesIO(data), allow_pickle=False))

    def binary(self, file: str, frame: str, decode: Callable[[bytes], T]) -> T | None:
        """Return what `decode` makes of a file's bytes; None if it is broken."""
        return self._read(file, frame, decode)

    def json(self, file: str, frame: str) -> Any | None:
        """Return the values of a JSON file; None if it is broken."""
        return self._json(file, frame)

    def mapping(self, file: str, frame: str) -> dict[str, Any] | None:
        """Return the object of a JSON file; None, and a fault, if it is broken or another value."""
        return self._of_type(file, frame, dict, "an object")

    def rows(self, file: str, frame: str) -> list[Any] | None:
        """Return the array of a JSON file; None, and a fault, if it is broken or another value."""
        return self._of_type(file, frame, list, "an array")

    def _of_type(self, file: str, frame: str, kind: type[T], expected: str) -> T | None:
        values = self.json(file, frame)
        if values is None or isinstance(values, kind):
            return values
        found = next((word for each, word in _JSON if isinstance(values, each)), "a value of another kind")
        self.faults.append(Fault(file, frame, "is not as its format has it", expected, found))
        return None

    def text(self, file: str, frame: str) -> str | None:
        """Return a text; None if it is broken."""
        return self._read(file, frame, lambda data: data.decode("utf-8"))

    def parsed(self, file: str, frame: str, parse: Callable[[], T]) -> T | None:
        """Return what `parse` makes of a file that was read; None, and a fault, if that is not as it should be."""
        self.in_hand = file
        return attempt(self.faults, file, frame, UNLIKE, parse)

    def opened(self, file: str, frame: str, read: Callable[[Path], T]) -> T | None:
        """Return what `read` makes of a file's path; None, and a fault, if it is broken, missing or no file."""
        self.in_hand = file

        def checked() -> T | None:
            path = self.path / file
            if not os.path.isfile(path) and os.path.exists(path):  # but a device or pipe, which may never end
                self.faults.append(Fault(file, frame, "is no file"))
                return None
            return read(path)

        return attempt(self.faults, file, frame, UNREADABLE, checked)

    def _closed(self, error: OSError) -> None:
        """Note a folder that cannot be listed."""
        file = os.path.relpath(error.filename or self.path, self.path)
        self.faults.append(fault_of(error, file, "all", UNREADABLE))

    def _read_json(self, file: str, frame: str) -> Any | None:
        return self._read(file, frame, _of_json)

    def _read(self, file: str, frame: str, decode: Callable[[bytes], T]) -> T | None:
        return self.opened(file, frame, lambda path: decode(path.read_bytes()))

    def _records(self) -> list[FrameRecord]:
        where = self.path / FRAMES

        def listed() -> list[str]:
            try:
                return os.listdir(where)
            except (FileNotFoundError, NotADirectoryError):  # records are turned off
                return []

        there = attempt(self.faults, FRAMES, "all", UNREADABLE, listed)
        names = sorted(name for name in there or [] if name.endswith(".npz"))
        found = []
        for name in names:
            frame = PurePosixPath(name).stem
            record = self._read(f"{FRAMES}/{name}", frame, frame_record.decode)
            if record is not None:
                found.append(record)
                if frame.rpartition("-")[2] != f"{record.number:06d}":
                    what = "is the record of another frame"
                    self.faults.append(Fault(f"{FRAMES}/{name}", frame, what, "", str(record.number)))
        return found


def _of_json(data: bytes) -> Any:
    """Return the values of JSON text.

    Raises:
        ValueError: it is none, or has nothing.
    """
    values = json.loads(data)
    if values is None:
        raise ValueError("it is null")
    return values


def _of_classes(data: bytes) -> dict[str, Any]:
    """Return the class tables of a dataset.

    Raises:
        ValueError, KeyError, TypeError: they are none.
    """
    values: dict[str, Any] = json.loads(data)
    for table in values["tables"]:
        if not isinstance(table["filter"], (str, type(None))):
            raise ValueError(f"a filter is {table['filter']!r}")
        for row in table["classes"]:
            if not isinstance(row["name"], str) or not isinstance(row["id"], int):
                raise ValueError(f"a class has the name {row['name']!r} and the id {row['id']!r}")
            if not isinstance(row["labels"], Mapping) or [type(each) for each in row["color"]] != [int] * 4:
                raise ValueError(f"a class has the labels {row['labels']!r} and the color {row['color']!r}")
            if not all(0 <= each <= 255 for each in row["color"]):
                raise ValueError(f"a class has the color {row['color']!r}")
    return values


def check_folder(path: Path) -> None:
    """Check that a folder can be listed.

    Raises:
        DatasetError: there is no such folder, or this user may not read it.
    """
    try:
        with os.scandir(path):
            return
    except FileNotFoundError:
        what = f"{path} does not exist; {_where_instead(path)}"
    except NotADirectoryError:
        what = f"{path} is a file; {_THE_FOLDER}"
    except OSError as error:
        what = f"{path} cannot be read: {error.strerror}"
    raise DatasetError(what)


def _where_instead(path: Path) -> str:
    """Return what to give in place of a folder that is not there: scripts write relative ones to a folder of theirs."""
    root = None if path.is_absolute() else known_disk_root()
    return f"did you mean {root / path}?" if root is not None and os.path.isdir(root / path) else _THE_FOLDER

"""A dataset folder: its files, its records and its tables, each read once; what cannot be read is a fault."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

import numpy as np
from PIL import Image

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.listing import files_below
from usdsdg.errors import DatasetError
from usdsdg.record import CLASSES, FRAMES, frame_record
from usdsdg.record.frame_record import FrameRecord

T = TypeVar("T")
_BROKEN = (
    OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, SyntaxError, zipfile.BadZipFile,
    Image.DecompressionBombError,
)  # fmt: skip

# What JSON has, in the order in which `isinstance` tells them apart.
_JSON = ((dict, "an object"), (list, "an array"), (str, "a text"), (bool, "true or false"), ((int, float), "a number"))


class Folder:
    """The files of a dataset, and what is recorded about them. Paths are relative, with slashes."""

    def __init__(self, path: Path, *, files: list[str] | None = None, recorded: bool = True) -> None:
        """
        files: those of the dataset; default all in the folder.
        recorded: whether to read the records of frames.

        Raises:
            DatasetError: there is no such folder.
        """
        if not path.is_dir():
            raise DatasetError(f"{path} is no folder; give the one that a writer wrote to (its output_dir)")
        self.path = path
        self.faults: list[Fault] = []
        self.files = [each.as_posix() for each in files_below(path)] if files is None else files
        self.records = self._records() if recorded else []
        self.record_of = {file: record for record in self.records for file in record.files}
        self.classes: dict[str, Any] | None = self._read(CLASSES, "?", json.loads) if self.has(CLASSES) else None
        self._json = lru_cache(maxsize=64)(self._read_json)

    def has(self, file: str) -> bool:
        """Return whether a file exists."""
        return (self.path / file).is_file()

    def image(self, file: str, frame: str) -> np.ndarray | None:
        """Return an image, (H, W) or (H, W, C); None if it is broken."""
        return self._read(file, frame, lambda data: np.array(Image.open(io.BytesIO(data))))

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
        try:
            return parse()
        except (AttributeError, KeyError, TypeError, ValueError, IndexError, SyntaxError) as error:
            said = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            said = "a value is of another kind" if isinstance(error, AttributeError) else said
            self.faults.append(Fault(file, frame, f"is not as its format has it: {said}"))
            return None

    def _read_json(self, file: str, frame: str) -> Any | None:
        return self._read(file, frame, _of_json)

    def _read(self, file: str, frame: str, decode: Callable[[bytes], T]) -> T | None:
        try:
            path = self.path / file
            if path.exists() and not path.is_file():
                self.faults.append(Fault(file, frame, "is no file"))  # but a device or pipe, which may never end
                return None
            return decode(path.read_bytes())
        except FileNotFoundError:
            self.faults.append(Fault(file, frame, "is missing"))
        except json.JSONDecodeError as error:
            self.faults.append(Fault(file, frame, f"is not valid JSON at line {error.lineno}: {error.msg}"))
        except _BROKEN as error:
            self.faults.append(Fault(file, frame, f"cannot be read: {str(error).splitlines()[0] or type(error)}"))
        return None

    def _records(self) -> list[FrameRecord]:
        where = self.path / FRAMES
        names = sorted(each.name for each in where.glob("*.npz")) if where.is_dir() else []
        found = []
        for name in names:
            frame = PurePosixPath(name).stem
            record = self._read(f"{FRAMES}/{name}", frame, frame_record.decode)
            if record is not None:
                found.append(record)
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

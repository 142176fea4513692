"""Records of the files of a mirror: what was downloaded, and how to tell that it is whole."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from usdsdg.operating_system import process_name


@dataclass(frozen=True)
class Record:
    """A file of a mirror."""

    path: str  # below the root, with forward slashes
    sha256: str
    size: int  # bytes
    etag: str  # of the server; "" if it gave none

    @property
    def blob(self) -> str:
        """The name of its content: the hash, with the file's extension, by which USD knows formats."""
        return f"{self.sha256[:2]}/{self.sha256}{Path(self.path).suffix}"


class Records:
    """The records of one root, one JSON file each."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, path: str) -> Record | None:
        """Return the record of a file; None if it was never downloaded."""
        try:
            return Record(**json.loads(self._file(path).read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            return None

    def put(self, record: Record) -> None:
        """Store a record, atomically."""
        file = self._file(record.path)
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary = file.with_name(f".{file.name}.{process_name()}")
        temporary.write_text(json.dumps(asdict(record)), encoding="utf-8")
        temporary.replace(file)

    def drop(self, path: str) -> None:
        """Forget a file."""
        self._file(path).unlink(missing_ok=True)

    def __iter__(self) -> Iterator[Record]:
        for file in sorted(self._folder.rglob("*.json")):
            path = file.relative_to(self._folder).as_posix().removesuffix(".json")
            if not file.name.startswith(".") and (record := self.get(path)):
                yield record

    def _file(self, path: str) -> Path:
        return self._folder / f"{path}.json"

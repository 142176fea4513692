"""A local copy of the few files of a store that grow or are read as files, such as the journal of a dataset.

Objects cannot be appended to, and are durable when a put returns. So what a store has of a file is one object with its
name, and pieces: `NAME.pieces/9f86d081884c-000000001234` holds what was appended after the first 1,234 bytes to the
version of the object of which the SHA-256 begins with 9f86d081884c ("new" if there is none). Pieces of other versions
are what a process that died did not remove any more.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from usdsdg.errors import StoreError
from usdsdg.stores.store import Store
from usdsdg.stores.temporary import TemporaryFolder

_PIECE = re.compile(r"(.+)\.pieces/(\w+)-(\d+)")
_NEW = "new"
_AT_ONCE = 16  # requests
_ATTEMPTS = 20  # to read files while other processes write them


class Mirror:
    """A local folder with some files of a store."""

    def __init__(self, store: Store, prefix: str, is_kept: Callable[[str], bool], grows: Callable[[str], bool]) -> None:
        """Make an empty folder, which is removed with this object.

        prefix: of the files. is_kept: whether a file, by its path in the store, is among them. grows: whether it is
        appended to.
        """
        self._folder = TemporaryFolder("mirror")
        self.path = self._folder.path
        self._store, self._prefix, self._is_kept, self._grows = store, prefix, is_kept, grows
        self._there: dict[str, set[str]] = {}  # objects of the store by the file of which they are
        self._same: dict[str, tuple[int, int]] = {}  # of each file: time [ns] and size when the store had the same
        self._sent: dict[str, int] = {}  # bytes of each file that the store has
        self._versions: dict[str, tuple[int | None, str]] = {}  # of the object of each file: size, name of the version

    def pull(self, wanted: Callable[[str], bool] = lambda name: True) -> None:
        """Bring the local files to what the store has; only what is new is fetched.

        wanted: whether a file, by its path, is looked at.

        Raises:
            StoreError: the store does not answer, or denies it.
        """
        for attempt in range(_ATTEMPTS):
            try:
                return self._pull_all(wanted)
            except FileNotFoundError as gone:  # another process has put pieces together since they were listed
                if attempt == _ATTEMPTS - 1:
                    raise StoreError(f"{gone} was listed, but is not there.") from gone

    def _pull_all(self, wanted: Callable[[str], bool]) -> None:
        wholes: dict[str, int] = {}
        pieces: dict[str, dict[tuple[str, int], str]] = {}
        for name, size in self._store.list(self._prefix):
            piece = _PIECE.fullmatch(name)
            if not self._is_kept(file := name if piece is None else piece[1]) or not wanted(file):
                continue
            if piece is not None:
                pieces.setdefault(piece[1], {})[piece[2], int(piece[3])] = name
            else:
                wholes[name] = size
        names = wholes.keys() | pieces.keys()
        others = {name: there for name, there in self._there.items() if not wanted(name)}
        found = {name: {*([name] if name in wholes else []), *pieces.get(name, {}).values()} for name in names}
        self._there = others | found
        for gone in filter(wanted, self._sent.keys() - names):
            (self.path / gone).unlink(missing_ok=True)
            del self._sent[gone], self._versions[gone]
        for name in sorted(names):
            self._pull(name, wholes.get(name), pieces.get(name, {}))

    def push(self, *, whole: bool = False) -> None:
        """Send what was appended to files or written anew, in the order of their names; remove what is gone here.

        whole: files that were appended to become one object each.

        Raises:
            OutputNotWritable: the store denies it, or does not answer.
        """
        here = {each.relative_to(self.path).as_posix(): each for each in self.path.rglob("*") if each.is_file()}
        here = {name: each for name, each in sorted(here.items(), key=self._turn) if self._is_kept(name)}
        for name, file in here.items():
            size, sent = file.stat().st_size, self._sent.get(name)
            is_whole = self._there.get(name) == {name}
            if self._grows(name) and not whole and (sent or 0) <= size:
                if (sent or 0) < size:
                    self._send_piece(name, file, sent or 0, size)
            elif not (is_whole and self._same.get(name) == (_stamp(file), size)):
                self._send_whole(name, file)
        for name in self._there.keys() - here.keys():
            self.delete(self._there.pop(name))
            self._sent.pop(name, None)

    def delete(self, names: Iterable[str]) -> None:
        """Remove files of the store, also such as are not in the mirror."""
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            list(pool.map(self._store.delete, names))

    def _turn(self, item: tuple[str, Path]) -> tuple[int, str]:
        """Files that grow last, and of these the ones that are deepest first: records before the journal."""
        name = item[0]
        return (-name.count("/") if self._grows(name) else -99, name)

    def _pull(self, name: str, whole: int | None, pieces: dict[tuple[str, int], str]) -> None:
        file = self.path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        known, version = self._versions.get(name, (None, ""))
        if not version or whole != known or not self._grows(name) or not file.exists():
            data = self._store.get(name) if whole is not None else b""
            file.write_bytes(data)
            version = _version(data) if whole is not None else _NEW
            self._versions[name] = whole, version
        size = file.stat().st_size
        with open(file, "ab") as stream:
            while (piece := pieces.get((version, size))) is not None:
                data = self._store.get(piece)
                stream.write(data)
                size += len(data)
        self._sent[name] = size
        self._same[name] = _stamp(file), size

    def _send_piece(self, name: str, file: Path, start: int, end: int) -> None:
        with open(file, "rb") as stream:
            stream.seek(start)
            data = stream.read(end - start)
        _, version = self._versions.setdefault(name, (None, _NEW))
        piece = f"{name}.pieces/{version}-{start:012}"
        self._store.put(piece, data)
        self._there.setdefault(name, set()).add(piece)
        self._sent[name] = end

    def _send_whole(self, name: str, file: Path) -> None:
        data = file.read_bytes()
        self._store.put(name, data)
        self.delete(self._there.get(name, set()) - {name})
        self._there[name] = {name}
        self._sent[name] = len(data)
        self._versions[name] = len(data), _version(data)
        self._same[name] = _stamp(file), len(data)


def _stamp(file: Path) -> int:
    return file.stat().st_mtime_ns


def _version(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]

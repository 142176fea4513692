"""The mirror of one assets root: files come with all that they refer to."""

from __future__ import annotations

import hashlib
import os
import re
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path

from usdsdg.errors import AssetError
from usdsdg.mirror.download import Blobs
from usdsdg.mirror.records import Record, Records
from usdsdg.mirror.references import references_of
from usdsdg.mirror.store import RemoteStore
from usdsdg.operating_system import process_name
from usdsdg.session.progress import report
from usdsdg.stage.assets import cache_folder

DOWNLOADS = 8  # at the same time
_LABEL = "assets fetched"


class RootMirror:
    """A copy of the assets root at a URL, in the user's cache folder.

    Raises:
        Unsupported: the URL is of another kind than http(s), s3, gs or az, or obstore is not installed.
    """

    def __init__(self, url: str) -> None:
        self._store = RemoteStore(url)
        cache = cache_folder() / "mirror"
        self._root = cache / "roots" / _folder_name(self._store.url)
        self._blobs = Blobs(cache)
        self._records = Records(self._root / "records")
        self._absent: set[str] = set()  # the store has no such file
        try:
            (self._root / "files").mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise AssetError(f"assets cannot be mirrored to {self._root}: {error}. Set XDG_CACHE_HOME.") from error

    @property
    def url(self) -> str:
        """The URL of the root, without a slash at its end."""
        return self._store.url

    @property
    def folder(self) -> str:
        """The folder that is laid out like the root."""
        return str(self._root / "files")

    def records(self) -> list[Record]:
        """Return the records of all files that have come, by path."""
        return list(self._records)

    def fetch(self, path: str) -> bool:
        """Bring a file and all that it refers to; False if the root has no such file.

        What the file refers to and the root lacks is left out: the stage that opens it says so.

        Raises:
            AssetError: a download failed, or the cache folder cannot be written.
        """
        if not Path(path).suffix or path in self._absent:
            return False
        if self._is_linked(path):
            return True
        try:
            found = self._gather(path)
            if path not in found:
                return False
            # The file that was asked for comes last: once it is there, so is what it refers to.
            for each in [*(name for name in found if name != path), path]:
                self._link(found[each])
        except OSError as error:
            raise AssetError(f"{self.url}/{path} cannot be kept in {self._root}: {error}. Free space there.") from error
        return True

    def damaged(self) -> list[tuple[Record, str]]:
        """Return the files whose content is missing, cut off or changed, with what is wrong."""
        checked = ((record, self._blobs.damage(record)) for record in self._records)
        return [(record, damage) for record, damage in checked if damage]

    def drop(self, record: Record) -> None:
        """Remove a file, so that it comes again when it is needed."""
        (Path(self.folder) / record.path).unlink(missing_ok=True)
        self._blobs.drop(record)
        self._records.drop(record.path)

    def _gather(self, path: str) -> dict[str, Record]:
        """Download a file and, over and over, what the files so far refer to; return what there is, by path."""
        found: dict[str, Record] = {}
        seen = {path}
        pending: dict[Future[Record | None], str] = {}
        with ThreadPoolExecutor(DOWNLOADS, thread_name_prefix="usdsdg-mirror") as pool:
            try:
                pending[pool.submit(self._obtain, path)] = path
                while pending:
                    done, _ = wait(pending, return_when=FIRST_COMPLETED)
                    for future in done:
                        name, record = pending.pop(future), future.result()
                        if record is None:
                            self._absent.add(name)
                            continue
                        found[name] = record
                        for each in references_of(self._blobs.path_of(record), name):
                            if each not in seen and not self._is_linked(each):
                                seen.add(each)
                                pending[pool.submit(self._obtain, each)] = each
                    report(_LABEL, len(seen) - len(pending), len(seen))
            finally:
                pool.shutdown(wait=True, cancel_futures=True)
        return found

    def _obtain(self, path: str) -> Record | None:
        """Return the record of a file that has come before and is whole, or download it."""
        if path in self._absent or not Path(path).suffix:
            return None
        with self._blobs.locked(self._store, path):
            known = self._records.get(path)
            if known is not None and self._blobs.has(known):
                return known
            record = self._blobs.download(self._store, path)
            if record is not None:
                self._records.put(record)
            return record

    def _is_linked(self, path: str) -> bool:
        return (Path(self.folder) / path).is_file()

    def _link(self, record: Record) -> None:
        """Put a file into the mirror, atomically: a link to its content, or a copy where links are not possible."""
        target = Path(self.folder) / record.path
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = target.with_name(f".{process_name()}.{target.name}")
        temporary.unlink(missing_ok=True)
        try:
            os.link(self._blobs.path_of(record), temporary)
        except OSError:
            import shutil

            shutil.copy(self._blobs.path_of(record), temporary)
        temporary.replace(target)
        temporary.unlink(missing_ok=True)  # renaming one link of a file to another does nothing


def _folder_name(url: str) -> str:
    host = re.sub(r"[^\w.-]", "_", url.split("://", 1)[1])[:40]
    return f"{host}-{hashlib.sha256(url.encode()).hexdigest()[:8]}"

"""Files at URLs: a bucket of S3, Google or Azure, or any other store."""

from __future__ import annotations

import hashlib
import itertools
import mimetypes
from collections.abc import Iterable, Iterator
from typing import Any

from usdsdg.errors import ALLOW_OUTSIDE, OutputNotWritable, StoreError, WriterError, warn_once
from usdsdg.session.session import current
from usdsdg.stores.addresses import Address, address_of
from usdsdg.stores.folder import FolderStore
from usdsdg.stores.object_store import ObjectStore
from usdsdg.stores.paths import checked_path
from usdsdg.stores.retries import retry_seconds
from usdsdg.writers.backends.backend import BaseBackend, checked_blob
from usdsdg.writers.journal.places.place import StorePlace
from usdsdg.writers.journal.recipe import FILE as RECIPE

# How long the first answer of a store may take [s], so that a wrong address is told soon.
FIRST_ANSWER_SECONDS = 30.0


class StoreBackend(BaseBackend):
    """A backend that writes files to a URL, as to "gs://bucket/runs/7"."""

    ends_run = False  # as of `DiskBackend`
    _store: ObjectStore | FolderStore
    keeps_journal = True  # a copy beside a folder has none: the folder's journal tells which frames are whole

    def __init__(
        self, url: str, region: str | None = None, endpoint_url: str | None = None, overwrite: bool = True
    ) -> None:
        """Ask what is there; warn if there are files below the URL.

        url: of an existing bucket with a prefix: "s3://bucket/prefix", "gs://bucket/prefix", "az://container/prefix".
        region, endpoint_url: of the bucket, in place of what the environment says.
        overwrite: False writes below a new prefix next to an existing one, with _0001 (and so on) appended.

        Raises:
            Unsupported: obstore is not installed.
            OutputNotWritable: the bucket does not exist, or cannot be reached with these credentials.
        """
        try:
            address = address_of(url)
        except StoreError as error:
            raise OutputNotWritable(str(error)) from error
        self._open(address, region, endpoint_url, overwrite)

    def _open(self, address: Address, region: str | None, endpoint_url: str | None, overwrite: bool) -> None:
        if address.kind in ("folder", "http"):
            kind = "a folder: use DiskBackend" if address.kind == "folder" else "a web server, which is only read"
            raise OutputNotWritable(f"{address.url} is {kind}.")
        if (limit := current().confined_to) is not None:
            raise OutputNotWritable(
                f"{address.url} is outside of {limit}, below which the output of such files goes. {ALLOW_OUTSIDE}"
            )
        if (scratch := current().run.scratch) is not None:  # frames that are made again for a comparison
            self._store = FolderStore(scratch / address.kind / address.host / address.path)
            current().run.check(self._store.url)
            return
        options: dict[str, Any] = {"region": region, "endpoint_url": endpoint_url}
        try:
            patience = retry_seconds()
            first = ObjectStore(address, **options, retry_seconds=min(patience, FIRST_ANSWER_SECONDS))
            if not overwrite and address.path:
                copy = current().run.numbered.ask(first.url)
                first = self._to_go_on(first, copy) or self._free(first)
                current().run.numbered.give(first.url, copy)
            is_used = _has_files(first)
            self._store = ObjectStore(first.address, **options, retry_seconds=patience)
        except OutputNotWritable:
            raise
        except StoreError as error:
            raise OutputNotWritable(str(error)) from error
        place = StorePlace(self._store)
        current().run.know(place)
        current().run.check(place.name)
        if is_used and place.read(RECIPE) is None:
            warn_once(
                f"{self.output_dir} is not empty: files of the same names are replaced, the others stay. "
                "Give another prefix to keep runs apart."
            )

    @classmethod
    def at(cls, place: StorePlace) -> StoreBackend:
        """Return a backend for a place that the run has claimed; nothing is asked."""
        backend = cls.__new__(cls)
        backend._store = place.store
        return backend

    @property
    def output_dir(self) -> str:
        """The URL: "s3://bucket/prefix".

        Raises:
            WriterError: the backend was not initialized.
        """
        store = self.__dict__.get("_store")
        if store is None:
            raise WriterError(f"This {self.get_name()} has no place to write yet: call initialize(...) first.")
        return store.url

    def _place(self) -> str:
        return self.output_dir

    def resolve_path(self, path: str) -> str:
        """Return the URL of a file of this backend.

        Raises:
            WriterError: `path` is not below the prefix, as one with `..`.
        """
        return f"{self.output_dir}/{checked_path(path, self.output_dir)}"

    def write_blob(self, path: str, data: bytes) -> None:
        """Store `data`, in parts if it is large; it is there whole or not at all.

        Raises:
            WriterError: as `resolve_path`, and for data that are no bytes.
            OutputNotWritable: the server refused it, or did not answer again and again.
        """
        self._write(path, checked_blob(path, data))

    def write_chunks(self, path: str, chunks: Iterable[bytes | memoryview]) -> None:
        """As `write_blob`, without a copy of all chunks in one piece."""
        if type(self).write_blob is not _OWN_WRITE_BLOB:
            super().write_chunks(path, chunks)  # to that of a subclass
        else:
            self._write(path, chunks)

    def _write(self, path: str, data: bytes | Iterable[bytes | memoryview]) -> None:
        key, run = checked_path(path, self.output_dir), current().run
        claimed = run.claim(self.output_dir) if self.keeps_journal else None
        if isinstance(self._store, ObjectStore):
            self._store.put(key, data, kind=_kind_of(path))
        else:
            self._store.put(key, data)
        if claimed is not None:
            run.note(self.output_dir, key, _facts(data), current().io_queue.files_in_hand())

    def read_blob(self, path: str) -> bytes:
        """Return what was stored under `path`.

        Raises:
            FileNotFoundError: there is no such file.
            StoreError: the server did not answer again and again, or denied access.
        """
        return self._store.get(checked_path(path, self.output_dir))

    @staticmethod
    def _free(store: ObjectStore) -> ObjectStore:
        """Return the store itself if nothing is there, else the first one with a number that is free."""
        return next(each for each in _numbered(store) if not _has_files(each))

    @staticmethod
    def _to_go_on(store: ObjectStore, copy: int) -> ObjectStore | None:
        """Return the latest store with this run or a part of it, where new runs are put beside earlier ones.

        copy: as in a recipe.
        """
        used = list(itertools.takewhile(_has_files, _numbered(store))) if current().run.may_go_on else []
        found = current().run.first_of_this(map(StorePlace, reversed(used)), copy)
        return next((each for each in used if found is not None and each.url == found.name), None)


_OWN_WRITE_BLOB = StoreBackend.write_blob


class S3Backend(StoreBackend):
    """A backend that writes objects into a bucket. Mirrors `rep.backends.S3Backend`."""

    def __init__(
        self,
        bucket: str,
        key_prefix: str | None,
        region: str | None = None,
        endpoint_url: str | None = None,
        overwrite: bool = False,
    ) -> None:
        """Ask what is in the bucket; warn if there are objects below `key_prefix`.

        bucket: name of an existing bucket of S3, or of a server with the same protocol (MinIO, R2, B2, Ceph).
        key_prefix: prefix of the keys, as a folder: "runs/7" gives "runs/7/rgb_0000.png". None: no prefix.
        region: such as "eu-central-1"; None: the one that the environment or `aws configure` says.
        endpoint_url: URL of a server other than Amazon's, such as "http://localhost:9000".
        overwrite: False writes below a new prefix next to an existing one, with _0001 (and so on) appended.

        Raises:
            Unsupported: obstore is not installed.
            OutputNotWritable: the bucket does not exist, or cannot be reached with these credentials.
        """
        prefix = [part for part in str(key_prefix or "").split("/") if part not in ("", ".")]
        if ".." in prefix or not bucket:
            raise OutputNotWritable(f"S3Backend: {bucket!r} and {key_prefix!r} name no place; give a bucket, no '..'.")
        self._open(Address("s3", bucket, "/".join(prefix)), region, endpoint_url, overwrite)


def _numbered(store: ObjectStore) -> Iterator[ObjectStore]:
    """Return the store, and those with _0001 and so on appended."""
    return itertools.chain([store], (store.at(f"{store.address.path}_{number:04d}") for number in itertools.count(1)))


def _has_files(store: ObjectStore) -> bool:
    return next(store.list(), None) is not None


def _facts(data: bytes | Iterable[bytes | memoryview]) -> tuple[int, str]:
    """Return the size [bytes] and the SHA-256 of a file."""
    size, digest = 0, hashlib.sha256()
    for chunk in [data] if isinstance(data, bytes) else data:
        size += memoryview(chunk).nbytes
        digest.update(chunk)
    return size, digest.hexdigest()


def _kind_of(path: str) -> str:
    return mimetypes.guess_type(path)[0] or "application/octet-stream"

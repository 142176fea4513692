"""What a store is: bytes by relative path, whole or absent, with puts that depend on what is there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol


class Entry(NamedTuple):
    """One version of a file in a store."""

    data: bytes
    etag: str  # changes with the content; of a folder a hash of it


class Store(Protocol):
    """Files below a folder or the prefix of a bucket.

    Paths are relative, with slashes: "rgb/0001.png". A file appears whole or not at all, and is durable when the call
    returns. All calls may come from any thread.

    Raises:
        StoreError: a path leaves the store; the store does not exist, denies access, or did not answer for as long as
            `open_store` was told. Of what writes it is an OutputNotWritable. The message says what to do.
    """

    url: str  # of the store itself, without a slash at its end; of a folder its absolute path

    def get(self, path: str) -> bytes:
        """Return the content of a file.

        Raises:
            FileNotFoundError: there is no such file.
        """
        ...

    def get_entry(self, path: str) -> Entry:
        """As `get`, with the etag that `put_if_match` asks for."""
        ...

    def size(self, path: str) -> int | None:
        """Return the size of a file [bytes]; None if there is no such file."""
        ...

    def put(self, path: str, data: bytes | Iterable[bytes | memoryview]) -> None:
        """Store a file, of bytes or of chunks, in place of one that may be there.

        data: chunks may be gone over several times, so they are no generator.
        """
        ...

    def put_if_absent(self, path: str, data: bytes) -> bool:
        """Store a file unless one is there; of several that try at once exactly one does. Return whether it did.

        Where an answer was lost, the store is asked what it holds. So put something of your own into `data`, such as a
        process and a time: of two with equal bytes, both may be told that theirs is there.
        """
        ...

    def put_if_match(self, path: str, data: bytes, etag: str) -> bool:
        """Replace a file if it still has the etag of `get_entry`; return whether it had. A file that went is not made.

        Answers that were lost: as for `put_if_absent`. Where another one has replaced the file since, the answer is
        False though the put was done: right for a lease, which is gone, but a count would be one too many.
        """
        ...

    def delete(self, path: str) -> None:
        """Remove a file; nothing happens if it is not there."""
        ...

    def list(self, prefix: str = "") -> Iterator[tuple[str, int]]:
        """Go over all files below a folder of the store, as (path, size [bytes]), in no particular order."""
        ...

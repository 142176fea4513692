"""Leases in a store: locks that a process keeps by renewing them, and that end by themselves when it has died."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterable

from usdsdg.errors import OutputNotWritable, StoreError
from usdsdg.operating_system import has_ended, numbers_of_processes
from usdsdg.stores.locks import Locked
from usdsdg.stores.store import Entry, Store

SECONDS = 30.0  # after which a lease that was not renewed has ended
_RENEWALS = 3  # in that time
_POLLS = 10


class Lease:
    """One file of a store that says who works there; another process takes it only when it is no longer renewed.

    Clocks of other machines are not trusted: whoever waits looks whether the file changes for `seconds` of its own.
    """

    def __init__(self, store: Store, path: str, *, rivals: Callable[[], Iterable[str]], seconds: float = SECONDS):
        """Take the lease, and renew it on a thread.

        path: of its file. rivals: returns the files of leases that may not be held beside it; called once the own
        file is there, so of two that begin at once at least one gives way.

        Raises:
            Locked: another process holds this lease or a rival.
            OutputNotWritable, StoreError: the store denies it, or did not answer.
        """
        self._store, self._path, self._seconds = store, path, seconds
        self._id = uuid.uuid4().hex
        self._turn = 0
        self._has_lost = False
        self._ended = threading.Event()
        if not store.put_if_absent(path, self._text()):
            before = end_of(store, [path], seconds)
            if path in before and not store.put_if_match(path, self._text(), before[path]):
                raise Locked(f"{store.url}/{path}")
            if path not in before and not store.put_if_absent(path, self._text()):
                raise Locked(f"{store.url}/{path}")
        self._thread = threading.Thread(target=self._renew, name="usdsdg-lease", daemon=True)
        self._thread.start()
        try:
            others = [each for each in rivals() if each != path]
            for other in end_of(store, others, seconds):
                store.delete(other)
        except BaseException:
            self.release()
            raise

    def check(self) -> None:
        """Raise OutputNotWritable if another process has taken the lease, because it was not renewed in time."""
        if self._has_lost:
            raise OutputNotWritable(
                f"{self._store.url}: another process has gone on with this dataset, since this one could not say for "
                f"{self._seconds:g} s that it still runs. Go on with --resume once the other has ended."
            )

    def release(self) -> None:
        """Give the lease back; nothing happens the second time."""
        if self._ended.is_set():
            return
        self._ended.set()
        self._thread.join(self._seconds)
        if not self._has_lost:
            with contextlib.suppress(StoreError):  # then it ends by itself
                self._store.delete(self._path)

    def _text(self) -> bytes:
        self._turn += 1
        holder = {"id": self._id, "host": socket.gethostname(), "pid": os.getpid(), "numbers": numbers_of_processes()}
        return json.dumps({**holder, "turn": self._turn}).encode()

    def _renew(self) -> None:
        while not self._ended.wait(self._seconds / _RENEWALS):
            try:
                entry = self._store.get_entry(self._path)
                is_mine = json.loads(entry.data).get("id") == self._id
                if not is_mine or not self._store.put_if_match(self._path, self._text(), entry.etag):
                    self._has_lost = True
            except FileNotFoundError:
                self._has_lost = True
            except (StoreError, ValueError):
                continue  # a store that does not answer gives the lease to nobody else, either
            if self._has_lost:
                return


def end_of(store: Store, paths: Iterable[str], seconds: float = SECONDS) -> dict[str, str]:
    """Return the etags of the leases that have ended without being given back; waits until that is certain.

    Raises:
        Locked: one of them is renewed.
    """
    found = {path: entry for path in paths if (entry := _entry(store, path)) is not None}
    waiting = {path: entry for path, entry in found.items() if not _has_died_here(entry.data)}
    until = time.monotonic() + seconds
    while waiting and time.monotonic() < until:
        time.sleep(seconds / _RENEWALS / _POLLS * 2)
        for path, entry in tuple(waiting.items()):
            now = _entry(store, path)
            if now is None:  # given back
                del waiting[path], found[path]
            elif now.etag != entry.etag:
                raise Locked(_holder(now.data) or f"{store.url}/{path}")
    return {path: entry.etag for path, entry in found.items()}


def _entry(store: Store, path: str) -> Entry | None:
    try:
        return store.get_entry(path)
    except FileNotFoundError:
        return None


def _has_died_here(data: bytes) -> bool:
    """Return whether a lease is that of a process of this machine that does not run any more."""
    with contextlib.suppress(ValueError, TypeError, KeyError):
        holder = json.loads(data)
        return bool(holder["numbers"]) and holder["numbers"] == numbers_of_processes() and has_ended(int(holder["pid"]))
    return False


def _holder(data: bytes) -> str:
    with contextlib.suppress(ValueError, TypeError, KeyError):
        holder = json.loads(data)
        return f"process {holder['pid']} of {holder['host']}"
    return ""

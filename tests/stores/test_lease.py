"""Leases: one process has each, and it ends when its holder does not renew it."""

import contextlib
import json
import subprocess
import sys
import threading
import time

import pytest

from usdsdg.errors import OutputNotWritable
from usdsdg.stores import lease as leases
from usdsdg.stores.folder import FolderStore
from usdsdg.stores.lease import Lease
from usdsdg.stores.locks import Locked

SECONDS = 0.6


@pytest.fixture
def store(tmp_path):
    return FolderStore(tmp_path)


def take(store, path="lease", *rivals):
    return Lease(store, path, rivals=lambda: rivals, seconds=SECONDS)


def stop_renewing(lease):
    """Let it be as after a crash of its machine."""
    lease._ended.set()
    lease._thread.join()


def test_only_one_has_it_until_it_is_given_back(store):
    first = take(store)
    with pytest.raises(Locked, match=r"process .* of "):
        take(store)
    first.check()
    first.release()
    first.release()
    assert list(store.list()) == []
    take(store).release()


def test_of_many_that_begin_at_once_one_has_it(store):
    had = []

    def begin():
        with contextlib.suppress(Locked):
            had.append(take(store))

    threads = [threading.Thread(target=begin) for _ in range(8)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(had) == 1
    had[0].release()


def test_one_that_is_not_renewed_ends_and_its_holder_is_told(store, monkeypatch):
    monkeypatch.setattr(leases, "_has_died_here", lambda data: False)
    first = take(store)
    stop_renewing(first)
    began = time.monotonic()
    second = take(store)
    assert time.monotonic() - began >= SECONDS * 0.9
    first._ended.clear()
    first._renew()
    with pytest.raises(OutputNotWritable, match="another process has gone on"):
        first.check()
    first.release()
    second.check()
    assert [name for name, _ in store.list()] == ["lease"]
    second.release()


def test_that_of_a_process_of_this_machine_that_has_died_ends_at_once(store):
    first = take(store)
    stop_renewing(first)
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    dead = json.dumps(json.loads(store.get("lease")) | {"pid": process.pid}).encode()
    store.put("lease", dead)
    if not leases._has_died_here(dead):
        pytest.skip("this system does not tell who numbers its processes")
    monotonic = time.monotonic()
    second = take(store)
    assert time.monotonic() - monotonic < SECONDS / 2
    second.release()


def test_rivals_keep_each_other_out(store):
    part = take(store, "part", "all")
    with pytest.raises(Locked):
        take(store, "all", "part")
    assert [name for name, _ in store.list()] == ["part"]
    part.release()
    whole = take(store, "all", "part")
    with pytest.raises(Locked):
        take(store, "part", "all")
    whole.release()
    assert list(store.list()) == []

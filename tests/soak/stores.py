"""Stores on real servers that run here: what they promise, then many failures, then a store that is gone for long.

Ceph's gateway (Debian's `ceph-mon ceph-osd ceph-common radosgw`) runs where it is installed; moto, which the tests use,
always. `--url URL` adds one of your own, with the credentials of your environment.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager

import pytest

from tests.soak import ceph
from tests.stores.servers import Bucket, FailingProxy, moto_port, only_ours
from usdsdg.errors import StoreError
from usdsdg.stores import Store, clients, open_store

KEYS = ["a b.txt", "100%.txt", "a%20b", "%2e%2e", "ü/é̈.json", "日本.png", "a+b&c=d", "#x?y", "a*b", "'q\"", "~", "..a"]
WAYS = ["drop", "lose", "cut", "503 SlowDown", "500 InternalError"]


def promises(store: Store) -> None:
    """Check every operation once, conditional puts by many threads, and a large file."""
    for key in KEYS:
        store.put(f"odd/{key}", key.encode())
    assert {path: store.get(path) for path, _ in store.list("odd")} == {f"odd/{key}": key.encode() for key in KEYS}
    data = random.Random(1).randbytes(60 << 20)
    store.put("large", [memoryview(data)[start : start + 1_000_003] for start in range(0, len(data), 1_000_003)])
    assert store.get("large") == data
    with ThreadPoolExecutor(16) as pool:
        for turn in range(20):
            won = list(pool.map(lambda i, t=turn: store.put_if_absent(f"lock{t}", b"%d" % i), range(16)))
            assert won.count(True) == 1
            assert store.get(f"lock{turn}") == b"%d" % won.index(True)
    assert count_up(store, threads=8, each=25) == 200
    with ThreadPoolExecutor(16) as pool:
        list(pool.map(lambda i: store.put(f"many/{i:05}", b"x"), range(2500)))
    assert sorted(store.list("many")) == [(f"many/{i:05}", 1) for i in range(2500)]
    store.delete("large")
    store.delete("large")
    assert store.size("large") is None


def count_up(store: Store, *, threads: int, each: int) -> int:
    """Add one again and again by put_if_match; return the sum, from which nothing may be lost."""
    store.put("count", b"0 by nobody")

    def add(thread: int) -> None:
        for number in range(each):
            while True:
                entry = store.get_entry("count")
                value = int(entry.data.split()[0]) + 1
                if store.put_if_match("count", b"%d by %d %d" % (value, thread, number), entry.etag):
                    break

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(add, range(threads)))
    return int(store.get("count").split()[0])


def failures(open_at: Callable[[str], Store], port: int, seed: int) -> int:
    """Put and read through a proxy that fails one request in four, in every way; return how many have failed."""
    rng, lock, top = random.Random(seed), threading.Lock(), f"failures{seed}"

    def fate(number: int, method: str, target: str) -> str:
        with lock:
            return rng.choice(WAYS) if rng.random() < 0.25 else "pass"

    with FailingProxy(port, fate) as proxy:
        store = open_at(proxy.url)
        contents = {
            f"{top}/{number:03}": random.Random(number).randbytes(number * 150_000) for number in range(0, 120, 3)
        }
        with ThreadPoolExecutor(8) as pool:
            list(pool.map(lambda item: store.put(*item), contents.items()))
            assert dict(zip(contents, pool.map(store.get, contents))) == contents
            won = list(pool.map(lambda i: store.put_if_absent(f"{top}/lock", b"%d" % i), range(32)))
        assert won.count(True) == 1
        assert store.get(f"{top}/lock") == b"%d" % won.index(True)
        # Who does not learn that a put was done before another one came adds again.
        assert count_up(store, threads=4, each=10) >= 40
        assert {path for path, _ in store.list(top)} == {*contents, f"{top}/lock"}
        return sum(each != "pass" for _, _, each in proxy.seen)


def absence(open_at: Callable[[str], Store], port: int, seconds: float) -> float:
    """Put files while the store is gone for some seconds; return how long it took [s]."""
    gone = threading.Event()
    with FailingProxy(port, lambda *_: "drop" if gone.is_set() else "pass") as proxy:
        store = open_at(proxy.url)
        gone.set()
        threading.Timer(seconds, gone.clear).start()
        start = time.monotonic()
        with ThreadPoolExecutor(4) as pool:
            list(pool.map(lambda i: store.put(f"gone/{i}", b"%d" % i), range(20)))
        took = time.monotonic() - start
        assert sorted(store.get(path) for path, _ in store.list("gone")) == sorted(b"%d" % i for i in range(20))
        return took


def refusals(bucket: Bucket) -> None:
    """Check the words for wrong keys and for a bucket that is not there, as the server says it."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
            patch.setenv(name, "wrong")
            with pytest.raises(StoreError, match=r"credentials are wrong|do not allow"):
                open_store(f"s3://{bucket.name}", endpoint_url=bucket.url).put("x", b"")
            patch.undo()
    with pytest.raises(StoreError, match="no such bucket"):
        open_store("s3://there-is-none", endpoint_url=bucket.url).put("x", b"")


@contextmanager
def servers() -> Iterator[dict[str, int]]:
    """Run the servers that are installed; yield their ports."""
    with ExitStack() as stack:
        found = {"moto": moto_port()}
        if ceph.is_installed():
            found["Ceph"] = stack.enter_context(ceph.running())
        else:
            print(f"Ceph is not installed: apt-get install --no-install-recommends {ceph.PACKAGES}")
        yield found


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.soak stores", description=__doc__)
    parser.add_argument("--seconds", type=float, default=20, help="how long the store is gone")
    parser.add_argument("--rounds", type=int, default=3, help="of failures")
    parser.add_argument("--url", help="of a bucket of your own, of which only the promises are checked")
    asked = parser.parse_args()
    if asked.url:
        promises(open_store(f"{asked.url.rstrip('/')}/soak-{os.getpid()}"))
        print(f"{asked.url}: keeps its promises")
        return 0
    with pytest.MonkeyPatch.context() as patch, servers() as ports:
        _ours_without_haste(patch)
        for name, port in ports.items():
            bucket = Bucket(port)

            def open_at(url: str, bucket: Bucket = bucket) -> Store:
                return open_store(f"s3://{bucket.name}/a b", endpoint_url=url)

            begin = time.monotonic()
            promises(open_at(bucket.url))
            print(f"{name}: keeps its promises, {time.monotonic() - begin:.0f} s", flush=True)
            if name != "moto":  # which lets everybody in
                refusals(bucket)
                print(f"{name}: wrong keys and a missing bucket are told", flush=True)
            failed = sum(failures(open_at, port, seed) for seed in range(asked.rounds))
            print(f"{name}: {failed} failed requests are outlived, nothing is lost", flush=True)
            took = absence(open_at, port, asked.seconds)
            print(f"{name}: gone for {asked.seconds:.0f} s, all is there after {took:.1f} s", flush=True)
    return 0


def _ours_without_haste(patch: pytest.MonkeyPatch) -> None:
    """Set the credentials of the tests, but wait as users do."""
    pauses = clients.PAUSE_SECONDS
    only_ours(patch, os.devnull)
    patch.setattr(clients, "PAUSE_SECONDS", pauses)


if __name__ == "__main__":
    sys.exit(main())

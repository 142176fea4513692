"""Bands of rows over threads: each row once, failures, two callers at a time, limits, forked processes."""

import os
import threading
import time

import pytest

from tests import forked
from usdsdg import parallel
from usdsdg.parallel import available_threads, for_bands, limit_threads


@pytest.fixture
def no_limit():
    yield
    limit_threads(None)


def rows_of(bands: list[tuple[int, int]]) -> list[int]:
    return sorted(row for first, count in bands for row in range(first, first + count))


@pytest.mark.parametrize("rows", [0, 1, 7, 37, 480])
@pytest.mark.parametrize("threads", [1, 2, 3, 16])
def test_bands_cover_all_rows_once(rows, threads):
    bands: list[tuple[int, int]] = []
    for_bands(rows, lambda first, count: bands.append((first, count)), threads=threads, band_rows=4)
    assert rows_of(bands) == list(range(rows))


def test_bands_shrink_to_the_smallest():
    bands: list[tuple[int, int]] = []
    for_bands(1000, lambda first, count: bands.append((first, count)), threads=2, band_rows=8)
    counts = [count for _, count in sorted(bands)]
    assert counts[0] == 4 * 8
    assert all(8 <= count <= 4 * 8 for count in counts[:-1])
    assert counts[-2] == 8


def test_a_failure_on_any_thread_stops_the_rest_and_is_raised():
    seen: list[int] = []
    lock = threading.Lock()

    def fails(first: int, count: int) -> None:
        with lock:
            seen.append(first)
        time.sleep(0.001)
        if len(seen) > 3 and threading.current_thread() is not threading.main_thread():
            raise ValueError(f"band {first}")

    with pytest.raises(ValueError, match="band "):
        for_bands(8000, fails, threads=2)
    assert len(seen) < 1000


def test_an_interruption_is_raised_after_the_bands_that_have_begun():
    working, ended = threading.Event(), threading.Event()

    def band(first: int, count: int) -> None:
        if threading.current_thread() is threading.main_thread():
            assert working.wait(5)
            raise KeyboardInterrupt
        working.set()
        time.sleep(0.05)
        ended.set()

    with pytest.raises(KeyboardInterrupt):
        for_bands(8000, band, threads=2)
    assert ended.is_set()


def test_a_caller_does_not_wait_for_threads_that_help_another_one():
    """All helpers are busy with bands of the first caller, and the second one works alone."""
    release, busy = threading.Event(), threading.Semaphore(0)

    def blocked(first: int, count: int) -> None:
        busy.release()
        assert release.wait(5)

    first = threading.Thread(target=for_bands, args=(64, blocked), kwargs={"threads": 2, "band_rows": 1})
    first.start()
    assert busy.acquire(timeout=5)
    assert busy.acquire(timeout=5)
    bands: list[tuple[int, int]] = []
    for_bands(100, lambda first, count: bands.append((first, count)), threads=2)
    assert rows_of(bands) == list(range(100))
    release.set()
    first.join(5)
    assert not first.is_alive()


def test_the_limit_bounds_how_many_threads_work(no_limit):
    limit_threads(1)
    assert available_threads() == 1
    workers: set[int] = set()
    for_bands(1000, lambda first, count: workers.add(threading.get_ident()))
    assert workers == {threading.get_ident()}
    limit_threads(None)
    assert available_threads() >= 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked on POSIX only")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_has_threads_of_its_own():
    for_bands(100, lambda first, count: None, threads=3)
    both = threading.Barrier(2, timeout=5)
    child = os.fork()
    if child == 0:
        workers: set[int] = set()

        def band(first: int, count: int) -> None:
            both.wait()  # is passed only where two threads work
            workers.add(threading.get_ident())

        for_bands(2, band, threads=2, band_rows=1)
        os._exit(0 if len(workers) == 2 else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_cheap_pixels_are_handed_out_in_bands_of_many():
    assert parallel.cheap_rows(640) * 640 <= parallel.CHEAP_PIXELS < (parallel.cheap_rows(640) + 1) * 640
    assert parallel.cheap_rows(1 << 20) == 1


def test_threads_that_load_a_kernel_at_the_same_time_all_launch_it(tmp_path):
    """The code that one of them has loaded is not unloaded because another has loaded it as well."""
    done = forked.run(["-c", LOADED_AT_ONCE], cwd=tmp_path, env=dict(os.environ))
    assert (done.returncode, done.stdout) == (0, "done\n"), done.stderr


LOADED_AT_ONCE = """
import warp as wp
import usdsdg
from usdsdg.parallel import launch_rows
from usdsdg.warp_start import quiet_warp
from usdsdg_render.kernels.labels.label_boxes import map_labels

quiet_warp()
shown, table = wp.zeros((64, 2, 2), dtype=wp.int32, device="cpu"), wp.array([7, 0], dtype=wp.int32, device="cpu")
masks = wp.zeros((64, 2, 2), dtype=wp.int32, device="cpu")
for _ in range(200):
    map_labels.module.unload()
    launch_rows(map_labels, shown.shape, [shown, table], [masks], device="cpu", threads=4, band_rows=1)
    assert (masks.numpy() == 7).all()
print("done")
"""

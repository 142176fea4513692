"""The queue between the frame loop and storage: a few threads, a bounded backlog, errors kept until they are raised."""

import atexit
import os
import sys
import threading
import weakref
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

from usdsdg.errors import UsdsdgError, WriterError
from usdsdg.session.session import current

THREADS = min(4, os.cpu_count() or 1)


class _Job(NamedTuple):
    run: Callable[[], None]
    what: str  # file or function, for messages
    size: int  # bytes that it keeps alive
    owner: Any


class IoQueue:
    """Runs jobs on threads, first in, first out, several at a time.

    `submit` blocks while `max_jobs` wait or while open jobs hold `max_bytes`, so that a fast renderer cannot exhaust
    the memory.
    """

    def __init__(self, *, threads: int = THREADS, max_jobs: int = 1000, max_bytes: int = 1 << 30) -> None:
        self.max_jobs, self.max_bytes = max_jobs, max_bytes
        self._threads = threads
        self._changed = threading.Condition()
        self._waiting: deque[_Job] = deque()
        self._bytes = 0
        self._open: Counter[int] = Counter()  # jobs waiting or running, by id of their owner
        self._failures: list[tuple[Any, UsdsdgError]] = []
        self._workers: set[threading.Thread] = set()
        self._at_exit: list[weakref.WeakMethod] = []
        self._noted: list[str] | None = None  # paths of scheduled files inside `noting_files`, else None

    def submit(self, run: Callable[[], None], *, what: str, size: int, owner: Any) -> None:
        """Run `run` later.

        Raises:
            the first failure of an earlier job of the same owner, for which more frames would be pointless.
        """
        job = _Job(run, what, size, owner)
        if threading.current_thread() in self._workers:
            run()  # a job that waited for its own queue could deadlock
            return
        with self._changed:
            self._raise_failure(owner)
            while self._is_full(size):
                self._changed.wait()
            self._waiting.append(job)
            self._open[id(owner)] += 1
            self._bytes += size
            self._start_workers()
            self._changed.notify_all()

    @contextmanager
    def noting_files(self) -> Iterator[list[str]]:
        """Collect, in the context, the paths of the files that jobs are scheduled for."""
        before, self._noted = self._noted, []
        try:
            yield self._noted
        finally:
            self._noted = before

    def note_files(self, paths: Iterable[str]) -> None:
        """Tell that a job was scheduled that writes these files."""
        if self._noted is not None:
            self._noted.extend(paths)

    def is_done_writing(self, owner: Any = None) -> bool:
        """Return whether no job of `owner` (None: of anyone) waits or runs."""
        with self._changed:
            return not self._count(owner)

    def open_jobs(self) -> int:
        """Return the number of jobs that wait or run."""
        with self._changed:
            return self._open.total()

    def wait_until_done(self, owner: Any = None) -> None:
        """Block until no job of `owner` (None: of anyone) waits or runs.

        Raises:
            the first failure since the last time that one was raised; it is raised once.
        """
        with self._changed:
            while self._count(owner):
                self._changed.wait()
            self._raise_failure(owner)

    def set_max_queue_size(self, jobs: int) -> None:
        """Set how many jobs may wait before `submit` blocks."""
        self.max_jobs = max(1, int(jobs))

    def call_at_exit(self, method: Callable[[], None]) -> None:
        """Call `method`, bound to an object that still exists then, when the program ends; it may submit last jobs."""
        self._at_exit.append(weakref.WeakMethod(method))

    def _count(self, owner: Any) -> int:
        return self._open.total() if owner is None else self._open[id(owner)]

    def _is_full(self, size: int) -> bool:
        return len(self._waiting) >= self.max_jobs or bool(self._bytes and self._bytes + size > self.max_bytes)

    def _raise_failure(self, owner: Any) -> None:
        mine = [error for who, error in self._failures if owner is None or owner is who]
        if not mine:
            return
        self._failures = [(who, error) for who, error in self._failures if owner is not None and owner is not who]
        if len(mine) > 1:
            mine[0].add_note(f"({len(mine) - 1} more jobs failed after this one)")
        raise mine[0]

    def _start_workers(self) -> None:
        if self._workers:
            return
        for index in range(self._threads):
            worker = threading.Thread(target=self._work, name=f"usdsdg-io-{index}", daemon=True)
            self._workers.add(worker)
            worker.start()
        # Threads are daemons, so that Ctrl-C while draining still ends the program.
        atexit.register(self._finish)

    def _work(self) -> None:
        while True:
            with self._changed:
                while not self._waiting:
                    self._changed.wait()
                job = self._waiting.popleft()
                self._changed.notify_all()
            failure = _failure_of(job)
            with self._changed:
                self._open[id(job.owner)] -= 1
                if not self._open[id(job.owner)]:
                    del self._open[id(job.owner)]
                self._bytes -= job.size
                if failure is not None:
                    self._failures.append((job.owner, failure))
                self._changed.notify_all()
            del job

    def _finish(self) -> None:
        """Run the remaining write jobs at exit; a failure that no call has raised makes the exit code 1."""
        last = [method for each in self._at_exit if (method := each()) is not None]
        for step in (*last, self.wait_until_done):
            try:
                step()
            except UsdsdgError as error:
                print(f"error: {error}", file=sys.stderr)
                current().failed_at_exit = True


def _failure_of(job: _Job) -> UsdsdgError | None:
    """Run the job and return its error, if any."""
    try:
        job.run()
    except UsdsdgError as error:
        return error
    except Exception as error:  # noqa: BLE001 - raised again by the thread that waits
        failure = WriterError(f"{job.what} could not be written: {type(error).__name__}: {error}")
        failure.__cause__ = error
        return failure
    return None


def is_done_writing() -> bool:
    """Return whether every backend has written everything."""
    return current().io_queue.is_done_writing()


def wait_until_done() -> None:
    """Block until every backend has written everything; raises the first failure."""
    current().io_queue.wait_until_done()


def set_max_queue_size(jobs: int) -> None:
    """Set how many jobs may wait before `schedule` blocks."""
    current().io_queue.set_max_queue_size(jobs)

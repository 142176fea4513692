"""The queue between the frame loop and storage: a few threads, a bounded backlog, errors kept until they are raised."""

from __future__ import annotations

import atexit
import threading
import weakref
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from usdsdg.errors import UsdsdgError, WriterError, counted
from usdsdg.operating_system import around_fork
from usdsdg.session.endings.failures import tell
from usdsdg.session.progress import print_safely
from usdsdg.session.session import current
from usdsdg.session.turns import LAST_FRAME_SECONDS, turns
from usdsdg.writers.backends.job import Job

if TYPE_CHECKING:
    from usdsdg.parallel import Later
    from usdsdg.readback import Arrival
    from usdsdg.writers.journal.frames import FrameFiles

# As Replicator's setting /omni/replicator/backend/writeThreads; more than cores, since storage is waited for as well.
THREADS = 4
# How long `stop` waits for the jobs that run; one writes a file in a fraction of that.
STOP_SECONDS = 5.0


class IoQueue:
    """Runs jobs on threads, first in, first out, several at a time.

    `submit` blocks while `max_jobs` wait or while open jobs hold `max_bytes`, so that a fast renderer cannot exhaust
    the memory. Without threads a job runs where it is submitted.
    """

    def __init__(self, *, threads: int = THREADS, max_jobs: int = 1000, max_bytes: int = 1 << 30) -> None:
        self.max_jobs, self.max_bytes = max_jobs, max_bytes
        self._threads = threads
        self._at_exit: list[weakref.WeakMethod] = []
        self._noted: list[str] | None = None  # paths of scheduled files inside `frame`, else None
        self._frame: int | None = None
        self._files: FrameFiles | None = None
        self._held: FrameFiles | None = None  # by files of all frames that are scheduled with it
        self._pixels: Later | Arrival | None = None
        self.copies_arguments = False  # whether what is scheduled may be changed afterward, as by scripts' writers
        self._on_thread = threading.local()  # `job` is the one that runs there
        self._finishes_at_exit = False
        self._forget_all()
        alive: weakref.ref[IoQueue] = weakref.ref(self)
        around_fork(in_child=lambda: _forget_in_child(alive))

    def _forget_all(self) -> None:
        # Taken by itself: the `with` of a Condition is Python code, in which Ctrl-C can leave it taken for ever.
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)  # for all but the threads
        # For the threads: a job wakes one of them; all of them would keep Python's lock from the frame.
        self._work_is_there = threading.Condition(self._lock)
        self._ready: deque[Job] = deque()  # waiting for a thread; `_open` also has those that run or wait for others
        self._open: dict[int, Job] = {}  # by number, oldest first
        self._submitted = self._running = self._bytes = 0
        self._failures: list[tuple[Job, UsdsdgError]] = []
        self._workers: set[threading.Thread] = set()

    def submit(
        self,
        run: Callable[[], None],
        *,
        what: str,
        size: int,
        owner: Any,
        turn: Hashable = None,
        after_all: bool = False,
    ) -> None:
        """Run `run` later.

        turn: jobs with the same turn, of any owner, run one after the other, in the order of their submission.
        after_all: it runs after all earlier jobs of the owner, and is left out if one of them fails.

        Raises:
            the first failure of an earlier job of the same owner, for which more frames would be pointless.
        """
        if threading.current_thread() in self._workers:
            run()  # a job that waited for its own queue could deadlock
            return
        job = Job(run, what, size, owner, pixels=self._pixels, frame=self._frame, turn=turn, after_all=after_all)
        self._finish_at_exit()
        with self._lock:
            self._raise_failure(owner)
            while self._is_full(size):
                self._changed.wait()
                self._raise_failure(owner)
            job.of(self._files, self._held)
            if self._threads:
                self._add(job)
                self._start_workers()
                return
        failure = self._failure_of(job)
        job.end(failed=failure is not None)
        if failure is not None:
            raise failure

    @contextmanager
    def frame(
        self,
        number: int,
        *,
        pixels: Later | Arrival | None = None,
        files: FrameFiles | None = None,
        copies_arguments: bool = False,
    ) -> Iterator[list[str]]:
        """Submit, in the context, jobs of this captured frame; yields the paths of the files that they write.

        pixels: its images have their pixels when this has ended; its jobs wait for that.
        files: what is told of the files of the frame.
        copies_arguments: whether backends schedule copies, because the writer may change what it has scheduled.
        """
        before = self._noted, self._frame, self._pixels, self._files, self.copies_arguments
        noted: list[str] = []
        self._noted, self._frame, self._pixels, self._files = noted, number, pixels, files
        self.copies_arguments = copies_arguments
        try:
            yield noted
        finally:
            self._noted, self._frame, self._pixels, self._files, self.copies_arguments = before

    @contextmanager
    def of_all_frames(self) -> Iterator[None]:
        """Submit, in the context, jobs of files that belong to no single frame, such as the class table.

        The frame that is captured meanwhile is not whole before they have ended.
        """
        before = self._files, self._held, self._noted
        self._files, self._held, self._noted = None, self._files or self._held, None
        try:
            yield
        finally:
            self._files, self._held, self._noted = before

    def files_in_hand(self) -> FrameFiles | None:
        """Return the frame to which a file belongs that is written now; None if to no single one."""
        job: Job | None = getattr(self._on_thread, "job", None)
        return job.files if job is not None else self._files

    def note_files(self, paths: Iterable[str]) -> None:
        """Tell that a job was scheduled that writes these files."""
        if self._noted is not None:
            self._noted.extend(paths)

    def is_done_writing(self, owner: Any = None) -> bool:
        """Return whether no job of `owner` (None: of anyone) waits or runs."""
        with self._lock:
            return not self._is_open(owner)

    def open_jobs(self) -> int:
        """Return the number of jobs that wait or run."""
        with self._lock:
            return len(self._open)

    def wait_until_done(self, owner: Any = None) -> None:
        """Block until no job of `owner` (None: of anyone) waits or runs.

        Raises:
            the first failure since the last time that one was raised; it is raised once.
            WriterError: a job waits, which would wait for itself.
        """
        if threading.current_thread() in self._workers:
            raise WriterError("a job waits for its own queue, and would never end: use schedule_after_all.")
        with self._lock:
            while self._is_open(owner):
                self._changed.wait()
            self._raise_failure(owner)

    def set_max_queue_size(self, jobs: int) -> None:
        """Set how many jobs may wait before `submit` blocks."""
        self.max_jobs = max(1, int(jobs))

    def set_max_bytes(self, count: int) -> None:
        """Set how many bytes open jobs may keep alive before `submit` blocks; a larger job is taken alone."""
        self.max_bytes = max(1, int(count))

    def set_threads(self, count: int) -> None:
        """Set how many jobs run at a time; with 0 each runs where it is submitted, after those that are open now."""
        with self._lock:
            while not count and self._open:
                self._changed.wait()
            self._threads = max(0, int(count))
            self._work_is_there.notify_all()

    def call_at_exit(self, method: Callable[[], None]) -> None:
        """Call `method`, bound to an object that still exists then, when the program ends; it may submit last jobs."""
        self._at_exit = [each for each in self._at_exit if each() is not None]
        self._at_exit.append(weakref.WeakMethod(method))
        self._finish_at_exit()

    def finish_early(self) -> None:
        """Do now what waits for the exit of the program, and wait until it is done; raises the first failure."""
        last, self._at_exit = self._at_exit, []
        for each in last:
            if (method := each()) is not None:
                method()
        self.wait_until_done()

    def forget_at_exit(self) -> None:
        """Call no method at exit that was given until now: what it would write is written, or makes no sense."""
        self._at_exit = []

    def stop(self, seconds: float = STOP_SECONDS) -> int:
        """Drop the jobs that wait, give those that run some seconds to end, and return how many were dropped."""
        with self._lock:
            dropped = len(self._open) - self._running
            for job in self._open.values():
                job.is_left_out = True
            self._changed.wait_for(lambda: not self._running, timeout=seconds)
            return dropped

    # With the lock

    def _add(self, job: Job) -> None:
        self._submitted += 1
        job.number = self._submitted
        if job.after_all or job.turn is not None:
            for earlier in self._open.values():
                is_before = job.after_all and earlier.owner is job.owner
                if is_before or (job.turn is not None and earlier.turn == job.turn):
                    job.wait_for(earlier)
        self._open[job.number] = job
        self._bytes += job.size
        if not job.blockers:
            self._make_ready(job)

    def _end(self, job: Job, failure: UsdsdgError | None) -> None:
        del self._open[job.number]
        self._bytes -= job.size
        job.end(failed=failure is not None or job.is_left_out)
        if failure is not None:
            self._failures.append((job, failure))
        for follower in job.followers:
            follower.blockers -= 1
            follower.is_left_out |= follower.after_all and (failure is not None or job.is_left_out)
            if not follower.blockers:
                self._make_ready(follower)
        self._changed.notify_all()

    def _make_ready(self, job: Job) -> None:
        self._ready.append(job)
        self._work_is_there.notify()

    def _is_open(self, owner: Any) -> bool:
        return bool(self._open) if owner is None else any(True for _ in self._of(owner))

    def _of(self, owner: Any) -> Iterator[Job]:
        """Return the open jobs of an owner (None: of anyone), oldest first."""
        return (job for job in self._open.values() if owner is None or job.owner is owner)

    def _is_full(self, size: int) -> bool:
        waiting = len(self._open) - self._running
        return waiting >= self.max_jobs or bool(self._bytes and self._bytes + size > self.max_bytes)

    def _raise_failure(self, owner: Any) -> None:
        """Raise the failure of the earliest job that has failed, once the jobs before it have ended."""
        while mine := [each for each in self._failures if owner is None or each[0].owner is owner]:
            job, error = min(mine, key=lambda each: each[0].number)
            if any(earlier.number < job.number for earlier in self._of(owner)):
                self._changed.wait()  # it may still fail, and would be the first
                continue
            self._failures = [each for each in self._failures if each not in mine]
            if len(mine) > 1:
                error.add_note(f"({counted(len(mine) - 1, 'more file')} failed)")
            raise error

    # Threads

    def _start_workers(self) -> None:
        while len(self._workers) < self._threads:
            # Daemons, so that Ctrl-C while draining still ends the program.
            worker = threading.Thread(target=self._work, name=f"usdsdg-io-{len(self._workers)}", daemon=True)
            self._workers.add(worker)
            worker.start()

    def _work(self) -> None:
        turns.exempt_thread()  # a frame waits for its jobs
        while True:
            with self._lock:
                while not self._ready and len(self._workers) <= self._threads:
                    self._work_is_there.wait()
                if not self._ready:
                    self._workers.discard(threading.current_thread())
                    return
                job = self._ready.popleft()
                self._running += 1
                self._changed.notify_all()
            failure = None if job.is_left_out else self._failure_of(job)
            with self._lock:
                self._running -= 1
                self._end(job, failure)
            del job, failure  # with the arrays that they keep alive

    def _failure_of(self, job: Job) -> UsdsdgError | None:
        self._on_thread.job = job
        try:
            return job.failure()
        except BaseException as error:
            if threading.current_thread() not in self._workers:
                raise  # such as Ctrl-C
            return job.failed(error)  # as sys.exit, which would end the thread and let the others wait
        finally:
            self._on_thread.job = None

    # The end of the program

    def _finish_at_exit(self) -> None:
        if not self._finishes_at_exit:
            self._finishes_at_exit = True
            # Functions run last to first: the first finalizer, this one if there was none, registers what ends all of
            # them at exit, such as those of temporary folders that jobs still need.
            weakref.finalize(self, _nothing)
            atexit.register(self._finish)

    def _finish(self) -> None:
        """Run the remaining jobs at exit; a failure that no call has raised makes the exit code 1.

        Daemon threads that capture finish their frame before, and get no more of them.
        """
        current().run.is_at_exit = True
        with turns.within(LAST_FRAME_SECONDS):
            self._finish_jobs()

    def _finish_jobs(self) -> None:
        self._threads = len(self._workers)  # none can be started any more
        last = [method for each in self._at_exit if (method := each()) is not None]
        for step in (*last, self.wait_until_done):
            try:
                step()
            except UsdsdgError as error:
                tell(error)
                current().failed_at_exit = True
            except KeyboardInterrupt:
                lost = counted(self.stop(), "file was", "files were")
                print_safely(f"error: interrupted; {lost} not written")
                current().failed_at_exit = True
                return
        current().close_run()


def _nothing() -> None:
    pass


def _forget_in_child(queue: weakref.ref[IoQueue]) -> None:
    """Let a forked process begin with an empty queue: it has no copy of the threads, and the jobs are its parent's."""
    if (alive := queue()) is not None:
        alive._at_exit = []
        alive._forget_all()


def is_done_writing() -> bool:
    """Return whether every backend has written everything."""
    return current().io_queue.is_done_writing()


def wait_until_done() -> None:
    """Block until every backend has written everything; raises the first failure."""
    current().io_queue.wait_until_done()


def set_max_queue_size(jobs: int) -> None:
    """Set how many jobs may wait before `schedule` blocks."""
    current().io_queue.set_max_queue_size(jobs)

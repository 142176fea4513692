"""Turns of threads and tasks: one call of a script at a time authors the stage or captures a frame.

USD stages are not made for threads that write at once, and a frame is made of one state of the stage. Programs with a
user interface, notebooks and `asyncio.to_thread` call from several threads all the same: a call waits until that of
another thread has ended.
"""

from __future__ import annotations

import asyncio
import functools
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec, TypeVar

from usdsdg.errors import warn_once
from usdsdg.operating_system import around_fork

# After that long a thread that waits says so: a frame may take minutes, but threads may wait for each other, too.
PATIENCE = 30.0
# How long a loop of frames lets threads that wait begin, which takes them microseconds on an idle machine.
GIVE_WAY_SECONDS = 0.1
# How long the end of a program waits for the frame of a daemon thread, which may never end.
LAST_FRAME_SECONDS = 60.0

P = ParamSpec("P")
R = TypeVar("R")


class Turns:
    """A lock that the thread that has it may take again.

    Ctrl-C may come between any two lines of it, also before `__exit__` has begun: who catches the interrupt falls back.
    """

    def __init__(self) -> None:
        self._exempt = threading.local()
        self._lock = threading.RLock()  # taken once by the thread that has it
        self._owner: int | None = None  # that thread
        self._holder = ""  # its name, or that of the one before
        self._depth = 0  # how often it has taken it
        self._taken = self._waiting = 0  # how often it was taken by any; threads that wait

    def _begin_in_child(self) -> None:
        """Begin anew in a forked process: it has the thread that forked alone, which keeps the turn if it has it."""
        self._lock = threading.RLock()
        self._taken = self._waiting = 0
        if self._owner != threading.get_ident():
            self._owner, self._depth = None, 0
        if self._depth:
            self._lock.acquire()

    def __enter__(self) -> None:
        if getattr(self._exempt, "value", False):
            return
        if not self.depth and not self._lock.acquire(blocking=False):
            self._wait()
        self._take()

    def _take(self) -> None:
        """Note that this thread has the lock, once more."""
        if not self.depth:
            self._taken += 1
            self._owner, self._holder = threading.get_ident(), threading.current_thread().name
        self._depth += 1

    def _wait(self) -> None:
        self._waiting += 1
        try:
            while not self._lock.acquire(timeout=PATIENCE):
                self._tell()
        finally:
            self._waiting -= 1

    def __exit__(self, *_: object) -> None:
        # A thread that was interrupted while it waited to have the turn back, after `set_aside`, does not have it.
        if not getattr(self._exempt, "value", False) and self.depth:
            self.fall_back(self._depth - 1)

    @property
    def depth(self) -> int:
        """How often this thread has taken the turn."""
        return self._depth if self._owner == threading.get_ident() else 0

    def fall_back(self, depth: int) -> None:
        """Have the turn as often as before, where an exception may have come from the taking or the giving of it.

        depth: as it was. A thread that had set it aside, and has not got it back, does not get it here.
        """
        if depth and self.depth:
            self._depth = depth
        elif self._lock._is_owned():  # pyright: ignore[reportAttributeAccessIssue]  # as threading.Condition asks
            self._owner, self._depth = None, 0
            self._lock.release()

    def _tell(self) -> None:
        warn_once(
            f"the thread {threading.current_thread().name!r} has waited {PATIENCE:.0f} s for a call of usdsdg by the "
            f"thread {self._holder!r}, one of which runs at a time. If that one waits for this thread, both wait "
            "forever: call usdsdg from one of them."
        )

    def exempt_thread(self) -> None:
        """Let this thread never wait: one for which the thread that has the turn may wait, such as one that writes."""
        self._exempt.value = True

    @contextmanager
    def set_aside(self) -> Iterator[None]:
        """Let other threads call meanwhile, where a call that has the turn waits for them."""
        depth = self.depth
        self.fall_back(0)
        try:
            yield
        finally:
            if depth:
                self.__enter__()
                self._depth = depth

    @contextmanager
    def within(self, seconds: float) -> Iterator[None]:
        """Have the turn, or go on without it if another thread does not give it back within so many seconds."""
        if not self.depth and not self._lock.acquire(timeout=seconds):
            yield
            return
        self._take()
        try:
            yield
        finally:
            self.__exit__()

    def give_way(self) -> None:
        """Let threads that wait have the turn, between the frames of a run; call it without having the turn."""
        taken, end = self._taken, time.monotonic() + GIVE_WAY_SECONDS
        while self._waiting and self._taken == taken and time.monotonic() < end:
            time.sleep(0.0005)


turns = Turns()
around_fork(in_child=turns._begin_in_child)


def in_turn(function: Callable[P, R]) -> Callable[P, R]:
    """Let calls of a function or method wait until calls of other threads have ended."""

    @functools.wraps(function)
    def waiting(*args: P.args, **kwargs: P.kwargs) -> R:
        if turns.depth:  # a call in a call, of which a frame has many; the outermost gives the turn back
            return function(*args, **kwargs)
        try:
            with turns:
                return function(*args, **kwargs)
        except BaseException:
            turns.fall_back(0)
            raise

    return waiting


_of_loops: dict[asyncio.AbstractEventLoop, asyncio.Lock] = {}  # a lock refers to its loop, so no weak reference does


def turn_of_task() -> asyncio.Lock:
    """Return the lock that a task has from its frame until it goes on: else it would find data of another one's."""
    loop = asyncio.get_running_loop()
    if loop not in _of_loops:
        for each in [each for each in tuple(_of_loops) if each.is_closed()]:
            _of_loops.pop(each, None)
    return _of_loops.setdefault(loop, asyncio.Lock())

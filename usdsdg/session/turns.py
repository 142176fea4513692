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
from weakref import WeakKeyDictionary

from usdsdg.errors import warn_once
from usdsdg.operating_system import around_fork

# After that long a thread that waits says so: a frame may take minutes, but threads may wait for each other, too.
PATIENCE = 30.0
# How long a loop of frames lets threads that wait begin, which takes them microseconds on an idle machine.
GIVE_WAY_SECONDS = 0.1

P = ParamSpec("P")
R = TypeVar("R")


class Turns:
    """A lock that the thread that has it may take again."""

    def __init__(self) -> None:
        self._exempt = threading.local()
        self._lock = threading.RLock()
        self._owner: int | None = None  # the thread that has it
        self._holder = ""  # its name, or that of the one before
        self._depth = 0  # how often it has taken it
        self._taken = self._waiting = 0  # how often it was taken by any; threads that wait

    def _begin_in_child(self) -> None:
        """Begin anew in a forked process: it has the thread that forked alone, which keeps the turn if it has it."""
        self._lock = threading.RLock()
        self._taken = self._waiting = 0
        if self._owner != threading.get_ident():
            self._owner, self._depth = None, 0
        for _ in range(self._depth):
            self._lock.acquire()

    def __enter__(self) -> None:
        if getattr(self._exempt, "value", False):
            return
        if not self._lock.acquire(blocking=False):
            self._waiting += 1
            try:
                while not self._lock.acquire(timeout=PATIENCE):
                    self._tell()
            finally:
                self._waiting -= 1
        self._taken += 1
        self._depth += 1
        self._owner, self._holder = threading.get_ident(), threading.current_thread().name

    def __exit__(self, *_: object) -> None:
        # A thread that was interrupted while it waited to have the turn back, after `set_aside`, does not have it.
        if not getattr(self._exempt, "value", False) and self._owner == threading.get_ident():
            self._depth -= 1
            if not self._depth:
                self._owner = None
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
        depth = self._depth if self._owner == threading.get_ident() else 0
        for _ in range(depth):
            self.__exit__()
        try:
            yield
        finally:
            for _ in range(depth):
                self.__enter__()

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
        with turns:
            return function(*args, **kwargs)

    return waiting


_of_loops: WeakKeyDictionary[asyncio.AbstractEventLoop, asyncio.Lock] = WeakKeyDictionary()


def turn_of_task() -> asyncio.Lock:
    """Return the lock that a task has from its frame until it goes on: else it would find data of another one's."""
    return _of_loops.setdefault(asyncio.get_running_loop(), asyncio.Lock())

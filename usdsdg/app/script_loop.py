"""The event loop of scripts.

A script runs as in plain Python, outside any running loop: Ctrl-C, `asyncio.run` and `run_until_complete` do what they
always do, and `asyncio.ensure_future` finds the loop made here. Its tasks get a turn at every update of the application
and at every step; what is left of them runs after the script.
"""

from __future__ import annotations

import asyncio
import weakref
from collections.abc import Callable, Coroutine
from typing import Any

# How long tasks that are cancelled at the end may take to clean up.
CLEAN_UP_SECONDS = 2.0


class ScriptLoop:
    """An event loop that is turned a little at a time. The first failure that nobody collects is raised."""

    def __init__(self) -> None:
        self._tasks: weakref.WeakSet[asyncio.Task[Any]] = weakref.WeakSet()
        # asyncio itself holds tasks weakly: one that waits for something that only it knows would be collected.
        self._running: set[asyncio.Task[Any]] = set()
        self._lost: list[Exception] = []
        self._news: asyncio.Future[None] | None = None  # a task ended or a failure was lost
        self._loop = asyncio.new_event_loop()
        self._loop.set_task_factory(self._new_task)
        self._loop.set_exception_handler(self._on_lost)
        asyncio.set_event_loop(self._loop)

    def turn(self) -> None:
        """Let whatever is ready run once. Inside a running loop that happens by itself, so nothing is done."""
        if asyncio._get_running_loop() is not None or self._loop.is_running():
            return
        stop = self._loop.call_soon(self._loop.stop)
        try:
            self._loop.run_forever()
        finally:
            stop.cancel()
        self._raise_lost()

    def run_until_complete(self, work: Coroutine[Any, Any, Any]) -> Any:
        """The result of one coroutine; other tasks run meanwhile."""
        result = self._loop.run_until_complete(work)
        self._raise_lost()
        return result

    def run_dry(self, goes_on: Callable[[], bool]) -> None:
        """Run until every task has ended, or until `goes_on()` is false after one has."""
        while goes_on() and asyncio.all_tasks(self._loop):
            self._raise_lost()
            self._news = self._loop.create_future()
            self._loop.run_until_complete(self._news)
        self._raise_uncollected()

    def close(self) -> None:
        """Cancel what is left, let it clean up, and forget the loop, as `asyncio.run` does at its end."""
        left = asyncio.all_tasks(self._loop)
        for task in left:
            task.cancel()
        try:
            if left:
                self._loop.run_until_complete(asyncio.wait(left, timeout=CLEAN_UP_SECONDS))
            for task in left:
                # A Ctrl-C between the end of what a task waits for and its next step takes the step away for ever.
                task._log_destroy_pending = False  # type: ignore[attr-defined]
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
        finally:
            asyncio.set_event_loop(None)
            self._loop.close()

    # --- failures that nobody sees ---
    def _new_task(self, loop: asyncio.AbstractEventLoop, coro: Any, **options: Any) -> asyncio.Task[Any]:
        task = asyncio.Task(coro, loop=loop, **options)
        self._running.add(task)
        task.add_done_callback(self._running.discard)
        task.add_done_callback(lambda _: self._wake())
        self._tasks.add(task)
        return task

    def _on_lost(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """asyncio tells of a callback that failed, or of a failed task that is gone without having been awaited."""
        error = context.get("exception")
        if error is None:
            loop.default_exception_handler(context)
        elif isinstance(error, Exception):  # SystemExit and Ctrl-C have ended the loop already
            self._lost.append(error)
            if not loop.is_closed():
                loop.call_soon_threadsafe(self._wake)

    def _wake(self) -> None:
        if self._news is not None and not self._news.done():
            self._news.set_result(None)

    def _raise_lost(self) -> None:
        if self._lost:
            raise self._lost.pop(0)

    def _raise_uncollected(self) -> None:
        """Once nothing runs any more, nobody can collect the failure of a task that is still remembered somewhere."""
        self._raise_lost()
        for task in self._tasks:
            # True until somebody retrieves the exception: asyncio's own test for "never retrieved".
            if task.done() and not task.cancelled() and getattr(task, "_log_traceback", False):
                error = task.exception()
                if error is not None:
                    raise error

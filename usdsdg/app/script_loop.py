"""The event loop of scripts.

A script runs as in plain Python, outside any running loop: Ctrl-C, `asyncio.run` and `run_until_complete` behave as
usual, and `asyncio.ensure_future` uses the loop made here. Its tasks run one step at every update of the application
and at every orchestrator step; those that remain run after the script.
"""

import asyncio
import weakref
from collections.abc import Callable, Coroutine
from typing import Any

from usdsdg.errors import ScriptStopped
from usdsdg.session.turns import in_turn

# What has ended the loop already, or ends the script at its next frame.
_ENDS = (SystemExit, KeyboardInterrupt, ScriptStopped)
# Time that cancelled tasks have to clean up at the end.
CLEAN_UP_SECONDS = 2.0


class ScriptLoop:
    """An event loop that runs in steps and raises the first task exception that is never retrieved."""

    def __init__(self) -> None:
        self._tasks: weakref.WeakSet[asyncio.Task[Any]] = weakref.WeakSet()
        # asyncio references tasks weakly: a task that awaits a future referenced only by itself would be collected.
        self._running: set[asyncio.Task[Any]] = set()
        self._unretrieved: list[BaseException] = []
        self._wake_up: asyncio.Future[None] | None = None  # set when a task has ended or failed unretrieved
        self._loop = asyncio.new_event_loop()
        self._loop.set_task_factory(self._new_task)
        self._loop.set_exception_handler(self._on_unretrieved)
        asyncio.set_event_loop(self._loop)

    def run_ready(self) -> None:
        """Run what is ready once; does nothing inside a running loop, which does so by itself."""
        if asyncio._get_running_loop() is not None or self._loop.is_running():
            return
        stop = self._loop.call_soon(self._loop.stop)
        try:
            self._loop.run_forever()
        finally:
            stop.cancel()
        self._raise_unretrieved()

    def has_other_tasks(self) -> bool:
        """Return whether there are tasks that have not ended, apart from the one that runs."""
        own = asyncio.current_task(self._loop) if self._loop.is_running() else None
        return any(task is not own for task in asyncio.all_tasks(self._loop))

    def run_until_complete(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Run one coroutine to its end, along with other tasks, and return its result."""
        result = self._loop.run_until_complete(work)
        self._raise_unretrieved()
        return result

    def run_until_done(self, keep_running: Callable[[], bool]) -> None:
        """Run until every task has ended, or until `keep_running()` is false after one has."""
        while keep_running() and asyncio.all_tasks(self._loop):
            self._raise_unretrieved()
            self._wake_up = self._loop.create_future()
            self._loop.run_until_complete(self._wake_up)
        self._raise_remaining()

    @in_turn  # frames of other threads let the loop run
    def close(self) -> None:
        """Cancel the remaining tasks, let them clean up, and close the loop, as `asyncio.run` does at its end."""
        remaining = asyncio.all_tasks(self._loop)
        for task in remaining:
            task.cancel()
        try:
            if remaining:
                self._loop.run_until_complete(asyncio.wait(remaining, timeout=CLEAN_UP_SECONDS))
            for task in remaining:
                # A task never wakes up if Ctrl-C came between the end of what it awaits and its next step.
                task._log_destroy_pending = False  # type: ignore[attr-defined]
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
        finally:
            asyncio.set_event_loop(None)
            self._loop.close()

    # --- exceptions that are never retrieved ---
    def _new_task(self, loop: asyncio.AbstractEventLoop, coro: Any, **options: Any) -> asyncio.Task[Any]:
        task = asyncio.Task(coro, loop=loop, **options)
        self._running.add(task)
        task.add_done_callback(self._running.discard)
        task.add_done_callback(lambda _: self._wake())
        self._tasks.add(task)
        return task

    def _on_unretrieved(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Keep the exception of a callback, or of a task that was collected without being awaited."""
        error = context.get("exception")
        if error is None:
            loop.default_exception_handler(context)
        elif not isinstance(error, _ENDS):
            self._unretrieved.append(error)
            if not loop.is_closed():
                loop.call_soon_threadsafe(self._wake)

    def _wake(self) -> None:
        if self._wake_up is not None and not self._wake_up.done():
            self._wake_up.set_result(None)

    def _raise_unretrieved(self) -> None:
        if self._unretrieved:
            raise self._unretrieved.pop(0)

    def _raise_remaining(self) -> None:
        """Raise the exception of a task that is still referenced: once no task runs, none can retrieve it."""
        self._raise_unretrieved()
        for task in self._tasks:
            # True until the exception is retrieved: asyncio's own test for "never retrieved".
            if task.done() and not task.cancelled() and getattr(task, "_log_traceback", False):
                error = task.exception()
                if error is not None:
                    raise error

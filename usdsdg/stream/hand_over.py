"""A function that runs in a thread and hands over items, of which only a few wait."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

from usdsdg.errors import ScriptStopped
from usdsdg.session.turns import turns

Item = TypeVar("Item")

# Without a timeout Ctrl-C would not interrupt the wait on every platform.
POLL_SECONDS = 0.2
# How long `close` waits for the function to end, once it has been told to at its next item.
END_SECONDS = 600.0


class Closed(ScriptStopped):
    """Raised by `put` after `close`, to end the function."""


class HandOver(Generic[Item]):
    """Runs `work(put)` in a thread, where `put(item)` waits while `waiting` items have not been taken."""

    def __init__(self, work: Callable[[Callable[[Item], None]], None], *, waiting: int) -> None:
        self._work = work
        self._items: queue.Queue[Item] = queue.Queue(waiting)
        self._closing = threading.Event()
        self._failure: BaseException | None = None
        # A daemon, so that an interpreter that exits in the middle of a stream does not wait for its end.
        self._thread = threading.Thread(target=self._run, name="usdsdg-stream", daemon=True)
        self._thread.start()

    def __iter__(self) -> Iterator[Item]:
        """Yield the items in order; raises what the function raised, after the items before it."""
        while True:
            ended = not self._thread.is_alive()
            try:
                yield self._items.get(timeout=0.0 if ended else POLL_SECONDS, block=not ended)
            except queue.Empty:
                if ended:
                    break
        if self._failure is not None:
            raise self._failure

    def close(self) -> None:
        """Let the function end at its next item, and wait for it."""
        self._closing.set()
        self._thread.join(END_SECONDS)

    def _put(self, item: Item) -> None:
        while not self._closing.is_set():
            try:
                with turns.set_aside():  # within a frame; who takes the item may call usdsdg before
                    self._items.put(item, timeout=POLL_SECONDS)
                return
            except queue.Full:
                continue
        raise Closed

    def _run(self) -> None:
        try:
            self._work(self._put)
        except Closed:
            pass
        except BaseException as error:  # noqa: BLE001 - raised where the items are taken
            self._failure = error

"""Messages between one page and the thread that owns the engines.

What a page asks for waits in a bounded queue. Of pictures only the latest of each kind waits, and the owner draws the
next one when the page has shown the one before: a slow page gets fewer pictures, never old ones.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import Any

# A page sends a message for each of its own pictures at most; one that sends more is not ours.
MOST_WAITING = 2000
# Pictures that are on their way: one that is shown while the next is drawn.
IN_FLIGHT = 2


class TooMany(Exception):
    """A page asks for more than is worked off."""


class Channel:
    """One page's messages, in both directions. `wake` is called when the owner has something to do."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._lock = threading.Lock()
        self._asked: list[str] = []
        self._texts: list[str] = []
        self._pictures: dict[str, tuple[int, bytes]] = {}  # by kind: number and message
        self._drawn = self._shown = 0
        self._notify: Callable[[], None] = lambda: None
        self.is_open = True

    # --- for the server's thread ---
    def listen(self, notify: Callable[[], None]) -> None:
        """Call `notify` whenever something is to be sent."""
        self._notify = notify
        notify()

    def ask(self, text: str) -> None:
        """Add a message of the page.

        Raises:
            TooMany: so many wait already.
        """
        with self._lock:
            if len(self._asked) >= MOST_WAITING:
                raise TooMany
            self._asked.append(text)
        self._wake()

    def outgoing(self) -> list[str | bytes]:
        """Return what is to be sent now, texts before pictures."""
        with self._lock:
            texts, self._texts = self._texts, []
            pictures, self._pictures = self._pictures, {}
        return [*texts, *(message for _, message in pictures.values())]

    def close(self) -> None:
        """Tell the owner that the page is gone."""
        self.is_open = False
        self._wake()

    # --- for the owner's thread ---
    def asked(self) -> list[str]:
        """Return the messages of the page since the last call."""
        with self._lock:
            asked, self._asked = self._asked, []
        return asked

    def tell(self, **values: Any) -> None:
        """Send values to the page; none is left out."""
        text = json.dumps(values, separators=(",", ":"), allow_nan=False)
        with self._lock:
            self._texts.append(text)
        self._notify()

    def show(self, kind: str, header: dict[str, Any], data: bytes) -> None:
        """Send a picture: it replaces one of the same kind that has not been sent yet."""
        with self._lock:
            self._drawn += 1
            if kind in self._pictures:  # which the page will never show
                self._shown += 1
            head = json.dumps({"kind": kind, **header}, separators=(",", ":"), allow_nan=False).encode()
            self._pictures[kind] = self._drawn, len(head).to_bytes(4, "big") + head + data
        self._notify()

    def note_shown(self) -> None:
        """Note that the page has shown a picture."""
        with self._lock:
            self._shown = min(self._shown + 1, self._drawn)

    @property
    def wants_pictures(self) -> bool:
        """Whether the page keeps up with the pictures that it has been sent."""
        with self._lock:
            return self.is_open and self._drawn - self._shown < IN_FLIGHT

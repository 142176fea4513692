"""New frames, as Kit tells of them: its viewport shows one at every update, whether anything captures it or not."""

from __future__ import annotations

from collections.abc import Callable

from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import get_orchestrator


class NewFrames:
    """Calls `listener(number)` after every app update and every captured frame, once where an update captures one.

    No image is rendered for it: who reads a sensor then gets one of the stage as it is.
    """

    def __init__(self, listener: Callable[[int], None]) -> None:
        self._listener = listener
        self._number = 0
        self._captured_in = -1  # the number of the last update in or after which a frame was captured
        get_app().subscribe_update(lambda _dt: self._on_update())
        get_orchestrator().on_captured(self._on_captured)

    def _on_update(self) -> None:
        if self._captured_in != get_app().get_update_number():
            self._tell()

    def _on_captured(self) -> None:
        self._captured_in = get_app().get_update_number()
        self._tell()

    def _tell(self) -> None:
        self._number += 1
        self._listener(self._number)

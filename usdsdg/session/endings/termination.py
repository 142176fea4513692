"""Signals by which schedulers and closed terminals end a process: the frame in hand is finished first."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

# SIGXCPU comes once the processor time that a process may take (`ulimit -t`) is used up. Windows has SIGTERM only.
NAMES = ("SIGTERM", "SIGHUP", "SIGXCPU")


class Terminated(KeyboardInterrupt):
    """The process was asked to end by a signal; as after Ctrl-C, files in hand are finished."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number
        self.exit_code = 128 + number  # as a shell reports it


class _Pending:
    """The signal that waits for the end of the frame."""

    def __init__(self) -> None:
        self.number: int | None = None
        self.frames = 0  # that are being captured: one, or none
        self.process = 0  # the one that has frames to finish; its copies by fork, as of a pool, have none

    def on_signal(self, number: int, _frame: FrameType | None) -> None:
        if os.getpid() != self.process:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        if signal.Signals(number).name == "SIGXCPU":
            signal.signal(number, signal.SIG_IGN)  # the system sends it again each second, which asks for nothing more
        if self.number is None and self.frames:
            self.number = number
            # The terminal may be gone.
            with suppress(OSError):
                os.write(2, f"{signal.Signals(number).name}: stopping after this frame\n".encode())
            return
        raise Terminated(number)


_pending = _Pending()


@contextmanager
def listening() -> Iterator[None]:
    """Turn these signals into `Terminated`, raised between frames; those that are ignored, as under nohup, stay so.

    Only the main thread can; elsewhere nothing changes.
    """
    before, _pending.process = {}, os.getpid()
    if threading.current_thread() is threading.main_thread():
        for name in NAMES:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.signal(number, _pending.on_signal)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _pending.number = None


@contextmanager
def whole_frame() -> Iterator[None]:
    """Hold a signal back while a frame is captured; a second one is not held back.

    Raises:
        Terminated: at the end of the frame, if a signal came.
    """
    _pending.frames += 1
    _pending.process = os.getpid()
    try:
        yield
    finally:
        _pending.frames -= 1
    if _pending.number is not None:
        raise Terminated(_pending.number)


@contextmanager
def between_frames() -> Iterator[None]:
    """Within a frame that is whole already, let a signal end the process at once again, Ctrl-C too.

    Jobs, which hold Ctrl-C back until the end of the frame, do so again afterward.
    """
    frames, _pending.frames = _pending.frames, 0
    is_main = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, signal.default_int_handler) if is_main else None
    try:
        yield
    finally:
        _pending.frames = frames
        if is_main:
            signal.signal(signal.SIGINT, before)

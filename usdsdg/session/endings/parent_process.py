"""The process that has started this one to make a part of a dataset: where it is gone, this one ends as after SIGTERM.

Its own end of a pipe, the other of which is this one's input, is closed by the system however it ends, by SIGKILL too.
"""

from __future__ import annotations

import os
import signal
import threading

from usdsdg.operating_system import interrupt_main_thread

# Set for a process of which the input ends with its parent; it removes the variable, which is not of what it starts.
VARIABLE = "USDSDG_INPUT_ENDS_WITH_PARENT"


def watch() -> None:
    """Where the parent has asked for it, end the main thread as by SIGTERM once the parent is gone.

    Call it where signals are listened to. The input is empty from then on, for scripts that read it.
    """
    if os.environ.pop(VARIABLE, None) is None:
        return
    parent = os.dup(0)
    empty = os.open(os.devnull, os.O_RDONLY)
    os.dup2(empty, 0)
    os.close(empty)
    # A daemon, and no file object, of which the lock would be held at the end of this process.
    threading.Thread(target=_end_after, args=(parent,), name="usdsdg-parent", daemon=True).start()


def _end_after(parent: int) -> None:
    while os.read(parent, 1):
        pass
    interrupt_main_thread(signal.SIGTERM)

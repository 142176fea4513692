"""Copies of a process by fork that capture frames: of two that write to one dataset, each would replace the other's."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence

from usdsdg.errors import DatasetInTheWay
from usdsdg.writers.journal.run import Run

# A process that becomes a daemon forks and ends; its copy, which goes on with the dataset, may be quicker.
_SECONDS = 1.0


def check_copy(run: Run, folders: Sequence[str | None]) -> None:
    """Check that this process may capture frames for the output folders of writers; None: not known.

    Raises:
        DatasetInTheWay: it is a copy of one that has begun a dataset in one of them, and has not ended.
    """
    begun = {each.place.name for each in run.folders} if run.is_copy else set()
    shared = next((each for each in folders if each in begun), None)
    if shared is None:
        return
    end = time.monotonic() + _SECONDS
    while os.getppid() == run.process and time.monotonic() < end:
        time.sleep(0.01)
    if os.getppid() == run.process:
        raise DatasetInTheWay(
            f"{shared}: this process is a copy, by fork, of the one that writes to this dataset, and each would "
            "replace the other's frames. Capture in one of them, or have several processes make the frames with "
            "usdsdg run --workers N."
        )

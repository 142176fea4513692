"""USD's threads in processes that fork, as those of a DataLoader's workers do."""

from __future__ import annotations

from usdsdg.operating_system import around_fork, wait_for_other_threads

# A thread that has found nothing to do for some milliseconds sleeps.
REST_SECONDS = 0.1


def _let_rest() -> None:
    """Wait until USD's threads sleep.

    A fork that comes while one of them holds a lock leaves it locked in the child, which has no such thread, and then
    waits for ever when it closes or composes a stage.
    """
    wait_for_other_threads(REST_SECONDS)


def prepare_forks() -> None:
    """Let forks of this process, from now on, find USD's threads at rest."""
    around_fork(before=_let_rest)

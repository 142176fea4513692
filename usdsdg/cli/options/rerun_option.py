"""`--rerun`: show a job in the Rerun viewer while it runs, or record it in a file."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import click

from usdsdg.cli.options.values import PLACE
from usdsdg.errors import BadValue

VIEWER = "viewer"

rerun_option = click.option(
    "--rerun",
    metavar="[FILE.rrd]",
    type=PLACE,
    help="Show the frames in the Rerun viewer, or record them in a file; needs usdsdg[rerun].",
)


@contextmanager
def recorded(target: str | None, *, workers: bool) -> Iterator[None]:
    """Record the frames that are captured in the context. target: a file, "viewer", or None for neither.

    workers: whether other processes make the frames.

    Raises:
        BadValue: other processes make the frames.
        Unsupported, OutputNotWritable: as `JobRecording`.
    """
    if target is None:
        yield
        return
    if workers:
        raise BadValue("--rerun records the frames of one process: it cannot be given with --workers or --ray")
    from usdsdg.session.session import current
    from usdsdg.writers.formats.rerun.recording import JobRecording

    recording = current().companion = JobRecording(target)
    try:
        yield
    finally:
        current().companion = None
        if (file := recording.close()) is not None:
            print(f"recording: {file}; look at it with: rerun {file}", file=sys.stderr)

"""The frames of a job as an iterator."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from usdsdg.annotators import named_annotators
from usdsdg.annotators.class_table import CLOSED
from usdsdg.capture.tap import Tap
from usdsdg.errors import ArgumentError, GraphError
from usdsdg.operating_system import around_fork
from usdsdg.session import engines, session
from usdsdg.stream.hand_over import HandOver
from usdsdg.stream.sample import Sample
from usdsdg.stream.source import Source

# The session is one object of the process, and so is the job that runs in it.
_streaming = threading.Lock()


def _forget_parent() -> None:
    """Let a forked process stream, even if its parent did."""
    global _streaming
    _streaming = threading.Lock()


around_fork(in_child=_forget_parent)


def frames(
    job: str | os.PathLike[str],
    annotators: Sequence[str] = ("rgb",),
    *,
    arguments: Sequence[str] = (),
    seed: int | None = None,
    part: tuple[int, int] = (0, 1),
    ahead: int = 2,
    device: str | None = None,
) -> Iterator[Sample]:
    """Run a job in a thread of this process, and yield what its render products show, frame by frame.

    The writers of the job write nothing. Frame k is the same whatever part of the frames is asked for, since graph and
    physics run through all of them; only those asked for are rendered, unless an annotator compares frames.

    Args:
        job: a configuration of `usdsdg generate`, or a script of `usdsdg run`.
        annotators: their names, as for `rep.annotators.get`.
        arguments: "key=value" overrides of the configuration, or the arguments of the script.
        seed: of the run; None: the configuration's, 0 for a script.
        part: (i, n) yields the frames i, i + n, i + 2n and so on.
        ahead: how many samples are made before they are asked for; at least 1.
        device: where it runs, "cpu" or "cuda:0"; None: CUDA where there is one.

    Yields:
        one Sample for each render product of a frame that a writer is attached to, or for all of them in a job without
        writers; in the order of frames, then of render products.

    Raises:
        ConfigError: there is no such job, or it is wrong.
        AnnotatorRegistryError: there is no such annotator.
        ArgumentError: `part` or `ahead` is out of range.
        GraphError: a stage is open in this process, which the job would replace, or another stream runs in it.
        UsdsdgError: as the job raises.
    """
    first, step = _checked_part(part, ahead)
    source = Source(Path(job), tuple(arguments), seed)
    source.check()
    for name in annotators:
        named_annotators.get(name)
    return _stream(source, tuple(annotators), (first, step), ahead, device)


def _checked_part(part: tuple[int, int], ahead: int) -> tuple[int, int]:
    first, step = part
    if not 0 <= first < step:
        raise ArgumentError(f"stream: part is {part!r}; expected (i, n) with i from 0 to n - 1")
    if ahead < 1:
        raise ArgumentError(f"stream: ahead is {ahead!r}; expected 1 or more")
    return first, step


def _stream(
    source: Source, annotators: tuple[str, ...], part: tuple[int, int], ahead: int, device: str | None
) -> Iterator[Sample]:
    if not _streaming.acquire(blocking=False):
        raise GraphError("stream: another one runs in this process; end it first, or use a process for each")
    try:
        if session.current().stage is not None:
            raise GraphError(
                "stream: a stage is open in this process, which the job would replace; run the stream in a process of "
                "its own (DataLoader with num_workers=1)"
            )

        def work(put: Callable[[Sample], None]) -> None:
            engines.use_device(device)
            first, step = part
            # Parts have the same ids only of classes that all of them know.
            session.current().settings.set(CLOSED, step > 1)
            session.current().tap = Tap(
                annotators, lambda frame: frame % step == first, lambda view: put(Sample.of(view))
            )
            source.run()

        hand_over = HandOver(work, waiting=ahead)
        try:
            yield from hand_over
        finally:
            hand_over.close()
            session.restart()
    finally:
        _streaming.release()

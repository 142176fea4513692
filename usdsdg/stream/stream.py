"""The frames of a job as an iterator."""

from __future__ import annotations

import atexit
import contextlib
import operator
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, SupportsIndex
from weakref import WeakSet

from usdsdg.annotators.class_table import CLOSED
from usdsdg.capture.tap import Asked, Tap, annotator_of
from usdsdg.capture.worlds import WorldBatch, WorldTap
from usdsdg.errors import ArgumentError, GraphError, Unsupported
from usdsdg.operating_system import around_fork
from usdsdg.session import devices, session
from usdsdg.stream.files_aside import files_aside
from usdsdg.stream.hand_over import HandOver, Item
from usdsdg.stream.sample import Sample
from usdsdg.stream.source import Source

TURN_SECONDS = 0.0005

# The session is one object of the process, and so is the job that runs in it.
_streaming = threading.Lock()


def _forget_parent() -> None:
    """Let a forked process stream, even if its parent did."""
    global _streaming
    _streaming = threading.Lock()


around_fork(in_child=_forget_parent)

# Streams whose iterator is still referenced. At exit Python may finalize them after the modules that they use.
_held: WeakSet[Iterator[Any]] = WeakSet()
_is_exiting = False


def _let_go() -> None:
    """Close the streams that are held at the end of the program, without waiting for their jobs."""
    global _is_exiting
    _is_exiting = True
    for each in list(_held):
        with contextlib.suppress(ValueError):  # another thread waits for its next item
            each.close()  # pyright: ignore[reportAttributeAccessIssue]


atexit.register(_let_go)


def _closed_at_exit(items: Iterator[Item]) -> Iterator[Item]:
    _held.add(items)
    return items


def frames(
    job: str | os.PathLike[str],
    annotators: Sequence[Asked] = ("rgb",),
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
        annotators: their names, as for `rep.annotators.get`, or pairs (name, init_params).
        arguments: "key=value" overrides of the configuration, or the arguments of the script.
        seed: of the run; None: the configuration's, 0 for a script.
        part: (i, n) yields the frames i, i + n, i + 2n and so on.
        ahead: how many samples are made before they are asked for; at least 1.
        device: where it renders, "cpu" or "cuda:0"; None: CUDA where there is one.

    Yields:
        one Sample for each render product of a frame that a writer is attached to, or for all of them in a job without
        writers; in the order of frames, then of render products.

    Raises:
        ConfigError: there is no such job, or it is wrong.
        AnnotatorRegistryError: there is no such annotator.
        ArgumentError: `part` or `ahead` is out of range, or one text was given in place of a list.
        GraphError: a stage is open in this process, which the job would replace, or another stream runs in it.
        UsdsdgError: as the job raises.
    """
    first, step = checked_part(part)
    _check_ahead(ahead)
    annotators = _several("annotators", annotators)
    source = Source(Path(job), _texts(arguments), seed)
    source.check()
    asked: dict[str, Asked] = {}
    for each in annotators:
        name = annotator_of(each).get_name()
        if asked.setdefault(name, each) != each:
            raise ArgumentError(f"stream: annotators has {name} with several parameters; samples hold one of each name")

    def begin(put: Callable[[Sample], None]) -> None:
        # Parts have the same ids only of classes that all of them know.
        session.current().settings.set(CLOSED, step > 1)
        session.current().tap = Tap(annotators, lambda frame: frame % step == first, lambda view: put(Sample.of(view)))

    return _closed_at_exit(_run(source, begin, ahead, device))


def worlds(
    job: str | os.PathLike[str],
    annotators: Sequence[str] = ("rgb",),
    *,
    count: int,
    arguments: Sequence[str] = (),
    seed: int | None = None,
    ahead: int = 1,
    device: str | None = None,
) -> Iterator[WorldBatch]:
    """Run a job in a thread of this process as `count` worlds at a time, and yield what they show, on the device.

    World w of the batch with frame k shows what frame k + w of the job shows: the draws of the graph for the next
    `count` frames are made and rendered together. What a script changes itself between two steps is the same in all
    worlds of a step. The writers of the job write nothing.

    Args:
        annotators: rgb, LdrColor, HdrColor, semantic_segmentation, instance_segmentation, bounding_box_2d_tight, and
            AOVs of the renderer such as distance_to_camera, distance_to_image_plane and normals.
        count: of worlds.
        job: a script, or a Replicator YAML file.
        arguments, seed, device: as in `frames`.
        ahead: how many batches are made before they are asked for, beside the one that is being made; at least 1.

    Yields:
        one WorldBatch for each render product of a step; see `WorldBatch.wait`.

    Raises:
        ArgumentError: worlds cannot show an annotator, or `count` or `ahead` is below 1.
        Unsupported: something on the stage or in the graph cannot be drawn for worlds; names the script line. Or the
            job is a configuration.
        UsdsdgError: as in `frames`.
    """
    _check_ahead(ahead)
    annotators = _several("annotators", annotators)
    source = Source(Path(job), _texts(arguments), seed)
    source.check()
    if source.is_configuration:
        raise Unsupported(
            f"worlds: {job} is a configuration, whose job places things itself before each frame, so that all worlds "
            "would show the same. Give a script whose graph draws what changes, or take the frames of the job from "
            "usdsdg.stream.frames, or a LiveDataset without worlds."
        )

    def begin(put: Callable[[WorldBatch], None]) -> None:
        session.current().worlds = WorldTap(count, annotators, put)

    return _closed_at_exit(_in_short_turns(_run(source, begin, ahead, device)))


def _several(name: str, given: Sequence[Any]) -> tuple[Any, ...]:
    if isinstance(given, str):
        raise ArgumentError(f"stream: {name} is the text {given!r}; give a list, such as [{given!r}]")
    return tuple(given)


def _texts(arguments: Sequence[Any]) -> tuple[str, ...]:
    return tuple(map(str, _several("arguments", arguments)))


def _in_short_turns(items: Iterator[Item]) -> Iterator[Item]:
    """Let Python's threads take shorter turns meanwhile.

    A trainer gives Python's lock away at each call of its library, and would wait for a whole turn of the thread that
    draws to get it back.
    """
    before = sys.getswitchinterval()
    sys.setswitchinterval(TURN_SECONDS)
    try:
        yield from items
    finally:
        sys.setswitchinterval(before)


def checked_part(part: tuple[int, int], *, who: str = "stream") -> tuple[int, int]:
    """Return (i, n), the frames i, i + n, i + 2n and so on.

    Raises:
        ArgumentError: it is something else, or i is not from 0 to n - 1.
    """
    try:
        first, step = map(operator.index, part)
    except (TypeError, ValueError):  # something else, or not two of them
        first, step = 0, 0
    if not 0 <= first < step:
        raise ArgumentError(f"{who}: part is {part!r}; expected (i, n) with i from 0 to n - 1")
    return first, step


def _check_ahead(ahead: int) -> None:
    if not isinstance(ahead, SupportsIndex) or ahead.__index__() < 1:
        raise ArgumentError(f"stream: ahead is {ahead!r}; expected 1 or more")


def _run(
    source: Source, begin: Callable[[Callable[[Item], None]], None], ahead: int, device: str | None
) -> Iterator[Item]:
    """Run a job in a thread, after `begin` with a function that takes the items, and yield these."""
    if not _streaming.acquire(blocking=False):
        raise GraphError(
            "stream: another one runs in this process; end it first (close() it, or del the DataLoader's iterator), "
            "or use a process for each (DataLoader with num_workers=1)"
        )
    try:
        if session.current().stage is not None:
            raise GraphError(
                "stream: a stage is open in this process, which the job would replace; run the stream in a process of "
                "its own (DataLoader with num_workers=1)"
            )

        is_script, is_empty = not source.is_configuration, True

        def work(put: Callable[[Item], None]) -> None:
            def put_of_script(item: Item) -> None:
                source.tell_of_own_seed()
                put(item)

            devices.use_device(device)
            begin(put_of_script if is_script else put)
            source.run()

        with files_aside(keeps_folders=is_script):
            hand_over = HandOver(work, waiting=ahead)
            try:
                for item in hand_over:
                    is_empty = False
                    yield item
                if is_script and is_empty:
                    source.tell_of_no_frame()
            finally:
                if not _is_exiting:
                    hand_over.close()
                    session.restart()
    finally:
        _streaming.release()

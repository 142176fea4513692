"""Capturing the frames of a job: render settings, the loop, and what is said at the end."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import usdsdg as rep
from usdsdg.capture.render_settings import MIN_SAMPLES
from usdsdg.errors import counted, warn_once
from usdsdg.graph.sampling import set_global_seed
from usdsdg.orchestrator import get_orchestrator
from usdsdg.scenarios.interruption import stop_request
from usdsdg.scenarios.shared.formats import folders, make_writers
from usdsdg.scenarios.shared.sections import JobConfig, Rendering
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.writers import Writer
from usdsdg.writers.formats.splits import Splits
from usdsdg.writers.journal.run import get_run

_FEW = 100  # frames for each part of a dataset; with more, a part that gets none has a share of less than 1 %
# Samples of a path-traced picture that a filter cleans well.
_PATH_TRACED = 128


@dataclass(frozen=True)
class Arranged:
    """Frames of one stage, the current one, and what prepares the stage for each of them."""

    frames: range
    prepare: Callable[[int], None]


@dataclass(frozen=True)
class Summary:
    """Result of a run."""

    frames: int
    images: int
    seconds: float
    folders: tuple[str, ...]


def begin(
    config: JobConfig, *, frames_per_scene: int | None = None
) -> tuple[dict[str, list[str]], list[tuple[str, Writer]]]:
    """Set seed, render mode and classes; return the mesh files by class, and the initialized writers by format.

    frames_per_scene: so many frames in a row belong together, and are not divided by splits; None: each is its own.

    Raises:
        WriterError: an option of a format has a wrong value, or its files cannot be written.
    """
    set_global_seed(config.seed)
    _apply_rendering(config.rendering)
    by_label = config.files()
    if not current().class_tables.given:  # by --semantic-classes
        rep.settings.set_semantic_classes(list(by_label))
    _warn_of_empty_splits(config.splits, config.num_frames, frames_per_scene or 1)
    common = {"splits": config.splits, "min_visibility": config.min_visibility, "min_pixels": config.min_pixels}
    common |= {} if frames_per_scene is None else {"frames_per_scene": frames_per_scene}
    return by_label, make_writers(config.output_dir, config.formats, common)


def _apply_rendering(rendering: Rendering) -> None:
    settings = get_settings()
    settings.set("/rtx/rendermode", "PathTracing" if rendering.path_tracing else "RaytracedLighting")
    samples = max(rendering.samples, _PATH_TRACED)
    settings.set("/rtx/pathtracing/spp", samples)
    settings.set("/rtx/pathtracing/totalSpp", samples)
    settings.set("/rtx/pathtracing/optixDenoiser/enabled", True)


def capture(
    frames: int,
    stages: Iterable[Arranged],
    rendering: Rendering,
    *,
    views: int,
    writers: Sequence[tuple[str, Writer]],
) -> Summary:
    """Prepare and capture each frame; after Ctrl-C end with the frame, and raise KeyboardInterrupt.

    frames: of the job. stages: builds one stage after the other; frames that it leaves out are made elsewhere.
    views: pictures of a frame.
    """
    started, done = time.perf_counter(), frames
    with stop_request() as stop_requested:
        for stage in stages:
            done = _capture_stage(stage, frames, rendering, stop_requested)
            if get_run().is_over:
                done = frames
            if done == frames or stop_requested():
                break
            done = frames  # unless another stage follows
            del stage  # which can be freed before the next one is built
    summary = Summary(done, done * views, time.perf_counter() - started, tuple(folders(list(writers))))
    if current().tap is None:  # else nothing was written
        _print_summary(summary, views)
    if done < frames:
        raise KeyboardInterrupt
    return summary


def _capture_stage(stage: Arranged, frames: int, rendering: Rendering, stop_requested: Callable[[], bool]) -> int:
    """Capture the frames of a stage; return how many frames of the job are done then."""
    get_orchestrator().expect_frames(frames, before=stage.frames.start)
    done = stage.frames.start
    try:
        for frame in stage.frames:
            stage.prepare(frame)
            rep.orchestrator.step(delta_time=0.0, rt_subframes=rendering.samples - MIN_SAMPLES, pause_timeline=False)
            done = frame + 1
            if get_run().is_over or stop_requested():
                break
    finally:
        rep.orchestrator.wait_until_complete()
    return done


def _warn_of_empty_splits(splits: Mapping[str, float], frames: int, together: int) -> None:
    """Warn of parts of a dataset that get none of so few frames; so many `together` are not divided."""
    if 0 < frames <= _FEW * together * len(splits):
        dealt = Splits("splits", splits, together)
        empty = set(splits) - {dealt.of(frame) for frame in range(frames)}
        if empty:
            kept = f", of which {together} in a row stay together" if together > 1 else ""
            warn_once(f"splits: {', '.join(sorted(empty))} gets none of {counted(frames, 'frame')}{kept}. Make more.")


def frames_made(of: int) -> str:
    """Return how many frames this process has made, as it is printed: "40 frames", or "8 of 40 frames"."""
    made = get_run().made
    return counted(of, "frame") if made == of else f"{made} of {counted(of, 'frame')}"


def _print_summary(summary: Summary, views: int) -> None:
    images = get_run().made * views
    rate = images / summary.seconds if summary.seconds > 0 else 0.0
    made = f"{frames_made(summary.frames)}, {counted(images, 'picture')}"
    print(f"{made} in {summary.seconds:.1f} s ({rate:.2f} pictures/s)")
    for folder in summary.folders:
        print(f"dataset: {folder}")
    if not summary.folders:
        print("no format writes to a folder", file=sys.stderr)

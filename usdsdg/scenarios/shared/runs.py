"""Capturing the frames of a job: render settings, the loop, and what is said at the end."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import usdsdg as rep
from usdsdg.orchestrator import get_orchestrator
from usdsdg.scenarios.interruption import stop_request
from usdsdg.scenarios.shared.formats import folders
from usdsdg.scenarios.shared.sections import Rendering
from usdsdg.session.settings_store import get_settings
from usdsdg.writers import Writer

# The fast mode takes this many samples, and one more for each sub-frame.
MIN_SAMPLES = 4
# Samples of a path-traced picture that a filter cleans well.
_PATH_TRACED = 128


@dataclass(frozen=True)
class Summary:
    """Result of a run."""

    frames: int
    images: int
    seconds: float
    folders: tuple[Path, ...]


def apply_rendering(rendering: Rendering) -> None:
    """Set the render mode."""
    settings = get_settings()
    settings.set("/rtx/rendermode", "PathTracing" if rendering.path_tracing else "RaytracedLighting")
    samples = max(rendering.samples, _PATH_TRACED)
    settings.set("/rtx/pathtracing/spp", samples)
    settings.set("/rtx/pathtracing/totalSpp", samples)
    settings.set("/rtx/pathtracing/optixDenoiser/enabled", True)


def capture(
    frames: int,
    prepare: Callable[[int], None],
    rendering: Rendering,
    *,
    views: int,
    writers: Sequence[tuple[str, Writer]],
) -> Summary:
    """Prepare and capture each frame; after Ctrl-C end with the frame, and raise KeyboardInterrupt.

    views: pictures of a frame.
    """
    get_orchestrator().expect_frames(frames)
    started, done = time.perf_counter(), 0
    try:
        with stop_request() as stop_requested:
            for frame in range(frames):
                prepare(frame)
                rep.orchestrator.step(
                    delta_time=0.0, rt_subframes=rendering.samples - MIN_SAMPLES, pause_timeline=False
                )
                done = frame + 1
                if stop_requested():
                    break
    finally:
        rep.orchestrator.wait_until_complete()
    summary = Summary(done, done * views, time.perf_counter() - started, tuple(folders(list(writers))))
    _print_summary(summary)
    if done < frames:
        raise KeyboardInterrupt
    return summary


def _print_summary(summary: Summary) -> None:
    rate = summary.images / summary.seconds if summary.seconds > 0 else 0.0
    print(f"{summary.frames} frames, {summary.images} pictures in {summary.seconds:.1f} s ({rate:.2f} pictures/s)")
    for folder in summary.folders:
        print(f"dataset: {folder}")
    if not summary.folders:
        print("no format writes to a folder", file=sys.stderr)

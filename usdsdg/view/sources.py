"""What is viewed: a stage, or the frames of a script or a job, of which the writers write nothing."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path

from usdsdg.app import saved_graph
from usdsdg.capture.tap import Tap
from usdsdg.cli.file_kinds import FileKind, kind_of
from usdsdg.graph.node_prims import PIPELINE
from usdsdg.orchestrator import get_orchestrator
from usdsdg.session import session, stage_context
from usdsdg.session.confinement import confined
from usdsdg.stream.source import Source
from usdsdg.view.viewer import Viewer
from usdsdg.writers.backends.disk import disk_root


def show_stage(viewer: Viewer, file: Path) -> None:
    """Show a stage until the program ends; a graph that is saved in it can be run.

    Raises:
        AssetError: it cannot be opened.
        GraphError: its graph needs Python code.
    """
    stage = stage_context.open_stage(file)
    if stage.GetPrimAtPath(PIPELINE):
        saved_graph.load(stage)
    viewer.run()


def show_job(viewer: Viewer, file: Path, arguments: Sequence[str], seed: int | None) -> None:
    """Run a script or the job of a configuration, and stop at each frame that it captures until a page goes on.

    At its end, or at once where it captures nothing, its stage is shown until the program ends.

    Raises:
        GraphError: a script ended with an error, which has been printed.
        UsdsdgError: as the job raises.
    """
    source = Source(file, tuple(arguments), seed)
    source.check()
    # In place of the writers; it takes no frame, so none is rendered that no annotator of a script reads.
    session.current().tap = Tap((), lambda _frame: False, lambda _view: None)
    orchestrator, frames = get_orchestrator(), itertools.count()
    unsubscribe = orchestrator.on_captured(lambda: viewer.run(frame=next(frames)))
    # A graph in YAML is data: it may not name folders elsewhere, although its writers write nothing here.
    is_data = kind_of(file) is FileKind.REPLICATOR_YAML
    try:
        with confined(disk_root()) if is_data else nullcontext():
            source.run()
    finally:
        unsubscribe()
        session.current().tap = None
    if next(frames) == 0:
        orchestrator.preview()  # as before a first frame, so that the triggers have run once
    viewer.run()

"""The frames of a script or a job as what is viewed; its writers write nothing."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path

from usdsdg.capture.tap import Tap
from usdsdg.cli.options.file_kinds import FileKind, kind_of
from usdsdg.orchestrator import get_orchestrator
from usdsdg.session import session
from usdsdg.session.confinement import confined
from usdsdg.stream.files_aside import files_aside
from usdsdg.stream.source import Source
from usdsdg.view.viewer import Viewer
from usdsdg.writers.backends.disk import disk_root


def of_job(file: Path, arguments: Sequence[str], seed: int | None) -> Callable[[Viewer], None]:
    """Check a script or a configuration, and return what runs it and stops at each frame until a page goes on.

    At its end, or at once where it captures nothing, its stage is shown until the program ends. What is returned raises
    GraphError for a script that ended with an error, which has been printed, and else what the job raises.

    Raises:
        ConfigError: there is no such file, it is of another kind, or the configuration is wrong.
    """
    source = Source(file, tuple(arguments), seed)
    source.check()
    # A graph in YAML is data: it may not name folders elsewhere, although its writers write nothing here.
    limit = confined(disk_root()) if kind_of(file) is FileKind.REPLICATOR_YAML else nullcontext()

    def show(viewer: Viewer) -> None:
        with files_aside(keeps_folders=not source.is_configuration):
            with limit:
                _run(source, viewer)
            viewer.run()

    return show


def _run(source: Source, viewer: Viewer) -> None:
    # In place of the writers; it takes no frame, so none is rendered that no annotator of a script reads.
    session.current().tap = Tap((), lambda _frame: False, lambda _view: None)
    orchestrator, frames = get_orchestrator(), itertools.count()
    unsubscribe = orchestrator.on_captured(lambda: viewer.run(frame=next(frames)))
    try:
        source.run()
    finally:
        unsubscribe()
        session.current().tap = None
    if next(frames) == 0:
        orchestrator.preview()  # as before a first frame, so that the triggers have run once

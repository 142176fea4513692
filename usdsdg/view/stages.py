"""A stage as what is viewed. Apart from jobs, whose import takes half a second."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from usdsdg.app import saved_graph
from usdsdg.session import stage_context
from usdsdg.stage.scopes import PIPELINE
from usdsdg.view.viewer import Viewer


def of_stage(file: Path) -> Callable[[Viewer], None]:
    """Open a stage, and return what shows it until the program ends; a graph that is saved in it can be run.

    Raises:
        AssetError: it cannot be opened.
        GraphError: its graph needs Python code.
    """
    stage = stage_context.open_stage(file)
    if stage.GetPrimAtPath(PIPELINE):
        saved_graph.load(stage)
    return lambda viewer: viewer.run()

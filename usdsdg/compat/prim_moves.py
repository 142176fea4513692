"""Prims are moved and renamed, with all that refers to them: relationships, connections, and nodes of the graph."""

from pxr import Sdf, Usd

from usdsdg.graph.moved_prims import follow_move
from usdsdg.session.stage_context import current_stage


def move(stage: Usd.Stage, source: Sdf.Path, target: Sdf.Path) -> bool:
    """Move a prim with all below it; return False for what another file brings, or where the path is taken."""
    editor = Usd.NamespaceEditor(stage)
    if not (editor.MovePrimAtPath(source, target) and editor.CanApplyEdits()):
        return False
    editor.ApplyEdits()
    if stage == current_stage():
        follow_move(source, target)
    return True

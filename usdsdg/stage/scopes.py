"""Where Replicator puts what it makes: the scope `/Replicator` and those below it."""

from pxr import Sdf, Usd

REPLICATOR = "/Replicator"
LOOKS = "/Replicator/Looks"
PIPELINE = "/Replicator/SDGPipeline"


def define_scope(stage: Usd.Stage, path: str) -> None:
    """Define a Scope at a path, and at each above it, where no prim is."""
    if stage.GetPrimAtPath(path):
        return
    for scope in Sdf.Path(path).GetPrefixes():
        if not stage.GetPrimAtPath(scope):
            stage.DefinePrim(scope, "Scope")

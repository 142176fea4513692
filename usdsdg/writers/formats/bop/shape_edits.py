"""Which objects were given another shape, for models that are kept from frame to frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pxr import Usd

from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.geometry.deforming import SHAPE_ATTRIBUTES


class ShapeEdits:
    """Tells which prims had their triangles edited, by the paths at which they are labeled."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._changes = ChangeTracker(stage)

    def take(self, paths: Iterable[str]) -> list[str]:
        """Return those of several prims whose shape may be another than at the last call.

        That is where attributes of it were set, there or on prims below, where other prims are below or are moved
        within it, and where it was read again, as with another reference. paths: as annotators report prims.
        """
        changes = self._changes.take()
        if not changes:
            return []
        edited = set(_edited(changes))
        roots = set(map(str, changes.resynced))
        return [path for path in paths if own_path(path) in edited or not roots.isdisjoint(_upwards(own_path(path)))]


def _edited(changes: Changes) -> Iterator[str]:
    """Yield the paths of the prims whose shape was edited, and of all above that it belongs to."""
    for path in changes.resynced:
        yield from _upwards(str(path.GetParentPath()))
    for names, paths in changes.by_names.items():
        is_shape = not names.isdisjoint(SHAPE_ATTRIBUTES)
        is_move = "visibility" in names or any(name.startswith("xformOp") for name in names)
        for path in paths if is_shape or is_move else ():
            # A labeled prim that is moved or hidden itself has the shape that it had.
            yield from _upwards(str(path if is_shape else path.GetParentPath()))


def _upwards(path: str) -> Iterator[str]:
    """Yield a path and those above, up to "/"."""
    while path and path != "/":
        yield path
        path = path.rpartition("/")[0]
    yield "/"


def own_path(path: str) -> str:
    """Return the path of the prim of which a point instance, as `/Instancer[3]`, is one."""
    return path.split("[", 1)[0]

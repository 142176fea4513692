"""Which objects were given another shape, for models that are kept from frame to frame."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.geometry.deforming import SHAPE_ATTRIBUTES
from usdsdg.stage.geometry.point_names import Prototypes
from usdsdg.stage.poses.transforms import as_array, local_to_world
from usdsdg.stage.prims.instances import places_of
from usdsdg.stage.world_values import WorldValues

_PROTOTYPES = "prototypes"
_TURNS = ("xformOp:rotate", "xformOp:orient")


class ShapeEdits:
    """Tells which prims had their triangles edited, by the paths at which they are labeled."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._changes = ChangeTracker(stage)
        self._users: Mapping[Sdf.Path, Sequence[Sdf.Path]] | None = None  # point instancers by root of a prototype

    def take(self, paths: Iterable[str]) -> list[str]:
        """Return those of several prims whose shape may be another than at the last call.

        That is where attributes of it were set, there or on prims below, where other prims are below or are moved
        within it, and where it was read again, as with another reference; so also in what its instances share, and in
        what its point instancers draw. paths: as annotators report prims.
        """
        changes = self._changes.take()
        if not changes:
            return []
        if changes.resynced or any(_PROTOTYPES in names for names in changes.by_names):
            self._users = None
        resynced = {place for path in changes.resynced for place in places_of(self._stage, path)}
        edited, roots = self._with_all_above(self._edited(changes, resynced)), set(map(str, resynced))
        return [path for path in paths if own_path(path) in edited or not roots.isdisjoint(_upwards(own_path(path)))]

    def _edited(self, changes: Changes, resynced: Iterable[Sdf.Path]) -> Iterator[Sdf.Path]:
        """Yield the paths of the prims whose shape was edited."""
        for path in resynced:
            yield path.GetParentPath()
            for root, instancers in self._drawn_by_points().items():
                yield from instancers if root.HasPrefix(path) else ()
        for names, paths in changes.by_names.items():
            is_shape = _PROTOTYPES in names or not names.isdisjoint(SHAPE_ATTRIBUTES)
            is_move = "visibility" in names or any(name.startswith("xformOp") for name in names)
            for path in (place for each in paths for place in places_of(self._stage, each)):
                if is_shape:
                    yield path
                elif is_move:
                    # A labeled prim that is moved or hidden itself has the shape that it had.
                    yield path.GetParentPath()
                    yield from self._drawn_by_points().get(path, ())

    def _with_all_above(self, edited: Iterable[Sdf.Path]) -> set[str]:
        """Return the paths of prims and of all that they belong to: those above, and point instancers of any of these.

        Instancers may draw themselves in a circle.
        """
        waiting, found = list(edited), set[Sdf.Path]()
        while waiting:
            path = waiting.pop()
            while path not in found and not path.IsAbsoluteRootPath():
                found.add(path)
                waiting += self._drawn_by_points().get(path, ())
                path = path.GetParentPath()
        return set(map(str, found))

    def _drawn_by_points(self) -> Mapping[Sdf.Path, Sequence[Sdf.Path]]:
        if self._users is None:
            self._users = Prototypes(self._stage).users
        return self._users


def _upwards(path: str) -> Iterator[str]:
    """Yield a path and those above, up to "/"."""
    while path and path != "/":
        yield path
        path = path.rpartition("/")[0]
    yield "/"


def may_reshape(stage: Usd.Stage, values: WorldValues, labeled: Collection[Sdf.Path]) -> bool:
    """Return whether attributes that differ between frames may give an object another shape, or show another one.

    labeled: the labeled prims, and the point instancers that draw some of them.
    """
    above = {prefix for path in labeled for prefix in path.GetPrefixes()}
    for path, columns in values.values.items():
        is_part = any(each in labeled for each in path.GetParentPath().GetPrefixes())
        if is_part or path in above:
            prim = stage.GetPrimAtPath(path)
            if any(_may_reshape(prim, name, is_part=is_part) for name in columns):
                return True
    return False


def _may_reshape(prim: Usd.Prim, name: str, *, is_part: bool) -> bool:
    """Return whether an attribute may; is_part: whether its prim may be a part of an object."""
    if name in SHAPE_ATTRIBUTES or name == "visibility":
        return True
    if not name.startswith("xformOp"):
        return False
    if is_part or not name.startswith(("xformOp:translate", *_TURNS)):
        return True
    return name.startswith(_TURNS) and not _turns_rigidly(prim, name)


def _turns_rigidly(prim: Usd.Prim, name: str) -> bool:
    """Return whether a rotation of a prim is one in the world, too: nothing that comes after it stretches."""
    after = np.eye(3)
    for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
        if op.GetName() == name:
            break
        after = as_array(op.GetOpTransform(Usd.TimeCode.Default()))[:3, :3] @ after
    linear = after @ as_array(local_to_world(prim.GetParent()))[:3, :3]
    squared = linear @ linear.T
    return bool(np.allclose(squared, np.eye(3) * np.trace(squared) / 3, rtol=0.0, atol=1e-6 * np.trace(squared)))


def own_path(path: str) -> str:
    """Return the path of the prim of which a point instance, as `/Instancer[3]`, is one."""
    return path.split("[", 1)[0]

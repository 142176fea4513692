"""The skeletons of a stage, and the point instances of characters."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from pxr import Sdf, Usd, UsdGeom, UsdSkel

from usdsdg.annotators.ownership import Owner, ancestors
from usdsdg.annotators.point_instances import Steps, prim_path, undefined_prototypes


class SkeletonPrim(NamedTuple):
    """A skeleton where it stands, or in one point instance of its character."""

    skeleton: Owner
    character: Owner  # its SkelRoot, or the skeleton
    is_of: Callable[[int], bool]  # whether a gprim, by its index, is of the character


class _Known(NamedTuple):
    """A skeleton of the stage."""

    path: Sdf.Path
    character: Sdf.Path
    stands_alone: bool  # drawn where it is, if it is shown


class SkeletonPrims:
    """Finds the skeletons of a stage once, and again after `invalidate`: to go through all prims takes a while."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._known: list[_Known] | None = None  # None: not known
        # Gprims and their instances, with what follows from them alone: the instances of each character.
        self._drawn: tuple[Any, Any, dict[Sdf.Path, tuple[Owner, ...]]] | None = None

    def invalidate(self) -> None:
        """Look for skeletons again."""
        self._known = self._drawn = None

    def find(self, gprims: Sequence[str], steps: Sequence[Steps]) -> list[SkeletonPrim]:
        """Return all skeletons, shown or not, in stage order; those of scene-graph instances are proxies.

        A character in the prototype of a point instancer counts once for each instance of which a gprim is drawn.

        gprims, steps: paths as in the renderer's table, and the instancers and points of each.
        """
        if self._known is None:
            self._known = self._find_known()
        if self._drawn is None or self._drawn[0] is not gprims or self._drawn[1] is not steps:
            self._drawn = gprims, steps, _instances({known.character for known in self._known}, gprims, steps)
        found = []
        for known in self._known:
            characters = (Owner(known.character),) if known.stands_alone else ()
            for character in (*characters, *self._drawn[2][known.character]):
                skeleton = Owner(known.path, character.steps)
                found.append(SkeletonPrim(skeleton, character, _is_of(character, gprims, steps)))
        return found

    def _find_known(self) -> list[_Known]:
        roots = [self._stage.GetPseudoRoot(), *undefined_prototypes(self._stage)]
        found: dict[Sdf.Path, _Known] = {}
        for root in roots:
            inside = Usd.PrimIsActive if not root.IsPseudoRoot() else Usd.PrimDefaultPredicate
            for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies(inside)):
                if prim.IsA(UsdSkel.Skeleton):
                    character = UsdSkel.Root.Find(prim)
                    path = character.GetPath() if character else prim.GetPath()
                    stands_alone = root.IsPseudoRoot() and not self._is_below_instancer(prim)
                    found.setdefault(prim.GetPath(), _Known(prim.GetPath(), path, stands_alone))
        return list(found.values())

    def _is_below_instancer(self, prim: Usd.Prim) -> bool:
        """Return whether a prim is below a point instancer, which then is all that draws it."""
        above = map(self._stage.GetPrimAtPath, prim.GetPath().GetParentPath().GetPrefixes())
        return any(each.IsA(UsdGeom.PointInstancer) for each in above)


def _instances(
    characters: set[Sdf.Path], gprims: Sequence[str], steps: Sequence[Steps]
) -> dict[Sdf.Path, tuple[Owner, ...]]:
    """Return the point instances of each character of which gprims are drawn."""
    found: dict[Sdf.Path, dict[Owner, None]] = {path: {} for path in characters}
    for gprim, way in zip(gprims, steps):
        if way and characters:
            for owner in ancestors(prim_path(gprim), way):
                if owner.steps and owner.path in found:
                    found[owner.path][owner] = None
    return {path: tuple(owners) for path, owners in found.items()}


def _is_of(character: Owner, gprims: Sequence[str], steps: Sequence[Steps]) -> Callable[[int], bool]:
    return lambda gprim: character in ancestors(prim_path(gprims[gprim]), steps[gprim])

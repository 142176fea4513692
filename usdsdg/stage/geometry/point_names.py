"""Names of point instances: the path of a prim in a prototype, then the point, `path[7]`.

Where several instancers draw a prototype the point is named after its instancer, too: `path[/World/Trees:7]`. Points of
nested instancers follow each other from the inside, `path[flower][bed]`.
"""

from collections.abc import Sequence
from functools import cached_property

from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.prims.prim_types import PrimTypes

_EVERYTHING = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)

PrototypeUse = tuple[Sdf.Path, Sdf.Path]  # point instancer, and a target of its `prototypes`


def prototypes_of(instancer: Usd.Prim) -> tuple[Sdf.Path, ...]:
    """Return the targets of `prototypes`."""
    return tuple(UsdGeom.PointInstancer(instancer).GetPrototypesRel().GetForwardedTargets())


def draws_in_a_circle(instancer: Usd.Prim, outer: tuple[Sdf.Path, ...] = ()) -> bool:
    """Return whether a point instancer, or one among its prototypes, has itself among these.

    outer: the instancers that have this one among their prototypes.
    """
    outer = (*outer, instancer.GetPath())
    inner = _inner_instancers(instancer)
    return any(prim.GetPath() in outer for prim in inner) or any(draws_in_a_circle(prim, outer) for prim in inner)


def lacks_prototypes(instancer: Usd.Prim) -> bool:
    """Return whether a target of `prototypes` is no prim, of a point instancer or of one among its prototypes.

    It does not draw itself: `draws_in_a_circle`.
    """
    stage = instancer.GetStage()
    missing = any(not stage.GetPrimAtPath(path) for path in prototypes_of(instancer))
    return missing or any(map(lacks_prototypes, _inner_instancers(instancer)))


def _inner_instancers(instancer: Usd.Prim) -> list[Usd.Prim]:
    """Return the point instancers at and below the prototypes of one."""
    roots = [instancer.GetStage().GetPrimAtPath(path) for path in dict.fromkeys(prototypes_of(instancer))]
    below = (prim for root in roots if root for prim in Usd.PrimRange(root, _EVERYTHING))
    return [prim for prim in below if prim.IsA(UsdGeom.PointInstancer)]


class Prototypes:
    """The prototypes of all point instancers of a stage, hidden ones too."""

    def __init__(self, stage: Usd.Stage) -> None:
        everything = Usd.PrimRange.Stage(stage, _EVERYTHING)
        self.of = {
            prim.GetPath(): prototypes_of(prim) for prim in filter(PrimTypes(UsdGeom.PointInstancer).have, everything)
        }
        self.users: dict[Sdf.Path, list[Sdf.Path]] = {}  # instancers in stage order
        for instancer, roots in self.of.items():
            for root in dict.fromkeys(roots):
                self.users.setdefault(root, []).append(instancer)

    def drawing(self, path: Sdf.Path) -> list[PrototypeUse]:
        """Return the prototypes that a prim is in, nearest root first, without those that draw it through others."""
        found: list[PrototypeUse] = []
        while not path.IsAbsoluteRootPath():
            found += [(instancer, path) for instancer in self.users.get(path, ())]
            path = path.GetParentPath()
            if path in self.of:  # what is below an instancer is drawn by it alone
                break
        return found

    @cached_property
    def shared(self) -> frozenset[PrototypeUse]:
        """Those of which another instancer draws the same prims, as they are, contain or are in one of its own."""
        drawing = map(self.drawing, self.users)
        return frozenset(pair for pairs in drawing if len({each for each, _ in pairs}) > 1 for pair in pairs)


def point_name(instancer: Sdf.Path, point: int, *, is_shared: bool) -> str:
    """Return what follows the path of a prim in a prototype."""
    return names_of_points(instancer, (point,), is_shared=is_shared)[0]


def names_of_points(instancer: Sdf.Path, points: Sequence[int], *, is_shared: bool) -> list[str]:
    """Return `point_name` of many points."""
    prefix = f"{instancer}:" if is_shared else ""
    return [f"[{prefix}{point}]" for point in points]


def split_name(name: str) -> tuple[Sdf.Path, Sequence[tuple[Sdf.Path | None, int]]]:
    """Return the path of the prim, and the point of each instancer, with its path if it is named."""
    path, *points = name.replace("]", "").split("[")
    pairs = [point.rpartition(":") for point in points]
    return Sdf.Path(path), [(Sdf.Path(instancer) if instancer else None, int(point)) for instancer, _, point in pairs]

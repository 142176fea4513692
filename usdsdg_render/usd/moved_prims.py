"""Local matrices of prims that are moved again and again."""

from collections.abc import Iterable, Sequence

from pxr import Gf, Sdf, Tf, Usd, UsdGeom

Local = tuple[Gf.Matrix4d, bool]  # a local matrix, and whether it resets the transform stack


def is_movable(op: Usd.Attribute) -> bool:
    """Whether the strongest layer that says anything of an op gives its default value.

    That stays so until another layer says something, which notices tell, or until the value is gone, where USD raises.
    """
    if not op or op.GetResolveInfo().GetSource() != Usd.ResolveInfoSourceDefault:
        return False  # samples, a spline or value clips, or no value
    return not isinstance(op.GetPropertyStack()[0].default, (type(None), Sdf.ValueBlock))


class MovedPrims:
    """Reads local matrices at the default time, on stages without time samples.

    USD takes most of the time for looking up the ops of a prim and the layers of their values. Here it does so once for
    a node, when its prim is read first. By then `is_movable` must be true of the ops that will change.
    """

    def __init__(self) -> None:
        self._cache = UsdGeom.XformCache(Usd.TimeCode.Default())
        self._nodes: set[int] = set()

    def forget(self) -> None:
        """Forget all nodes."""
        self._cache.Clear()
        self._nodes = set()

    def holds(self, moved: Iterable[int], changed: Iterable[int]) -> bool:
        """Whether it knows all nodes that `moved`, and none of which anything else `changed`."""
        return self._nodes.issuperset(moved) and self._nodes.isdisjoint(changed)

    def read(self, prims: Sequence[Usd.Prim], nodes: Sequence[int]) -> list[Local] | None:
        """Return local matrices, and keep the nodes; None if a value is not any more where it was."""
        self._nodes.update(nodes)
        try:
            return list(map(self._cache.GetLocalTransformation, map(prims.__getitem__, nodes)))
        except Tf.ErrorException:
            return None

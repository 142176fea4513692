"""World matrices of prims while a stage plays: of rigid bodies, what steps write counts, and not samples of it."""

from collections.abc import Collection

from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.stage.poses.transforms import product_of_ops
from usdsdg.stage.time_code import current_time, default_or_current_time


class BodyXformCache(UsdGeom.XformCache):
    """A cache at the time of the context, but for `sampled`: dynamic bodies of which xform ops have samples.

    Their ops have their default values, which steps write, beside which a script may record samples; and only without
    one the value at that time.
    """

    def __init__(self, sampled: Collection[Sdf.Path] = ()) -> None:
        super().__init__(current_time())
        self._sampled = frozenset(sampled)

    def GetLocalToWorldTransform(self, prim: Usd.Prim) -> Gf.Matrix4d:
        """Return the matrix from a prim's space to the world."""
        if not self._sampled or not any(path in self._sampled for path in prim.GetPath().GetPrefixes()):
            return super().GetLocalToWorldTransform(prim)
        local = UsdGeom.Xformable(prim)
        if not local:
            return self.GetLocalToWorldTransform(prim.GetParent())
        matrix = self._own(local) if prim.GetPath() in self._sampled else local.GetLocalTransformation(self.GetTime())
        return matrix if local.GetResetXformStack() else matrix * self.GetLocalToWorldTransform(prim.GetParent())

    def _own(self, xformable: UsdGeom.Xformable) -> Gf.Matrix4d:
        ops = xformable.GetOrderedXformOps()
        return product_of_ops(op.GetOpTransform(default_or_current_time(op.GetAttr())) for op in ops)

"""World matrices of prims while a stage plays: of rigid bodies, what steps write counts, and not samples of it."""

from collections.abc import Collection

from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.stage.time_code import current_time, default_or_current_time

# By value, of which a comparison takes a tenth of the time.
_SAMPLED = {
    source.value
    for source in (Usd.ResolveInfoSourceTimeSamples, Usd.ResolveInfoSourceValueClips, Usd.ResolveInfoSourceSpline)
}


class BodyXformCache(UsdGeom.XformCache):
    """A cache at the time of the context, but for `sampled`: dynamic bodies of which xform ops have samples.

    Their ops have their default values, which steps write, and only without one the value at that time.
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
        matrix = Gf.Matrix4d(1.0)
        for op in xformable.GetOrderedXformOps():  # the op listed last is applied first
            matrix = op_matrix(op) * matrix
        return matrix


def op_matrix(op: UsdGeom.XformOp) -> Gf.Matrix4d:
    """Return the matrix of an xform op of a dynamic body: of its default value, else at the time of the context."""
    return op.GetOpTransform(default_or_current_time(op.GetAttr()))


def is_sampled(attribute: Usd.Attribute) -> bool:
    """Return whether samples, a spline or value clips give an attribute its value at the time of the context."""
    return bool(attribute) and attribute.GetResolveInfo(current_time()).GetSource().value in _SAMPLED


def varies(prim: Usd.Prim) -> bool:
    """Return whether the local transform of a prim varies with time, whatever is above it."""
    xformable = UsdGeom.Xformable(prim)
    return bool(xformable) and xformable.TransformMightBeTimeVarying()

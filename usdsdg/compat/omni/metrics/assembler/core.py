"""`omni.metrics.assembler.core`: references to files in other units or with another up axis are scaled and turned."""

from __future__ import annotations

from pxr import Gf, Usd, UsdGeom

from usdsdg.session.stage_context import stage_by_id
from usdsdg.stage import assets
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis

__all__ = ["MetricsAssemblerInterface", "get_metrics_assembler_interface"]

# The suffix of the xform ops that are added.
SUFFIX = "unitsResolve"


class MetricsAssemblerInterface:
    """Makes the files of a stage agree in units and up axis."""

    def resolve_stage(self, stage_id: int) -> bool:
        """Scale and turn each prim that references a file of other units or with another up axis; once only.

        The ops, `xformOp:rotateX:unitsResolve` and `xformOp:scale:unitsResolve`, are the innermost of the prim. Returns
        True.

        Raises:
            StageError: no open stage has this id.
        """
        stage = stage_by_id(stage_id)
        for prim in stage.Traverse():
            _resolve(stage, prim)
        return True


def _resolve(stage: Usd.Stage, prim: Usd.Prim) -> None:
    if not (prim.HasAuthoredReferences() or prim.HasAuthoredPayloads()) or not prim.IsA(UsdGeom.Xformable):
        return
    xformable = UsdGeom.Xformable(prim)
    if any(op.GetOpName().endswith(SUFFIX) for op in xformable.GetOrderedXformOps()):
        return
    for file in assets.referenced_layers(prim):
        if file == stage.GetRootLayer():
            continue
        referenced = Usd.Stage.Open(file, Usd.Stage.LoadNone)
        factor = meters_per_unit(referenced) / meters_per_unit(stage)
        angle = {("Y", "Z"): 90.0, ("Z", "Y"): -90.0}.get((up_axis(referenced), up_axis(stage)), 0.0)
        if angle:
            xformable.AddRotateXOp(opSuffix=SUFFIX).Set(angle)
        if abs(factor - 1.0) > 1e-9:
            xformable.AddScaleOp(opSuffix=SUFFIX).Set(Gf.Vec3f(factor))
        return


_interface = MetricsAssemblerInterface()


def get_metrics_assembler_interface() -> MetricsAssemblerInterface:
    """Return the interface."""
    return _interface

"""`Articulation`: the joints and links of a robot as they are on the stage; they are not simulated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pxr import Usd, UsdPhysics

from usdsdg.compat.isaacsim.core.experimental.prims.xform_prim import XformPrim
from usdsdg.compat.wrappers.unsupported import RefusedNames

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Values

_WHY = "robots under control are out of scope: joints are not simulated. Pose the links with XformPrim"


class Articulation(XformPrim):
    """Robots: their pose, links and joints. Whatever drives or measures joints raises `Unsupported`."""

    __getattr__ = RefusedNames(
        "Articulation",
        ("get_", "set_", "apply_", "switch_", "dof_", "num_shapes", "is_physics", "jacobian", "mass_matrix"),
        _WHY,
    )

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        resolve_paths: bool = True,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = False,
        enable_residual_reports: bool = False,
    ) -> None:
        """Wrap robots; see `XformPrim`. Residuals of a solver are not reported."""
        super().__init__(
            paths, resolve_paths=resolve_paths, positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip

    @property
    def joint_names(self) -> list[str]:
        """Return the names of the joints below the first prim, in the order of the stage."""
        return [joint.GetName() for joint in self._below(UsdPhysics.Joint)]

    @property
    def link_names(self) -> list[str]:
        """Return the names of the rigid bodies at and below the first prim, in the order of the stage."""
        return [prim.GetName() for prim in Usd.PrimRange(self.prims[0]) if prim.HasAPI(UsdPhysics.RigidBodyAPI)]

    @property
    def num_joints(self) -> int:
        return len(self.joint_names)

    @property
    def num_links(self) -> int:
        return len(self.link_names)

    def _below(self, schema: type) -> list[Usd.Prim]:
        return [prim for prim in Usd.PrimRange(self.prims[0]) if prim.IsA(schema)]

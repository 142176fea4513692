"""`GroundPlane`: a square that is seen and an unbounded plane that collides, or a mesh that does both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.api.materials import PhysicsMaterial, PreviewSurface, VisualMaterial
from usdsdg.compat.isaacsim.core.api.objects.shape import GRAY, LOOKS, PHYSICS_MATERIALS, free_path
from usdsdg.compat.isaacsim.core.prims import SingleGeometryPrim, SingleXFormPrim
from usdsdg.compat.isaacsim.core.utils.types import XFormPrimState
from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.errors import BadPrim
from usdsdg.stage.physics.ground_plane import add_ground_plane
from usdsdg.stage.poses.transforms import meters_per_unit


class GroundPlane:
    """A ground plane, which faces along Z."""

    def __init__(
        self,
        prim_path: str,
        name: str = "ground_plane",
        size: float | None = None,
        z_position: float | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        color: Sequence[float] | np.ndarray | None = None,
        physics_material: PhysicsMaterial | None = None,
        visual_material: VisualMaterial | None = None,
    ) -> None:
        """Wrap or define the plane; a new one is gray and has friction 0.5 and restitution 0.8.

        Args:
            size: Half an edge [stage units] of the square that is seen; by default 50 m.

        Raises:
            BadPrim: the prim has neither a plane nor a mesh below it.
        """
        stage = used_stage.current_stage()
        if not prim_of(prim_path):
            half = 50.0 / meters_per_unit(stage) if size is None else float(size)
            add_ground_plane(stage, prim_path, half_size=half, color=(0.0, 0.0, 0.0))
            physics_material = physics_material or PhysicsMaterial(
                free_path(PHYSICS_MATERIALS), static_friction=0.5, dynamic_friction=0.5, restitution=0.8
            )
            visual_material = visual_material or PreviewSurface(
                free_path(LOOKS), color=GRAY if color is None else color
            )
        ground = _collision_geometry(prim_of(prim_path))
        self._xform = SingleXFormPrim(prim_path, name, scale=scale, visible=visible)
        self._collider = SingleGeometryPrim(str(ground.GetPath()), f"{name}_collision_plane", collision=True)
        if z_position is not None:
            self.set_world_pose((0.0, 0.0, z_position))
            self.set_default_state((0.0, 0.0, z_position))
        if physics_material is not None:
            self.apply_physics_material(physics_material)
        if visual_material is not None:
            self._xform.apply_visual_material(visual_material)

    @property
    def prim_path(self) -> str:
        return self._xform.prim_path

    @property
    def name(self) -> str:
        return self._xform.name

    @property
    def prim(self) -> Usd.Prim:
        return self._xform.prim

    @property
    def xform_prim(self) -> SingleXFormPrim:
        return self._xform

    @property
    def collision_geometry_prim(self) -> SingleGeometryPrim:
        return self._collider

    def initialize(self, physics_sim_view: object = None) -> None:
        """Do nothing: there are no tensor views to make."""

    def post_reset(self) -> None:
        self._xform.post_reset()

    def is_valid(self) -> bool:
        return self._xform.is_valid()

    def apply_physics_material(self, physics_material: PhysicsMaterial, weaker_than_descendants: bool = False) -> None:
        self._collider.apply_physics_material(physics_material, weaker_than_descendants)

    def get_applied_physics_material(self) -> PhysicsMaterial | None:
        return self._collider.get_applied_physics_material()

    def set_world_pose(
        self, position: Sequence[float] | None = None, orientation: Sequence[float] | None = None
    ) -> None:
        """Place the plane in the world; what is not given stays."""
        self._xform.set_world_pose(position, orientation)

    def get_world_pose(self) -> tuple[np.ndarray, np.ndarray]:
        """Return position (3,) and orientation (4,), w, x, y, z, in the world."""
        return self._xform.get_world_pose()

    def get_default_state(self) -> XFormPrimState:
        return self._xform.get_default_state()

    def set_default_state(
        self, position: Sequence[float] | None = None, orientation: Sequence[float] | None = None
    ) -> None:
        self._xform.set_default_state(position, orientation)


def _collision_geometry(root: Usd.Prim) -> Usd.Prim:
    """Return what collides of a ground: its first plane, or else its first mesh, colliders before others.

    Raises:
        BadPrim: there is neither.
    """
    prims = list(Usd.PrimRange(root))
    for schema in (UsdGeom.Plane, UsdGeom.Mesh):
        found = [prim for prim in prims if prim.IsA(schema)]
        if found:
            return next((prim for prim in found if prim.HasAPI(UsdPhysics.CollisionAPI)), found[0])
    raise BadPrim(f"{root.GetPath()} is no ground plane: it has neither a Plane nor a Mesh below it")

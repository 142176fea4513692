"""What the shapes share: sizes, color, collider and rigid body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.api.materials import PhysicsMaterial, PreviewSurface, VisualMaterial
from usdsdg.compat.isaacsim.core.prims import SingleGeometryPrim, SingleRigidPrim
from usdsdg.compat.isaacsim.core.utils.string import find_unique_string_name
from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.errors import BadPrim

LOOKS, PHYSICS_MATERIALS = "/World/Looks/visual_material", "/World/Physics_Materials/physics_material"
GRAY = (0.5, 0.5, 0.5)
DYNAMIC_MASS = 0.02


def free_path(path: str) -> str:
    """Return the path, with a number if there is a prim already."""
    return find_unique_string_name(path, lambda each: not prim_of(each))


class VisualShape(SingleGeometryPrim):
    """A gprim that is seen and does not collide; a new one is gray unless it is given a color or a material."""

    _schema: ClassVar[Any]
    # Attribute and value of each size [stage units] of a new shape, by the name of its argument.
    _sizes: ClassVar[Mapping[str, tuple[str, float]]]

    def __init__(
        self,
        prim_path: str,
        name: str = "visual_shape",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        color: Sequence[float] | np.ndarray | None = None,
        visual_material: VisualMaterial | None = None,
        **sizes: float | None,
    ) -> None:
        """Wrap or define the shape, and place it: see `SingleXFormPrim`.

        Args:
            color: (3,) of the material of a new shape.
            sizes: `size` of a cuboid, `radius` and `height` of the others [stage units].

        Raises:
            BadPrim: the prim is of another type.
            TypeError: the shape has no such size.
        """
        unknown = sizes.keys() - self._sizes.keys()
        if unknown:
            raise TypeError(
                f"{type(self).__name__} has no {', '.join(sorted(unknown))}; it has {', '.join(self._sizes)}"
            )
        prim, is_new = prim_of(prim_path), not prim_of(prim_path)
        if is_new:
            self._schema.Define(used_stage.current_stage(), prim_path)
            usual: dict[str, float | None] = {argument: value for argument, (_, value) in self._sizes.items()}
            sizes = usual | {argument: value for argument, value in sizes.items() if value is not None}
            visual_material = visual_material or PreviewSurface(
                free_path(LOOKS), color=GRAY if color is None else color
            )
        elif not prim.IsA(self._schema):
            raise BadPrim(f"{prim_path} is a {prim.GetTypeName()}, not a {self._schema.__name__}")
        SingleGeometryPrim.__init__(self, prim_path, name, position, translation, orientation, scale, visible)
        for argument, value in sizes.items():
            if value is not None:
                self._set_size(argument, value)
        if visual_material is not None:
            self.apply_visual_material(visual_material)

    def _set_size(self, argument: str, value: float) -> None:
        getattr(self.geom, f"Create{self._sizes[argument][0]}Attr")().Set(float(value))
        boundable = UsdGeom.Boundable(self.prim)
        extent = UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, Usd.TimeCode.Default())
        boundable.CreateExtentAttr().Set(extent)

    def _get_size(self, argument: str) -> float:
        return getattr(self.geom, f"Get{self._sizes[argument][0]}Attr")().Get()


class FixedShape(VisualShape):
    """A shape that collides and does not move; a new one has a static friction of 0.2 and a dynamic one of 1."""

    _approximation: ClassVar[str] = "convexHull"

    def __init__(
        self,
        prim_path: str,
        name: str = "fixed_shape",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        color: Sequence[float] | np.ndarray | None = None,
        visual_material: VisualMaterial | None = None,
        physics_material: PhysicsMaterial | None = None,
        **sizes: float | None,
    ) -> None:
        """Wrap or define the shape, see `VisualShape`, and make it a collider."""
        is_new = not prim_of(prim_path)
        VisualShape.__init__(
            self, prim_path, name, position, translation, orientation, scale, visible, color, visual_material, **sizes
        )
        self.set_collision_enabled(True)
        self.set_collision_approximation(self._approximation)
        if is_new:
            physics_material = physics_material or PhysicsMaterial(
                free_path(PHYSICS_MATERIALS), static_friction=0.2, dynamic_friction=1.0, restitution=0.0
            )
            self.set_rest_offset(0.0)
            self.set_contact_offset(0.1)
            self.set_torsional_patch_radius(1.0)
            self.set_min_torsional_patch_radius(0.8)
        if physics_material is not None:
            self.apply_physics_material(physics_material)


class DynamicShape(SingleRigidPrim, FixedShape):
    """A shape that collides and falls; a new one has a mass of 0.02 unless it is given one."""

    def __init__(
        self,
        prim_path: str,
        name: str = "dynamic_shape",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        color: Sequence[float] | np.ndarray | None = None,
        visual_material: VisualMaterial | None = None,
        physics_material: PhysicsMaterial | None = None,
        mass: float | None = None,
        density: float | None = None,
        linear_velocity: Sequence[float] | None = None,
        angular_velocity: Sequence[float] | None = None,
        **sizes: float | None,
    ) -> None:
        """Wrap or define the shape, see `FixedShape`, and make it a rigid body: see `SingleRigidPrim`."""
        if mass is None and not prim_of(prim_path):
            mass = DYNAMIC_MASS
        FixedShape.__init__(
            self, prim_path, name, position, translation, orientation, scale, visible, color, visual_material,
            physics_material, **sizes,
        )  # fmt: skip
        SingleRigidPrim.__init__(
            self, prim_path, name, mass=mass, density=density, linear_velocity=linear_velocity,
            angular_velocity=angular_velocity,
        )  # fmt: skip

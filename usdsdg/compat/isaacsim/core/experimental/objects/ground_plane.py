"""`GroundPlane`: a square that is seen and an unbounded plane that collides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.experimental.materials.omni_pbr import OmniPbrMaterial
from usdsdg.compat.isaacsim.core.experimental.objects.mesh import Mesh
from usdsdg.compat.isaacsim.core.experimental.objects.shapes import Plane
from usdsdg.compat.isaacsim.core.experimental.prims import GeomPrim, XformPrim
from usdsdg.compat.wrappers import prim_paths
from usdsdg.compat.wrappers.arrays import column, names
from usdsdg.stage.physics.ground_plane import add_ground_plane
from usdsdg.stage.poses.transforms import up_axis

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.isaacsim.core.experimental.materials.physics_material import PhysicsMaterial
    from usdsdg.compat.wrappers.arrays import Indices, Values

# The color of each template; Isaac Sim's is a texture of lines in this color.
TEMPLATES = {"wireframe-blue": (0.11, 0.15, 0.22)}


class GroundPlane(XformPrim):
    """Ground planes, which face along the stage's up axis."""

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        sizes: Values = 100.0,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        templates: str | Sequence[str] | None = "wireframe-blue",
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap ground planes, or define them; see `XformPrim` for the poses.

        Args:
            sizes: Edges [stage units] of the squares that are seen; colliders have no bounds.
            templates: "wireframe-blue" is a dark blue material; None leaves `colors` visible.

        Raises:
            AssertionError: a prim has no mesh and no plane below it.
            ValueError: there is no such template.
        """
        existing, missing = self.resolve_paths(paths)
        stage = used_stage.current_stage()
        for path, size in zip(missing, column(sizes, len(missing)) if missing else (), strict=True):
            add_ground_plane(stage, path, axis=up_axis(stage), half_size=size / 2.0)
        super().__init__(
            existing or missing, resolve_paths=False, positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        self._meshes = Mesh([_child(path, UsdGeom.Mesh) for path in self.paths])
        self._planes = Plane([_child(path, UsdGeom.Plane) for path in self.paths])
        self._geoms = GeomPrim(self._planes.paths)
        if colors is not None:
            self._planes.set_display_colors(colors)
            self._meshes.set_display_colors(colors)
        if templates is not None:
            self.apply_visual_templates(templates)

    @property
    def planes(self) -> Plane:
        return self._planes

    @property
    def meshes(self) -> Mesh:
        return self._meshes

    def apply_visual_templates(self, templates: str | Sequence[str], *, indices: Indices = None) -> None:
        """Bind a new material to the meshes.

        Raises:
            ValueError: there is no such template.
        """
        chosen = self._chosen(indices)
        for prim, template in zip(chosen, names(templates, len(chosen)), strict=True):
            if template not in TEMPLATES:
                raise ValueError(f"there is no template {template!r}; templates are {', '.join(TEMPLATES)}")
            material = OmniPbrMaterial(f"{prim.GetPath()}/visualMaterial")
            material.set_input_values("diffuse_color_constant", TEMPLATES[template])
            material.set_input_values("reflection_roughness_constant", 0.8)
            self._meshes.apply_visual_materials(material, indices=[self.prims.index(prim)])

    # --- colliders: see `GeomPrim` ---
    def set_offsets(
        self, contact_offsets: Values | None = None, rest_offsets: Values | None = None, *, indices: Indices = None
    ) -> None:
        self._geoms.set_offsets(contact_offsets, rest_offsets, indices=indices)

    def get_offsets(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        return self._geoms.get_offsets(indices=indices)

    def set_torsional_patch_radii(self, radii: Values, *, indices: Indices = None, minimum: bool = False) -> None:
        self._geoms.set_torsional_patch_radii(radii, indices=indices, minimum=minimum)

    def get_torsional_patch_radii(self, *, indices: Indices = None, minimum: bool = False) -> wp.array:
        return self._geoms.get_torsional_patch_radii(indices=indices, minimum=minimum)

    def set_enabled_collisions(self, enabled: Values, *, indices: Indices = None) -> None:
        self._geoms.set_enabled_collisions(enabled, indices=indices)

    def get_enabled_collisions(self, *, indices: Indices = None) -> wp.array:
        return self._geoms.get_enabled_collisions(indices=indices)

    def apply_physics_materials(
        self,
        materials: PhysicsMaterial | Sequence[PhysicsMaterial],
        *,
        weaker_than_descendants: Values | None = None,
        indices: Indices = None,
    ) -> None:
        self._geoms.apply_physics_materials(materials, weaker_than_descendants=weaker_than_descendants, indices=indices)

    def get_applied_physics_materials(self, *, indices: Indices = None) -> list[PhysicsMaterial | None]:
        return self._geoms.get_applied_physics_materials(indices=indices)


def _child(path: str, schema: type) -> str:
    children: list[Usd.Prim] = prim_paths.prim_of(path).GetChildren()
    found = next((child for child in children if child.IsA(schema)), None)
    if found is None:
        raise AssertionError(f"{path} is no ground plane: it has no {schema.__name__} below it")
    return str(found.GetPath())

"""`XFormPrim`: poses, scales, visibility and materials of several prims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.core.utils.types import XFormPrimViewState
from usdsdg.compat.wrappers import bindings, poses, prim_paths
from usdsdg.compat.wrappers.arrays import as_backend, chosen, column, pose_rows, rows
from usdsdg.errors import BadPrim

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.api.materials.visual_material import VisualMaterial
    from usdsdg.compat.wrappers.arrays import Indices, Values


class XFormPrim:
    """Prims with a transform. Lengths are stage units, quaternions (w, x, y, z), arrays float32 with a row per prim.

    Arrays are NumPy's, unless `SimulationManager.set_backend` or a World says "torch" or "warp".
    """

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str = "xform_prim_view",
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        visibilities: Values | None = None,
        reset_xform_properties: bool = True,
        usd: bool = True,
    ) -> None:
        """Wrap the prims at these paths, in which "*" or ".*" stands for any part of a name, and place them.

        Args:
            positions: (N, 3) in the world; `translations` are relative to the parents.
            reset_xform_properties: Give the prims the ops translate, orient and scale, and no others.

        Raises:
            BadPrim: there are no such prims.
            ValueError: both positions and translations are given.
        """
        given = [prim_paths_expr] if isinstance(prim_paths_expr, str) else list(prim_paths_expr)
        self._name, self._given = name, given
        patterns = [prim_paths.from_wildcards(each) for each in given]
        self._prim_paths = [path for each in patterns for path in prim_paths.matching_paths(each)]
        if not self._prim_paths:
            raise BadPrim(f"{name}: no prim matches {', '.join(given)}")
        if positions is not None and translations is not None:
            raise ValueError(f"{name}: give either positions or translations, not both")
        self._prims = [prim_paths.prim_of(path) for path in self._prim_paths]
        if reset_xform_properties:
            poses.reset_ops(self._prims)
        if translations is not None:
            self.set_local_poses(translations, orientations)
        elif positions is not None or orientations is not None:
            self.set_world_poses(positions, orientations)
        if scales is not None:
            self.set_local_scales(scales)
        if visibilities is not None:
            self.set_visibilities(visibilities)
        self._materials: dict[int, VisualMaterial] = {}
        self._default_positions, self._default_orientations = poses.world_poses(self._prims)

    # --- which prims ---
    @property
    def prims(self) -> list[Usd.Prim]:
        return self._prims

    @property
    def prim_paths(self) -> list[str]:
        return self._prim_paths

    @property
    def count(self) -> int:
        return len(self._prims)

    @property
    def name(self) -> str:
        return self._name

    @property
    def is_non_root_articulation_link(self) -> bool:
        """Return False: there are no articulations, so every prim can be placed."""
        return False

    def is_valid(self, indices: Indices = None) -> bool:
        """Whether the prims are still on the stage."""
        return all(self._prims[index].IsValid() for index in chosen(indices, self.count))

    def initialize(self, physics_sim_view: object = None) -> None:
        """Do nothing: there are no tensor views to make; poses are read from the stage."""

    def post_reset(self) -> None:
        """Place the prims as `set_default_state` says; by default, as they were when they were wrapped."""
        self.set_world_poses(self._default_positions, self._default_orientations)

    # --- poses ---
    def get_world_poses(self, indices: Indices = None, usd: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Return positions (N, 3) and orientations (N, 4) in the world."""
        positions, orientations = self._out(*poses.world_poses(self._chosen(indices)))
        return positions, orientations

    def set_world_poses(
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        indices: Indices = None,
        usd: bool = True,
    ) -> None:
        """Place prims in the world; what is not given stays."""
        prims = self._chosen(indices)
        poses.set_world_poses(prims, *pose_rows(positions, orientations, len(prims)), strict=False)

    def get_local_poses(self, indices: Indices = None) -> tuple[np.ndarray, np.ndarray]:
        """Return translations (N, 3) and orientations (N, 4) relative to the parents."""
        translations, orientations = self._out(*poses.local_poses(self._chosen(indices)))
        return translations, orientations

    def set_local_poses(
        self, translations: Values | None = None, orientations: Values | None = None, indices: Indices = None
    ) -> None:
        """Place prims relative to their parents; what is not given stays."""
        prims = self._chosen(indices)
        poses.set_local_poses(prims, *pose_rows(translations, orientations, len(prims)), strict=False)

    def get_world_scales(self, indices: Indices = None) -> np.ndarray:
        """Return the scales (N, 3) of the matrices to the world."""
        return self._out(poses.world_scales(self._chosen(indices)))[0]

    def get_local_scales(self, indices: Indices = None) -> np.ndarray:
        """Return the values (N, 3) of the scale ops; 1 without one."""
        return self._out(poses.local_scales(self._chosen(indices), strict=False))[0]

    def set_local_scales(self, scales: Values, indices: Indices = None) -> None:
        """Set the scale ops (N, 3).

        Raises:
            AssertionError: a prim has none.
        """
        prims = self._chosen(indices)
        poses.set_local_scales(prims, rows(scales, 3, len(prims)))

    # --- default state ---
    def get_default_state(self) -> XFormPrimViewState:
        return XFormPrimViewState(*self._out(self._default_positions, self._default_orientations))

    def set_default_state(
        self, positions: Values | None = None, orientations: Values | None = None, indices: Indices = None
    ) -> None:
        """Set the poses in the world that `post_reset` restores; what is not given stays."""
        where = chosen(indices, self.count)
        if positions is not None:
            self._default_positions[where] = rows(positions, 3, len(where))
        if orientations is not None:
            self._default_orientations[where] = rows(orientations, 4, len(where))

    # --- appearance ---
    def set_visibilities(self, visibilities: Values, indices: Indices = None) -> None:
        """Make prims visible or invisible."""
        prims = self._chosen(indices)
        for prim, visible in zip(prims, column(visibilities, len(prims)), strict=True):
            imageable = UsdGeom.Imageable(prim)
            imageable.MakeVisible() if visible else imageable.MakeInvisible()

    def get_visibilities(self, indices: Indices = None) -> np.ndarray:
        """Return which prims are visible (N,), with their ancestors."""
        seen = [
            UsdGeom.Imageable(prim).ComputeVisibility() != UsdGeom.Tokens.invisible for prim in self._chosen(indices)
        ]
        return self._out(np.array(seen, bool))[0]

    def apply_visual_materials(
        self,
        visual_materials: VisualMaterial | Sequence[VisualMaterial],
        weaker_than_descendants: bool | Sequence[bool] | None = None,
        indices: Indices = None,
    ) -> None:
        """Bind materials; one for all, or one for each."""
        where = chosen(indices, self.count)
        several = isinstance(visual_materials, (list, tuple))
        weaker = column(False if weaker_than_descendants is None else weaker_than_descendants, len(where))
        for row, index in enumerate(where):
            material: VisualMaterial = visual_materials[row] if several else visual_materials  # pyright: ignore
            bindings.bind_one(self._prims[index], material.material, weaker=bool(weaker[row]))
            self._materials[index] = material

    def get_applied_visual_materials(self, indices: Indices = None) -> list[VisualMaterial | None]:
        """Return the materials bound to the prims themselves; None for prims without one."""
        material_at = bindings.wrapper_class("api.materials:material_at")
        found = []
        for index in chosen(indices, self.count):
            path = bindings.bound(self._prims[index])
            known = self._materials.get(index)
            found.append(known if known and known.prim_path == path else material_at(path) if path else None)
        return found

    def is_visual_material_applied(self, indices: Indices = None) -> list[bool]:
        """Return which prims have a material bound to themselves."""
        return [bool(bindings.bound(prim)) for prim in self._chosen(indices)]

    def _chosen(self, indices: Indices) -> list[Usd.Prim]:
        """Return the prims of some rows.

        Raises:
            BadPrim: a prim has been removed from the stage.
        """
        prims = [self._prims[index] for index in chosen(indices, self.count)]
        if not all(prim.IsValid() for prim in prims):
            raise BadPrim(f"{self._name}: a prim of {', '.join(self._given)} is not on the stage any more")
        return prims

    def _out(self, *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
        state = simulation()
        return tuple(as_backend(array, state.backend, state.device) for array in arrays)

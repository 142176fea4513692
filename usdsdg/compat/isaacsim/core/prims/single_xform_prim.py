"""`SingleXFormPrim`: pose, scale, visibility and material of one prim."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.isaacsim.core.utils.types import XFormPrimState

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.api.materials.visual_material import VisualMaterial


class SingleXFormPrim:
    """One prim with a transform; an Xform is defined if there is none. See `XFormPrim` for units and arrays."""

    def __init__(
        self,
        prim_path: str,
        name: str = "xform_prim",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        reset_xform_properties: bool = True,
    ) -> None:
        """Wrap or define the prim, and place it; `position` is in the world, `translation` relative to the parent."""
        stage = used_stage.current_stage()
        if not stage.GetPrimAtPath(prim_path):
            stage.DefinePrim(prim_path, "Xform")
        self._view: XFormPrim = self._make_view(
            prim_path, name, position, translation, orientation, scale, visible, reset_xform_properties
        )

    def _make_view(self, *args: object) -> XFormPrim:
        """Return the wrapper of several prims that does the work."""
        return XFormPrim(*args)  # pyright: ignore[reportArgumentType]

    # --- which prim ---
    @property
    def prim_path(self) -> str:
        return self._view.prim_paths[0]

    @property
    def name(self) -> str:
        return self._view.name

    @property
    def prim(self) -> Usd.Prim:
        return self._view.prims[0]

    @property
    def non_root_articulation_link(self) -> bool:
        """Return False: there are no articulations, so every prim can be placed."""
        return False

    def is_valid(self) -> bool:
        return self._view.is_valid()

    def initialize(self, physics_sim_view: object = None) -> None:
        """Do nothing: there are no tensor views to make; poses are read from the stage."""

    def post_reset(self) -> None:
        """Place the prim as `set_default_state` says; by default, as it was when it was wrapped."""
        self._view.post_reset()

    # --- poses ---
    def get_world_pose(self) -> tuple[np.ndarray, np.ndarray]:
        """Return position (3,) and orientation (4,) in the world."""
        positions, orientations = self._view.get_world_poses()
        return positions[0], orientations[0]

    def set_world_pose(
        self, position: Sequence[float] | None = None, orientation: Sequence[float] | None = None
    ) -> None:
        """Place the prim in the world; what is not given stays."""
        self._view.set_world_poses(position, orientation)

    def get_local_pose(self) -> tuple[np.ndarray, np.ndarray]:
        """Return translation (3,) and orientation (4,) relative to the parent."""
        translations, orientations = self._view.get_local_poses()
        return translations[0], orientations[0]

    def set_local_pose(
        self, translation: Sequence[float] | None = None, orientation: Sequence[float] | None = None
    ) -> None:
        """Place the prim relative to its parent; what is not given stays."""
        self._view.set_local_poses(translation, orientation)

    def get_world_scale(self) -> np.ndarray:
        """Return the scale (3,) of the matrix to the world."""
        return self._view.get_world_scales()[0]

    def get_local_scale(self) -> np.ndarray:
        """Return the value (3,) of the scale op."""
        return self._view.get_local_scales()[0]

    def set_local_scale(self, scale: Sequence[float]) -> None:
        self._view.set_local_scales(scale)

    def get_default_state(self) -> XFormPrimState:
        state = self._view.get_default_state()
        return XFormPrimState(state.positions[0], state.orientations[0])

    def set_default_state(
        self, position: Sequence[float] | None = None, orientation: Sequence[float] | None = None
    ) -> None:
        """Set the pose in the world that `post_reset` restores; what is not given stays."""
        self._view.set_default_state(position, orientation)

    # --- appearance ---
    def set_visibility(self, visible: bool) -> None:
        self._view.set_visibilities(visible)

    def get_visibility(self) -> bool:
        """Whether the prim is visible, with its ancestors."""
        return bool(self._view.get_visibilities()[0])

    def apply_visual_material(self, visual_material: VisualMaterial, weaker_than_descendants: bool = False) -> None:
        self._view.apply_visual_materials(visual_material, weaker_than_descendants)

    def get_applied_visual_material(self) -> VisualMaterial | None:
        return self._view.get_applied_visual_materials()[0]

    def is_visual_material_applied(self) -> bool:
        return self._view.is_visual_material_applied()[0]

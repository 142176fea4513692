"""`XformPrim`: poses, scales, visibility and materials of prims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat.isaacsim.core.experimental.prims.prim import Prim
from usdsdg.compat.isaacsim.core.experimental.utils.backend import get_current_backend
from usdsdg.compat.wrappers import bindings, poses
from usdsdg.compat.wrappers.arrays import as_numpy, chosen, column, pose_rows, rows
from usdsdg.errors import warn_once

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.isaacsim.core.experimental.materials.visual_material import VisualMaterial
    from usdsdg.compat.wrappers.arrays import Indices, Values


_WITHOUT_OPS = ("usdrt", "fabric")
_BACKENDS = ("usd", *_WITHOUT_OPS, "tensor")


class XformPrim(Prim):
    """Prims with a transform. Lengths are stage units, quaternions (w, x, y, z), arrays float32 with a row per prim."""

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
    ) -> None:
        """Wrap prims, and place them: one row for all, or one for each.

        Args:
            positions: (N, 3) in the world.
            translations: (N, 3) relative to the parents.
            orientations: (N, 4) in the world; relative to the parents where `translations` are given.
            reset_xform_op_properties: Give the prims the ops translate, orient and scale, and no others.

        Raises:
            AssertionError: there are no such prims, both positions and translations are given, or a prim lacks the op
                that is to be set.
        """
        super().__init__(paths, resolve_paths=resolve_paths)
        self._defaults: dict[str, np.ndarray] = {}
        if positions is not None and translations is not None:
            raise AssertionError("give either positions or translations, not both")
        if reset_xform_op_properties:
            self.reset_xform_op_properties()
        if positions is not None or (orientations is not None and translations is None):
            self.set_world_poses(positions, orientations)
        elif translations is not None:
            self.set_local_poses(translations, orientations)
        if scales is not None:
            self.set_local_scales(scales)

    @property
    def is_non_root_articulation_link(self) -> bool:
        """Return False: there are no articulations, so every prim can be placed."""
        return False

    # --- poses ---
    def get_world_poses(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return positions (N, 3) and orientations (N, 4) in the world."""
        positions, orientations = poses.world_poses(self._chosen(indices))
        return self._warp(positions), self._warp(orientations)

    def set_world_poses(
        self, positions: Values | None = None, orientations: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Place prims in the world; what is not given stays.

        Raises:
            AssertionError: neither is given, or a prim lacks the op translate or orient.
        """
        prims = self._chosen(indices)
        poses.set_world_poses(prims, *_pose_rows(positions, orientations, len(prims)), strict=self._needs_ops())

    def get_local_poses(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return translations (N, 3) and orientations (N, 4) relative to the parents."""
        translations, orientations = poses.local_poses(self._chosen(indices))
        return self._warp(translations), self._warp(orientations)

    def set_local_poses(
        self, translations: Values | None = None, orientations: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Place prims relative to their parents; what is not given stays.

        Raises:
            AssertionError: neither is given, or a prim lacks the op translate or orient.
        """
        prims = self._chosen(indices)
        poses.set_local_poses(prims, *_pose_rows(translations, orientations, len(prims)), strict=self._needs_ops())

    def get_local_scales(self, *, indices: Indices = None) -> wp.array:
        """Return the values (N, 3) of the scale ops.

        Raises:
            AssertionError: a prim has no scale op, and the backend is not Fabric.
        """
        return self._warp(poses.local_scales(self._chosen(indices), strict=self._needs_ops()))

    def set_local_scales(self, scales: Values, *, indices: Indices = None) -> None:
        """Set the scale ops (N, 3).

        Raises:
            AssertionError: a prim has no scale op, and the backend is not Fabric.
        """
        prims = self._chosen(indices)
        poses.set_local_scales(prims, rows(scales, 3, len(prims)), strict=self._needs_ops())

    def reset_xform_op_properties(self) -> None:
        """Give the prims the ops translate, orient and scale, and no others; their poses in the world stay."""
        poses.reset_ops(self._chosen(None))

    # --- default state ---
    def set_default_state(
        self, positions: Values | None = None, orientations: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Remember poses in the world for `reset_to_default_state`; rows that are never set are the identity.

        Raises:
            AssertionError: neither is given.
        """
        if positions is None and orientations is None:
            raise AssertionError("give positions or orientations")
        self._set_default("positions", positions, (0.0, 0.0, 0.0), indices)
        self._set_default("orientations", orientations, (1.0, 0.0, 0.0, 0.0), indices)

    def get_default_state(self, *, indices: Indices = None) -> tuple[wp.array | None, ...]:
        """Return the default positions (N, 3) and orientations (N, 4); None where none have been set."""
        return self._default("positions", indices), self._default("orientations", indices)

    def reset_to_default_state(self, *, warn_on_non_default_state: bool = False) -> None:
        """Place the prims as `set_default_state` says."""
        if self._defaults.keys() & {"positions", "orientations"}:
            self.set_world_poses(self._defaults.get("positions"), self._defaults.get("orientations"))
        elif warn_on_non_default_state:
            warn_once(f"{self.paths[0]}: there is no default pose to reset to; call set_default_state first")

    def _set_default(self, name: str, values: Values | None, usual: tuple[float, ...], indices: Indices) -> None:
        if values is None:
            return
        table = self._defaults.setdefault(name, np.tile(np.array(usual, np.float32), (len(self), 1)))
        where = chosen(indices, len(self))
        table[where] = rows(values, len(usual), len(where))

    def _default(self, name: str, indices: Indices) -> wp.array | None:
        table = self._defaults.get(name)
        return None if table is None else self._warp(table[chosen(indices, len(self))])

    # --- appearance ---
    def set_visibilities(self, visibilities: Values, *, indices: Indices = None) -> None:
        """Make prims visible or invisible; what makes one visible may make its ancestors visible too."""
        prims = self._chosen(indices)
        for prim, visible in zip(prims, column(visibilities, len(prims)), strict=True):
            imageable = UsdGeom.Imageable(prim)
            imageable.MakeVisible() if visible else imageable.MakeInvisible()

    def get_visibilities(self, *, indices: Indices = None) -> wp.array:
        """Return which prims are visible (N, 1), with their ancestors."""
        return self._warp(np.array([[_is_visible(prim)] for prim in self._chosen(indices)], bool))

    def apply_visual_materials(
        self,
        materials: VisualMaterial | Sequence[VisualMaterial],
        *,
        weaker_than_descendants: Values | None = None,
        indices: Indices = None,
    ) -> None:
        """Bind the first prim of each material; one for all, or one for each."""
        prims = self._chosen(indices)
        weaker = False if weaker_than_descendants is None else as_numpy(weaker_than_descendants)
        bindings.bind(prims, materials, column(weaker, len(prims)))

    def get_applied_visual_materials(self, *, indices: Indices = None) -> list[VisualMaterial | None]:
        """Return wrappers of the materials bound to the prims themselves; None for prims without one."""
        fetch = bindings.wrapper_class("experimental.materials:VisualMaterial").fetch_instances
        paths = [bindings.bound(prim) for prim in self._chosen(indices)]
        return [fetch(path)[0] if path else None for path in paths]

    def _needs_ops(self) -> bool:
        """Whether prims without the ops translate, orient and scale are refused: not by Fabric, which has none."""
        return get_current_backend(_BACKENDS) not in _WITHOUT_OPS


def _pose_rows(
    points: Values | None, orientations: Values | None, count: int
) -> tuple[np.ndarray | None, np.ndarray | None]:
    if points is None and orientations is None:
        raise AssertionError("give positions (translations) or orientations")
    return pose_rows(points, orientations, count)


def _is_visible(prim: Usd.Prim) -> bool:
    return UsdGeom.Imageable(prim).ComputeVisibility() != UsdGeom.Tokens.invisible

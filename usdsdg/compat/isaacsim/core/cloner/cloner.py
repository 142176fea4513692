"""`Cloner`: copies of a prim at given poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat import used_stage
from usdsdg.compat.wrappers import poses
from usdsdg.compat.wrappers.arrays import as_numpy
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.errors import BadPrim, counted
from usdsdg.stage import paths

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Values


class Cloner:
    """Makes copies of prims of one stage."""

    def __init__(self, stage: Usd.Stage | None = None) -> None:
        """Work on a stage, by default the current one."""
        self._stage = stage or used_stage.current_stage()

    def define_base_env(self, base_env_path: str) -> None:
        """Define a Scope for the copies."""
        UsdGeom.Scope.Define(self._stage, base_env_path)

    def generate_paths(self, root_path: str, num_paths: int) -> list[str]:
        """Return `num_paths` paths: `root_path`_0, `root_path`_1, ..."""
        return [f"{root_path}_{index}" for index in range(num_paths)]

    def clone(
        self,
        source_prim_path: str,
        prim_paths: Sequence[str],
        positions: Values | None = None,
        orientations: Values | None = None,
        replicate_physics: bool = False,
        base_env_path: str | None = None,
        root_path: str | None = None,
        copy_from_source: bool = False,
        unregister_physics_replication: bool = False,
        enable_env_ids: bool = False,
        clone_in_fabric: bool = False,
    ) -> None:
        """Copy a prim to several paths; a path that is the source's own is only placed.

        Copies and source get the ops translate, orient and scale. How PhysX replicates its bodies has no counterpart:
        every copy has bodies of its own.

        Args:
            positions: (N, 3) of the copies relative to their parents; by default those of the source.
            orientations: (N, 4), w, x, y, z.
            copy_from_source: Copy what is authored; otherwise copies inherit from the source and follow its changes.
            enable_env_ids: With `replicate_physics`, let no copy collide with another one or the source, as where all
                are in one place; they collide with everything else.

        Raises:
            BadPrim: there is no source.
            ValueError: there are not as many poses as paths.
        """
        source = self._stage.GetPrimAtPath(source_prim_path)
        if not source:
            raise BadPrim(f"there is no prim at {source_prim_path} to copy")
        for values in (positions, orientations):
            if values is not None and len(as_numpy(values)) != len(prim_paths):
                given = counted(len(as_numpy(values)), "pose is", "poses are")
                raise ValueError(f"{given} given for {counted(len(prim_paths), 'copy', 'copies')}")
        poses.reset_ops([source])
        self._place(self._copies(source, list(prim_paths), copy_from_source), positions, orientations)
        if replicate_physics and enable_env_ids:
            root = UsdGeom.Scope.Define(self._stage, paths.next_free_path(self._stage, "/EnvironmentCollisions"))
            self._keep_apart(str(root.GetPath()), list(dict.fromkeys([source_prim_path, *map(str, prim_paths)])))

    def _copies(self, source: Usd.Prim, prim_paths: list[str], copy_specs: bool) -> list[Usd.Prim]:
        layer = self._stage.GetRootLayer()
        with Sdf.ChangeBlock():
            for path in prim_paths:
                if path == str(source.GetPath()):
                    continue
                spec = Sdf.CreatePrimInLayer(layer, path)
                if copy_specs:
                    Sdf.CopySpec(layer, source.GetPath(), layer, Sdf.Path(path))
                else:
                    spec.inheritPathList.Prepend(source.GetPath())
        return [self._stage.GetPrimAtPath(path) for path in prim_paths]

    def _place(self, prims: list[Usd.Prim], positions: Values | None, orientations: Values | None) -> None:
        places, turns = poses.local_poses(prims)
        if positions is not None:
            places = as_numpy(positions).reshape(-1, 3).astype(np.float64)
        if orientations is not None:
            turns = as_numpy(orientations).reshape(-1, 4).astype(np.float64)
        poses.set_local_poses(prims, places, turns)

    def filter_collisions(
        self,
        physicsscene_path: str,
        collision_root_path: str,
        prim_paths: Sequence[str],
        global_paths: Sequence[str] = (),
    ) -> None:
        """Let the colliders of each copy collide only with each other and with those of `global_paths`."""
        existing_prim(physicsscene_path)
        UsdGeom.Scope.Define(self._stage, collision_root_path)
        self._keep_apart(collision_root_path, prim_paths)
        if global_paths:
            self._group(f"{collision_root_path}/global_group", global_paths)

    def _keep_apart(self, root_path: str, prim_paths: Sequence[str]) -> None:
        """Let nothing at or below one of the prims collide with another one of them, by groups below `root_path`."""
        groups = [self._group(f"{root_path}/group{i}", [path]) for i, path in enumerate(prim_paths)]
        # PhysX's inverted filter, which names the groups that do collide, has no counterpart in UsdPhysics.
        for group in groups:
            others = [other.GetPath() for other in groups if other is not group]
            group.CreateFilteredGroupsRel().SetTargets(others)

    def _group(self, path: str, members: Sequence[str]) -> UsdPhysics.CollisionGroup:
        group = UsdPhysics.CollisionGroup.Define(self._stage, path)
        group.GetCollidersCollectionAPI().CreateIncludesRel().SetTargets([Sdf.Path(str(each)) for each in members])
        return group

    def replicate_physics(self, *_: object, **__: object) -> None:
        """Do nothing: physics reads every copy from the stage."""

    def disable_change_listener(self) -> None:
        """Do nothing: changes of the stage are read at the next step."""

    def enable_change_listener(self) -> None:
        """Do nothing: changes of the stage are read at the next step."""

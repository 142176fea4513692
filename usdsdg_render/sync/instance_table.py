"""Placements of gprims to the instances of a scene."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from pxr import Sdf

from usdsdg import errors
from usdsdg_render.scene.scene import Instances, Scene
from usdsdg_render.sync.gprims import Placements
from usdsdg_render.usd.world_transforms import WorldTransforms, matrix_product


class InstanceTable:
    """Keeps the instances of one scene and their transforms up to date with the placements of gprims."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._placements = Placements()
        self._nodes = np.zeros(0, np.int64)  # tree node of each placement
        self._point_instances = np.zeros(0, np.int64)  # indices of placements
        self._to_instancer = np.zeros((0, 4, 4))  # matrices of those
        self._has_surface = np.zeros(0, bool)
        self._drawn = np.zeros(0, np.int64)  # placements that are instances

    def set_placements(self, placements: Placements) -> None:
        self._placements = placements
        self._nodes = np.array(placements.nodes, np.int64)
        points = placements.to_instancer
        self._point_instances = np.concatenate(
            [np.zeros(0, np.int64), *(np.arange(first, first + len(each)) for first, each in points)]
        )
        self._to_instancer = np.concatenate([np.zeros((0, 4, 4)), *(each for _, each in points)])
        self._has_surface = np.array([gprim.prototype is not None for gprim in placements.gprims], bool)

    def write(
        self, world: np.ndarray, prototypes: Mapping[int, int], slots: Mapping[Sdf.Path, int], *, always: bool
    ) -> None:
        """Write the instances with a surface and an invertible matrix; of all others warn.

        Args:
            world: (nodes, 4, 4) float64 local-to-world.
            prototypes: index in the scene, by id of the prototype.
            slots: first material slot of each gprim.
            always: also write the instances where the same ones are drawn, since their gprims may have changed.
        """
        matrices = world[self._nodes]
        if len(self._point_instances):
            matrices[self._point_instances] = matrix_product(self._to_instancer, matrices[self._point_instances])
        usable = invertible(matrices)
        for k in np.flatnonzero(self._has_surface & ~usable):
            errors.warn_once(
                f"{self._placements.paths[k]}: its transform is NaN, infinite, scaled to zero or so far out of "
                f"proportion that 32-bit numbers lose it, so it is not drawn. Correct the xformOps of it or of a prim "
                f"above."
            )
        drawn = np.flatnonzero(self._has_surface & usable)
        if always or not np.array_equal(drawn, self._drawn):
            self._write_instances(drawn, prototypes, slots)
        scene = self._scene
        if not np.array_equal(scene.instances.local_to_world, matrices[drawn]):
            scene.instances = replace(scene.instances, local_to_world=matrices[drawn])
            scene.touch("transforms")

    def in_worlds(self, world: WorldTransforms) -> np.ndarray:
        """(worlds, instances, 4, 4) transforms of the instances as last written."""
        matrices = world.at(self._nodes[self._drawn])
        if len(matrices) != world.count:
            matrices = np.repeat(matrices, world.count, axis=0)
        of_point = np.isin(self._drawn, self._point_instances)
        if of_point.any():
            to_instancer = self._to_instancer[np.searchsorted(self._point_instances, self._drawn[of_point])]
            matrices[:, of_point] = matrix_product(to_instancer, matrices[:, of_point])
        return matrices

    def _write_instances(self, drawn: np.ndarray, prototypes: Mapping[int, int], slots: Mapping[Sdf.Path, int]) -> None:
        placements, old = self._placements, self._scene.instances
        gprims = [placements.gprims[k] for k in drawn]
        new = Instances(
            paths=tuple(placements.paths[k] for k in drawn),
            prototype=np.array([prototypes[id(gprim.prototype)] for gprim in gprims], np.int32),
            local_to_world=old.local_to_world,
            slot_offset=np.array([slots[gprim.path] for gprim in gprims], np.int32),
            casts_shadow=np.array([gprim.casts_shadow for gprim in gprims], np.int32),
            lasting_paths=tuple(placements.lasting_paths[k] for k in drawn) if len(self._point_instances) else (),
        )
        self._drawn = drawn
        columns = ("prototype", "slot_offset", "casts_shadow")
        if old.paths != new.paths or any(not np.array_equal(getattr(old, c), getattr(new, c)) for c in columns):
            self._scene.instances = new
            self._scene.touch("instances")


def invertible(matrices: np.ndarray) -> np.ndarray:
    """(N,) bool: which (N, 4, 4) matrices are finite and have an inverse, in 32-bit numbers too."""
    linear = matrices[:, :3, :3]
    with np.errstate(invalid="ignore", over="ignore"):
        a, b, c = linear.transpose(1, 2, 0)
        volume = np.abs(
            a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        product = np.sqrt(np.einsum("nij,nij->ni", linear, linear)).prod(axis=1)
        within = (np.abs(matrices) < 1e17).all(axis=(1, 2))  # False for NaN
        return within & (product > 1e-30) & (volume > 1e-9 * product)

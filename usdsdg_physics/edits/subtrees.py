"""Read again what is below prims that were added, removed or changed, and put it into the scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike
from pxr import Sdf, Usd

from usdsdg.stage.paths import at_or_below
from usdsdg.stage.physics.instances import part_name, split_instance, whole
from usdsdg.stage.time_code import current_time
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.scene.prim_paths import paths_below
from usdsdg_physics.scene.records import Body, Collider, Scene, Shape

_Record = TypeVar("_Record")


class SubtreeReader:
    """Compares what is below prims of a stage with what a scene has there."""

    def __init__(self, stage: Usd.Stage, scene: Scene, hulls: HullCache) -> None:
        self._stage, self._scene, self._hulls = stage, scene, hulls
        # Sorted paths; instances of PointInstancers have no prims.
        self.bodies = sorted(path for path in scene.bodies if not split_instance(path))
        self.colliders = sorted(path for path in scene.colliders if not split_instance(path) and whole(path) == path)
        self._joints = sorted(scene.joints)
        self.materials = {collider.material.path for collider in scene.colliders.values()} - {""}

    def read(self, roots: Iterable[Sdf.Path]) -> dict[str, Scene] | None:
        """Return what differs, physically, from the scene below some roots, by root; None where all has to be read."""
        found: dict[str, Scene] = {}
        for root in roots:
            path = str(root)
            if root == Sdf.Path.absoluteRootPath or any(at_or_below(each, path) for each in self.materials):
                return None
            if any(at_or_below(p, path) or at_or_below(path, p) for p in self._scene.prototypes):
                return None
            now = parse(self._stage, self._hulls, root=root, time=current_time(), default=self._scene.default_material)
            if now.scene_path or now.filtered or now.instancers or at_or_below(self._scene.scene_path, path):
                return None
            if set(now.relations) != {each for each in self._scene.relations if at_or_below(each, path)}:
                return None
            if self._differs(path, now):
                if not all(map(_is_separable, (self._scene, now))) or path.startswith("/__Prototype"):
                    return None
                found[path] = now
        return found

    def parts_of(self, path: str) -> list[str]:
        """Return the names of the parts of a collider, of most only its own."""
        return [part_name(path, part) for part in range(self._scene.colliders[path].parts)]

    def _differs(self, path: str, now: Scene) -> bool:
        scene = self._scene
        before_bodies = paths_below(self.bodies, path)
        before_colliders = [part for each in paths_below(self.colliders, path) for part in self.parts_of(each)]
        return not (
            now.forces == {p: force for p, force in scene.forces.items() if at_or_below(p, path)}
            and now.reports == {p: report for p, report in scene.reports.items() if at_or_below(p, path)}
            and set(now.bodies) == set(before_bodies)
            and set(now.colliders) == set(before_colliders)
            and now.joints
            == {each: replace(scene.joints[each], articulated=False) for each in paths_below(self._joints, path)}
            and all(_same_body(now.bodies[p], scene.bodies[p]) for p in before_bodies)
            and all(_same_collider(now.colliders[p], scene.colliders[p]) for p in before_colliders)
        )


def with_subtrees(stage: Usd.Stage, scene: Scene, subtrees: Mapping[str, Scene]) -> Scene:
    """Return a scene with what is at or below some paths replaced by what was read there, in the order of the stage."""
    key = _StageOrder(stage).key

    def merged(records: Callable[[Scene], Mapping[str, _Record]]) -> dict[str, _Record]:
        kept = {
            path: record
            for path, record in records(scene).items()
            if not any(at_or_below(whole(path), root) for root in subtrees)
        }
        for part in subtrees.values():
            kept.update(records(part))
        return {path: kept[path] for path in sorted(kept, key=key)}

    return replace(
        scene,
        bodies=merged(lambda each: each.bodies),
        colliders=merged(lambda each: each.colliders),
        forces=merged(lambda each: each.forces),
        reports=merged(lambda each: each.reports),
    )


class _StageOrder:
    """Where prims are in a traversal of a stage."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._children: dict[str, dict[str, int]] = {}

    def key(self, name: str) -> tuple[int, ...]:
        """Return what sorts a prim, or a convex part of one."""
        found, parent = [], ""
        for child in whole(name)[1:].split("/"):
            if parent not in self._children:
                prim = self._stage.GetPrimAtPath(parent or "/")
                names = prim.GetFilteredChildrenNames(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
                self._children[parent] = {each: index for index, each in enumerate(names)}
            found.append(self._children[parent][child])
            parent = f"{parent}/{child}"
        return tuple(found)


def _is_separable(scene: Scene) -> bool:
    """Return whether parts of a scene mean the same alone: nothing relates them, and nothing depends on the time."""
    return not (scene.has_relations or scene.animated or scene.instancers)


def _same_body(a: Body, b: Body) -> bool:
    """Return whether two records differ in pose and velocities at most."""
    at_pose_of_b = replace(
        a,
        pose=b.pose,
        velocity=b.velocity,
        angular_velocity=b.angular_velocity,
        body_from_prim=b.body_from_prim,
        kinematic=a.kinematic or b.held,
        held=b.held,
    )
    return at_pose_of_b == b and nearly_equal(a.body_from_prim, b.body_from_prim)


def _same_collider(a: Collider, b: Collider) -> bool:
    """Return whether two records are equal but for rounding."""
    return replace(a, shape=b.shape) == b and same_geometry(a.shape, b.shape) and same_place(a.shape, b.shape)


def same_place(a: Shape, b: Shape) -> bool:
    """Return whether two shapes are at the same place but for rounding."""
    is_near = bool(np.allclose(a.position, b.position, atol=1e-6))
    return is_near and bool(abs(np.dot(a.rotation, b.rotation)) > 1.0 - 1e-9)


def same_geometry(a: Shape, b: Shape) -> bool:
    """Return whether two shapes are equal but for rounding and where they are."""
    return a.kind == b.kind and a.solid == b.solid and nearly_equal(a.size, b.size)


def nearly_equal(a: ArrayLike, b: ArrayLike) -> bool:
    """Return whether values are equal but for the rounding of single-precision ops."""
    return bool(np.allclose(a, b, rtol=1e-4, atol=1e-9))

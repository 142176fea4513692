"""Hits of scene queries, in the forms of `omni.physics.core` and of `omni.physx`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from usdsdg.compat.carb import Float3
from usdsdg.compat.physics_schema_tools import encodeSdfPath, sdfPathToInt
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry.face_triangles import face_triangles
from usdsdg.stage.physics.instances import prim_of, split_instance

if TYPE_CHECKING:
    from usdsdg_physics.queries.scene_queries import Overlap, RayHit

# The index of a prototype, or of a face, for a collider that has none.
NO_INDEX = 0xFFFFFFFF
ORIGIN = Float3()

Vector = Sequence[float]


@dataclass(frozen=True)
class SceneQueryHitObject:
    """A collider of a hit, as `omni.physics.core` has it: paths are integers of `PhysicsSchemaTools`."""

    collision: int = 0
    rigid_body: int = 0  # that of the collider itself where it has no body
    proto_index: int = NO_INDEX


@dataclass(frozen=True)
class OverlapHit(SceneQueryHitObject):
    """A collider that overlaps the volume of a query."""


@dataclass(frozen=True)
class SceneQueryHitLocation(SceneQueryHitObject):
    """Where a collider is hit: position and normal in the world, lengths in stage units."""

    normal: Float3 = ORIGIN
    position: Float3 = ORIGIN
    distance: float = 0.0
    face_index: int = NO_INDEX  # of the USD mesh of a triangle mesh
    material: int = 0  # the physics material's path


@dataclass(frozen=True)
class RaycastHit(SceneQueryHitLocation):
    """Where a ray hits a collider."""


@dataclass(frozen=True)
class SweepHit(SceneQueryHitLocation):
    """Where a moving shape touches a collider; `distance` is how far it moves."""


@dataclass(frozen=True)
class PhysxHit:
    """A collider of a hit, as `omni.physx` has it: paths are strings."""

    collision: str
    rigid_body: str
    protoIndex: int = NO_INDEX

    @property
    def collision_encoded(self) -> list[int]:
        """The collider's path as two integers of `PhysicsSchemaTools.encodeSdfPath`."""
        return list(encodeSdfPath(self.collision))

    @property
    def rigid_body_encoded(self) -> list[int]:
        """The body's path as two integers."""
        return list(encodeSdfPath(self.rigid_body))


@dataclass(frozen=True)
class PhysxLocatedHit(PhysxHit):
    """Where a collider is hit, as `omni.physx` has it."""

    position: Float3 = ORIGIN
    normal: Float3 = ORIGIN
    distance: float = 0.0
    face_index: int = NO_INDEX
    material: str = ""

    @property
    def material_encoded(self) -> list[int]:
        """The material's path as two integers."""
        return list(encodeSdfPath(self.material))


def overlap_hit(hit: Overlap) -> OverlapHit:
    """Return a hit in the form of `omni.physics.core`."""
    return OverlapHit(*_collider(hit))


def raycast_hit(hit: RayHit) -> RaycastHit:
    """Return a hit in the form of `omni.physics.core`."""
    return RaycastHit(*_collider(hit), *_location(hit))


def sweep_hit(hit: RayHit) -> SweepHit:
    """Return a hit in the form of `omni.physics.core`."""
    return SweepHit(*_collider(hit), *_location(hit))


def proto_index(name: str) -> int:
    """Return the index of the instance of a PointInstancer that a collider belongs to, NO_INDEX of any other."""
    found = split_instance(name)
    return found[1] if found else NO_INDEX


def path_id(name: str) -> int:
    """Return the integer of the path of a body or collider; of an instance it is that of the PointInstancer."""
    return sdfPathToInt(prim_of(name))


def _collider(hit: Overlap | RayHit) -> tuple[int, int, int]:
    return path_id(hit.collision), path_id(hit.rigid_body), proto_index(hit.collision)


def _location(hit: RayHit) -> tuple[Float3, Float3, float, int, int]:
    material = sdfPathToInt(material_path(hit.collision))
    return Float3(hit.normal), Float3(hit.position), hit.distance, usd_face(hit), material


def physx_hit(hit: Overlap) -> PhysxHit:
    """Return a hit in the form of `omni.physx`."""
    return PhysxHit(prim_of(hit.collision), prim_of(hit.rigid_body), proto_index(hit.collision))


def physx_located_hit(hit: RayHit) -> PhysxLocatedHit:
    """Return a hit in the form of `omni.physx`."""
    where = Float3(hit.position), Float3(hit.normal), hit.distance, usd_face(hit), material_path(hit.collision)
    return PhysxLocatedHit(prim_of(hit.collision), prim_of(hit.rigid_body), proto_index(hit.collision), *where)


def usd_face(hit: RayHit) -> int:
    """Return the face of the USD mesh whose triangle was hit, NO_INDEX for other shapes."""
    if hit.face < 0:
        return NO_INDEX
    mesh = UsdGeom.Mesh(_prim(hit.collision))
    points = np.asarray(mesh.GetPointsAttr().Get() or (), np.float32).reshape(-1, 3)
    counts, indices, holes = (
        np.asarray(attribute.Get() or (), np.int64)
        for attribute in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(), mesh.GetHoleIndicesAttr())
    )
    faces = face_triangles(points, counts, indices, holes).faces
    return int(faces[hit.face]) if hit.face < len(faces) else NO_INDEX


def material_path(collider: str) -> str:
    """Return the path of a collider's physics material, "" where none is bound."""
    material = UsdShade.MaterialBindingAPI(_prim(collider)).ComputeBoundMaterial("physics")[0]
    return str(material.GetPath()) if material else ""


def _prim(name: str) -> Usd.Prim:
    """Return the prim of a collider; of an instance of a PointInstancer that of the prototype."""
    found = split_instance(name)
    if found is None:
        return current_stage().GetPrimAtPath(name)
    instancer = UsdGeom.PointInstancer(current_stage().GetPrimAtPath(found[0]))
    prototype = instancer.GetPrototypesRel().GetForwardedTargets()[instancer.GetProtoIndicesAttr().Get()[found[1]]]
    return current_stage().GetPrimAtPath(f"{prototype}{found[2]}")

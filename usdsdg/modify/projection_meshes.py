"""Projection meshes: the surface of targets that a projector covers, as a separate mesh with baked UVs.

A projection is a Mesh prim with the properties `usdsdg:projector` (the prim whose box is projected), `usdsdg:axis` (its
axis against which it is projected, "X" or "Z"), `usdsdg:targets`, `usdsdg:offset` and `usdsdg:depth`. `bake` recomputes
its points and UVs, and `follow` does so before each picture where one of them has moved.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import BadPrim
from usdsdg.graph.evaluate import graph
from usdsdg.scatter.bounds import Bounds
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry.triangles import triangles_below
from usdsdg.stage.poses import pivots, transforms
from usdsdg.stage.scopes import REPLICATOR

PROJECTOR, TARGETS, OFFSET, DEPTH, AXIS = (
    f"usdsdg:{name}" for name in ("projector", "targets", "offset", "depth", "axis")
)
# Sine of the angle between a face and the direction of projection below which the face is skipped.
_GRAZING = 0.05


def define(
    stage: Usd.Stage, path: str, projector: Usd.Prim, targets: Sequence[Usd.Prim], *, offset: float, depth: float = 0.0,
    axis: str = "Z",
) -> UsdGeom.Mesh:  # fmt: skip
    """Define and bake a projection mesh from a projector onto targets.

    Args:
        offset: distance of the mesh above the surface of the targets [stage units].
        depth: shift of the projector along its axis [stage units].
        axis: of the projector, "X" or "Z", which points away from what is covered.
    """
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    prim = mesh.GetPrim()
    prim.CreateRelationship(PROJECTOR, custom=True).SetTargets([projector.GetPath()])
    prim.CreateRelationship(TARGETS, custom=True).SetTargets([target.GetPath() for target in targets])
    for name, value in ((OFFSET, offset), (DEPTH, depth)):
        prim.CreateAttribute(name, Sdf.ValueTypeNames.Float, custom=True).Set(float(value))
    prim.CreateAttribute(AXIS, Sdf.ValueTypeNames.Token, custom=True).Set(axis)
    bake(prim)
    return mesh


def projector_of(prim: Usd.Prim) -> Usd.Prim:
    """Return the projector of a projection mesh.

    Raises:
        BadPrim: `prim` is not a projection, or its projector does not exist.
    """
    found = _related(prim, PROJECTOR)
    if len(found) != 1:
        raise BadPrim(f"{prim.GetPath()} is not a projection; make one with create.projection_material")
    return found[0]


def _related(prim: Usd.Prim, name: str) -> list[Usd.Prim]:
    relation = prim.GetRelationship(name)
    found = [prim.GetStage().GetPrimAtPath(path) for path in relation.GetTargets()] if relation else []
    return [each for each in found if each]


def bake(prim: Usd.Prim) -> None:
    """Recompute the points and UVs of a projection from the current poses of projector and targets.

    All faces of the targets that lie in the projector's box and face the projector are covered, including occluded
    ones. UVs run from (0, 0) to (1, 1) over the side of the box that one sees who looks along the projection with Y up:
    over X and Y, or, against X, over Z from its end and Y. If nothing is covered the mesh is empty.

    Raises:
        BadPrim: `prim` is not a projection.
    """
    offset, depth = (float(prim.GetAttribute(name).Get()) for name in (OFFSET, DEPTH))
    axis = prim.GetAttribute(AXIS).Get() if prim.HasAttribute(AXIS) else "Z"
    corners, uvs = covered(projector_of(prim), _related(prim, TARGETS), offset, depth, axis)
    to_local = transforms.as_array(transforms.world_to_local(prim))
    points = (corners.reshape(-1, 3) @ to_local[:3, :3] + to_local[3, :3]).astype(np.float32)
    mesh = UsdGeom.Mesh(prim)
    with Sdf.ChangeBlock():
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(corners), 3))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.arange(len(points), dtype=np.int32)))
        if len(points):
            mesh.CreateExtentAttr([Gf.Vec3f(*points.min(0).tolist()), Gf.Vec3f(*points.max(0).tolist())])
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set(Vt.Vec2fArray.FromNumpy(uvs.reshape(-1, 2).astype(np.float32)))
    _baked()[str(prim.GetPath())] = _places(prim)


def follow() -> None:
    """Recompute the projections of the stage whose projector or targets have moved, by whatever moved them.

    Poses count, and not points of meshes. Projections without their projector or a target stay as they are.
    """
    baked, stage = _baked(), current_stage()
    for path, places in list(baked.items()):
        prim = stage.GetPrimAtPath(path)
        if not prim or not prim.HasRelationship(PROJECTOR):
            del baked[path]
        elif (now := _places(prim)) is not None and now != places:
            bake(prim)


def _baked() -> dict[str, Any]:
    """Return where projector and targets of each projection were when it was computed; None in a stage as opened."""
    baked = graph().projections
    if baked is None:
        root = current_stage().GetPrimAtPath(REPLICATOR)
        found = [each for each in Usd.PrimRange(root) if each.HasRelationship(PROJECTOR)] if root else []
        baked = graph().projections = {str(prim.GetPath()): None for prim in found}
    return baked


def _places(prim: Usd.Prim) -> bytes | None:
    """Return the poses of projector, targets and the shapes below them; None where one is not on the stage."""
    stage = prim.GetStage()
    paths = [path for name in (PROJECTOR, TARGETS) for path in prim.GetRelationship(name).GetTargets()]
    prims = [stage.GetPrimAtPath(path) for path in paths]
    if not all(prims):
        return None
    cache, shapes = UsdGeom.XformCache(), Usd.TraverseInstanceProxies()
    matrices = [
        cache.GetLocalToWorldTransform(each)
        for root in prims
        for each in Usd.PrimRange(root, shapes)
        if each == root or each.IsA(UsdGeom.Gprim)
    ]
    return np.array(matrices).tobytes()


def covered(
    projector: Usd.Prim, targets: Sequence[Usd.Prim], offset: float = 0.0, depth: float = 0.0, axis: str = "Z"
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the covered surface: world triangles (T, 3, 3), `offset` above the surface, and their UVs (T, 3, 2)."""
    box = _box(projector)
    to_world = transforms.as_array(transforms.local_to_world(projector))
    backward = to_world["XYZ".index(axis), :3]
    backward = backward / np.linalg.norm(backward)
    to_world[3, :3] += depth * backward
    to_projector = np.linalg.inv(to_world)
    parts = [placed.in_world().corners() for placed in triangles_below(targets)]
    corners = np.concatenate(parts) if parts else np.zeros((0, 3, 3))
    normals = _normals(corners)
    # Facing is tested in world space: the projector's own space may be stretched or mirrored.
    facing = normals @ backward > _GRAZING
    inside = box.clip(corners[facing] @ to_projector[:3, :3] + to_projector[3, :3])
    fractions = (inside - box.lower) / (box.upper - box.lower)
    uvs = fractions[..., :2] if axis == "Z" else np.stack([1 - fractions[..., 2], fractions[..., 1]], axis=-1)
    in_world = inside @ to_world[:3, :3] + to_world[3, :3]
    return in_world + offset * _normals(in_world)[:, None], uvs


def _normals(corners: np.ndarray) -> np.ndarray:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def size_of(projector: Usd.Prim) -> float:
    """Return the cube root of the world volume of a projector's box [stage units].

    Raises:
        DegenerateFrame: the projector has a scale of zero.
    """
    transforms.world_to_local(projector)
    box, to_world = _box(projector), transforms.as_array(transforms.local_to_world(projector))
    return float(abs(np.linalg.det(to_world[:3, :3])) * np.prod(box.upper - box.lower)) ** (1 / 3)


def _box(projector: Usd.Prim) -> Bounds:
    """Return the projector's local bounding box: a one meter cube if it has no geometry, as deep as wide if flat."""
    found = pivots.bounds(projector)
    if found.IsEmpty():
        half = np.full(3, 0.5 / transforms.meters_per_unit(projector.GetStage()))
        return Bounds(-half, half)
    center, half = np.array(found.GetMidpoint()), np.array(found.GetSize()) / 2
    half = np.where(half > 1e-9 * half.max(), half, half.max())
    return Bounds(center - half, center + half)

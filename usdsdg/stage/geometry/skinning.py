"""Deformation of skinned meshes, by the rules of UsdSkel.

Blend shapes with their in-betweens are applied first, then the joints: by linear blending or dual quaternions, with
influences per point or for the whole mesh. Results are in the mesh's own frame, to which its own transform applies.
"""

from typing import NamedTuple

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdSkel, Vt

from usdsdg.errors import warn_once
from usdsdg.stage.changes import Changes
from usdsdg.stage.geometry.joint_influences import warn_of_influences
from usdsdg.stage.geometry.skeleton_faults import (
    has_bind_pose,
    has_blend_shapes,
    warn_of_animation,
    warn_of_channels,
    warn_of_lost_skeleton,
)
from usdsdg.stage.usd_errors import reason

# Properties and prim types that define how meshes are skinned, or the poses of joints.
SKEL_PREFIXES = ("skel:", "primvars:skel:")
SKEL_TYPES = ("Skeleton", "SkelAnimation", "BlendShape")


class SkinnedMesh(NamedTuple):
    """Points and normals of a mesh, deformed by its skeleton."""

    points: np.ndarray  # (V, 3) float32, the mesh's own frame [stage units]
    normals: np.ndarray | None  # (M, 3) float32, not normalized; as many as were given


class _Binding(NamedTuple):
    skeleton: UsdSkel.SkeletonQuery
    skeleton_prim: Usd.Prim  # inside an instance this is the instance proxy; the query has the prototype's prim
    mesh: UsdSkel.SkinningQuery
    parts: tuple[Sdf.Path, ...]  # prims outside of the mesh that it depends on
    movers: frozenset[Sdf.Path]  # prims above mesh and skeleton, and these, if a move of the SkelRoot deforms the mesh


def character_predicate(root: UsdSkel.Root) -> Usd._PrimFlagsPredicate:
    """Return which prims below a SkelRoot are the character's.

    A prototype of a point instancer may be a class or an over, or below one: USD's traversals leave out all of it then.
    """
    prim = root.GetPrim()
    is_left_out = prim.IsAbstract() or not prim.IsDefined()
    return Usd.TraverseInstanceProxies(Usd.PrimIsActive if is_left_out else Usd.PrimDefaultPredicate)


class Skinning:
    """Skinned meshes below the SkelRoots of a stage; bindings are read on first use, and again after `invalidate`."""

    def __init__(self) -> None:
        self._bindings: dict[Sdf.Path, dict[Sdf.Path, _Binding]] = {}  # SkelRoot -> mesh
        self._looked_at: set[Sdf.Path] = set()  # meshes of which faults of joints and blend shapes were named
        self._cache = UsdSkel.Cache()

    def invalidate(self) -> None:
        """Drop all bindings, so that they are read again: schemas, relationships or animations changed."""
        self._bindings.clear()
        self._looked_at.clear()
        self._cache = UsdSkel.Cache()

    def is_affected_by(self, stage: Usd.Stage, changes: Changes) -> bool:
        """Whether changes may affect skinned meshes; then call `invalidate` and skin them again."""
        if self._bindings and any(self._is_within(stage, root) for root in changes.resynced):
            return True
        if not self._bindings:
            return False
        roots = [root for root, meshes in self._bindings.items() if meshes]
        movers = frozenset().union(*(each.movers for meshes in self._bindings.values() for each in meshes.values()))
        edits = changes.changed.items()
        return any(_affects_skinning(stage, path, names, roots, movers) for path, names in edits)

    def _is_within(self, stage: Usd.Stage, resynced: Sdf.Path) -> bool:
        """Whether a subtree contains, or lies below, a SkelRoot or a prim that skinning depends on, or adds one."""
        roots = list(self._bindings)
        parts = [path for meshes in self._bindings.values() for each in meshes.values() for path in each.parts]
        if any(map(resynced.HasPrefix, roots)) or any(path.HasPrefix(resynced) for path in (*roots, *parts)):
            return True
        prim = stage.GetPrimAtPath(resynced)
        below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)) if prim else ()
        return any(each.GetTypeName() in SKEL_TYPES for each in below)

    def is_skinned(self, prim: Usd.Prim) -> bool:
        """Whether a skeleton deforms the prim."""
        return self._binding(prim) is not None

    def skin(
        self,
        prim: Usd.Prim,
        time: Usd.TimeCode,
        *,
        normals: np.ndarray | None = None,
        vertices: np.ndarray | None = None,
    ) -> SkinnedMesh | None:
        """Deform a mesh at `time`; None without a skeleton, or (with a warning) when its bindings are invalid.

        Args:
            normals: (M, 3) to deform with the surface.
            vertices: (M,) index of the point of each normal.
        """
        binding = self._binding(prim)
        if binding is None:
            return None
        rest = UsdGeom.PointBased(prim).GetPointsAttr().Get(time)
        if rest is None or not len(rest):
            return None
        is_new = prim.GetPath() not in self._looked_at
        self._looked_at.add(prim.GetPath())
        if is_new:
            warn_of_channels(binding.skeleton, binding.skeleton_prim, time)
        points = Vt.Vec3fArray(rest)
        skinned = None if normals is None else np.ascontiguousarray(normals, np.float32)
        if binding.mesh.HasBlendShapes() and has_blend_shapes(prim):
            skinned = self._blend(prim, binding, points, skinned, vertices, time)
        if not binding.mesh.HasJointInfluences():
            return SkinnedMesh(np.array(points), skinned)
        if not has_bind_pose(binding.skeleton, binding.skeleton_prim):
            return SkinnedMesh(np.array(points), skinned)
        if is_new:
            known = binding.mesh.GetJointOrder() or binding.skeleton.GetJointOrder()
            warn_of_influences(prim, binding.mesh, len(known), time)
        joints = binding.skeleton.ComputeSkinningTransforms(time)
        if not joints or not binding.mesh.ComputeSkinnedPoints(joints, points, time):
            warn_once(
                f"{prim.GetPath()}: its joints cannot be read, so it is drawn as authored. Correct its skel:joints, "
                f"jointIndices and jointWeights, and the joints and restTransforms of "
                f"{binding.skeleton_prim.GetPath()}."
            )
            return None
        to_mesh = _skeleton_to_mesh(binding.skeleton_prim, prim, time)
        if skinned is not None and vertices is not None:
            skinned = _skin_normals(binding.mesh, joints, skinned, vertices, len(points), time)
        if skinned is not None:
            # Normals transform by the inverse transpose.
            skinned = (skinned.astype(np.float64) @ np.linalg.pinv(to_mesh[:3, :3]).T).astype(np.float32)
        skinned_points = np.array(points, np.float64) @ to_mesh[:3, :3] + to_mesh[3, :3]
        return SkinnedMesh(skinned_points.astype(np.float32), skinned)

    def _binding(self, prim: Usd.Prim) -> _Binding | None:
        root = UsdSkel.Root.Find(prim)
        if not root:
            if prim.HasAttribute("primvars:skel:jointIndices"):
                warn_once(
                    f"{prim.GetPath()}: it has no SkelRoot ancestor, so its joints do not move it and it is drawn as "
                    f"authored. Give the prim that holds mesh and skeleton the type SkelRoot."
                )
            return None
        path = root.GetPath()
        if path not in self._bindings:
            self._bindings[path] = self._read(root)
        found = self._bindings[path].get(prim.GetPath())
        if found is None:
            warn_of_lost_skeleton(prim)
        return found

    def _read(self, root: UsdSkel.Root) -> dict[Sdf.Path, _Binding]:
        predicate = character_predicate(root)
        self._cache.Populate(root, predicate)
        found = {}
        for binding in self._cache.ComputeSkelBindings(root, predicate):
            skeleton = self._cache.GetSkelQuery(binding.GetSkeleton())
            if not skeleton:
                warn_once(
                    f"{binding.GetSkeleton().GetPath()}: the skeleton cannot be read, so what is bound to it is drawn "
                    f"as authored. Correct its joints, bindTransforms and restTransforms."
                )
                continue
            warn_of_animation(skeleton, binding.GetSkeleton().GetPrim(), binding.GetSkinningTargets())
            animation = skeleton.GetAnimQuery()
            prims = [binding.GetSkeleton().GetPrim(), *([animation.GetPrim()] if animation else [])]
            parts = tuple(prim.GetPath() for prim in prims)
            for mesh in binding.GetSkinningTargets():
                if not mesh.GetPrim().IsA(UsdGeom.PointBased):
                    _warn_of_shape(mesh, prims[0])
                    continue
                movers = _movers(root.GetPrim(), prims[0], mesh.GetPrim())
                found[mesh.GetPrim().GetPath()] = _Binding(skeleton, prims[0], mesh, parts, movers)
        return found

    @staticmethod
    def _blend(
        prim: Usd.Prim, binding: _Binding, points: Vt.Vec3fArray, normals, vertices, time: Usd.TimeCode
    ) -> np.ndarray | None:
        """Apply the blend shapes to `points` in place; return the normals with their offsets."""
        animation = binding.skeleton.GetAnimQuery()
        weights = animation.ComputeBlendShapeWeights(time) if animation else None
        if weights is None:
            return normals
        mapper = binding.mesh.GetBlendShapeMapper()
        if not mapper:
            if len(weights):
                warn_once(
                    f"{prim.GetPath()}: its skel:blendShapes is empty, so the shapes of skel:blendShapeTargets have no "
                    "names, and are left out. Name them as the animation does."
                )
            return normals
        own = mapper.Remap(weights, Vt.FloatArray(), 1)
        query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
        active = query.ComputeSubShapeWeights(own)
        where = query.ComputeBlendShapePointIndices()
        authored = Vt.Vec3fArray(points)
        if not query.ComputeDeformedPoints(*active, where, query.ComputeSubShapePointOffsets(), points):
            points[:] = authored  # some were changed before the first invalid shape
            warn_once(
                f"{prim.GetPath()}: its blend shapes do not fit its points and are left out. Give their offsets and "
                f"pointIndices equal lengths, and indices that exist."
            )
            return normals
        if normals is None or vertices is None or not len(active[0]):
            return normals
        offsets = Vt.Vec3fArray.FromNumpy(np.zeros((len(points), 3), np.float32))
        query.ComputeDeformedPoints(*active, where, _normal_offsets(query), offsets)
        return normals + np.array(offsets)[vertices]


def _warn_of_shape(shape: UsdSkel.SkinningQuery, skeleton: Usd.Prim) -> None:
    """Warn of a shape with joints, which is not moved."""
    if shape.HasJointInfluences():
        prim = shape.GetPrim()
        warn_once(
            f"{prim.GetPath()}: joints of {skeleton.GetPath()} do not move a {prim.GetTypeName()}, so it stays where "
            f"it is authored. Convert it to a Mesh."
        )


def _movers(root: Usd.Prim, skeleton: Usd.Prim, mesh: Usd.Prim) -> frozenset[Sdf.Path]:
    """Return the prims whose transforms move a skeleton and its mesh apart; none if both move with their SkelRoot."""
    cache = UsdGeom.XformCache()
    is_inside = skeleton.GetPath().HasPrefix(root.GetPath())
    if is_inside and not any(cache.ComputeRelativeTransform(prim, root)[1] for prim in (skeleton, mesh)):
        return frozenset()
    return frozenset((*skeleton.GetPath().GetPrefixes(), *mesh.GetPath().GetPrefixes()))


def _affects_skinning(
    stage: Usd.Stage, path: Sdf.Path, names: set[str], roots: list[Sdf.Path], movers: frozenset[Sdf.Path]
) -> bool:
    if any(name.startswith(SKEL_PREFIXES) for name in names):
        return True
    # Meshes and skeletons depend on their transforms relative to the root.
    if any(name.startswith("xformOp") for name in names) and (
        path in movers or any(path != root and path.HasPrefix(root) for root in roots)
    ):
        return True
    prim = stage.GetPrimAtPath(path)
    return bool(prim) and prim.GetTypeName() in SKEL_TYPES


def _normal_offsets(query: UsdSkel.BlendShapeQuery) -> list[Vt.Vec3fArray]:
    """Return the normal offsets of all sub-shapes, as `ComputeSubShapePointOffsets`; zeros for shapes without them."""
    offsets = []
    for sub_shape, points in enumerate(query.ComputeSubShapePointOffsets()):
        between = query.GetInbetween(sub_shape)
        shape = query.GetBlendShape(query.GetBlendShapeIndex(sub_shape))
        found = between.GetNormalOffsets() if between else shape.GetNormalOffsetsAttr().Get()
        fits = found is not None and len(found) == len(points)
        offsets.append(found if fits else Vt.Vec3fArray(len(points)))
    return offsets


def _skin_normals(
    mesh: UsdSkel.SkinningQuery, joints, normals: np.ndarray, vertices: np.ndarray, count: int, time: Usd.TimeCode
) -> np.ndarray:
    """Skin normals by the joint influences of their points; in the skeleton's frame."""
    mapper = mesh.GetJointMapper()
    if mapper:
        joints = mapper.RemapTransforms(joints, Vt.Matrix4dArray(), 1)
    influences = mesh.ComputeVaryingJointInfluences(count, time)
    per_point = mesh.GetNumInfluencesPerComponent()
    indices, weights = (np.array(each).reshape(count, per_point)[vertices].ravel() for each in influences)
    skinned = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(normals, np.float32))
    UsdSkel.SkinNormals(
        mesh.GetSkinningMethod(),
        _for_normals(mesh.GetGeomBindTransform(time)),
        Vt.Matrix3dArray([_for_normals(joint) for joint in joints]),
        Vt.IntArray.FromNumpy(indices),
        Vt.FloatArray.FromNumpy(weights),
        per_point,
        skinned,
        True,
    )
    return np.array(skinned)


def _for_normals(matrix: Gf.Matrix4d) -> Gf.Matrix3d:
    return matrix.ExtractRotationMatrix().GetInverse().GetTranspose()


def _skeleton_to_mesh(skeleton: Usd.Prim, mesh: Usd.Prim, time: Usd.TimeCode) -> np.ndarray:
    """Return the matrix (4, 4) from the skeleton's frame to the mesh's; identity if there is no inverse of that one."""
    cache = UsdGeom.XformCache(time)
    root = UsdSkel.Root.Find(mesh).GetPrim()
    try:
        transforms = [cache.GetLocalToWorldTransform(prim) for prim in (skeleton, mesh)]
    except Tf.ErrorException as failure:
        warn_once(
            f"{mesh.GetPath()}: its place in {skeleton.GetPath()} cannot be read: {reason(failure).rstrip('.')}. "
            f"Correct the xformOpOrder and xformOps of both, and of what is above them."
        )
        return np.eye(4)
    if skeleton.GetPath().HasPrefix(root.GetPath()):
        # Relative to the root, so that copies of a character are bit-identical wherever they are.
        relative = [cache.ComputeRelativeTransform(prim, root) for prim in (skeleton, mesh)]
        if not any(resets for _, resets in relative):
            transforms = [matrix for matrix, _ in relative]
    of_skeleton, of_mesh = (np.array(matrix) for matrix in transforms)
    if not np.isfinite(of_mesh).all() or abs(np.linalg.det(of_mesh[:3, :3])) == 0.0:
        return np.eye(4)
    return of_skeleton @ np.linalg.inv(of_mesh)

"""UsdSkel: the points of skinned meshes at a time, by the schema's own rules.

Blend shapes with their in-betweens come first, then the joints: linear blending or dual quaternions, influences of
points or of the whole mesh. Results are in the mesh's own frame, so that its own transform takes them to where the
skeleton puts them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from usdsdg.errors import warn_once
from usdsdg.stage.changes import Changes

# Properties and types of prims that say how meshes are skinned, or where their joints are.
SKEL_PREFIXES = ("skel:", "primvars:skel:")
SKEL_TYPES = ("Skeleton", "SkelAnimation", "BlendShape")


class Skinned(NamedTuple):
    """One mesh as its skeleton shapes it."""

    points: np.ndarray  # (V, 3) float32, the mesh's own frame [stage units]
    normals: np.ndarray | None  # (M, 3) float32, not of unit length; as many as were given


class _Binding(NamedTuple):
    skeleton: UsdSkel.SkeletonQuery
    skeleton_prim: Usd.Prim  # of an instance where the query knows its prototype only
    mesh: UsdSkel.SkinningQuery
    parts: tuple[Sdf.Path, ...]  # what it depends on outside of the mesh


class Skinning:
    """What is skinned below the SkelRoots of a stage. It reads them when first asked, and again after `forget`."""

    def __init__(self) -> None:
        self._bindings: dict[Sdf.Path, dict[Sdf.Path, _Binding]] = {}  # SkelRoot -> mesh
        self._cache = UsdSkel.Cache()

    def forget(self) -> None:
        """Read everything again: schemas, relationships or animations changed."""
        self._bindings.clear()
        self._cache = UsdSkel.Cache()

    def concerns(self, stage: Usd.Stage, changes: Changes) -> bool:
        """Whether what changed may move what is skinned; then `forget` and ask again."""
        if self._bindings and any(self._is_within(stage, root) for root in changes.resynced):
            return True
        roots = [root for root, meshes in self._bindings.items() if meshes]
        return bool(roots) and any(_concerns(stage, path, names, roots) for path, names in changes.changed.items())

    def _is_within(self, stage: Usd.Stage, resynced: Sdf.Path) -> bool:
        """Whether a subtree is part of what skins, has such a part, or brings one that was missing."""
        roots = list(self._bindings)
        parts = [path for meshes in self._bindings.values() for each in meshes.values() for path in each.parts]
        if any(map(resynced.HasPrefix, roots)) or any(path.HasPrefix(resynced) for path in (*roots, *parts)):
            return True
        prim = stage.GetPrimAtPath(resynced)
        below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)) if prim else ()
        return any(each.GetTypeName() in SKEL_TYPES for each in below)

    def is_skinned(self, prim: Usd.Prim) -> bool:
        """Whether a skeleton shapes the prim."""
        return self._binding(prim) is not None

    def skin(
        self,
        prim: Usd.Prim,
        time: Usd.TimeCode,
        *,
        normals: np.ndarray | None = None,
        vertices: np.ndarray | None = None,
    ) -> Skinned | None:
        """The mesh at `time`; None when no skeleton shapes it, or (with a warning) when its bindings are broken.

        Args:
            normals: (M, 3) to turn along with the surface.
            vertices: (M,) the point that each normal stands at.
        """
        binding = self._binding(prim)
        if binding is None:
            return None
        rest = UsdGeom.PointBased(prim).GetPointsAttr().Get(time)
        if rest is None or not len(rest):
            return None
        points = Vt.Vec3fArray(rest)
        turned = None if normals is None else np.ascontiguousarray(normals, np.float32)
        if binding.mesh.HasBlendShapes():
            turned = self._blend(prim, binding, points, turned, vertices, time)
        if not binding.mesh.HasJointInfluences():
            return Skinned(np.array(points), turned)
        joints = binding.skeleton.ComputeSkinningTransforms(time)
        if not joints or not binding.mesh.ComputeSkinnedPoints(joints, points, time):
            warn_once(
                f"{prim.GetPath()}: its joints cannot be read, so it is drawn as authored. Correct its skel:joints, "
                f"jointIndices and jointWeights, and the joints of {binding.skeleton_prim.GetPath()}."
            )
            return None
        to_mesh = _skeleton_to_mesh(binding.skeleton_prim, prim, time)
        if turned is not None and vertices is not None:
            turned = _skin_normals(binding.mesh, joints, turned, vertices, len(points), time)
        if turned is not None:
            # Normals go by the inverse transpose.
            turned = (turned.astype(np.float64) @ np.linalg.pinv(to_mesh[:3, :3]).T).astype(np.float32)
        placed = np.array(points, np.float64) @ to_mesh[:3, :3] + to_mesh[3, :3]
        return Skinned(placed.astype(np.float32), turned)

    def _binding(self, prim: Usd.Prim) -> _Binding | None:
        root = UsdSkel.Root.Find(prim)
        if not root:
            if prim.HasAttribute("primvars:skel:jointIndices"):
                warn_once(
                    f"{prim.GetPath()}: no SkelRoot stands above it, so its joints do not move it and it is drawn as "
                    f"authored. Give the prim that holds mesh and skeleton the type SkelRoot."
                )
            return None
        path = root.GetPath()
        if path not in self._bindings:
            self._bindings[path] = self._read(root)
        return self._bindings[path].get(prim.GetPath())

    def _read(self, root: UsdSkel.Root) -> dict[Sdf.Path, _Binding]:
        through_instances = Usd.TraverseInstanceProxies()
        self._cache.Populate(root, through_instances)
        found = {}
        for binding in self._cache.ComputeSkelBindings(root, through_instances):
            skeleton = self._cache.GetSkelQuery(binding.GetSkeleton())
            if not skeleton:
                warn_once(
                    f"{binding.GetSkeleton().GetPath()}: the skeleton cannot be read, so what is bound to it is drawn "
                    f"as authored. Correct its joints, bindTransforms and restTransforms."
                )
                continue
            animation = skeleton.GetAnimQuery()
            prims = [binding.GetSkeleton().GetPrim(), *([animation.GetPrim()] if animation else [])]
            parts = tuple(prim.GetPath() for prim in prims)
            for mesh in binding.GetSkinningTargets():
                found[mesh.GetPrim().GetPath()] = _Binding(skeleton, prims[0], mesh, parts)
        return found

    @staticmethod
    def _blend(
        prim: Usd.Prim, binding: _Binding, points: Vt.Vec3fArray, normals, vertices, time: Usd.TimeCode
    ) -> np.ndarray | None:
        """Add the blend shapes to `points` in place; returns the normals with theirs."""
        animation = binding.skeleton.GetAnimQuery()
        weights = animation.ComputeBlendShapeWeights(time) if animation else None
        if weights is None:
            return normals
        mapper = binding.mesh.GetBlendShapeMapper()
        own = mapper.Remap(weights, Vt.FloatArray(), 1) if mapper else weights
        query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
        active = query.ComputeSubShapeWeights(own)
        where = query.ComputeBlendShapePointIndices()
        authored = Vt.Vec3fArray(points)
        if not query.ComputeDeformedPoints(*active, where, query.ComputeSubShapePointOffsets(), points):
            points[:] = authored  # some may have moved before the first that does not fit
            warn_once(
                f"{prim.GetPath()}: its blend shapes do not fit its points and are left out. Give their offsets and "
                f"pointIndices equal lengths, and indices that exist."
            )
            return normals
        if normals is None or vertices is None or not len(active[0]):
            return normals
        bent = Vt.Vec3fArray.FromNumpy(np.zeros((len(points), 3), np.float32))
        query.ComputeDeformedPoints(*active, where, _normal_offsets(query), bent)
        return normals + np.array(bent)[vertices]


def _concerns(stage: Usd.Stage, path: Sdf.Path, names: set[str], roots: list[Sdf.Path]) -> bool:
    if any(name.startswith(SKEL_PREFIXES) for name in names):
        return True
    # Meshes and skeletons count by where they stand below their root.
    if any(name.startswith("xformOp") for name in names) and any(
        path != root and path.HasPrefix(root) for root in roots
    ):
        return True
    prim = stage.GetPrimAtPath(path)
    return bool(prim) and prim.GetTypeName() in SKEL_TYPES


def _normal_offsets(query: UsdSkel.BlendShapeQuery) -> list[Vt.Vec3fArray]:
    """As `ComputeSubShapePointOffsets`, of normals; zeros where a shape says nothing of them."""
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
    """Normals turned by the joints of the point that each stands at; in the skeleton's frame."""
    mapper = mesh.GetJointMapper()
    if mapper:
        joints = mapper.RemapTransforms(joints, Vt.Matrix4dArray(), 1)
    influences = mesh.ComputeVaryingJointInfluences(count, time)
    per_point = mesh.GetNumInfluencesPerComponent()
    indices, weights = (np.array(each).reshape(count, per_point)[vertices].ravel() for each in influences)
    turned = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(normals, np.float32))
    UsdSkel.SkinNormals(
        mesh.GetSkinningMethod(),
        _for_normals(mesh.GetGeomBindTransform(time)),
        Vt.Matrix3dArray([_for_normals(joint) for joint in joints]),
        Vt.IntArray.FromNumpy(indices),
        Vt.FloatArray.FromNumpy(weights),
        per_point,
        turned,
        True,
    )
    return np.array(turned)


def _for_normals(matrix: Gf.Matrix4d) -> Gf.Matrix3d:
    return matrix.ExtractRotationMatrix().GetInverse().GetTranspose()


def _skeleton_to_mesh(skeleton: Usd.Prim, mesh: Usd.Prim, time: Usd.TimeCode) -> np.ndarray:
    """(4, 4) from the skeleton's frame to the mesh's; the identity where the mesh's own cannot be inverted."""
    cache = UsdGeom.XformCache(time)
    root = UsdSkel.Root.Find(mesh).GetPrim()
    placed = [cache.GetLocalToWorldTransform(prim) for prim in (skeleton, mesh)]
    if skeleton.GetPath().HasPrefix(root.GetPath()):
        # By the root, so that copies of a character are the same bit for bit wherever they stand.
        relative = [cache.ComputeRelativeTransform(prim, root) for prim in (skeleton, mesh)]
        if not any(resets for _, resets in relative):
            placed = [matrix for matrix, _ in relative]
    of_skeleton, of_mesh = (np.array(matrix) for matrix in placed)
    if not np.isfinite(of_mesh).all() or abs(np.linalg.det(of_mesh[:3, :3])) == 0.0:
        return np.eye(4)
    return of_skeleton @ np.linalg.inv(of_mesh)

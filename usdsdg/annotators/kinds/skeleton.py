"""Joints of UsdSkel characters: rest and current poses, in the world and in the image."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.point_instances import PointFrames, find_steps
from usdsdg.annotators.prims.skeleton_prims import SkeletonPrim, SkeletonPrims
from usdsdg.errors import warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry.skinning import character_predicate

OUT_OF_VIEW = "OUT_OF_VIEW"
_NOTHING = "None"  # Replicator's text for missing values


@dataclass(frozen=True)
class Skeleton:
    """The J joints of one skeleton at one time; (4, 4) matrices are for row vectors."""

    prim: Usd.Prim
    path: str  # as annotators report it
    is_of: Callable[[int], bool]  # whether a gprim, by its index, is of the character
    joints: tuple[str, ...]
    parents: np.ndarray  # (J,) int32, -1 for roots
    rest_local: np.ndarray  # (J, 4, 4)
    rest_world: np.ndarray
    local: np.ndarray
    world: np.ndarray


# Name in the payload, key of the older form, number type, shape of one row.
_ARRAYS: Sequence[tuple[str, str, Any, tuple[int, ...]]] = (
    ("skeletonParents", "skeleton_parents", np.int32, ()),
    ("restGlobalTranslations", "rest_global_translations", np.float32, (3,)),
    ("restLocalTranslations", "rest_local_translations", np.float32, (3,)),
    ("restLocalRotations", "rest_local_rotations", np.float32, (4,)),
    ("globalTranslations", "global_translations", np.float32, (3,)),
    ("localRotations", "local_rotations", np.float32, (4,)),
    ("translations2d", "translations_2d", np.float32, (2,)),
    ("jointOcclusions", "joint_occlusions", bool, ()),
)


def _info(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the payload of skeletons in the older form."""
    info: dict[str, Any] = {
        "numSkeletons": len(records),
        "skelName": [each["skel_name"] for each in records],
        "skelPath": [each["skel_path"] for each in records],
        "assetPath": [each["asset_path"] or _NOTHING for each in records],
        "animationVariant": [each["animation_variant"] or _NOTHING for each in records],
        "skeletonJoints": [str(each["skeleton_joints"]) for each in records],
        "occlusionTypes": [str(each["occlusion_types"]) for each in records],
        "inView": np.array([each["in_view"] for each in records], bool),
        "skeletonData": json.dumps(records),
    }
    for name, key, dtype, shape in _ARRAYS:
        info[name] = np.array([row for each in records for row in each[key]], dtype).reshape(-1, *shape)
        info[f"{name}Sizes"] = np.array([len(each[key]) for each in records], np.int32)
    info["occlusionTypesSizes"] = info["jointOcclusionsSizes"]
    return dict(sorted(info.items()))


@define("skeleton_data", aovs=["instance"], params={"useSkelJoints": False}, info=_info([]))
def skeleton_data(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Joints of every visible skeleton on the stage, concatenated in flat arrays.

    Joints follow the UsdSkel animation. A character in the prototype of a point instancer has one skeleton for each
    instance of which anything is drawn, `path[id]`. N joints in all, S skeletons:

    - numSkeletons; skelName, skelPath, assetPath, animationVariant: lists of S texts ("None" where there is none).
    - skeletonParents (N) int32: index among the skeleton's own joints, -1 for roots.
    - restGlobalTranslations, globalTranslations (N, 3) float32 in the world, restLocalTranslations (N, 3) float32 in
      the parent joint [stage units]; restLocalRotations, localRotations (N, 4) float32, (w, x, y, z).
    - translations2d (N, 2) float32: column and row in pixels, nan behind the camera.
    - jointOcclusions (N) bool: the pixel of the joint shows something other than the character.
    - `...Sizes` (S) int32 beside each of these and beside occlusionTypes: joints per skeleton.
    - skeletonJoints, occlusionTypes: S texts, each a printed list with one entry per joint: its path; the label of its
      occluder (or "BACKGROUND", "UNLABELLED", "OUT_OF_VIEW", "None").
    - inView (S) bool: all joints are inside the image.
    - skeletonData: the same as JSON, in Replicator's older form.

    useSkelJoints: ignored with a warning; joints come from the animation.
    """
    if params["useSkelJoints"]:
        warn_once("skeleton_data: useSkelJoints is ignored; joints are those of the UsdSkel animation.")
    stage = current_stage()
    find = frame.labeled_prims.find_skeletons
    found = find() if find else SkeletonPrims(stage).find(frame.gprims, find_steps(stage, frame.gprims))
    records = [_legacy_record(frame, skeleton) for skeleton in skeletons(stage, found, frame.queries.time)]
    return Annotation(None, _info(records))


def skeletons(stage: Usd.Stage, prims: Iterable[SkeletonPrim], code: Usd.TimeCode) -> Iterator[Skeleton]:
    """Yield those of the skeletons that are visible and have joints."""
    cache, frames = UsdSkel.Cache(), PointFrames(stage, UsdGeom.XformCache(code))
    for each in prims:
        prim, character = (stage.GetPrimAtPath(owner.path) for owner in (each.skeleton, each.character))
        if not each.skeleton.steps and UsdGeom.Imageable(prim).ComputeVisibility(code) == "invisible":
            continue
        if character != prim:
            root = UsdSkel.Root(character)
            cache.Populate(root, character_predicate(root))
        query = cache.GetSkelQuery(UsdSkel.Skeleton(prim))
        if not query or not len(query.GetJointOrder()):
            continue
        joints = tuple(str(joint) for joint in query.GetJointOrder())
        parents = np.array(query.GetTopology().GetParentIndices(), np.int32)
        to_world = frames.to_world(each.skeleton.path, each.skeleton.steps)
        rest = _matrices(query.ComputeJointLocalTransforms(code, True), len(joints))
        animated = _matrices(query.ComputeJointLocalTransforms(code), len(joints))
        yield Skeleton(
            prim, each.skeleton.name, each.is_of, joints, parents,
            rest, _joints_to_world(rest, parents, to_world),
            animated, _joints_to_world(animated, parents, to_world),
        )  # fmt: skip


def _matrices(transforms: Any, count: int) -> np.ndarray:
    found = np.array(transforms, np.float64) if transforms else np.zeros(0)
    return found.reshape(-1, 4, 4) if found.size == count * 16 else np.broadcast_to(np.eye(4), (count, 4, 4))


def _joints_to_world(local: np.ndarray, parents: np.ndarray, to_world: np.ndarray) -> np.ndarray:
    """Return (J, 4, 4) joint to world. Parents precede their children, as UsdSkel requires."""
    world = np.empty_like(local)
    for joint, parent in enumerate(parents):
        world[joint] = local[joint] @ (world[parent] if parent >= 0 else to_world)
    return world


def _legacy_record(frame: Frame, skeleton: Skeleton) -> dict[str, Any]:
    """Return one skeleton as a dict of Replicator's older form."""
    points = skeleton.world[:, 3, :3]
    pixels, _ = frame.camera.project(points)
    size = (frame.camera.width, frame.camera.height)
    with np.errstate(invalid="ignore"):
        inside = np.all((pixels >= 0) & (pixels < size), axis=1)
    occluders = [_occluder(frame, skeleton, pixel) if shown else OUT_OF_VIEW for pixel, shown in zip(pixels, inside)]
    return {
        "skel_name": skeleton.prim.GetName(),
        "skel_path": skeleton.path,
        "asset_path": _asset_of(skeleton.prim),
        "animation_variant": _variant_of(skeleton.prim),
        "skeleton_parents": skeleton.parents.tolist(),
        "rest_global_translations": skeleton.rest_world[:, 3, :3].tolist(),
        "rest_local_translations": skeleton.rest_local[:, 3, :3].tolist(),
        "rest_local_rotations": [_quaternion(matrix) for matrix in skeleton.rest_local],
        "global_translations": points.tolist(),
        "local_rotations": [_quaternion(matrix) for matrix in skeleton.local],
        # JSON has no nan.
        "translations_2d": [pixel.tolist() if np.isfinite(pixel).all() else [None, None] for pixel in pixels],
        "skeleton_joints": list(skeleton.joints),
        "joint_occlusions": [occluder != _NOTHING for occluder in occluders],
        "occlusion_types": occluders,
        "in_view": bool(inside.all()),
    }


def _occluder(frame: Frame, skeleton: Skeleton, pixel: np.ndarray) -> str:
    """Return the label of what occludes a joint at `pixel`, or "None" where the character itself is visible."""
    gprim = int(frame.aov("instance")[int(pixel[1]), int(pixel[0])])
    if gprim < 0:
        return "BACKGROUND"
    if skeleton.is_of(gprim):
        return _NOTHING
    selection = frame.selection(None)
    member = selection.member_of_gprim[gprim]
    return ",".join(selection.labels[member].values()) if member >= 0 else "UNLABELLED"


def _quaternion(matrix: np.ndarray) -> list[float]:
    rotation = Gf.Matrix4d(matrix.tolist()).RemoveScaleShear().ExtractRotationQuat()
    return [rotation.GetReal(), *rotation.GetImaginary()]


def _asset_of(prim: Usd.Prim) -> str | None:
    """Return the path of the referenced asset that the skeleton comes from."""
    while prim and not prim.IsPseudoRoot():
        for spec in prim.GetPrimStack():
            for reference in spec.referenceList.GetAddedOrExplicitItems():
                if reference.assetPath:
                    return reference.assetPath
        prim = prim.GetParent()
    return None


def _variant_of(prim: Usd.Prim) -> str | None:
    """Return the selection of the variant set "animationVariant" of the skeleton or its nearest ancestor with one."""
    while prim and not prim.IsPseudoRoot():
        if "animationVariant" in prim.GetVariantSets().GetNames():
            return prim.GetVariantSet("animationVariant").GetVariantSelection() or None
        prim = prim.GetParent()
    return None

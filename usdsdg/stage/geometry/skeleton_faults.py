"""Faults of skeletons, of their animations and of blend shapes, which UsdSkel leaves out or draws otherwise."""

from __future__ import annotations

from collections.abc import Sequence, Sized

from pxr import Usd, UsdSkel

from usdsdg.errors import counted, warn_once

_CHANNELS = ("translations", "rotations", "scales")


def has_bind_pose(skeleton: UsdSkel.SkeletonQuery, prim: Usd.Prim) -> bool:
    """Return whether every joint has a transform to which meshes are bound; warn if not.

    prim: the skeleton, inside an instance its instance proxy.
    """
    joints = len(skeleton.GetJointOrder())
    transforms = _length(UsdSkel.Skeleton(prim).GetBindTransformsAttr(), Usd.TimeCode.Default())
    if joints != transforms:
        warn_once(
            f"{prim.GetPath()}: it has {counted(joints, 'joint')} and {counted(transforms, 'bindTransform')}, so its "
            f"joints deform nothing. Author one of bindTransforms for each joint."
        )
    return joints == transforms


def warn_of_animation(skeleton: UsdSkel.SkeletonQuery, prim: Usd.Prim, meshes: Sequence[UsdSkel.SkinningQuery]) -> None:
    """Warn of joints that a skeleton lacks, and of an animation that is none, or of other joints or blend shapes.

    prim: the skeleton, inside an instance its instance proxy.
    meshes: what is bound to it.
    """
    known = set(skeleton.GetJointOrder())
    for mesh in meshes:
        if lost := [name for name in mesh.GetJointOrder() or () if name not in known]:
            warn_once(
                f"{mesh.GetPrim().GetPath()}: {lost[0]!r} of its skel:joints is no joint of {prim.GetPath()}, so it "
                f"does not move. Correct skel:joints."
            )
    animation = skeleton.GetAnimQuery()
    if not animation:
        _warn_of_lost_animation(prim)
        return
    path, joints, shapes = (
        animation_of(skeleton, prim).GetPath(),
        animation.GetJointOrder(),
        animation.GetBlendShapeOrder(),
    )
    if joints and known and known.isdisjoint(joints):
        warn_once(
            f"{path}: none of its joints, such as {joints[0]!r}, is one of {prim.GetPath()}, such as "
            f"{skeleton.GetJointOrder()[0]!r}, which keeps its rest pose. Give both the same names."
        )
    own = {name for mesh in meshes for name in mesh.GetBlendShapeOrder() or ()}
    if shapes and own and own.isdisjoint(shapes):
        warn_once(
            f"{path}: none of its blendShapes, such as {shapes[0]!r}, is one of what is bound to {prim.GetPath()}, "
            f"such as {min(own)!r}, so no blend shape counts. Give both the same names."
        )


def animation_of(skeleton: UsdSkel.SkeletonQuery, prim: Usd.Prim) -> Usd.Prim:
    """Return the animation of a skeleton, inside an instance its instance proxy."""
    return UsdSkel.BindingAPI(prim).GetInheritedAnimationSource() or skeleton.GetAnimQuery().GetPrim()


def _warn_of_lost_animation(skeleton: Usd.Prim) -> None:
    """Warn where the `skel:animationSource` that a skeleton has, or inherits, gives no animation."""
    above: Usd.Prim | None = skeleton
    while above and not above.IsPseudoRoot():
        source = above.GetRelationship("skel:animationSource")
        if source and source.HasAuthoredTargets():
            if targets := source.GetForwardedTargets():
                found = above.GetStage().GetPrimAtPath(targets[0])
                what = f"{targets[0]} is no active SkelAnimation" if not found else f"{targets[0]} does not count"
                warn_once(
                    f"{above.GetPath()}: its skel:animationSource {what}, so {skeleton.GetPath()} keeps its rest pose. "
                    f"{_remedy(above)}."
                )
            return
        above = above.GetParent()


def warn_of_channels(skeleton: UsdSkel.SkeletonQuery, prim: Usd.Prim, time: Usd.TimeCode) -> None:
    """Warn of an animation that has not one translation, rotation and scale for each of its joints."""
    animation = skeleton.GetAnimQuery()
    if not animation:
        return
    prim, joints = animation_of(skeleton, prim), len(animation.GetJointOrder())
    # At the default time, what has samples alone has no value, which is no fault of it.
    time = Usd.TimeCode.EarliestTime() if time.IsDefault() else time
    lengths = [_length(prim.GetAttribute(name), time) for name in _CHANNELS]
    if joints and set(lengths) != {joints}:
        found = ", ".join(f"{length} {name}" for name, length in zip(_CHANNELS, lengths))
        warn_once(
            f"{prim.GetPath()}: it has {counted(joints, 'joint')}, but {found}, so it moves none. Author one of all "
            f"three for each joint.",
            key=f"{prim.GetPath()}: channels of joints",
        )
    shapes, weights = len(animation.GetBlendShapeOrder()), _length(prim.GetAttribute("blendShapeWeights"), time)
    if weights != shapes:
        warn_once(
            f"{prim.GetPath()}: it has {counted(shapes, 'name', 'names')} in blendShapes and {weights} "
            f"blendShapeWeights; shapes without a weight have 0. Author one for each name.",
            key=f"{prim.GetPath()}: weights of blend shapes",
        )


def _length(attribute: Usd.Attribute, time: Usd.TimeCode) -> int:
    """Return how many values an array has; 0 for what is none."""
    value = attribute.Get(time) if attribute else None
    return len(value) if isinstance(value, Sized) else 0


def has_blend_shapes(mesh: Usd.Prim) -> bool:
    """Return whether each blend shape that a mesh names exists; warn if not, except of shapes without any names."""
    names = _length(mesh.GetAttribute("skel:blendShapes"), Usd.TimeCode.Default())
    targets = mesh.GetRelationship("skel:blendShapeTargets").GetForwardedTargets()
    stage = mesh.GetStage()
    if lost := [path for path in targets if not UsdSkel.BlendShape(stage.GetPrimAtPath(path))]:
        warn_once(
            f"{mesh.GetPath()}: its skel:blendShapeTargets {lost[0]} is no BlendShape, so its blend shapes are left "
            f"out. Correct the relationship."
        )
    elif names and names != len(targets):
        warn_once(
            f"{mesh.GetPath()}: it has {counted(names, 'name', 'names')} in skel:blendShapes and "
            f"{counted(len(targets), 'target')} in skel:blendShapeTargets, so its blend shapes are left out. Author "
            f"one name for each target."
        )
    return not lost and names in (0, len(targets))


def warn_of_lost_skeleton(mesh: Usd.Prim) -> None:
    """Warn of a mesh below a SkelRoot that has joints, and no skeleton."""
    indices = mesh.GetAttribute("primvars:skel:jointIndices")
    if not indices or not indices.HasAuthoredValue() or UsdSkel.BindingAPI(mesh).GetInheritedSkeleton():
        return
    warn_once(
        f"{mesh.GetPath()}: it has joints and no skeleton, so it is drawn as authored: its skel:skeleton, or that of a "
        f"prim above, does not count. {_remedy(mesh)}."
    )


def _remedy(prim: Usd.Prim) -> str:
    if not prim.HasAPI(UsdSkel.BindingAPI):
        return f"Apply SkelBindingAPI to {prim.GetPath()}"
    return "Correct the relationship, or activate its target"

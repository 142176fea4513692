"""A small UsdSkel character: a tube along z on two joints, the upper of which bends over 24 time codes."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

RINGS, SIDES, LENGTH = 9, 8, 2.0


def add_character(
    stage: Usd.Stage, path: str = "/Character", *, method: str = "classicLinear", joints: tuple[str, ...] | None = None
) -> UsdGeom.Mesh:
    """Define a character, return its mesh; `joints` is the mesh's joint order, `method` its `skel:skinningMethod`."""
    root = UsdSkel.Root.Define(stage, path)
    add_skeleton(stage, path)
    mesh = UsdGeom.Mesh.Define(stage, f"{path}/Body")
    angle = np.arange(SIDES) * 2 * np.pi / SIDES
    height = np.repeat(np.linspace(0, LENGTH, RINGS), SIDES)
    points = np.column_stack([np.tile(np.cos(angle), RINGS) * 0.3, np.tile(np.sin(angle), RINGS) * 0.3, height])
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    faces = [
        (r * SIDES + s, r * SIDES + (s + 1) % SIDES, (r + 1) * SIDES + (s + 1) % SIDES, (r + 1) * SIDES + s)
        for r in range(RINGS - 1)
        for s in range(SIDES)
    ]
    mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr([int(k) for face in faces for k in face])
    mesh.CreateSubdivisionSchemeAttr("none")
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([Sdf.Path(f"{path}/Skeleton")])
    binding.CreateSkinningMethodAttr(method)
    upper = np.clip(height / LENGTH * 2 - 0.5, 0, 1)
    order = [0, 1]
    if joints:
        binding.CreateJointsAttr(list(joints))
        order = [joints.index("hip"), joints.index("hip/knee")]
    binding.CreateJointIndicesPrimvar(False, 2).Set(np.tile(order, len(points)).tolist())
    binding.CreateJointWeightsPrimvar(False, 2).Set(np.column_stack([1 - upper, upper]).ravel().tolist())
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(24)
    assert root
    return mesh


def add_skeleton(stage: Usd.Stage, path: str) -> UsdSkel.Skeleton:
    """Define a hip at the origin and a knee at half height; the knee rotates to 90° about x, the hip sinks by 0.5."""
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/Skeleton")
    knee = Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(0, 0, LENGTH / 2))
    skeleton.CreateJointsAttr(["hip", "hip/knee"])
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1.0), knee])
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1.0), knee])
    animation = UsdSkel.Animation.Define(stage, f"{path}/Bend")
    animation.CreateJointsAttr(["hip", "hip/knee"])
    animation.CreateScalesAttr([Gf.Vec3h(1)] * 2)
    translations, rotations = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
    for code in (0, 12, 24):
        translations.Set([Gf.Vec3f(0, 0, -0.5 * code / 24), Gf.Vec3f(0, 0, LENGTH / 2)], code)
        turn = Gf.Rotation(Gf.Vec3d(1, 0, 0), 90 * code / 24).GetQuat()
        rotations.Set([Gf.Quatf(1), Gf.Quatf(turn)], code)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    return skeleton


def add_blend_shape(stage: Usd.Stage, mesh: UsdGeom.Mesh, *, between: bool = True) -> None:
    """Add a blend shape, weight 1 at code 24, that moves the last ring up by 1; an in-between at 0.5, by 0.2."""
    path = mesh.GetPath().AppendChild("Longer")
    shape = UsdSkel.BlendShape.Define(stage, path)
    last = list(range((RINGS - 1) * SIDES, RINGS * SIDES))
    shape.CreatePointIndicesAttr(last)
    shape.CreateOffsetsAttr([Gf.Vec3f(0, 0, 1)] * SIDES)
    shape.CreateNormalOffsetsAttr([Gf.Vec3f(0, 0, 0.5)] * SIDES)
    if between:
        half = shape.CreateInbetween("half")
        half.SetWeight(0.5)
        half.SetOffsets([Gf.Vec3f(0, 0, 0.2)] * SIDES)
    binding = UsdSkel.BindingAPI(mesh.GetPrim())
    binding.CreateBlendShapesAttr(["longer"])
    binding.CreateBlendShapeTargetsRel().SetTargets([path])
    animation = UsdSkel.Animation(stage.GetPrimAtPath(mesh.GetPath().GetParentPath().AppendChild("Bend")))
    animation.CreateBlendShapesAttr(["other", "longer"])
    weights = animation.CreateBlendShapeWeightsAttr()
    weights.Set([0.7, 0.0], 0)
    weights.Set([0.7, 1.0], 24)

"""Walls around the space above a prim, which keep dropped assets there."""

from __future__ import annotations

from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.compat.isaacsim.replicator.behavior.utils.rigid_bodies import add_colliders
from usdsdg.compat.isaacsim.replicator.prim_poses import set_transform_attributes
from usdsdg.stage.paths import next_free_path


def scaled_box(bound: Gf.BBox3d) -> tuple[Gf.Vec3d, Gf.Vec3d]:
    """Return center and size of a bound's box in its own rotated frame, with the scale of its matrix applied."""
    scale = Gf.Transform(bound.GetMatrix()).GetScale()
    box = bound.GetRange()
    return Gf.CompMult(box.GetMidpoint(), scale), Gf.CompMult(box.GetSize(), scale)


def create_collision_walls(
    stage: Usd.Stage,
    prim: Usd.Prim,
    prim_path: str,
    height: float,
    thickness: float = 0.4,
    physics_scene: UsdPhysics.Scene | None = None,
    physics_material: UsdShade.Material | None = None,
    bbox_cache: UsdGeom.BBoxCache | None = None,
    visible: bool = False,
) -> list[Usd.Prim]:
    """Close the space of `height` above the top of a prim's box with six cubes of `thickness`, outside of it.

    Returns:
        floor, ceiling, left_wall (-x), right_wall, front_wall (+y) and back_wall, under `prim_path`/CollisionWalls,
        which has the prim's position and rotation.
    """
    cache = bbox_cache or UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    bound = cache.ComputeWorldBound(prim)
    middle, (width, depth, tall) = scaled_box(bound)
    x, y, top = middle[0], middle[1], middle[2] + tall / 2.0
    half = thickness / 2.0
    walls = {
        "floor": ((x, y, top - half), (width, depth, thickness)),
        "ceiling": ((x, y, top + height + half), (width, depth, thickness)),
        "left_wall": ((x - width / 2.0 - half, y, top + height / 2.0), (thickness, depth, height)),
        "right_wall": ((x + width / 2.0 + half, y, top + height / 2.0), (thickness, depth, height)),
        "front_wall": ((x, y + depth / 2.0 + half, top + height / 2.0), (width, thickness, height)),
        "back_wall": ((x, y - depth / 2.0 - half, top + height / 2.0), (width, thickness, height)),
    }
    root = stage.DefinePrim(next_free_path(stage, f"{prim_path}/CollisionWalls", False), "Xform")
    UsdGeom.Xformable(root).AddTransformOp().Set(bound.GetMatrix().RemoveScaleShear())
    return [
        _wall(root, name, Gf.Vec3d(*center), Gf.Vec3d(*size), physics_scene, physics_material, visible)
        for name, (center, size) in walls.items()
    ]


def _wall(
    root: Usd.Prim,
    name: str,
    center: Gf.Vec3d,
    size: Gf.Vec3d,
    physics_scene: UsdPhysics.Scene | None,
    physics_material: UsdShade.Material | None,
    visible: bool,
) -> Usd.Prim:
    wall = root.GetStage().DefinePrim(root.GetPath().AppendChild(name), "Cube")
    set_transform_attributes(wall, location=center, scale=Gf.Vec3f(size / 2.0))  # a Cube's edge is 2
    add_colliders(wall, physics_scene=physics_scene)
    if not visible:
        UsdGeom.Imageable(wall).MakeInvisible()
    if physics_material is not None:
        binding = UsdShade.MaterialBindingAPI.Apply(wall)
        binding.Bind(physics_material, UsdShade.Tokens.weakerThanDescendants, "physics")
    return wall

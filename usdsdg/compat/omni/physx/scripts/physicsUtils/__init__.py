"""`omni.physx.scripts.physicsUtils`: shapes, grounds, joints and settings of physics on a stage."""

from usdsdg.compat.omni.physx.scripts.physicsUtils.grounds import (
    add_cube_ground_plane,
    add_ground_plane,
    add_quad_plane,
    create_mesh,
    create_mesh_cube,
    create_mesh_square_axis,
)
from usdsdg.compat.omni.physx.scripts.physicsUtils.settings import (
    add_collision_to_collision_group,
    add_density,
    add_force_torque,
    add_joint_fixed,
    add_mass,
    add_physics_material_to_prim,
    is_in_collision_group,
    remove_collision_from_collision_group,
)
from usdsdg.compat.omni.physx.scripts.physicsUtils.shapes import (
    add_box,
    add_capsule,
    add_collider_box,
    add_collider_capsule,
    add_collider_cone,
    add_collider_cube,
    add_collider_cylinder,
    add_collider_sphere,
    add_cone,
    add_cube,
    add_cylinder,
    add_rigid_box,
    add_rigid_capsule,
    add_rigid_cone,
    add_rigid_cube,
    add_rigid_cylinder,
    add_rigid_sphere,
    add_rigid_xform,
    add_sphere,
    add_xform,
    get_stage_next_free_path,
)
from usdsdg.compat.omni.physx.scripts.physicsUtils.xform_ops import (
    copy_transform_as_scale_orient_translate,
    get_translation,
    set_or_add_orient_op,
    set_or_add_scale_op,
    set_or_add_scale_orient_translate,
    set_or_add_translate_op,
    setup_transform_as_scale_orient_translate,
)

__all__ = [
    "add_box", "add_capsule", "add_collider_box", "add_collider_capsule", "add_collider_cone", "add_collider_cube",
    "add_collider_cylinder", "add_collider_sphere", "add_collision_to_collision_group", "add_cone", "add_cube",
    "add_cube_ground_plane", "add_cylinder", "add_density", "add_force_torque", "add_ground_plane", "add_joint_fixed",
    "add_mass", "add_physics_material_to_prim", "add_quad_plane", "add_rigid_box", "add_rigid_capsule",
    "add_rigid_cone", "add_rigid_cube", "add_rigid_cylinder", "add_rigid_sphere", "add_rigid_xform", "add_sphere",
    "add_xform", "copy_transform_as_scale_orient_translate", "create_mesh", "create_mesh_cube",
    "create_mesh_square_axis", "get_stage_next_free_path", "get_translation", "is_in_collision_group",
    "remove_collision_from_collision_group", "set_or_add_orient_op", "set_or_add_scale_op",
    "set_or_add_scale_orient_translate", "set_or_add_translate_op", "setup_transform_as_scale_orient_translate",
]  # fmt: skip

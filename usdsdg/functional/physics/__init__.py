"""Author UsdPhysics and PhysX schemas at once, and simulate without a timeline.

Mirrors `rep.functional.physics`. `prims` is one prim, a path, or a list of these.
"""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.functional.physics.bodies import (
    DEFAULTS_RIGID_BODY,
    VALID_COLLIDER_APPROXIMATIONS,
    apply_collider,
    apply_rigid_body,
    modify_attribute,
    remove_collider,
    remove_rigid_body,
)
from usdsdg.functional.physics.camera_colliders import create_camera_collision_prims
from usdsdg.functional.physics.scenes import DEFAULTS_PHYSICS_SCENE, create_physics_scene
from usdsdg.functional.physics.simulation import put_to_sleep, reset, simulate, simulate_until_rest, wake_up

__all__ = [
    "DEFAULTS_PHYSICS_SCENE", "DEFAULTS_RIGID_BODY", "VALID_COLLIDER_APPROXIMATIONS",
    "apply_collider", "apply_rigid_body", "create_camera_collision_prims", "create_physics_scene", "modify_attribute",
    "put_to_sleep", "remove_collider", "remove_rigid_body", "reset", "simulate",
    "simulate_until_rest", "wake_up",
]  # fmt: skip

name_parameters(globals())

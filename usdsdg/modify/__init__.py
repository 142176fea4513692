"""Changes to existing prims at each firing of a trigger: `rep.modify`."""

from collections.abc import Callable
from typing import Any

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.registry import register_function
from usdsdg.modify import attribute_worlds as _attribute_worlds  # noqa: F401 - registers twins for worlds
from usdsdg.modify import label_worlds as _label_worlds  # noqa: F401
from usdsdg.modify import orbit_worlds as _orbit_worlds  # noqa: F401
from usdsdg.modify import pose_worlds as _pose_worlds  # noqa: F401
from usdsdg.modify.appearance import semantics, variant, visibility
from usdsdg.modify.attributes import apply_or_schedule, attribute, set_attribute
from usdsdg.modify.bound_materials import bind_each, bind_material, check_material, material
from usdsdg.modify.camera_relative import pose_camera_relative, pose_orbit
from usdsdg.modify.clock import animation, frame, time, timeline
from usdsdg.modify.poses import apply_or_schedule_pose, pose
from usdsdg.modify.prims import non_xform_prims
from usdsdg.modify.projections import projection_material

__all__ = [  # noqa: RUF022
    # what scripts call
    "animation", "attribute", "frame", "material", "pose", "pose_camera_relative", "pose_orbit",
    "projection_material", "register",
    "semantics", "time", "timeline", "variant", "visibility",
    # what the other families use
    "apply_or_schedule", "apply_or_schedule_pose", "bind_each", "bind_material", "check_material", "non_xform_prims",
    "set_attribute",
]  # fmt: skip


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.modify.<name>` call `fn`.

    Raises:
        ValueError: the name is not an identifier, or taken while `override` is False.
    """
    register_function(globals(), "modify", fn, override, fn_name)


name_parameters(globals())

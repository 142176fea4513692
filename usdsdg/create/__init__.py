"""Creation of prims: `rep.create`.

An object is an Xform `/Replicator/<Type>_Xform[_NN]` with pose and labels, and one child `<Type>` with geometry or
light. Constant arguments are written immediately; distributions become nodes under the current trigger.
"""

from collections.abc import Callable
from typing import Any

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.registry import register_function
from usdsdg.create.cameras import camera, camera_rig, stereo_camera
from usdsdg.create.groups import group, xform
from usdsdg.create.lights import light
from usdsdg.create.materials import material_omnipbr, mdl_from_json
from usdsdg.create.projections import mesh_decal, projection_material
from usdsdg.create.references import from_dir, from_usd
from usdsdg.create.render_products import render_product, render_product_tiled
from usdsdg.create.shapes import cone, cube, cylinder, disk, plane, sphere, torus
from usdsdg.create.tiled_sensors import tiled_sensor
from usdsdg.stage.scopes import REPLICATOR

# Parent of what is created.
REPLICATOR_SCOPE = REPLICATOR

__all__ = [
    "REPLICATOR_SCOPE",
    "camera", "camera_rig", "cone", "cube", "cylinder", "disk", "from_dir", "from_usd", "group", "light",
    "material_omnipbr", "mdl_from_json", "mesh_decal", "plane", "projection_material", "register", "render_product",
    "render_product_tiled", "sphere", "stereo_camera", "tiled_sensor", "torus", "xform",
]  # fmt: skip


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.create.<name>` call `fn`.

    Raises:
        ValueError: the name is not an identifier, or taken while `override` is False.
    """
    register_function(globals(), "create", fn, override, fn_name)


name_parameters(globals())

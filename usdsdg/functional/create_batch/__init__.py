"""Creation of many prims in one call: `rep.functional.create_batch`. Each function returns a list of pxr prims.

Arguments that all functions share (N is `count`):

position, scale, rotation: one value for all, or one per prim, (N, 3): stage units, factors, degrees about x, then y,
    then z. One number is used for all three axes; `scale` also takes N numbers. In the space of the parent.
look_at: world point, prim or path that -Z points at, or one per prim; `look_at_up_axis` is the world direction of +Y,
    by default the stage's up axis.
pivot: point of the bounding box, -1 to 1 per axis, that is placed at `position`.
relative_to: prim or path; the pose is then in the space of that prim.
semantics: {"class": "cube"} or [("class", "cube")], or a list with one of these per prim.
visible: False hides a prim.
name, parent: the first prim is `<parent>/<name>`, further ones and names that are taken get _01, _02, ... By default
    the name is that of the type and the prim is a root prim. `parent` may be a list of N.

Errors are those of `modify.pose`; besides ArgumentError for `count` and for values of a wrong shape, BadPrim for a
parent that is not on the stage or is itself a shape, and Unsupported where a function documents it.
"""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.functional.create_batch.cameras import camera
from usdsdg.functional.create_batch.copies import clone, reference
from usdsdg.functional.create_batch.groups import scope, xform
from usdsdg.functional.create_batch.lights import (
    cylinder_light,
    disk_light,
    distant_light,
    dome_light,
    rect_light,
    sphere_light,
)
from usdsdg.functional.create_batch.materials import material
from usdsdg.functional.create_batch.sensors import omni_lidar, omni_radar
from usdsdg.functional.create_batch.shapes import capsule, cone, cube, cylinder, disk, plane, sphere, torus

__all__ = [
    "camera", "capsule", "clone", "cone", "cube", "cylinder", "cylinder_light", "disk", "disk_light", "distant_light",
    "dome_light", "material", "omni_lidar", "omni_radar", "plane", "rect_light", "reference", "scope", "sphere",
    "sphere_light", "torus", "xform",
]  # fmt: skip

name_parameters(globals())

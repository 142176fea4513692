"""Shapes: `rep.create.sphere`, `cube`, `cylinder`, `cone`, `torus`, `disk` and `plane`.

Meshes are one meter across (a torus one and a half), whatever the stage's units, and aligned with its up axis. With
`as_mesh=False` a shape is the UsdGeom prim in USD's own default size, two stage units across, as in Replicator.

Arguments that all of them share; each but the last four is one for all, a list of one per prim, or a distribution:

position: in the space of `parent` [stage units]; of `pivot` where that is given.
scale: factors, or one for all axes. rotation: angles about x, y, z [degrees], x first.
pivot: point that `position` places and that rotations are about, -1 to 1 on each axis of the shape's bounding box.
look_at: a point of the world [stage units] or prims, which -Z points to; look_at_up_axis: up direction for `look_at`.
semantics: [("class", "cube")] or {"class": "cube"}. visible: False hides. material: item, prim or path, or a list of
    one for each object; see `modify.material`.
as_mesh, count: whether to create a mesh, and how many objects. name, parent: the first object is
    `<parent>/<name>_Xform`, further ones get _01, _02, ...; by default `/Replicator/<Type>_Xform`.

Errors: ArgumentError for a value of another shape and for `count`, BadPrim for an unknown parent or material.
"""

from typing import Any

from usdsdg import modify
from usdsdg.create.objects import create_objects
from usdsdg.graph.node import ReplicatorItem
from usdsdg.stage.geometry import shape_meshes


def _shape(kind: str, arguments: dict[str, Any]) -> ReplicatorItem:
    define = shape_meshes.define if arguments.pop("as_mesh") else shape_meshes.define_gprim
    material = arguments.pop("material")
    item = create_objects(kind, lambda stage, path: define(stage, path, kind), node=f"OgnCreate{kind}", **arguments)
    if isinstance(material, (list, tuple)) and len(material) == len(item.prims):
        modify.bind_each(list(material), item)
    elif material is not None:
        modify.material(material, input_prims=item)
    return item


def sphere(
    position: Any = None, scale: Any = None, pivot: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, material: Any = None, visible: Any = True, as_mesh: bool = True,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create spheres of one meter diameter; the module documents the arguments."""
    return _shape("Sphere", locals())


def cube(
    position: Any = None, scale: Any = None, pivot: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, material: Any = None, visible: Any = True, as_mesh: bool = True,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create cubes with edges of one meter; the module documents the arguments."""
    return _shape("Cube", locals())


def cylinder(
    position: Any = None, scale: Any = None, pivot: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, material: Any = None, visible: Any = True, as_mesh: bool = True,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create cylinders of one meter height and diameter along the up axis; the module documents the arguments."""
    return _shape("Cylinder", locals())


def cone(
    position: Any = None, scale: Any = None, pivot: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, material: Any = None, visible: Any = True, as_mesh: bool = True,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create cones of one meter height and base diameter, pointing up; the module documents the arguments."""
    return _shape("Cone", locals())


def torus(
    position: Any = None, scale: Any = None, pivot: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, material: Any = None, visible: Any = True, as_mesh: bool = True,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create tori around the up axis, tubes of half a meter around rings of one; the module documents the arguments.

    Raises:
        Unsupported: as_mesh=False, since UsdGeom has no torus.
    """
    return _shape("Torus", locals())


def disk(
    position: Any = None, scale: Any = None, pivot: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, material: Any = None, visible: Any = True, as_mesh: bool = True,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create flat disks of one meter diameter, facing up; the module documents the arguments.

    Raises:
        Unsupported: as_mesh=False, since UsdGeom has no disk.
    """
    return _shape("Disk", locals())


def plane(
    position: Any = None, scale: Any = None, pivot: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, material: Any = None, visible: Any = True, as_mesh: bool = True,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create flat squares with edges of one meter, facing up; the module documents the arguments."""
    return _shape("Plane", locals())

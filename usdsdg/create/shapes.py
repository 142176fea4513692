"""Shapes. Mirrors `rep.create.sphere` and its siblings.

Meshes are one meter across, in whatever units the stage has, and stand on its up axis. With `as_mesh=False` a shape is
the UsdGeom prim in USD's own default size, two stage units across, as in Replicator.

Arguments that all of them share; each but the last four is one for all, a list of one per prim, or a distribution:

position: in the space of `parent` [stage units]; of `pivot` where that is given.
scale: factors, or one for all axes. rotation: angles about x, y, z [degrees], x first.
pivot: point that is placed and turned about, -1 to 1 on each axis of the shape's own box.
look_at: a point of the world [stage units] or prims, which -Z points to; look_at_up_axis: direction that is up then.
semantics: [("class", "cube")] or {"class": "cube"}. visible: False hides. material: item, prim or path.
as_mesh, count: how it is made, and how many. name, parent: the first object is `<parent>/<name>_Xform`, further ones
    get _01, _02, ...; by default `/Replicator/<Type>_Xform`.

Errors: ArgumentError for a value of another shape and for `count`, BadPrim for a parent or material that is not there.
"""

from typing import Any

from usdsdg import modify
from usdsdg.arguments.values import count_of
from usdsdg.create.objects import apply_common_arguments, new_object
from usdsdg.graph.node import ReplicatorItem
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry import shape_meshes


def _shape(kind: str, arguments: dict[str, Any]) -> ReplicatorItem:
    stage, as_mesh, material = current_stage(), arguments.pop("as_mesh"), arguments.pop("material")
    count, parent = arguments.pop("count"), arguments.pop("parent")
    objects = []
    for _ in range(count_of(count)):
        prim, child = new_object(kind, arguments["name"], parent)
        if as_mesh:
            shape_meshes.define(stage, child, kind)
        else:
            shape_meshes.define_gprim(stage, child, kind)
        objects.append(prim)
    item = apply_common_arguments(objects, kind=f"OgnCreate{kind}", **arguments)
    if material is not None:
        modify.material(material, input_prims=item)
    return item


def sphere(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
           material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Spheres of one meter diameter; the module says what the arguments are."""
    return _shape("Sphere", locals())


def cube(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cubes of one meter edge; the module says what the arguments are."""
    return _shape("Cube", locals())


def cylinder(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
             material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cylinders of one meter height and diameter, along the up axis; the module says what the arguments are."""
    return _shape("Cylinder", locals())


def cone(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cones of one meter height and base diameter, pointing up; the module says what the arguments are."""
    return _shape("Cone", locals())


def torus(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
          material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Tori of one meter outer diameter around the up axis; the module says what the arguments are.

    Raises:
        Unsupported: as_mesh=False, since UsdGeom has no torus.
    """
    return _shape("Torus", locals())


def disk(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Flat disks of one meter diameter, facing up; the module says what the arguments are.

    Raises:
        Unsupported: as_mesh=False, since UsdGeom has no disk.
    """
    return _shape("Disk", locals())


def plane(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
          material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Flat squares of one meter edge, facing up; the module says what the arguments are."""
    return _shape("Plane", locals())

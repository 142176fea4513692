"""Shapes. Mirrors `rep.create.sphere` and its siblings.

Meshes are one metre across, in whatever units the stage has, and stand on its up axis. With `as_mesh=False` a shape is
the UsdGeom prim in USD's own default size, two stage units across, as in Replicator.
"""

from __future__ import annotations

from typing import Any

from usdsdg import modify
from usdsdg.create.objects import new_object, posed
from usdsdg.graph.node import ReplicatorItem
from usdsdg.stage import meshes
from usdsdg.stage.context import current_stage
from usdsdg.values import count_of


def _shape(kind: str, arguments: dict[str, Any]) -> ReplicatorItem:
    stage, as_mesh, material = current_stage(), arguments.pop("as_mesh"), arguments.pop("material")
    count, parent = arguments.pop("count"), arguments.pop("parent")
    objects = []
    for _ in range(count_of(count)):
        prim, child = new_object(kind, arguments["name"], parent)
        if as_mesh:
            meshes.define(stage, child, kind)
        else:
            meshes.define_gprim(stage, child, kind)
        objects.append(prim)
    item = posed(objects, kind=f"OgnCreate{kind}", **arguments)
    if material is not None:
        modify.material(material, input_prims=item)
    return item


def sphere(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
           material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Spheres of one metre diameter."""
    return _shape("Sphere", locals())


def cube(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cubes of one metre edge."""
    return _shape("Cube", locals())


def cylinder(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
             material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cylinders of one metre height and diameter, along the stage's up axis."""
    return _shape("Cylinder", locals())


def cone(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cones of one metre height and base diameter, pointing up."""
    return _shape("Cone", locals())


def torus(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
          material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Tori of one metre outer diameter around the up axis.

    Raises:
        Unsupported: as_mesh=False, since UsdGeom has no torus.
    """
    return _shape("Torus", locals())


def disk(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Flat discs of one metre diameter, facing up.

    Raises:
        Unsupported: as_mesh=False, since UsdGeom has no disc.
    """
    return _shape("Disk", locals())


def plane(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
          material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Flat squares of one metre edge, facing up."""
    return _shape("Plane", locals())

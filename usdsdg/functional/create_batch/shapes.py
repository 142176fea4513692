"""Shapes, as meshes one meter across or as UsdGeom prims of USD's own default size (mostly two stage units)."""

from typing import Any

from pxr import Usd

from usdsdg.errors import Unsupported
from usdsdg.functional.new_prims import apply_common_arguments, define, new_paths
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry import shape_meshes


def _shapes(kind: str, arguments: dict[str, Any]) -> list[Usd.Prim]:
    as_mesh, count = arguments.pop("as_mesh"), arguments.pop("count")
    if not as_mesh and kind not in shape_meshes.GPRIMS:
        raise Unsupported(f"as_mesh=False for {kind.lower()}: UsdGeom has no such shape; leave as_mesh True")
    prims = define(
        new_paths(arguments.pop("name") or kind, arguments.pop("parent"), count), "Mesh" if as_mesh else kind
    )
    for prim in prims:
        if as_mesh:
            shape_meshes.define(current_stage(), str(prim.GetPath()), kind)
        else:
            shape_meshes.define_gprim(current_stage(), str(prim.GetPath()), kind)
    return apply_common_arguments(prims, **arguments)


def plane(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Squares with edges of one meter that face the stage's up axis."""
    return _shapes("Plane", locals())


def sphere(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Spheres of one meter diameter."""
    return _shapes("Sphere", locals())


def torus(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Rings around the stage's up axis, one meter across; always meshes."""
    return _shapes("Torus", locals())


def disk(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Flat disks of one meter diameter that face the stage's up axis; always meshes."""
    return _shapes("Disk", locals())


def cube(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Cubes with edges of one meter."""
    return _shapes("Cube", locals())


def cylinder(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Cylinders of one meter height and diameter along the stage's up axis."""
    return _shapes("Cylinder", locals())


def cone(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Cones of one meter height and base diameter along the stage's up axis."""
    return _shapes("Cone", locals())


def capsule(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Capsules of one meter height with caps and half a meter diameter, along the stage's up axis. Since 6.0."""
    return _shapes("Capsule", locals())

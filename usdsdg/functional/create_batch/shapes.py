"""Shapes, as meshes one meter across or as UsdGeom prims of USD's own default size (mostly two stage units)."""

from collections.abc import Callable
from typing import Any, TypeVar

from pxr import Usd

from usdsdg.errors import Unsupported
from usdsdg.functional.new_prims import apply_common_arguments, define, new_paths
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry import shape_meshes

_Make = TypeVar("_Make", bound=Callable[..., list[Usd.Prim]])


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


# Replicator's parameters differ between shapes, and scripts may pass them in order.


def _solid(kind: str, doc: str):  # the signature is inferred
    """Return the function that makes shapes of one kind, as meshes or not."""

    def make(
        position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
        pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
        count: int = 1, name: str | None = None, parent: Any = None, material: Any = None,
    ) -> list[Usd.Prim]:  # fmt: skip
        return _shapes(kind, {name: value for name, value in locals().items() if name != "kind"})

    return _named(make, kind, doc)


def _flat_or_ring(kind: str, doc: str):  # the signature is inferred
    """Return the function that makes shapes of one kind; `as_mesh` goes by name, since Replicator's are meshes."""

    def make(
        position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
        pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, count: int = 1,
        name: str | None = None, parent: Any = None, material: Any = None, *, as_mesh: bool = True,
    ) -> list[Usd.Prim]:  # fmt: skip
        return _shapes(kind, {name: value for name, value in locals().items() if name != "kind"})

    return _named(make, kind, doc)


def _named(make: _Make, kind: str, doc: str) -> _Make:
    make.__name__ = make.__qualname__ = kind.lower()
    make.__doc__ = doc
    return make


plane = _flat_or_ring("Plane", "Squares with edges of one meter that face the stage's up axis.")
sphere = _solid("Sphere", "Spheres of one meter diameter.")
torus = _flat_or_ring("Torus", "Rings around the stage's up axis, one and a half meters across; always meshes.")
disk = _flat_or_ring("Disk", "Flat disks of one meter diameter that face the stage's up axis; always meshes.")
cube = _solid("Cube", "Cubes with edges of one meter.")
cone = _solid("Cone", "Cones of one meter height and base diameter along the stage's up axis.")
capsule = _solid(
    "Capsule", "Capsules of one meter height with caps and half a meter diameter, along the stage's up axis. Since 6.0."
)


def cylinder(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, as_mesh: bool = True, visible: Any = True,
    count: int = 1, name: str | None = None, parent: Any = None, material: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Cylinders of one meter height and diameter along the stage's up axis."""
    return _shapes("Cylinder", locals())

"""Prims made by scripts. Mirrors `rep.create`.

An object is an Xform `/Replicator/<Type>_Xform[_NN]` that carries pose and labels, with one child `<Type>` that carries
geometry or light. Constant arguments are written at once; distributions become nodes under the current trigger.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from usdsdg import modify
from usdsdg.errors import AssetError, BadPrim, GraphError, Unsupported
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths
from usdsdg.render_product import render_product
from usdsdg.stage import assets, meshes, paths, transforms
from usdsdg.stage.context import current_stage
from usdsdg.values import count_of, vector

__all__ = [
    "camera", "cone", "cube", "cylinder", "disk", "from_usd", "group", "light", "plane", "render_product", "sphere",
    "torus", "xform",
]  # fmt: skip

ROOT = "/Replicator"
LIGHT_SCHEMAS = {
    "cylinder": UsdLux.CylinderLight,
    "disk": UsdLux.DiskLight,
    "distant": UsdLux.DistantLight,
    "dome": UsdLux.DomeLight,
    "rect": UsdLux.RectLight,
    "sphere": UsdLux.SphereLight,
}


def group(items: Any, semantics: Any = None, name: str | None = None) -> ReplicatorItem:
    """Prims to be randomized together, in the order given.

    Raises:
        BadPrim: a path is not on the stage.
    """
    targets = prim_paths(items)
    stage = current_stage()
    missing = [path for path in targets if not stage.GetPrimAtPath(path)]
    if missing:
        raise BadPrim(f"create.group: not on the stage: {', '.join(missing[:5])}")
    item = ReplicatorItem(Node(kind="OgnGroup", prims=targets, name=name))
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    return item


def _object(kind: str, name: str | None, parent: Any) -> tuple[Usd.Prim, str]:
    """A new object Xform and the path its child shall have."""
    stage = current_stage()
    root = prim_paths(parent)[0] if parent is not None else ROOT
    if parent is None and not stage.GetPrimAtPath(ROOT):
        stage.DefinePrim(ROOT, "Scope")
    if not stage.GetPrimAtPath(root):
        raise BadPrim(f"create.{kind.lower()}: parent {root} is not on the stage")
    label = name or kind
    path = paths.next_free_path(stage, f"{root}/{label}_Xform")
    prim = stage.DefinePrim(path, "Xform")
    prim.CreateAttribute("replicatorXform", Sdf.ValueTypeNames.Bool, custom=True).Set(True)
    return prim, f"{path}/{label}"


def _posed(
    objects: Sequence[Usd.Prim],
    *,
    position: Any = None,
    rotation: Any = None,
    scale: Any = None,
    look_at: Any = None,
    look_at_up_axis: Any = None,
    pivot: Any = None,
    semantics: Any = None,
    visible: Any = True,
    kind: str,
    name: str | None = None,
) -> ReplicatorItem:
    """Write or schedule what all objects have in common and return their handle."""
    item = ReplicatorItem(Node(kind=kind, prims=tuple(str(prim.GetPath()) for prim in objects), name=name))
    modify.apply_or_schedule_pose(
        item, position=position, pivot=pivot, rotation=rotation, scale=scale, look_at=look_at,
        look_at_up_axis=look_at_up_axis,
    )  # fmt: skip
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    if visible is not True:
        modify.visibility(visible, input_prims=item)
    return item


def xform(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    semantics: Any = None, visible: Any = True, count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """`count` empty transforms."""
    objects = [_object("Xform", name, parent)[0] for _ in range(count_of(count))]
    return _posed(
        objects, position=position, scale=scale, rotation=rotation, look_at=look_at, look_at_up_axis=look_at_up_axis,
        semantics=semantics, visible=visible, kind="OgnCreateXform", name=name,
    )  # fmt: skip


def _shape(kind: str, arguments: dict[str, Any]) -> ReplicatorItem:
    stage, as_mesh, material = current_stage(), arguments.pop("as_mesh"), arguments.pop("material")
    count, parent = arguments.pop("count"), arguments.pop("parent")
    objects = []
    for _ in range(count_of(count)):
        prim, child = _object(kind, arguments["name"], parent)
        if as_mesh:
            meshes.define(stage, child, kind)
        else:
            meshes.define_gprim(stage, child, kind)
        objects.append(prim)
    item = _posed(objects, kind=f"OgnCreate{kind}", **arguments)
    if material is not None:
        modify.material(material, input_prims=item)
    return item


def sphere(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
           material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Spheres of one metre diameter, as meshes or as UsdGeom prims."""
    return _shape("Sphere", locals())


def cube(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cubes of one metre edge."""
    return _shape("Cube", locals())


def cylinder(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
             material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cylinders of one metre height and diameter, along the stage's Z axis."""
    return _shape("Cylinder", locals())


def cone(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Cones of one metre height and base diameter, along Z."""
    return _shape("Cone", locals())


def torus(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
          material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Tori of one metre outer diameter around Z; always a mesh, since UsdGeom has no torus."""
    return _shape("Torus", locals())


def disk(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
         material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Flat discs of one metre diameter, facing +Z; always a mesh."""
    return _shape("Disk", locals())


def plane(position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None,
          material=None, visible=True, as_mesh=True, count=1, name=None, parent=None) -> ReplicatorItem:  # fmt: skip
    """Flat squares of one metre edge, facing +Z."""
    return _shape("Plane", locals())


def light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    light_type: str = "Distant", color: Any = (1.0, 1.0, 1.0), intensity: Any = 1000.0, exposure: Any = None,
    temperature: Any = 6500, texture: Any = None, count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """UsdLux lights: cylinder, disk, distant, dome, rect or sphere (any case).

    Made once, when this line runs; arguments that are distributions are drawn again at every firing of the enclosing
    trigger. `intensity` is in nits (distant: lux), `temperature` in kelvin; None switches colour temperature off.

    Raises:
        GraphError: unknown light_type.
    """
    schema = LIGHT_SCHEMAS.get(str(light_type).lower())
    if schema is None:
        raise GraphError(f"create.light: light_type={light_type!r}; known: {', '.join(LIGHT_SCHEMAS)}")
    stage = current_stage()
    objects, lights = [], []
    for _ in range(count_of(count)):
        prim, child = _object(f"{light_type.capitalize()}Light", name, parent)
        objects.append(prim)
        lights.append(schema.Define(stage, child).GetPrim())
        enabled = UsdLux.LightAPI(lights[-1]).CreateEnableColorTemperatureAttr()
        enabled.Set(temperature is not None)
    item = _posed(
        objects, position=position, scale=scale, rotation=rotation, look_at=look_at, look_at_up_axis=look_at_up_axis,
        kind="OgnCreateLight", name=name,
    )  # fmt: skip
    values = {
        "inputs:color": color,
        "inputs:intensity": intensity,
        "inputs:exposure": exposure,
        "inputs:colorTemperature": temperature,
        "inputs:texture:file": texture,
    }
    for attribute, value in values.items():
        if value is not None:
            modify.apply_or_schedule(attribute, value, lights)
    return item


def camera(
    position: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    focal_length: Any = 24.0, focus_distance: Any = 400.0, f_stop: Any = 0.0, horizontal_aperture: Any = 20.955,
    horizontal_aperture_offset: Any = 0.0, vertical_aperture_offset: Any = 0.0,
    clipping_range: tuple[float, float] = (1.0, 1000000.0), projection_type: str = "pinhole", count: int = 1,
    parent: Any = None, name: str | None = None, **lens: Any,
) -> ReplicatorItem:  # fmt: skip
    """Cameras. Lengths of the lens are in tenths of a stage unit, as in UsdGeomCamera.

    In a Z-up stage the camera looks along its object's +X with +Z up, as in Replicator: the child carries the fixed
    rotation that makes it so.

    Raises:
        Unsupported: a projection other than pinhole, or its parameters.
    """
    if projection_type != "pinhole" or lens:
        raise Unsupported(
            f"create.camera: projection_type={projection_type!r} {sorted(lens)} is not available yet; use 'pinhole'."
        )
    stage = current_stage()
    objects, cameras = [], []
    for _ in range(count_of(count)):
        prim, child = _object("Camera", name, parent)
        objects.append(prim)
        usd_camera = UsdGeom.Camera.Define(stage, child)
        usd_camera.CreateClippingRangeAttr(Gf.Vec2f(vector("clipping_range", clipping_range, 2)))
        if transforms.up_axis(stage) == "Z":
            usd_camera.AddRotateXYZOp().Set(Gf.Vec3f(90, 0, -90))
        cameras.append(usd_camera.GetPrim())
    item = _posed(
        objects, position=position, rotation=rotation, look_at=look_at, look_at_up_axis=look_at_up_axis,
        kind="OgnCreateCamera", name=name,
    )  # fmt: skip
    optics = dict(
        focalLength=focal_length, focusDistance=focus_distance, fStop=f_stop, horizontalAperture=horizontal_aperture,
        horizontalApertureOffset=horizontal_aperture_offset, verticalApertureOffset=vertical_aperture_offset,
    )  # fmt: skip
    for attribute, value in optics.items():
        modify.apply_or_schedule(attribute, value, cameras)
    return item


def from_usd(
    usd: str, position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, count: int = 1, name: str | None = "Ref", parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """`count` references to a USD file: `/Replicator/Ref_Xform/Ref`.

    Raises:
        AssetError: the file is missing or has no prim to reference.
    """
    stage, file = current_stage(), assets.resolve(usd)
    objects = []
    for _ in range(count_of(count)):
        prim, child = _object("Ref", name, parent)
        reference = stage.DefinePrim(child)
        if not reference.GetReferences().AddReference(file):
            raise AssetError(f"create.from_usd: {file} cannot be referenced at {child}")
        objects.append(prim)
    return _posed(
        objects, position=position, scale=scale, rotation=rotation, look_at=look_at, look_at_up_axis=look_at_up_axis,
        semantics=semantics, kind="OgnCreateFromUsd", name=name,
    )  # fmt: skip

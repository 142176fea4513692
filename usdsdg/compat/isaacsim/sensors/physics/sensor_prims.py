"""The prims of physics sensors: how they are defined, and the rigid body that they measure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Gf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.wrappers import contacts
from usdsdg.errors import BadPrim
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import next_free_path


def define_sensor(
    kind: str,
    path: str,
    parent: str | None,
    attributes: Mapping[str, Any],
    *,
    translation: Gf.Vec3d | None = None,
    orientation: Gf.Quatd | None = None,
) -> Usd.Prim:
    """Define an IsaacContactSensor or IsaacImuSensor below `parent`, at a path that is free.

    Raises:
        BadPrim: there is no such parent.
    """
    stage = current_stage()
    above = stage.GetPrimAtPath(parent) if parent else None
    if not above:
        raise BadPrim(
            f"{kind}: there is no prim at parent={parent!r}; give the path of the rigid body that it measures"
        )
    prim = stage.DefinePrim(next_free_path(stage, f"{parent}/{path.strip('/')}"), kind)
    prim.GetAttribute("enabled").Set(True)
    xformable = UsdGeom.Xformable(prim)
    xformable.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(translation or Gf.Vec3d(0.0))
    xformable.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(_quaternion(orientation))
    xformable.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(1.0))
    for name, value in attributes.items():
        prim.GetAttribute(name).Set(value)
    return prim


def define_contact_sensor(parent: str | None, path: str = "/Contact_Sensor", **values: Any) -> Usd.Prim:
    """Define a contact sensor, and let its parent report contacts; `values` are those of `define_sensor`."""
    prim = define_sensor("IsaacContactSensor", path, parent, **values)
    contacts.report_contacts([prim.GetParent()])
    return prim


def define_imu_sensor(parent: str | None, path: str = "/Imu_Sensor", **values: Any) -> Usd.Prim:
    """Define a sensor of motion; `values` are those of `define_sensor`."""
    return define_sensor("IsaacImuSensor", path, parent, **values)


def has_body_above(prim: Usd.Prim) -> bool:
    """Return whether there is a rigid body above a sensor."""
    try:
        body_above(prim)
    except BadPrim:
        return False
    return True


def body_above(prim: Usd.Prim) -> Usd.Prim:
    """Return the nearest rigid body above a sensor.

    Raises:
        BadPrim: there is none.
    """
    above = prim.GetParent()
    while above and not above.IsPseudoRoot():
        if above.HasAPI(UsdPhysics.RigidBodyAPI):
            return above
        above = above.GetParent()
    raise BadPrim(f"{prim.GetPath()} has no rigid body above it, so it measures nothing. Define it below one.")


def period_of(frequency: float | None, dt: float | None) -> float:
    """Return the period [s] of a sensor: `dt`, or one over the frequency [Hz]; by default that of physics.

    Raises:
        ValueError: both are given.
    """
    if frequency is not None and dt is not None:
        raise ValueError("give either frequency or dt of a sensor, not both")
    if frequency is not None:
        return 1.0 / frequency
    return simulation().scene().get_dt() if dt is None else dt


def _quaternion(given: Gf.Quatd | Sequence[float] | None) -> Gf.Quatd:
    """Return a quaternion, also of the numbers (w, x, y, z)."""
    if given is None or isinstance(given, (Gf.Quatd, Gf.Quatf, Gf.Quath)):
        return Gf.Quatd(given) if given is not None else Gf.Quatd(1.0)
    w, x, y, z = (float(number) for number in given)
    return Gf.Quatd(w, x, y, z)

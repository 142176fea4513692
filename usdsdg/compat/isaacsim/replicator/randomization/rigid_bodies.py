"""The attributes of rigid bodies as rows of numbers, one row per body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdPhysics, UsdShade

from usdsdg.compat.isaacsim.replicator.randomization import prim_values
from usdsdg.session import body_velocities, engines
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import valid_name
from usdsdg.stage.schemas import physx
from usdsdg.stage.scopes import REPLICATOR, define_scope

Array = NDArray[np.float64]

MATERIALS = f"{REPLICATOR}/PhysicsMaterials"
# PhysX's friction, static and dynamic, and restitution where no material is bound.
_NO_MATERIAL = (0.5, 0.5, 0.0)


class RigidBodies:
    """Rigid bodies of a view. Rows are float64; NaN is a value that nobody has authored.

    angular_velocity is in rad/s; mass, inertia, forces and velocities are in the stage's units.
    """

    def __init__(self, paths: Sequence[str]) -> None:
        self.paths = tuple(paths)

    def read(self, attribute: str) -> Array:
        """Return the present values (N, K) of an attribute."""
        prims = prim_values.prims_at(self.paths)
        if attribute == "position":
            return prim_values.positions(prims)
        if attribute == "orientation":
            return prim_values.orientations(prims)
        if attribute == "force":
            return np.zeros((len(prims), 3))
        return np.array([_READ[attribute](prim) for prim in prims], np.float64).reshape(len(prims), -1)

    def write(self, attribute: str, rows: Sequence[int], values: Array) -> None:
        """Set an attribute of the bodies in `rows` to values (n, K); forces act during the next step."""
        prims = prim_values.prims_at([self.paths[row] for row in rows])
        if attribute == "position":
            prim_values.set_positions(prims, values)
        elif attribute == "orientation":
            prim_values.set_orientations(prims, values)
        elif attribute == "force":
            engines.physics().apply_forces([str(prim.GetPath()) for prim in prims], values)
        else:
            for prim, value in zip(prims, values, strict=True):
                _WRITE[attribute](prim, value.tolist())


# --- velocities ---
def _linear(prim: Usd.Prim) -> Sequence[float]:
    return body_velocities.velocities([prim])[0][0].tolist()


def _set_linear(prim: Usd.Prim, value: Sequence[float]) -> None:
    UsdPhysics.RigidBodyAPI(prim).CreateVelocityAttr().Set(Gf.Vec3f(*value))


def _angular(prim: Usd.Prim) -> Sequence[float]:
    return body_velocities.velocities([prim])[1][0].tolist()


def _set_angular(prim: Usd.Prim, value: Sequence[float]) -> None:
    UsdPhysics.RigidBodyAPI(prim).CreateAngularVelocityAttr().Set(Gf.Vec3f(*np.degrees(value).tolist()))


def _velocity(prim: Usd.Prim) -> Sequence[float]:
    return (*_linear(prim), *_angular(prim))


def _set_velocity(prim: Usd.Prim, value: Sequence[float]) -> None:
    _set_linear(prim, value[:3])
    _set_angular(prim, value[3:])


# --- masses ---
def _mass(prim: Usd.Prim) -> Sequence[float]:
    mass = UsdPhysics.MassAPI(prim).GetMassAttr()
    return [mass.Get() if mass and mass.Get() else np.nan]


def _set_mass(prim: Usd.Prim, value: Sequence[float]) -> None:
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr().Set(value[0])


def _inertia(prim: Usd.Prim) -> Sequence[float]:
    inertia = UsdPhysics.MassAPI(prim).GetDiagonalInertiaAttr()
    return tuple(inertia.Get()) if inertia and any(inertia.Get()) else (np.nan,) * 3


def _set_inertia(prim: Usd.Prim, value: Sequence[float]) -> None:
    UsdPhysics.MassAPI.Apply(prim).CreateDiagonalInertiaAttr().Set(Gf.Vec3f(*value))


# --- colliders: one group of columns for each ---
def _colliders(prim: Usd.Prim) -> list[Usd.Prim]:
    return [each for each in Usd.PrimRange(prim) if each.HasAPI(UsdPhysics.CollisionAPI)]


def _materials(prim: Usd.Prim) -> Sequence[float]:
    found: list[float] = []
    for collider in _colliders(prim):
        material, _ = UsdShade.MaterialBindingAPI(collider).ComputeBoundMaterial("physics")
        physics = UsdPhysics.MaterialAPI(material.GetPrim()) if material else None
        found += (
            [float(each.Get()) for each in _material_attributes(physics)]
            if physics and physics.GetPrim().HasAPI(UsdPhysics.MaterialAPI)
            else _NO_MATERIAL
        )
    return found


def _set_materials(prim: Usd.Prim, value: Sequence[float]) -> None:
    """Set static friction, dynamic friction and restitution of each collider, in a material of its own."""
    for collider, numbers in _grouped(prim, value, 3):
        path = f"{MATERIALS}/{valid_name(str(collider.GetPath()).lstrip('/'))}"
        material = UsdShade.Material.Get(current_stage(), path)
        if not material:
            define_scope(current_stage(), MATERIALS)
            material = UsdShade.Material.Define(current_stage(), path)
            UsdPhysics.MaterialAPI.Apply(material.GetPrim())
            binding = UsdShade.MaterialBindingAPI.Apply(collider)
            binding.Bind(material, UsdShade.Tokens.strongerThanDescendants, "physics")
        for attribute, number in zip(_material_attributes(UsdPhysics.MaterialAPI(material.GetPrim())), numbers):
            attribute.Set(number)


def _material_attributes(physics: UsdPhysics.MaterialAPI) -> tuple[Usd.Attribute, ...]:
    return (
        physics.CreateStaticFrictionAttr(),
        physics.CreateDynamicFrictionAttr(),
        physics.CreateRestitutionAttr(),
    )


def _offsets(name: str, prim: Usd.Prim) -> Sequence[float]:
    attributes = [collider.GetAttribute(f"physxCollision:{name}Offset") for collider in _colliders(prim)]
    values = [attribute.Get() if attribute else None for attribute in attributes]
    return [value if value is not None and np.isfinite(value) else np.nan for value in values]


def _set_offsets(name: str, prim: Usd.Prim, value: Sequence[float]) -> None:
    for collider, (number,) in _grouped(prim, value, 1):
        api = physx.PhysxCollisionAPI.Apply(collider)  # pyright: ignore[reportAttributeAccessIssue]
        (api.CreateContactOffsetAttr() if name == "contact" else api.CreateRestOffsetAttr()).Set(number)


def _grouped(prim: Usd.Prim, value: Sequence[float], width: int) -> list[tuple[Usd.Prim, Sequence[float]]]:
    """Return each collider with its columns; where there are only `width` columns, they are for all."""
    colliders = _colliders(prim)
    rows = np.broadcast_to(np.asarray(value).reshape(-1, width), (len(colliders), width))
    return list(zip(colliders, rows.tolist(), strict=True))


_READ = {
    "linear_velocity": _linear,
    "angular_velocity": _angular,
    "velocity": _velocity,
    "mass": _mass,
    "inertia": _inertia,
    "material_properties": _materials,
    "contact_offset": lambda prim: _offsets("contact", prim),
    "rest_offset": lambda prim: _offsets("rest", prim),
}
_WRITE = {
    "linear_velocity": _set_linear,
    "angular_velocity": _set_angular,
    "velocity": _set_velocity,
    "mass": _set_mass,
    "inertia": _set_inertia,
    "material_properties": _set_materials,
    "contact_offset": lambda prim, value: _set_offsets("contact", prim, value),
    "rest_offset": lambda prim, value: _set_offsets("rest", prim, value),
}

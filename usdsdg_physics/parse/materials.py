"""Read the physics materials that are bound to colliders."""

from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import has_api, value
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import Material


def bound_materials(prims: list[Usd.Prim], units: Units) -> list[Material]:
    """Return the physics material bound to each prim or its ancestors; PhysX's defaults where there is none."""
    if not prims:
        return []
    bound, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(prims, "physics")
    known: dict[Sdf.Path, Material] = {}
    materials = []
    for material in bound:
        prim = material.GetPrim()
        if not prim or not has_api(prim, "PhysicsMaterialAPI"):
            materials.append(Material())
            continue
        if prim.GetPath() not in known:
            known[prim.GetPath()] = _read_material(prim, units)
        materials.append(known[prim.GetPath()])
    return materials


def _read_material(prim: Usd.Prim, units: Units) -> Material:
    static = float(value(prim, "physics:staticFriction", 0.0))
    dynamic = float(value(prim, "physics:dynamicFriction", 0.0))
    if abs(static - dynamic) > 0.01:
        warn_once(
            f"{prim.GetPath()}: the solver has one friction coefficient; dynamicFriction {dynamic:g} is used and "
            f"staticFriction {static:g} is not. Give both the same value."
        )
    for name in ("frictionCombineMode", "restitutionCombineMode"):
        mode = str(value(prim, f"physxMaterial:{name}", "average"))
        if mode != "average":
            warn_once(f"{prim.GetPath()}: {name} {mode!r} is not supported, coefficients are averaged; use 'average'.")
    return Material(
        path=str(prim.GetPath()),
        friction=max(0.0, dynamic),
        restitution=min(1.0, max(0.0, float(value(prim, "physics:restitution", 0.0)))),
        density=max(0.0, float(value(prim, "physics:density", 0.0))) * units.density,
    )

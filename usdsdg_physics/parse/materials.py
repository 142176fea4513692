"""Read the physics materials that are bound to colliders."""

from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import has_api, value
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import COMBINE_MODES, CombineMode, Material


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
    return Material(
        path=str(prim.GetPath()),
        friction=max(0.0, dynamic),
        restitution=min(1.0, max(0.0, float(value(prim, "physics:restitution", 0.0)))),
        density=max(0.0, float(value(prim, "physics:density", 0.0))) * units.density,
        # As in PhysX, sliding never brakes more than sticking.
        static_friction=max(0.0, static, dynamic),
        friction_mode=_combine_mode(prim, "frictionCombineMode"),
        restitution_mode=_combine_mode(prim, "restitutionCombineMode"),
    )


def _combine_mode(prim: Usd.Prim, name: str) -> CombineMode:
    """Return how a coefficient is combined with that of the other surface."""
    authored = str(value(prim, f"physxMaterial:{name}", "average"))
    for mode in COMBINE_MODES:
        if mode == authored:
            return mode
    warn_once(
        f"{prim.GetPath()}: physxMaterial:{name} {authored!r} is none of {', '.join(COMBINE_MODES)}; average counts."
    )
    return "average"

"""Read the physics materials that are bound to colliders."""

from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import has_api, positive, value
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import COMBINE_MODES, CombineMode, Material

# What slides on a surface with this friction stops at once; an infinite one cannot be averaged.
MOST_FRICTION = 1e6


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
    static = _coefficient(prim, "physics:staticFriction", MOST_FRICTION)
    dynamic = _coefficient(prim, "physics:dynamicFriction", MOST_FRICTION)
    return Material(
        path=str(prim.GetPath()),
        friction=dynamic,
        restitution=_coefficient(prim, "physics:restitution", 1.0),
        density=positive(prim, "physics:density") * units.density,
        # As in PhysX, sliding never brakes more than sticking.
        static_friction=max(static, dynamic),
        friction_mode=_combine_mode(prim, "frictionCombineMode"),
        restitution_mode=_combine_mode(prim, "restitutionCombineMode"),
    )


def _coefficient(prim: Usd.Prim, name: str, most: float) -> float:
    """Return a coefficient from 0 to `most`; name one that is outside, or no number."""
    number = float(value(prim, name, 0.0))
    counts = min(most, max(0.0, number)) if number == number else 0.0
    if number != counts:
        warn_once(
            f"{prim.GetPath()}: {name} is {number:g}, so it counts as {counts:g}. Set a number from 0 to {most:g}."
        )
    return counts


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

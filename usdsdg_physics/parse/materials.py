"""Read the physics materials that are bound to colliders."""

from collections.abc import Iterable

from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import MATERIAL, has_api, positive, value
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import COMBINE_MODES, CombineMode, Material

# What slides on a surface with this friction stops at once; an infinite one cannot be averaged.
MOST_FRICTION = 1e6


def default_material(scene: Usd.Prim | None, units: Units) -> Material:
    """Return what colliders without a physics material have: what is bound to the PhysicsScene, or PhysX's defaults."""
    return bound_materials([scene], units, Material())[0] if scene else Material()


def bound_materials(prims: list[Usd.Prim], units: Units, default: Material) -> list[Material]:
    """Return the physics material bound to each prim or its ancestors, `default` where there is none."""
    if not prims:
        return []
    bound, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(prims, "physics")
    known: dict[Sdf.Path, Material] = {}
    materials, bindings = [], _Bindings()
    for collider, material in zip(prims, bound):
        prim = bindings.loose_material(collider) or material.GetPrim()
        if not prim or not has_api(prim, MATERIAL):
            materials.append(default)
            continue
        if prim.GetPath() not in known:
            known[prim.GetPath()] = _read_material(prim, units)
        materials.append(known[prim.GetPath()])
    return materials


def warn_unbound(loose: list[Usd.Prim], materials: Iterable[Material]) -> None:
    """Warn of prims that have a physics material's attributes, but are neither Materials nor bound to a collider."""
    used = {material.path for material in materials}
    if unbound := [path for path in (str(prim.GetPath()) for prim in loose) if path not in used]:
        warn_once(
            f"a physics material acts on the colliders that it is bound to, and these are bound to none: "
            f"{listed(unbound)}. Apply PhysicsMaterialAPI to a Material, and bind it with the purpose 'physics'."
        )


class _Bindings:
    """Direct bindings to prims that are no Materials, which UsdShade passes over and PhysX does not."""

    def __init__(self) -> None:
        self._known: dict[tuple[Sdf.Path, str], tuple[Sdf.Path | None, bool]] = {}

    def loose_material(self, prim: Usd.Prim) -> Usd.Prim | None:
        """Return what is bound to a prim or the nearest above if it is no Material, but has a physics material."""
        for name in ("material:binding:physics", "material:binding"):
            path, _ = self._binding(prim, name)
            if path is not None:
                target = prim.GetStage().GetPrimAtPath(path)
                is_loose = target and target.GetTypeName() != "Material" and has_api(target, MATERIAL)
                return target if is_loose else None
        return None

    def _binding(self, prim: Usd.Prim, name: str) -> tuple[Sdf.Path | None, bool]:
        """Return the target of the binding that counts, and whether it is stronger than those below it."""
        if prim.IsPseudoRoot():
            return None, False
        key = prim.GetPath(), name
        if key not in self._known:
            above, is_strong = self._binding(prim.GetParent(), name)
            relation = prim.GetRelationship(name)
            targets = relation.GetTargets() if relation and not is_strong else []
            if targets:
                strength = UsdShade.MaterialBindingAPI.GetMaterialBindingStrength(relation)
                above, is_strong = targets[0], strength == UsdShade.Tokens.strongerThanDescendants
            self._known[key] = above, is_strong
        return self._known[key]


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

"""MDL materials."""

from typing import Any

from pxr import Sdf, Usd, UsdShade

from usdsdg.arguments.prims import prims_of
from usdsdg.arguments.values import count_of
from usdsdg.errors import ArgumentError, BadPrim, counted
from usdsdg.functional.arguments import per_prim
from usdsdg.functional.new_prims import new_paths
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import materials


def material(
    mdl: str, bind_prims: Any = None, count: int = 1, name: str | None = None, parent: Any = None, **inputs: Any
) -> list[Usd.Prim]:
    """Create materials of an MDL module such as "OmniPBR.mdl" with the given `inputs`.

    The name is "Material" by default; a `parent` path that is not on the stage yet becomes a Scope. An input may be a
    list with one value per material; strings for textures are files or URLs below the assets root.

    Args:
        bind_prims: `count` prims, to each of which one material is bound; with a count of 1, any number of prims, to
            all of which it is bound. The binding is stronger than those of descendants.

    Raises:
        AssetNotFound: a texture does not exist.
        BadPrim: OmniPBR has no such input, or a prim to bind is not on the stage.
        BadValue: an input does not take its value.
        ArgumentError: the number of prims to bind differs from the number of materials.
    """
    count = count_of(count)
    bound = [] if bind_prims is None else _bindings(bind_prims, count)
    _make_parent(parent)
    made = [materials.define_mdl(current_stage(), path, mdl) for path in new_paths(name or "Material", parent, count)]
    for input_name, value in inputs.items():
        if value is None:
            continue
        for each, one in zip(made, _per_material(value, count)):
            materials.set_input(each.GetPrim(), input_name, one)
    for each, prims in zip(made, bound):
        for prim in prims:
            binding = UsdShade.MaterialBindingAPI.Apply(prim)
            binding.Bind(each, UsdShade.Tokens.strongerThanDescendants)
    return [each.GetPrim() for each in made]


def _bindings(bind_prims: Any, count: int) -> list[list[Usd.Prim]]:
    if count == 1:
        return [prims_of(bind_prims)]
    each = list(bind_prims) if isinstance(bind_prims, (list, tuple)) else [bind_prims]
    if len(each) != count:
        entries = counted(len(each), "entry", "entries")
        raise ArgumentError(f"bind_prims has {entries} for {count} materials; give one for each")
    return [[] if prims is None else prims_of(prims) for prims in each]


def _per_material(value: Any, count: int) -> list[Any]:
    # [1, 0, 0] for three materials is one color.
    flat = isinstance(value, list) and len(value) in (2, 3) and all(isinstance(each, (int, float)) for each in value)
    return [value] * count if flat else per_prim(value, count)


def _make_parent(parent: Any) -> None:
    stage = current_stage()
    for each in parent if isinstance(parent, (list, tuple)) else [parent]:
        if not isinstance(each, (str, Sdf.Path)) or stage.GetPrimAtPath(str(each)):
            continue
        if not Sdf.Path.IsValidPathString(str(each)) or not Sdf.Path(str(each)).IsAbsolutePath():
            raise BadPrim(f"parent {each!r} is not the path of a prim; it should look like '/World/Looks'")
        stage.DefinePrim(str(each), "Scope")

"""UsdLux light linking and UsdLuxShadowAPI, read to `scene.LightLinks`."""

import math
from collections.abc import Sequence

import numpy as np
from pxr import Sdf, Usd, UsdLux

from usdsdg import errors
from usdsdg_render.lights.light_values import light_number, light_value
from usdsdg_render.scene.scene import LightLinks

BLACK = (0.0, 0.0, 0.0)


def read_links(prim: Usd.Prim, paths: Sequence[str]) -> LightLinks | None:
    """Read links and shadow parameters of a light for instances of prims with these paths; None if all are default.

    Disabled shadows are expressed as a shadow distance of 0.
    """
    api = UsdLux.LightAPI(prim)
    lit = _members(api.GetLightLinkCollectionAPI(), paths)
    casting = _members(api.GetShadowLinkCollectionAPI(), paths)
    distance = light_number(prim, "shadow:distance", -1.0)
    distance = distance if distance >= 0.0 else math.inf
    if light_value(prim, "shadow:enable", True) is False:
        distance = 0.0
    falloff = min(max(light_number(prim, "shadow:falloff", -1.0), 0.0), distance if distance < math.inf else 0.0)
    gamma = max(light_number(prim, "shadow:falloffGamma", 1.0), 0.0)
    color = _shadow_color(prim)
    if lit is None and casting is None and distance == math.inf and not any(color):
        return None
    return LightLinks(lit, casting, color, distance, falloff, gamma)


def _shadow_color(prim: Usd.Prim) -> tuple[float, float, float]:
    red, green, blue = (float(c) for c in light_value(prim, "shadow:color", BLACK))
    if all(math.isfinite(c) and c >= 0.0 for c in (red, green, blue)):
        return red, green, blue
    errors.warn_once(
        f"{prim.GetPath()}: inputs:shadow:color = {(red, green, blue)} is no color; black is used. Correct it."
    )
    return BLACK


def is_linked(prim: Usd.Prim) -> bool:
    """Whether a light has a light link or shadow link that differs from the default (everything)."""
    api = UsdLux.LightAPI(prim)
    return _is_authored(api.GetLightLinkCollectionAPI()) or _is_authored(api.GetShadowLinkCollectionAPI())


def _is_authored(collection: Usd.CollectionAPI) -> bool:
    """Whether a collection may exclude anything; reads attributes only, because most lights author nothing."""
    if collection.GetIncludeRootAttr().Get() is False or collection.GetMembershipExpressionAttr().HasAuthoredValue():
        return True
    if collection.GetExcludesRel().HasAuthoredTargets() or collection.GetModeAttr().Get() == "expression":
        return True
    return collection.GetExpansionRuleAttr().Get() == Usd.Tokens.explicitOnly  # the root does not count then


def _members(collection: Usd.CollectionAPI, paths: Sequence[str]) -> np.ndarray | None:
    """(paths,) bool: members of the collection; None if it contains all."""
    if not _is_authored(collection):
        return None
    query = collection.ComputeMembershipQuery()
    known: dict[str, bool] = {}
    for path in paths:
        if path not in known:
            known[path] = bool(query.IsPathIncluded(Sdf.Path(path)))
    members = np.array([known[path] for path in paths], bool)
    return None if members.all() else members

"""Camera attributes that images do not follow, and the warnings that say so."""

from collections.abc import Mapping
from typing import Any

from usdsdg.errors import warn_once

# Values at which UsdGeomCamera's exposure changes nothing.
_NEUTRAL = {
    "exposure": 0.0,
    "exposure:iso": 100.0,
    "exposure:time": 1.0,
    "exposure:fStop": 1.0,
    "exposure:responsivity": 1.0,
}


def warn_of_clipping_planes(path: object, values: Mapping[str, Any]) -> None:
    """Warn once of a camera whose attribute values have clipping planes, which cut nothing off."""
    if values.get("clippingPlanes"):
        warn_once(f"{path}: clippingPlanes cut nothing off: what is beyond them is seen and labeled. Hide those prims.")


def warn_of_exposure(path: object, values: Mapping[str, Any]) -> None:
    """Warn once of a camera whose attribute values have an exposure, which color images do not follow."""
    changed = [name for name, neutral in _NEUTRAL.items() if values.get(name, neutral) != neutral]
    if changed:
        warn_once(
            f"{path}: color images do not follow {', '.join(changed)}: they have the exposure of the settings below "
            "/rtx/post/tonemap, as in Omniverse. Set filmIso, cameraShutter or fNumber there."
        )

"""Whether a stage shows what is simulated, and a warning where it does not."""

from collections.abc import Sequence

from pxr import Sdf, Usd

from usdsdg.errors import warn_once


def is_strongest(stage: Usd.Stage, target: Usd.EditTarget) -> bool:
    """Return whether no layer with any prim is stronger than the edit target."""
    for layer in stage.GetLayerStack():
        if layer == target.GetLayer():
            return target.GetMapFunction().isIdentity
        if layer.rootPrims:
            return False
    return False


def warn_if_overridden(attribute: Usd.Attribute, spec: Sdf.AttributeSpec) -> None:
    """Warn where a stronger layer has an opinion about an attribute that is written."""
    stack = attribute.GetPropertyStack(Usd.TimeCode.Default())
    strongest = next((each for each in stack if each == spec or each.HasDefaultValue()), spec)
    if strongest != spec:
        warn_once(
            f"{attribute.GetPath()} is simulated but will not show: layer {strongest.layer.identifier} says otherwise "
            "and is stronger than the edit target. Remove that opinion or edit in that layer."
        )


def warn_if_deformed(bodies: Sequence[str]) -> None:
    """Warn of the paths of bodies whose shape changes as they turn."""
    if bodies:
        warn_once(
            f"{bodies[0]} is scaled unevenly by a prim above it, or by an op before its rotation: it is drawn with "
            "another shape as it turns, and collides with the first one. Scale it by an op after its rotation.",
            key="bodies that are deformed as they turn",
        )

"""Write what is inside triggers to the prims with PhysxTriggerStateAPI."""

from collections.abc import Collection, Iterable

from pxr import Sdf, Usd

from usdsdg.stage.physics.instances import prim_of, split_instance

_SCHEMA, _INSIDE = "PhysxTriggerStateAPI", "physxTrigger:triggeredCollisions"


class TriggerStates:
    """Writes the targets of a relationship, and restores those from before."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        # Targets from before by layer and spec path; None where there was no relationship.
        self._before: dict[tuple[Sdf.Layer, Sdf.Path], Sdf.PathListOp | None] = {}

    def write(self, triggers: Iterable[str], inside: Collection[tuple[str, str]]) -> None:
        """Write the colliders inside each of the triggers, by pairs of a trigger and a collider."""
        target = self._stage.GetEditTarget()
        for trigger in triggers:
            # The instance of an instancer has no prim to write to.
            prim = None if split_instance(trigger) else self._stage.GetPrimAtPath(trigger)
            if not prim or _SCHEMA not in prim.GetAppliedSchemas():
                continue
            path = target.MapToSpecPath(prim.GetPath()).AppendProperty(_INSIDE)
            self._keep(target.GetLayer(), path)
            relationship = prim.CreateRelationship(_INSIDE, custom=False)
            relationship.SetTargets(list(dict.fromkeys(prim_of(other) for each, other in inside if each == trigger)))

    def restore(self) -> None:
        """Restore the targets from before the first write."""
        for (layer, path), targets in self._before.items():
            spec = None if layer.expired else layer.GetRelationshipAtPath(path)
            if spec is None:
                continue
            if targets is None:
                spec.owner.RemoveProperty(spec)
            else:
                spec.SetInfo("targetPaths", targets)
        self._before.clear()

    def _keep(self, layer: Sdf.Layer, path: Sdf.Path) -> None:
        if (layer, path) not in self._before:
            spec = layer.GetRelationshipAtPath(path)
            self._before[layer, path] = spec.GetInfo("targetPaths") if spec else None

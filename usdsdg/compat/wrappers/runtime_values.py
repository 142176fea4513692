"""Values that scripts set in the running simulation alone, as with PhysX: stop puts back what the stage had."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pxr import Sdf, Usd

from usdsdg.listeners import weakly
from usdsdg.session import engines
from usdsdg.session.session import current
from usdsdg.session.timeline import get_timeline

_ABSENT = object()


class RuntimeValues:
    """Opinions of attributes from before a script set them for bodies and joints that are simulated."""

    def __init__(self) -> None:
        self._before: dict[tuple[Sdf.Layer, Sdf.Path], object] = {}
        get_timeline().subscribe(weakly(self._follow))

    def keep(self, prim: Usd.Prim, attribute: str) -> None:
        """Remember the opinion of an attribute in the layer that is edited, before it is set for the first time."""
        target = prim.GetStage().GetEditTarget()
        layer, path = target.GetLayer(), target.MapToSpecPath(prim.GetPath().AppendProperty(attribute))
        if (layer, path) not in self._before:
            spec = layer.GetAttributeAtPath(path)
            self._before[layer, path] = _ABSENT if spec is None else spec.default

    def _follow(self, event: str) -> None:
        if event == "stop":
            self._put_back()

    def _put_back(self) -> None:
        with Sdf.ChangeBlock():
            for (layer, path), value in self._before.items():
                spec = layer.GetAttributeAtPath(path) if layer else None
                if spec is None:
                    continue
                if value is _ABSENT:
                    spec.owner.RemoveProperty(spec)
                elif value is None:
                    spec.ClearDefaultValue()
                else:
                    spec.default = value
        self._before.clear()


def keep_until_stop(prims: Sequence[Usd.Prim], attributes: Iterable[str]) -> None:
    """Let what a script sets next act until physics stops, for those of the prims that are simulated."""
    physics, names = engines.physics_if_made(), list(attributes)
    if physics is None or not physics.is_playing:
        return
    simulated = set(physics.rigid_bodies)
    for prim in prims:
        if str(prim.GetPath()) in simulated:
            for name in names:
                current().runtime_values.keep(prim, name)


def keep_joint_until_stop(joint: Usd.Prim, *attributes: str) -> None:
    """Let what a script sets next on a joint act until physics stops, where it plays."""
    physics = engines.physics_if_made()
    if physics is not None and physics.is_playing:
        for name in attributes:
            current().runtime_values.keep(joint, name)

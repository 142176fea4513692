"""Which PhysicsScene simulates a body or collider: physics:simulationOwner."""

from collections.abc import Iterable

from pxr import Sdf, Usd

from usdsdg.errors import warn_once
from usdsdg_physics.parse.name_lists import listed


def has_scene(prim: Usd.Prim) -> bool:
    """Return whether a body or collider is simulated: it names no owner, or a PhysicsScene among them."""
    owners = _owners(prim)
    return not owners or any(map(_is_scene, map(prim.GetStage().GetPrimAtPath, owners)))


def warn_without_scene(paths: list[str]) -> None:
    """Warn of bodies and colliders that name owners that simulate nothing."""
    if paths:
        warn_once(
            "as in PhysX, bodies and colliders whose physics:simulationOwner names no active PhysicsScene are not "
            f"simulated: {listed(paths)}. Name the PhysicsScene of the stage, or clear the relationship."
        )


def warn_several_scenes(scenes: Iterable[Usd.Prim], bodies: Iterable[Usd.Prim]) -> None:
    """Warn where there are several PhysicsScenes, of which the first simulates all bodies."""
    paths = sorted(prim.GetPath() for prim in scenes)
    if len(paths) < 2:
        return
    others = sorted(str(prim.GetPath()) for prim in bodies if _owners(prim) and paths[0] not in _owners(prim))
    owned = f", also bodies of the others, which collide with all: {listed(others)}" if others else ""
    end = ", and let their bodies' physics:simulationOwner name the first" if others else ""
    warn_once(
        f"the stage has several PhysicsScenes ({listed(list(map(str, paths)))}); everything is simulated in the "
        f"first, {paths[0]}, with its gravity and steps{owned}. Remove the others{end}."
    )


def _owners(prim: Usd.Prim) -> list[Sdf.Path]:
    relation = prim.GetRelationship("physics:simulationOwner")
    return relation.GetTargets() if relation else []


def _is_scene(prim: Usd.Prim) -> bool:
    return bool(prim) and prim.IsActive() and prim.GetTypeName() == "PhysicsScene"

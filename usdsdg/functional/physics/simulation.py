"""Simulate, reset, and put bodies to sleep without a timeline."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pxr import Usd, UsdPhysics

from usdsdg.arguments.prims import prims_of
from usdsdg.errors import BadPrim, PhysicsError, Unsupported, warn_once
from usdsdg.functional.physics.scenes import create_physics_scene, scene_of
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.physics import scenes
from usdsdg.stage.physics.rest import still_moving


def simulate(time: float, step_dt: float | None = None, physics_scene: Any = None) -> None:
    """Simulate the rigid bodies of the stage for `time` seconds in steps of `step_dt` (default: the PhysicsScene's).

    The timeline stays where it is and nothing is rendered. Bodies stay where they end, also when the timeline is
    stopped later; while it plays they go on from there.

    Raises:
        PhysicsError: `time` or `step_dt` is not positive, or no whole number of steps makes a second.
        Unsupported: `physics_scene` is not the first PhysicsScene, which is the one that is simulated.
    """
    from usdsdg.session import engines

    if not float(time) > 0.0:
        raise PhysicsError(f"simulate: time is {time!r}; expected a positive number of seconds")
    stage = current_stage()
    first = scenes.physics_scene(stage)
    if physics_scene is not None and scene_of(physics_scene) != first:
        raise Unsupported(
            f"simulate: physics_scene is {scene_of(physics_scene).GetPath()}, but only the first scene, "
            f"{first and first.GetPath()}, is simulated; leave physics_scene out or remove the others"
        )
    with _stepping(stage, step_dt):
        engine = engines.physics()
        playing = engine.is_playing
        if not playing:
            engine.play()
        try:
            engine.advance(float(time))
        finally:
            if not playing:
                engine.stop(restore=False)


def simulate_until_rest(prims: Any = None, max_time: float = 10.0) -> list[str]:
    """Move rigid bodies that overlap apart, then simulate until they rest; Replicator has nothing like it.

    All bodies move, as in thick oil, so that they stay about where they were put. The timeline stays where it is and
    nothing is rendered; bodies stay where they end, with zero velocity where they rest.

    Args:
        prims: the rigid bodies to wait for; None: all.
        max_time: simulated seconds after which it ends in any case.

    Returns:
        The paths of the bodies that are still faster than 1 mm/s; a warning names them too.

    Raises:
        BadPrim: a prim is no rigid body.
        PhysicsError: `max_time` is not positive.
    """
    from usdsdg.session import engines

    if not float(max_time) > 0.0:
        raise PhysicsError(f"simulate_until_rest: max_time is {max_time!r}; expected a positive number of seconds")
    bodies = None if prims is None else [str(body.GetPath()) for body in _bodies(prims)]
    engine = engines.physics()
    playing = engine.is_playing
    if not playing:
        engine.play()
    try:
        moving = engine.settle(bodies, max_time=float(max_time))
    finally:
        if not playing:
            engine.stop(restore=False)
    if moving:
        warn_once(f"simulate_until_rest: {still_moving(moving, max_time)}")
    return moving


def reset(prims: Any = None) -> None:
    """Restore the poses and velocities that bodies had when the timeline began to play.

    Without `prims` all bodies restart; with `prims` only these, while the others go on.
    Kinematic bodies, which the simulation does not move, stay. Without a running simulation nothing happens.

    Raises:
        BadPrim: a prim is no rigid body.
    """
    from usdsdg.session import engines

    bodies = None if prims is None else _bodies(prims)
    engine = engines.physics_if_made()
    if engine is not None:
        engine.reset(None if bodies is None else [str(body.GetPath()) for body in bodies])


def put_to_sleep(prims: Any) -> None:
    """Zero the velocities of rigid bodies and hold them where they are, gravity or not, until something wakes them.

    A body wakes when another one that moves faster than its own `sleepThreshold` (1 cm/s by default) touches it, when a
    sleeping body that it touches wakes, when its pose, velocity or gravity switch is set, and by `wake_up`. Unlike
    PhysX's, it does not wake when a static collider below it is switched off. Kinematic bodies stay as they are.

    While the timeline is stopped, `physics:startsAsleep` is set: the bodies are asleep when the next simulation starts,
    be it with the timeline or by `simulate`.

    Raises:
        BadPrim: a prim is no rigid body.
    """
    _set_asleep(_bodies(prims), True)


def wake_up(prims: Any) -> None:
    """Let rigid bodies move again that are asleep or at rest; they start with velocity zero.

    While the timeline is stopped, `physics:startsAsleep` is cleared instead.

    Raises:
        BadPrim: a prim is no rigid body.
    """
    _set_asleep(_bodies(prims), False)


def _set_asleep(bodies: list[Usd.Prim], asleep: bool) -> None:
    from usdsdg.session import engines

    engine = engines.physics_if_made()
    if engine is not None and engine.is_playing:
        (engine.put_to_sleep if asleep else engine.wake_up)([str(body.GetPath()) for body in bodies])
        return
    for body in bodies:
        attribute = UsdPhysics.RigidBodyAPI(body).GetStartsAsleepAttr()
        if bool(attribute.Get()) != asleep:
            attribute.Set(asleep)


def _bodies(prims: Any) -> list[Usd.Prim]:
    """Return the prims of an argument, all of them rigid bodies."""
    found = prims_of(prims)
    for prim in found:
        if not prim.HasAPI(UsdPhysics.RigidBodyAPI):
            raise BadPrim(f"{prim.GetPath()} is no rigid body; make it one with functional.physics.apply_rigid_body")
    return found


@contextmanager
def _stepping(stage: Usd.Stage, step_dt: float | None) -> Iterator[None]:
    """Set the step rate of the simulated scene inside; in the session layer, so that it is not saved."""
    if step_dt is None:
        yield
        return
    if not float(step_dt) > 0.0 or abs(round(1.0 / step_dt) * step_dt - 1.0) > 1e-3:
        raise PhysicsError(
            f"simulate: step_dt is {step_dt!r}; expected 1 / (a whole number of steps per second), such as 1 / 120"
        )
    scene = scenes.physics_scene(stage) or create_physics_scene()
    layer, path = stage.GetSessionLayer(), scene.GetPath().AppendProperty(scenes.STEP_RATE)
    known = layer.GetAttributeAtPath(path)
    before = known.default if known else None
    with Usd.EditContext(stage, layer):
        scenes.step_rate_attribute(scene).Set(round(1.0 / step_dt))
    try:
        yield
    finally:
        spec = layer.GetAttributeAtPath(path)
        if before is not None:
            spec.default = before
        else:
            owner = spec.owner
            owner.RemoveProperty(spec)
            layer.ScheduleRemoveIfInert(owner)

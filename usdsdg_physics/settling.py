"""Settled start: move bodies that overlap apart, then let all come to rest, with damping and within a time."""

from collections.abc import Collection, Sequence

import numpy as np
from pxr import Usd

from usdsdg_physics.play import PlaySession
from usdsdg_physics.world.world import World

MAX_SEPARATION_STEPS = 240
SEPARATED_MOTION = 1e-4  # m, of the body that moves farthest in a step
# As in thick oil: nothing falls faster than 1.6 m/s, and what rolls stops after a few decimeters.
DAMPING = 6.0  # 1/s
REST_TIME = 0.25  # s that all bodies have to rest for
WEIGHTLESS = (0.0, 0.0, 0.0)


def settle(session: PlaySession, bodies: Collection[str] | None, max_time: float, time: Usd.TimeCode) -> list[str]:
    """Move bodies that overlap apart, and simulate until `bodies` rest (None: all) or for `max_time` seconds.

    Returns:
        The paths of those that still move, in the order of the stage.
    """
    if not session.scene.bodies:
        return []
    dt, gravity = 1.0 / session.steps_per_second(), tuple(session.current_world().gravity.tolist())
    try:
        for _ in range(MAX_SEPARATION_STEPS):
            if not _separate(session, dt, time):
                break
        moving = _come_to_rest(session, bodies, max_time, dt, time, gravity)
    finally:
        world = session.current_world()
        # Gravity would wake what rests.
        if not np.array_equal(world.gravity, gravity):
            world.set_gravity(gravity)
        world.set_least_damping(session.scene, 0.0)
    session.write()
    return moving


def _separate(session: PlaySession, dt: float, time: Usd.TimeCode) -> bool:
    """Take a step without gravity that moves bodies out of each other and leaves them no speed.

    Returns:
        Whether a body moved, or the step has to be repeated with larger buffers.
    """
    world = _prepared_world(session, WEIGHTLESS)
    world.stop_bodies()
    before = world.poses()[:, :3]
    session.step(dt, time, write=False)
    moved = np.linalg.norm(world.poses()[:, :3] - before, axis=1).max()
    world.stop_bodies()
    return bool(moved > SEPARATED_MOTION) or world.contacts_overflowed


def _come_to_rest(
    session: PlaySession,
    bodies: Collection[str] | None,
    max_time: float,
    dt: float,
    time: Usd.TimeCode,
    gravity: Sequence[float],
) -> list[str]:
    resting, moving = 0.0, []
    for _ in range(max(1, round(max_time / dt))):
        world = _prepared_world(session, gravity)
        session.step(dt, time, write=False)
        moving = [path for path in world.moving() if bodies is None or path in bodies]
        resting = 0.0 if moving else resting + dt
        if resting >= REST_TIME:
            break
    return moving


def _prepared_world(session: PlaySession, gravity: Sequence[float]) -> World:
    """Return the world of the session, which a step may have built anew, with this gravity [m/s²] and damping."""
    world = session.current_world()
    if not np.array_equal(world.gravity, gravity):
        world.set_gravity(gravity)
    world.set_least_damping(session.scene, DAMPING)
    return world

"""How fast bodies swing about their joints, which bounds the length of substeps."""

# Newton declares the arrays of models optional; after `finalize` all are there.
# pyright: reportOptionalMemberAccess=false

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.errors import warn_once
from usdsdg.stage.poses.rotations import rotated

if TYPE_CHECKING:
    import newton

# The solver integrates joint coordinates with the forces at the begin of a substep. Where an arm turns by more than
# this [rad] in one, chains gain energy from swing to swing: ten links that fall from the horizontal gain 1 % of what
# they have above zero, 4 % at twice as much, and fly apart in four substeps of a step, however fast they are.
MAX_TURN = 0.025
MAX_FACTOR, MAX_TOP_FACTOR = 16, 64  # so many substeps in place of one, at most; the second for tops
SHORTEST_ARM = 1e-6  # m
# Newton keeps the energy of the spin about a center of mass, but not what a ball joint far from that adds, on which a
# spinning top falls or climbs: from this ratio of mass * arm² and the largest inertia on, arms must turn about
# themselves by no more than twice `MAX_TURN`, too. From twice that on the spin itself grows without end.
FAR_ARM = 0.3
# Substeps do not become longer before so many seconds without the need for shorter ones: where they change twice in a
# swing, it loses energy, a rod of a meter that swings by 115 degrees 3 % of it in ten seconds.
CALM = 1.5
SPIN_SHARE = 0.5
GROWS = 2.0
TRIPLE = 3


class SwingingJoints:
    """The arms from joints to the centers of mass of their bodies; wheels, which turn about these, have none."""

    def __init__(self, model: newton.Model, paths: Sequence[str]) -> None:
        """`paths` are those of the bodies; others, which close loops of joints, come after these."""
        import newton

        self._paths = paths

        names = ("type", "parent", "child", "X_p", "X_c")
        joint = {name: getattr(model, f"joint_{name}").numpy() for name in names}
        centers = model.body_com.numpy().astype(np.float64).reshape(-1, 3)
        held = np.flatnonzero(joint["type"] != int(newton.JointType.FREE))
        on_bodies = held[joint["parent"][held] >= 0]
        self._bodies = np.concatenate([joint["child"][held], joint["parent"][on_bodies]]).astype(int)
        arms = np.concatenate([joint["X_c"][held, :3], joint["X_p"][on_bodies, :3]]) - centers[self._bodies]
        lengths = np.linalg.norm(arms, axis=1)
        long = lengths > SHORTEST_ARM
        inertia = np.linalg.eigvalsh(model.body_inertia.numpy().astype(np.float64).reshape(-1, 3, 3))[:, 2]
        mass = model.body_mass.numpy().astype(np.float64)
        is_ball = joint["type"] == int(newton.JointType.BALL)
        spins = np.concatenate([is_ball[held], is_ball[on_bodies]])
        spins &= mass[self._bodies] * lengths**2 > FAR_ARM * inertia[self._bodies]
        self._tops = np.unique(self._bodies[long & spins])
        self._bodies, self._arms = self._bodies[long], arms[long] / lengths[long, None]
        # Where two of three axes nearly coincide, they turn faster than their body.
        turning = model.joint_dof_dim.numpy().reshape(-1, 2)[:, 1]
        triple = np.flatnonzero((joint["type"] == int(newton.JointType.D6)) & (turning == TRIPLE))
        ends = model.joint_qd_start.numpy()[triple + 1]
        self.triple_axes = (ends[:, None] - np.arange(1, TRIPLE + 1)).ravel()  # in joint_qd
        self._latest, self._calm = 1, 0.0  # factor of the latest step, and the seconds since it was needed

    def __bool__(self) -> bool:
        return len(self._bodies) + len(self.triple_axes) > 0

    def factor(self, dt: float, substep: float, poses: np.ndarray, velocities: np.ndarray, speeds: np.ndarray) -> int:
        """Return how many substeps a step of `dt` seconds takes in place of one of `substep`: a power of two.

        poses, velocities: (N, 7) and (N, 6) of all bodies; speeds: (A,) of `triple_axes` [rad/s].
        """
        arms = rotated(poses[self._bodies, 3:].astype(np.float64), self._arms)
        rates = np.linalg.norm(np.cross(velocities[self._bodies, 3:], arms), axis=1)
        spins = np.nan_to_num(SPIN_SHARE * np.linalg.norm(velocities[self._tops, 3:], axis=1))
        swing = np.nan_to_num(np.concatenate([rates, np.abs(speeds)])).max(initial=0.0)
        spin = spins.max(initial=0.0)
        factor = max(_power(swing * substep, MAX_FACTOR), _power(spin * substep, MAX_TOP_FACTOR))
        if spin * substep > GROWS * factor * MAX_TURN:
            body = int(self._tops[spins.argmax()])
            name = self._paths[body] if body < len(self._paths) else "a body of a loop of joints"
            warn_once(
                f"{name} turns at {spin / SPIN_SHARE:.0f} rad/s on a ball joint far from its center of "
                "mass: steps that are this long let it gain energy. Raise physxScene:timeStepsPerSecond or lower "
                "physxRigidBody:maxAngularVelocity.",
                key="tops that turn too fast",
            )
        self._calm = 0.0 if factor >= self._latest else self._calm + dt
        if factor > self._latest or self._calm > CALM:
            self._latest, self._calm = factor, 0.0
        return self._latest


def _power(turn: float, most: int) -> int:
    """Return the least power of two in which parts of a turn [rad] are no larger than `MAX_TURN`, or the most."""
    factor = 1
    while factor < most and turn > factor * MAX_TURN:
        factor *= 2
    return factor

"""What a world that replaces another one, because its scene was edited, goes on with beside the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.world.body_forces import BodyForces
    from usdsdg_physics.world.joints import Joints

AxisKey = tuple[str, str]  # path of a joint, name of its axis


@dataclass(frozen=True)
class Continued:
    """Of bodies and joints, by path; those of which the new world knows nothing do not matter."""

    positions: Mapping[AxisKey, float]  # m, rad: poses of bodies tell angles but for whole turns
    # What a script pushes with during the next step.
    wrenches: Mapping[str, np.ndarray]  # (6,) N, and N m about the center of mass
    efforts: Mapping[AxisKey, float]  # N, N m

    def pushed(self, body_index: Mapping[str, int]) -> tuple[list[int], np.ndarray]:
        """Return the indices (n,) of the bodies that are pushed, and their wrenches (n, 6)."""
        pushed = {body_index[path]: wrench for path, wrench in self.wrenches.items() if path in body_index}
        return list(pushed), np.array(list(pushed.values())).reshape(-1, 6)


NOTHING = Continued({}, {}, {})


def continued_of(bodies: Sequence[str], pushes: BodyForces, joints: Joints | None, state: newton.State) -> Continued:
    """Return what a world has, of which these are the paths of the bodies."""
    wrenches = {bodies[row]: wrench for row, wrench in pushes.wrenches().items()}
    if joints is None:
        return Continued({}, wrenches, {})
    return Continued(joints.positions_by_axis(state), wrenches, joints.efforts())

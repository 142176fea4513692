"""What contact sensors read: how strongly a body is touched, and where."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.sensors.physics.samples import Samples
from usdsdg.compat.isaacsim.sensors.physics.sensor_prims import body_above
from usdsdg.compat.wrappers import contacts, poses
from usdsdg.session import engines


@dataclass(frozen=True)
class RawContact:
    """A point where a body is touched, in the world; vectors are on body 0."""

    body0: str
    body1: str
    position: tuple[float, float, float]
    normal: tuple[float, float, float]
    impulse: tuple[float, float, float]


@dataclass(frozen=True)
class ContactReading:
    """What a contact sensor read; invalid before the first step."""

    is_valid: bool = False
    time: float = 0.0
    in_contact: bool = False
    value: float = 0.0  # force in the stage's units
    contacts: tuple[RawContact, ...] = ()


class ContactReadings:
    """Reads the contacts of the rigid body above a sensor after every physics step."""

    def __init__(self, prim: Usd.Prim) -> None:
        """Begin to read.

        Raises:
            BadPrim: there is no rigid body above the sensor.
        """
        self._prim, self._body = prim, str(body_above(prim).GetPath())
        self._samples: Samples[ContactReading] = Samples(prim)
        contacts.report_contacts([body_above(prim)])
        self._end = simulation().on_step(self._step, before=False)

    def reading(self, *, latest: bool = False) -> ContactReading:
        """Return the reading at the time when the sensor measured last, or with `latest` after the latest step."""
        samples = self._samples
        samples.begin()
        if not samples.enabled or not samples.all:
            return ContactReading()
        if latest or samples.is_every_step:
            return samples.all[0]
        if samples.between is None:
            return ContactReading()
        part, (newer, *older) = samples.between
        return replace(newer if part >= 0.5 or not older else older[0], time=samples.time)

    def _step(self, dt: float, _context: object) -> None:
        if not self._prim.IsValid():
            self._end()
        elif self._samples.enabled:
            self._samples.add(self._read(dt), dt)

    def _read(self, dt: float) -> ContactReading:
        low, high = self._prim.GetAttribute("threshold").Get()
        radius = float(self._prim.GetAttribute("radius").Get())
        place, total, found = poses.world_poses([self._prim])[0][0], np.zeros(3), []
        for event in engines.physics().contacts:
            if self._body not in (event.body0, event.body1):
                continue
            sign = 1.0 if event.body0 == self._body else -1.0
            for point in event.points:
                if radius > 0.0 and np.linalg.norm(place - np.array(point.position)) >= radius:
                    continue
                # As in PhysX, friction is not among the impulses of contacts.
                normal = np.array(point.normal)
                impulse = normal * (normal @ np.array(point.impulse))
                total += sign * impulse
                x, y, z = impulse.tolist()
                found.append(RawContact(event.body0, event.body1, point.position, point.normal, (x, y, z)))
        force = min(float(np.linalg.norm(total)) / dt, float(high))
        touched = bool(found) and force >= low
        return ContactReading(True, simulation().time, touched, force if touched else 0.0, tuple(found))

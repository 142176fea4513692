"""Contacts of the latest physics step as arrays, by the prims that feel them and the prims that they touch.

Forces are impulses of the step on the prim that feels them, in the stage's units of mass and length, divided by a time.
Those along the normals are contact forces, those across them friction, as in PhysX.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from pxr import Usd

from usdsdg.compat.physics_schema_tools import sdfPathToInt
from usdsdg.compat.wrappers import bodies
from usdsdg.compat.wrappers.prim_paths import matching_paths, prim_of
from usdsdg.errors import BadPrim, BadValue, counted, warn_once
from usdsdg.session import engines
from usdsdg.stage.schemas import physx

if TYPE_CHECKING:
    from usdsdg_physics.scene.events import ContactPoint

    _Side: TypeAlias = tuple[str, str]  # the body and the collider of one side of a contact


class Contacts(NamedTuple):
    """Points where sensors are touched, sorted; the first four have `max_count` rows, zeros where there are no more."""

    force: np.ndarray  # (max, 1) along the normal
    position: np.ndarray  # (max, 3) world [stage units]
    normal: np.ndarray  # (max, 3) toward the sensor
    separation: np.ndarray  # (max, 1) [stage units], negative where they overlap
    count: np.ndarray  # (N, F) how many rows a sensor has with each partner; (N,) with any
    start: np.ndarray  # the first of these rows, likewise


class Friction(NamedTuple):
    """Friction in the points of `Contacts`."""

    force: np.ndarray  # (max, 3)
    position: np.ndarray  # (max, 3)
    count: np.ndarray  # (N, F)
    start: np.ndarray  # (N, F)


@dataclass(frozen=True)
class _Points:
    """A row for each contact point of each sensor."""

    sensor: np.ndarray  # (P,) row of the sensor
    partner: np.ndarray  # (P, F) whether it touches that partner
    other: np.ndarray  # (P,) integer of the path of the body that it touches
    position: np.ndarray  # (P, 3)
    normal: np.ndarray  # (P, 3) toward the sensor
    force: np.ndarray  # (P,) impulse on the sensor along the normal
    friction: np.ndarray  # (P, 3) impulse on the sensor across the normal
    separation: np.ndarray  # (P,)


class ContactSensors:
    """Prims that feel contacts: rigid bodies with all their colliders, colliders, or prims above static colliders."""

    def __init__(self, sensors: Sequence[str], partners: Sequence[Sequence[str]], max_count: int = 0) -> None:
        """`partners` (N, F) are the paths whose contacts each sensor tells apart."""
        self._sensors, self._partners, self._max_count = sensors, partners, max_count
        self.num_partners = len(partners[0]) if partners else 0
        for path in sensors:
            if not _is_reported(prim_of(path)):
                warn_once(
                    f"{path} has no PhysxContactReportAPI, so only contacts that the other prim reports are counted. "
                    "Apply the schema with a threshold of 0, as prepare_contact_sensors=True does."
                )

    def net_forces(self, dt: float = 1.0) -> np.ndarray:
        """Return the sums (N, 3) of the contact forces."""
        points = self._points()
        found = np.zeros((len(self._sensors), 3))
        np.add.at(found, points.sensor, points.force[:, None] * points.normal)
        return (found / dt).astype(np.float32)

    def force_matrix(self, dt: float = 1.0) -> np.ndarray:
        """Return the sums (N, F, 3) of the contact forces with each partner."""
        points = self._points()
        found = np.zeros((len(self._sensors), self.num_partners, 3))
        rows, columns = np.nonzero(points.partner)
        np.add.at(found, (points.sensor[rows], columns), (points.force[:, None] * points.normal)[rows])
        return (found / dt).astype(np.float32)

    def contacts(self, dt: float = 1.0) -> Contacts:
        """Return the contacts with partners, pair by pair."""
        points = self._points()
        rows, count, start = self._by_partner(points)
        return self._contacts(points, rows, count, start, dt)

    def friction(self, dt: float = 1.0) -> Friction:
        """Return the friction in the contacts with partners, pair by pair."""
        points = self._points()
        rows, count, start = self._by_partner(points)
        return Friction(self._filled(points.friction[rows] / dt), self._filled(points.position[rows]), count, start)

    def all_contacts(self, dt: float = 1.0) -> tuple[Contacts, np.ndarray]:
        """Return the contacts with anything, and integers (max,) of the paths that are touched: `intToSdfPath`."""
        points = self._points()
        rows, count, start = self._sorted(points.sensor, len(self._sensors))
        others = np.zeros(self._max_count, np.uint64)
        others[: len(rows)] = points.other[rows]
        return self._contacts(points, rows, count, start, dt), others

    def _contacts(self, points: _Points, rows: np.ndarray, count: np.ndarray, start: np.ndarray, dt: float) -> Contacts:
        return Contacts(
            self._filled(points.force[rows, None] / dt),
            self._filled(points.position[rows]),
            self._filled(points.normal[rows]),
            self._filled(points.separation[rows, None]),
            count,
            start,
        )

    def _filled(self, rows: np.ndarray) -> np.ndarray:
        """Return float32 rows with zeros below, `max_count` in all."""
        filled = np.zeros((self._max_count, rows.shape[1]), np.float32)
        filled[: len(rows)] = rows
        return filled

    def _by_partner(self, points: _Points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return rows of points by pair of sensor and partner, and how many and from where (N, F)."""
        shape = len(self._sensors), self.num_partners
        rows, columns = np.nonzero(points.partner)
        order, count, start = self._sorted(points.sensor[rows] * self.num_partners + columns, shape[0] * shape[1])
        return rows[order], count.reshape(shape), start.reshape(shape)

    def _sorted(self, keys: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the order of keys below `size` as far as there is room, and how many and from where for each key."""
        order = np.argsort(keys, kind="stable")
        if len(order) > self._max_count:
            warn_once(
                f"{self._sensors[0]}: there are {len(order)} contact points, of which max_contact_count="
                f"{self._max_count} are returned; give a larger number",
                key=f"max_contact_count {self._sensors[0]}",
            )
            order = order[: self._max_count]
        count = np.bincount(keys[order], minlength=size)
        return order, count.astype(np.uint32), (np.cumsum(count) - count).astype(np.uint32)

    def _points(self) -> _Points:
        """Return the points of the latest step."""
        moving = set(engines.physics().rigid_bodies)
        numbers, partner, sensor, other = [], [], [], []
        for row, touched, points, sign in self._touches(moving):
            sensor += [row] * len(points)
            other += [sdfPathToInt(touched[0])] * len(points)
            partner += [[_is_part(touched, path, moving) for path in self._partners[row]]] * len(points)
            numbers += [(*p.position, *p.normal, *p.impulse, p.separation, sign) for p in points]
        values = np.array(numbers, np.float64).reshape(-1, 11)
        normal, impulse = values[:, 3:6] * values[:, 10:], values[:, 6:9] * values[:, 10:]
        force = np.einsum("pi,pi->p", normal, impulse)
        return _Points(
            np.array(sensor, int),
            np.array(partner, bool).reshape(len(sensor), self.num_partners),
            np.array(other, np.uint64),
            values[:, :3],
            normal,
            force,
            impulse - force[:, None] * normal,
            values[:, 9],
        )

    def _touches(self, moving: set[str]) -> Iterator[tuple[int, _Side, tuple[ContactPoint, ...], float]]:
        """Yield for each contact of a sensor its row, what it touches, the points, and the sign of their vectors."""
        whole: defaultdict[str, list[int]] = defaultdict(list)
        parts: list[tuple[int, str]] = []
        for row, path in enumerate(self._sensors):
            whole[path].append(row) if path in moving else parts.append((row, path))
        for event in engines.physics().contacts:
            first, second = (event.body0, event.collider0), (event.body1, event.collider1)
            for own, touched, sign in ((first, second, 1.0), (second, first, -1.0)):
                rows = whole.get(own[0], []) + [row for row, path in parts if _is_part(own, path, moving)]
                for row in rows:
                    yield row, touched, event.points, sign


def report_contacts(prims: Iterable[Usd.Prim], threshold: float = 0.0) -> None:
    """Let physics report contacts of prims that push with at least `threshold` [stage units of force]."""
    each = list(prims)
    bodies.write(each, physx.PhysxContactReportAPI, "Threshold", [float(threshold)] * len(each))


def stop_reporting(prims: Iterable[Usd.Prim]) -> None:
    """Remove the schema with which prims report contacts, where it is applied."""
    for prim in prims:
        if prim.HasAPI(physx.PhysxContactReportAPI):
            prim.RemoveAPI(physx.PhysxContactReportAPI)


def reporting(prims: Sequence[Usd.Prim]) -> np.ndarray:
    """Return which prims have the schema with which they report contacts (N, 1)."""
    return np.array([prim.HasAPI(physx.PhysxContactReportAPI) for prim in prims], bool).reshape(-1, 1)


def partners_of(groups: Sequence[Sequence[str]], filters: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return the paths (N, F) that filters stand for, one row per sensor.

    Args:
        groups: The paths of the sensors of each group.
        filters: The paths or patterns of each group; one that matches several prims has one for each sensor.

    Raises:
        BadPrim: a filter matches no prim.
        BadValue: one matches several prims, but not as many as the group has sensors, or the groups have different
            numbers of filters.
    """
    if len({len(each) for each in filters}) > 1 or len(filters) != len(groups):
        raise BadValue(f"give each of the {len(groups)} groups of prims the same number of contact filters")
    return [row for group, patterns in zip(groups, filters) for row in _partners_of_group(group, patterns)]


def _partners_of_group(sensors: Sequence[str], patterns: Sequence[str]) -> list[list[str]]:
    columns = []
    for pattern in patterns:
        found = matching_paths(pattern)
        if not found:
            raise BadPrim(f"no prim matches the contact filter {pattern}")
        if len(found) not in (1, len(sensors)):
            raise BadValue(
                f"the contact filter {pattern} matches {len(found)} prims; it must match one, or one for each of the "
                f"{counted(len(sensors), 'prim')} whose contacts are tracked"
            )
        columns.append(found * len(sensors) if len(found) == 1 else found)
    return [list(row) for row in zip(*columns)] if columns else [[] for _ in sensors]


def _is_part(side: _Side, path: str, moving: set[str]) -> bool:
    """Return whether a side of a contact belongs to a path: to that body itself, else to what is at or below it."""
    body, collider = side
    return body == path if path in moving else f"{collider}/".startswith(f"{path}/")


def _is_reported(prim: Usd.Prim) -> bool:
    """Return whether contacts of a prim are reported by it, by what is above it or by what is below it."""
    above = prim
    while above:
        if above.HasAPI(physx.PhysxContactReportAPI):
            return True
        above = above.GetParent()
    return any(each.HasAPI(physx.PhysxContactReportAPI) for each in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))

"""Contact events of steps: which pairs of colliders began to touch, still touch and no longer touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from usdsdg.stage.paths import at_or_below
from usdsdg.stage.physics.instances import whole
from usdsdg_physics.corrections.contacts.contact_report import ContactRows
from usdsdg_physics.scene.events import ContactEvent, ContactPoint
from usdsdg_physics.scene.records import ContactReportSpec, Scene

_Pair = tuple[str, str]  # colliders in the order of their paths


def reports_of(scene: Scene) -> dict[str, list[ContactReportSpec]]:
    """Return the PhysxContactReportAPIs on colliders, on their bodies and above them, by collider that has any."""
    found = {}
    for path, collider in scene.colliders.items():
        own = whole(path)
        above = [own[:end] for end, letter in enumerate(own) if letter == "/" and end] + [own]
        specs = [scene.reports[each] for each in dict.fromkeys([collider.body, *above]) if each in scene.reports]
        if specs:
            found[path] = specs
    return found


class ContactEvents:
    """Compares the contacts of each step with those of the step before, on one scene."""

    def __init__(
        self, scene: Scene, shape_index: Mapping[str, int], *, meters: float, kilograms: float, touching: set[_Pair]
    ) -> None:
        """`touching` are the pairs that touched in the step before; `meters` and `kilograms` the stage's units."""
        self._scene, self._meters, self._kilograms = scene, meters, kilograms
        self._reports = reports_of(scene)
        self._paths = {index: whole(path) for path, index in shape_index.items()}
        self.touching = touching

    def of_step(self, substeps: Sequence[ContactRows], dt: float) -> list[ContactEvent]:
        """Return the events of a step of `dt` seconds, pairs in the order of their paths."""
        points = {pair: found for pair, found in self._points(substeps).items() if self._is_reported(pair, found, dt)}
        lost = [self._event("lost", pair, []) for pair in sorted(self.touching - points.keys())]
        found = [
            self._event("persist" if pair in self.touching else "found", pair, points[pair]) for pair in sorted(points)
        ]
        self.touching = set(points)
        return lost + found

    def _points(self, substeps: Sequence[ContactRows]) -> dict[_Pair, list[ContactPoint]]:
        """Return the points of each pair in the last substep in which it touched, with the impulse of all substeps."""
        latest: dict[_Pair, list[ContactPoint]] = {}
        total: dict[_Pair, np.ndarray] = {}
        for rows in substeps:
            here: dict[_Pair, list[ContactPoint]] = {}
            for row in np.flatnonzero((rows.separation <= 0.0) | rows.impulse.any(axis=1)).tolist():
                pair, point = self._point(rows, row)
                here.setdefault(pair, []).append(point)
            for pair, points in here.items():
                impulse = np.sum([point.impulse for point in points], axis=0)
                total[pair] = total.get(pair, np.zeros(3)) + impulse
            latest |= here
        return {pair: _with_impulse(points, total[pair]) for pair, points in latest.items()}

    def _point(self, rows: ContactRows, row: int) -> tuple[_Pair, ContactPoint]:
        first, second = (self._paths[index] for index in rows.shapes[row].tolist())
        # Rows have the normal from the first to the second collider, events the other way.
        sign = -1.0 if first < second else 1.0
        newton_seconds = self._kilograms * self._meters
        point = ContactPoint(
            _triple(rows.position[row] / self._meters),
            _triple(sign * rows.normal[row]),
            _triple(-sign * rows.impulse[row] / newton_seconds),
            float(rows.separation[row]) / self._meters,
        )
        return (first, second) if first < second else (second, first), point

    def _is_reported(self, pair: _Pair, points: Sequence[ContactPoint], dt: float) -> bool:
        force = np.linalg.norm(np.sum([point.impulse for point in points], axis=0)) / dt
        newtons = float(force) * self._kilograms * self._meters
        for own, other in (pair, pair[::-1]):
            for spec in self._reports.get(own, ()):
                partner = not spec.partners or any(at_or_below(other, path) for path in spec.partners)
                if partner and newtons >= spec.threshold:
                    return True
        return False

    def _event(self, kind: str, pair: _Pair, points: Sequence[ContactPoint]) -> ContactEvent:
        first, second = (self._scene.colliders.get(path) for path in pair)
        return ContactEvent(
            kind,  # pyright: ignore[reportArgumentType]
            (first.body if first else "") or pair[0],
            (second.body if second else "") or pair[1],
            *pair,
            first.material.path if first else "",
            second.material.path if second else "",
            tuple(points),
        )


def _with_impulse(points: Sequence[ContactPoint], total: np.ndarray) -> list[ContactPoint]:
    """Return the points with the impulse of earlier substeps spread over them."""
    missing = (total - np.sum([point.impulse for point in points], axis=0)) / len(points)
    return [
        ContactPoint(point.position, point.normal, _triple(np.asarray(point.impulse) + missing), point.separation)
        for point in points
    ]


def _triple(vector: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(component) for component in vector)
    return x, y, z

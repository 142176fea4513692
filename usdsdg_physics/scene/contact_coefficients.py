"""Friction and restitution of each pair of materials, for a solver that knows the mean of two shapes' coefficients.

A contact between shapes of which that mean is wrong is given to stand-ins: shapes of the same bodies that collide with
nothing and have other coefficients. Where two materials are not averaged, both stand-ins have the combined value;
where surfaces stick, each has its own static friction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from usdsdg_physics.scene.records import COMBINE_MODES, CombineMode, Material, Scene

SLIDING, STICKING = 0, 1
# With more, building the model takes longer than the difference is worth.
MAX_STAND_INS = 20000

_Pair = tuple[float, float]  # friction, restitution


@dataclass(frozen=True)
class StandIn:
    """A shape that collides with nothing."""

    body: str  # STATIC for the world
    friction: float
    restitution: float


@dataclass(frozen=True)
class CoefficientTable:
    """Which stand-ins a contact is given to."""

    material: dict[str, int]  # row of each collider's material
    # (M, M, 2): value for a shape of the first material against the second that slides or sticks; -1: its own.
    value: np.ndarray
    static_friction: np.ndarray  # (M, M) of two materials together
    stand_ins: list[StandIn]
    stand_in: dict[tuple[str, int], int]  # by body and value: row of `stand_ins`


def coefficient_table(scene: Scene) -> CoefficientTable | None:
    """Return the table of a scene; None where the mean of two coefficients is right for every pair."""
    materials = list(dict.fromkeys(map(_coefficients, (c.material for c in scene.colliders.values()))))
    if all(m.friction_mode == m.restitution_mode == "average" and m.friction == m.static_friction for m in materials):
        return None
    values: dict[_Pair, int] = {}
    value = np.full((len(materials), len(materials), 2), -1, np.int32)
    for i, own in enumerate(materials):
        for j, other in enumerate(materials):
            for state in (SLIDING, STICKING):
                pair = _pair(own, other, state)
                if pair != (own.friction, own.restitution):
                    value[i, j, state] = values.setdefault(pair, len(values))
    material = {path: materials.index(_coefficients(c.material)) for path, c in scene.colliders.items()}
    needed = [sorted(set(value[i].ravel().tolist()) - {-1}) for i in range(len(materials))]
    keys = dict.fromkeys((c.body, each) for path, c in scene.colliders.items() for each in needed[material[path]])
    coefficients = list(values)
    static = [[_static_friction(own, other) for other in materials] for own in materials]
    return CoefficientTable(
        material,
        value,
        np.array(static, np.float32),
        [StandIn(body, *coefficients[each]) for body, each in keys],
        {key: row for row, key in enumerate(keys)},
    )


def _coefficients(material: Material) -> Material:
    """Return a material that is equal to all with the same coefficients."""
    return Material(
        friction=material.friction,
        restitution=material.restitution,
        static_friction=material.static_friction,
        friction_mode=material.friction_mode,
        restitution_mode=material.restitution_mode,
    )


def _pair(own: Material, other: Material, state: int) -> _Pair:
    """Return the coefficients that a shape needs, so that their mean with those of the other shape is right."""
    frictions = (own.friction, other.friction)
    if state == STICKING:
        frictions = (own.static_friction, other.static_friction)
    friction_mode = _stronger(own.friction_mode, other.friction_mode)
    restitution_mode = _stronger(own.restitution_mode, other.restitution_mode)
    return (
        _COMBINED[friction_mode](*frictions),
        _COMBINED[restitution_mode](own.restitution, other.restitution),
    )


def _static_friction(own: Material, other: Material) -> float:
    return (_pair(own, other, STICKING)[0] + _pair(other, own, STICKING)[0]) / 2.0


def _stronger(a: CombineMode, b: CombineMode) -> CombineMode:
    return COMBINE_MODES[max(COMBINE_MODES.index(a), COMBINE_MODES.index(b))]


_COMBINED: dict[CombineMode, Callable[[float, float], float]] = {
    "average": lambda own, _other: own,
    "min": min,
    "multiply": lambda own, other: own * other,
    "max": max,
}

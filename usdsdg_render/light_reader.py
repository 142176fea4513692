"""All lights of a stage but its domes: rows of `scene.LIGHT`, and the patterns and rules that they point to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pxr import Usd

from .instancer import source_path
from .light_patterns import read_pattern
from .light_rules import is_linked, read_rules
from .lights import read_light
from .scene import LIGHT, LightPattern, LightRules, Scene


class Lights(NamedTuple):
    """What `Scene` holds of lights."""

    table: np.ndarray
    patterns: list[LightPattern]
    rules: list[LightRules]
    linked: bool  # some light's rules depend on which instances there are

    def write(self, scene: Scene) -> None:
        """Put them into a scene, and say so if they differ from what it has."""
        same = self.table.tobytes() == scene.lights.tobytes()
        same = same and list(map(id, self.patterns)) == list(map(id, scene.light_patterns))
        if same and list(map(_content, self.rules)) == list(map(_content, scene.light_rules)):
            return
        scene.lights, scene.light_patterns, scene.light_rules = self.table, self.patterns, self.rules
        scene.touch("lights")


def read_lights(
    prims: Sequence[Usd.Prim], local_to_world: Sequence[np.ndarray], metres_per_unit: float, instances: Sequence[str]
) -> Lights:
    """Read the lights at `prims`; `instances` are the paths of `scene.Instances`."""
    rows, rules = [], []
    patterns: dict[int, tuple[int, LightPattern]] = {}
    sources: list[str] | None = None
    linked = False
    for prim, matrix in zip(prims, local_to_world):
        row = read_light(prim, matrix, metres_per_unit)
        if row is None:
            continue
        pattern = read_pattern(prim)
        if pattern is not None:
            row["pattern"] = patterns.setdefault(id(pattern), (len(patterns), pattern))[0]
        if is_linked(prim):
            linked = True
            sources = sources or [source_path(path) for path in instances]
        rule = read_rules(prim, sources or ())
        if rule is not None:
            row["rules"] = len(rules)
            rules.append(rule)
        rows.append(row)
    return Lights(np.array(rows, LIGHT), [pattern for _, pattern in patterns.values()], rules, linked)


def _content(rules: LightRules) -> tuple:
    members = (None if m is None else m.tobytes() for m in (rules.lit, rules.casting))
    return *members, rules.shadow_color, rules.shadow_distance, rules.shadow_falloff, rules.shadow_gamma

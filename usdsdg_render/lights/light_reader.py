"""All lights of a stage but its domes: rows of `scene.LIGHT`, and the patterns and rules that they point to."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd

from usdsdg_render.lights.light_rows import read_light
from usdsdg_render.lights.linking import is_linked, read_rules
from usdsdg_render.lights.patterns import read_pattern
from usdsdg_render.scene.scene import LIGHT, LightPattern, LightRules, Scene
from usdsdg_render.usd.point_instancer import source_path
from usdsdg_render.usd.prim_kinds import is_below


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


class _Light(NamedTuple):
    """One light as it was read; without a row it gives no light."""

    matrix: bytes
    instances: Sequence[str] | None  # by which its links were read; None without links
    row: np.ndarray | None
    pattern: LightPattern | None
    rules: LightRules | None


class LightReader:
    """Reads lights, and each again only when told to `forget` it, when it moved, or when links may mean others."""

    def __init__(self) -> None:
        self._known: dict[Sdf.Path, _Light] = {}

    def forget(self, roots: Collection[Sdf.Path]) -> None:
        """Forget the lights at and below `roots`."""
        self._known = {path: light for path, light in self._known.items() if not is_below(path, roots)}

    def read(
        self,
        prims: Sequence[Usd.Prim],
        local_to_world: Sequence[np.ndarray],
        metres_per_unit: float,
        instances: Sequence[str],
    ) -> Lights:
        """The lights at `prims`; `instances` are the paths of `scene.Instances`."""
        before, self._known = self._known, {}
        sources: list[str] = []
        for prim, matrix in zip(prims, local_to_world):
            path, place = prim.GetPath(), matrix.tobytes()
            light = before.get(path)
            same_links = light is not None and (light.instances is None or light.instances is instances)
            if light is None or light.matrix != place or not same_links:
                linked = is_linked(prim)
                if linked and not sources:
                    sources = [source_path(each) for each in instances]
                light = _Light(
                    place,
                    instances if linked else None,
                    read_light(prim, matrix, metres_per_unit),
                    read_pattern(prim),
                    read_rules(prim, sources),
                )
            self._known[path] = light
        return _together(self._known.values())


def _together(lights: Iterable[_Light]) -> Lights:
    rows, rules = [], []
    patterns: dict[int, tuple[int, LightPattern]] = {}
    linked = False
    for light in lights:
        if light.row is None:
            continue
        linked = linked or light.instances is not None
        row = light.row.copy()
        if light.pattern is not None:
            row["pattern"] = patterns.setdefault(id(light.pattern), (len(patterns), light.pattern))[0]
        if light.rules is not None:
            row["rules"] = len(rules)
            rules.append(light.rules)
        rows.append(row)
    return Lights(np.array(rows, LIGHT), [pattern for _, pattern in patterns.values()], rules, linked)


def _content(rules: LightRules) -> tuple:
    members = (None if m is None else m.tobytes() for m in (rules.lit, rules.casting))
    return *members, rules.shadow_color, rules.shadow_distance, rules.shadow_falloff, rules.shadow_gamma

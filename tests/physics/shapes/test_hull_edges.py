"""Newton finds the edges of a convex hull once in a process."""

from __future__ import annotations

import pytest
import trimesh
from newton._src.sim import builder

from tests.physics.scenes import collide, make_body, mesh, new_stage, playing, position


def test_edges_of_a_hull_are_found_once(monkeypatch):
    calls, original = [], builder._convex_hull_adjacency

    def counted(source, **options):
        calls.append(source)
        return original(source, **options)

    monkeypatch.setattr(builder, "_convex_hull_adjacency", counted)
    heights = []
    for _ in range(2):
        stage, hull = new_stage(), trimesh.creation.icosphere(subdivisions=1, radius=0.123)
        prim = mesh(stage, "/World/rock", hull.vertices, hull.faces).GetPrim()
        collide(prim)
        make_body(prim)
        playing(stage).advance(0.2)
        heights.append(position(prim)[2])
    assert len(calls) == 1
    assert heights[0] == heights[1] == pytest.approx(-0.5 * 9.81 * 0.2**2, abs=0.02)
    assert builder._convex_hull_adjacency is counted

"""Scenes of things that shall lie down calmly: drops, rebounds, stacks, overlapping starts, a bin.

The prims that are of interest are the children of /World/Things; their half size is their scale.
"""

from __future__ import annotations

import numpy as np
import trimesh
from pxr import Usd

from tests.physics.scenes import add, mesh, new_stage, physics_material

SIZES = (0.005, 0.04)  # m, half sizes of small things
HEIGHTS = (0.5, 3.0)  # m


def small_things(count: int, *, seed: int = 1) -> Usd.Stage:
    """Boxes and spheres of 1 to 8 cm, turned at random, above a large floor and apart from each other."""
    stage = _floor()
    rng = np.random.default_rng(seed)
    columns = int(np.ceil(np.sqrt(count)))
    for i in range(count):
        half, height = rng.uniform(*SIZES), rng.uniform(*HEIGHTS)
        at = (0.5 * (i % columns), 0.5 * (i // columns), half + height)
        kind = ("Cube", "Sphere")[i % 2]
        _thing(stage, i, kind, at=at, scale=(half,) * 3, rotate=tuple(rng.uniform(0, 360, 3)))
    return stage


def drops(heights=(5.0, 10.0, 20.0), *, half: float = 0.05) -> Usd.Stage:
    """A sphere and an upright box from each height."""
    stage = _floor()
    for i, height in enumerate(heights):
        for j, kind in enumerate(("Sphere", "Cube")):
            _thing(stage, 2 * i + j, kind, at=(2.0 * i, 2.0 * j, half + height), scale=(half,) * 3)
    return stage


def rebounds(restitutions=(0.0, 0.5, 0.9), *, half: float = 0.1, height: float = 1.0, kind="Sphere") -> Usd.Stage:
    """A body on a pad of its own for each restitution, `height` above it."""
    stage = new_stage()
    for i, restitution in enumerate(restitutions):
        material = physics_material(stage, f"/World/material_{i}", restitution=restitution)
        add(stage, f"/World/pad_{i}", at=(4.0 * i, 0, -0.5), scale=(1, 1, 0.5), body=False, material=material)
        _thing(stage, i, kind, at=(4.0 * i, 0, half + height), scale=(half,) * 3, material=material)
    return stage


def stack(half: float, *, count: int = 10) -> Usd.Stage:
    """Cubes that lie on each other, `half` their half size."""
    stage = _floor()
    for i in range(count):
        _thing(stage, i, at=(0, 0, half + 2.0 * half * i), scale=(half,) * 3)
    return stage


def overlapping_pair(*, half: float = 0.1, depth: float = 0.19) -> Usd.Stage:
    """A box that starts `depth` inside another, which lies on the floor."""
    stage = _floor()
    _thing(stage, 0, at=(0, 0, half), scale=(half,) * 3)
    _thing(stage, 1, at=(0, 0, 3.0 * half - depth), scale=(half,) * 3)
    return stage


def one_place(count: int = 60, *, half: float = 0.05) -> Usd.Stage:
    """Bodies of several kinds with one center, above a floor."""
    stage = _floor()
    rng = np.random.default_rng(5)
    for i in range(count):
        kind = ("Cube", "Sphere", "Cylinder", "Capsule")[i % 4]
        scale = (half, half, half / 2) if kind == "Capsule" else (half,) * 3
        _thing(stage, i, kind, at=(0, 0, 0.5), scale=scale, rotate=tuple(rng.uniform(0, 360, 3)))
    return stage


def bin_of(count: int = 200, *, seed: int = 3) -> Usd.Stage:
    """Boxes, spheres and cylinders of 3 to 10 cm that fall into a bin of 60 cm."""
    stage = _bin()
    rng = np.random.default_rng(seed)
    for i in range(count):
        x, y = rng.uniform(-0.22, 0.22, 2)
        at = (x, y, 0.1 + 0.11 * (i // 4))
        scale = rng.uniform(0.015, 0.05, 3)
        kind = ("Cube", "Sphere", "Cube", "Cylinder")[i % 4]
        if kind != "Cube":
            scale[1] = scale[2] = scale[0]
        _thing(stage, i, kind, at=at, scale=tuple(scale), rotate=tuple(rng.uniform(0, 360, 3)))
    return stage


def bin_of_pebbles(count: int = 200, *, seed: int = 3) -> Usd.Stage:
    """Meshes with 40 corners each, flat and long ones of 4 to 14 cm, that fall into a bin of 60 cm."""
    stage = _bin()
    rng = np.random.default_rng(seed)
    for i in range(count):
        points = rng.normal(size=(40, 3))
        points *= rng.uniform(0.02, 0.07, 3) / np.linalg.norm(points, axis=1, keepdims=True)
        hull = trimesh.convex.convex_hull(points)
        x, y = rng.uniform(-0.2, 0.2, 2)
        at, rotate = (x, y, 0.1 + 0.13 * (i // 4)), tuple(rng.uniform(0, 360, 3))
        _thing(stage, i, "Mesh", at=at, rotate=rotate, scale=(1, 1, 1))
        mesh(stage, f"/World/Things/thing_{i:03}", hull.vertices, hull.faces)
    return stage


def _bin() -> Usd.Stage:
    stage = _floor()
    for name, at, scale in (
        ("east", (0.35, 0, 1.0), (0.05, 0.4, 1.0)),
        ("west", (-0.35, 0, 1.0), (0.05, 0.4, 1.0)),
        ("north", (0, 0.35, 1.0), (0.3, 0.05, 1.0)),
        ("south", (0, -0.35, 1.0), (0.3, 0.05, 1.0)),
    ):
        add(stage, f"/World/{name}", at=at, scale=scale, body=False)
    return stage


def things(stage: Usd.Stage) -> list[Usd.Prim]:
    return list(stage.GetPrimAtPath("/World/Things").GetChildren())


def half_sizes(stage: Usd.Stage) -> np.ndarray:
    return np.array([max(prim.GetAttribute("xformOp:scale").Get()) for prim in things(stage)])


def _floor() -> Usd.Stage:
    stage = new_stage()
    add(stage, "/World/floor", at=(0, 0, -0.5), scale=(30, 30, 0.5), body=False)
    return stage


def _thing(stage: Usd.Stage, index: int, kind: str = "Cube", **options) -> None:
    stage.DefinePrim("/World/Things", "Xform")
    add(stage, f"/World/Things/thing_{index:03}", kind, angular_damping=0.05, **options)

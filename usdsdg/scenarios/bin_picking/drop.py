"""Filling the bin: parts above it in layers, falling, until they rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd, UsdPhysics

import usdsdg as rep
from usdsdg.errors import counted, warn_once
from usdsdg.scenarios import rigid_bodies
from usdsdg.scenarios.bin_picking.bin import StageBin
from usdsdg.scenarios.shared.bodies import Body
from usdsdg.stage.physics.scenes import EARTH_GRAVITY
from usdsdg.stage.poses.transforms import local_to_world

_SETTLED = 1.0  # seconds between the fall of the last part and waiting for rest


@dataclass(frozen=True)
class Part:
    """A part that may be in the bin, with the prim's rigid body."""

    body: Body
    colliders: list[Usd.Prim]

    def take_away(self) -> None:
        """Hide it, and let it neither collide nor move."""
        self.body.show(False)
        UsdPhysics.RigidBodyAPI(self.body.prim).GetRigidBodyEnabledAttr().Set(False)
        for prim in self.colliders:
            UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Set(False)


def make_part(body: Body, approximation: str) -> Part:
    """Make a body a rigid body with colliders."""
    rigid_bodies.add_colliders(body.prim, approximation)
    rigid_bodies.add_rigid_body(body.prim, floating=False)
    colliders = [prim for prim in Usd.PrimRange(body.prim) if prim.HasAPI(UsdPhysics.CollisionAPI)]
    return Part(body, colliders)


def fill(bin_: StageBin, parts: Sequence[Part], generator: np.random.Generator, *, max_time: float) -> None:
    """Drop parts into the bin; those that do not lie in it then are taken away."""
    height = _place_above(bin_, parts, generator)
    bin_.set_mold(True)
    rep.functional.physics.simulate(math.sqrt(2.0 * height / EARTH_GRAVITY) + _SETTLED)
    moving = set(rep.functional.physics.simulate_until_rest([part.body.prim for part in parts], max_time=max_time))
    bin_.set_mold(False)
    for part in parts:
        if not bin_.size.holds(middle_of(part.body)):
            part.take_away()
    if moving:
        warn_once(
            f"{len(moving)} of {counted(len(parts), 'part')} had not come to rest after {max_time:g} s; their pictures "
            "show them where they were then. Raise parts.max_time"
        )


def _place_above(bin_: StageBin, parts: Sequence[Part], generator: np.random.Generator) -> float:
    """Place parts in layers above the bin, turned at random, without touching each other; return the highest place."""
    cell = 2.05 * max(part.body.radius for part in parts)
    counts = [max(int(extent // cell), 1) for extent in (bin_.size.width, bin_.size.depth)]
    steps = [extent / count for extent, count in zip((bin_.size.width, bin_.size.depth), counts)]
    per_layer = counts[0] * counts[1]
    top = 0.0
    for number, index in enumerate(generator.permutation(len(parts)).tolist()):
        layer, place = divmod(number, per_layer)
        column, row = place % counts[0], place // counts[0]
        free = [max(step - cell, 0.0) / 2.0 for step in steps]
        x = (column + 0.5) * steps[0] - bin_.size.width / 2.0 + generator.uniform(-free[0], free[0])
        y = (row + 0.5) * steps[1] - bin_.size.depth / 2.0 + generator.uniform(-free[1], free[1])
        top = (layer + 0.5) * cell + 0.3 * bin_.size.height
        part = parts[index]
        w, i, j, k = generator.normal(size=4)
        part.body.place(np.array((x, y, top)), Gf.Quatd(w, i, j, k).GetNormalized())
    return top


def middle_of(body: Body) -> Gf.Vec3d:
    """Return the center of a body's bounds in the world."""
    return local_to_world(body.prim, Usd.TimeCode.Default()).Transform(Gf.Vec3d(*(body.center / body.scale).tolist()))

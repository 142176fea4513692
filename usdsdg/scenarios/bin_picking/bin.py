"""The bin and the table that it stands on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.errors import ConfigError
from usdsdg.scenarios import rigid_bodies
from usdsdg.scenarios.shared.mesh_folder import MeshAsset
from usdsdg.scenarios.shared.pictures import Picture
from usdsdg.scenarios.shared.textured_plane import TexturedPlane
from usdsdg.stage.poses.xform_ops import author_pose

# A bin that suits its parts is so full of their bounds, and at least so many of the largest one wide and deep.
_FILLED, _LARGEST = 2.0, 2.0
_SHAPE = (4.0, 3.0, 1.5)  # width, depth, height
# Lengths of the smallest part from one side of a bin to the other, at most. Its positions are a thousandth of it apart.
_MOST = 10_000
_TABLE = 6.0  # width of the table, in widths of the bin
# Height of the mold's walls above the rim, and its thickness below the floor, in heights of the bin.
_MOLD_ABOVE, _MOLD_BELOW = 20.0, 1.0


@dataclass(frozen=True)
class BinSize:
    """Inner width, depth and height [m]."""

    width: float
    depth: float
    height: float

    @property
    def radius(self) -> float:
        """Of the circle around its rim."""
        return math.hypot(self.width, self.depth) / 2.0

    def holds(self, point: Sequence[float]) -> bool:
        """Whether a point is in the bin, or above its rim by less than its height."""
        x, y, z = point
        return abs(x) < self.width / 2 and abs(y) < self.depth / 2 and 0.0 < z < 2.0 * self.height


def suiting(assets: Sequence[MeshAsset], parts: int) -> BinSize:
    """Return the size of a bin that so many parts fill to about the rim."""
    sizes = np.array([np.subtract(each.high, each.low) for each in assets])
    volume = float(sizes.prod(axis=1).mean()) * parts / _FILLED
    unit = (volume / math.prod(_SHAPE)) ** (1.0 / 3.0)
    unit = max(unit, _LARGEST * float(sizes.max()) / _SHAPE[1])
    width, depth, height = (_rounded(unit * each) for each in _SHAPE)
    return BinSize(width, depth, height)


def given(size: Sequence[float], assets: Sequence[MeshAsset]) -> BinSize:
    """Return the size that a configuration gives.

    Raises:
        ConfigError: positions that far from its middle are too coarse, in 32-bit numbers, for parts of that size.
    """
    smallest = min(assets, key=_longest)
    if max(size) > _MOST * _longest(smallest):
        raise ConfigError(
            f"bin.size is {list(size)} m: contacts and pictures have positions in 32-bit numbers, too coarse there for "
            f"parts such as {smallest.label}, which is {_longest(smallest):.2g} m long. Give at most {_MOST:,} times "
            "its length, or null for a bin that suits the parts"
        )
    return BinSize(*size)


def _longest(asset: MeshAsset) -> float:
    """Return the longest side of a mesh's bounds [m]."""
    return float(np.subtract(asset.high, asset.low).max())


def _rounded(meters: float) -> float:
    """Return a length with two digits."""
    digits = 1 - math.floor(math.log10(meters))
    return round(meters, digits)


class StageBin:
    """The bin, the mold in which it is filled, and the table, on the stage.

    The mold is an invisible floor and walls that go on above the rim, in place of the bin's own. They begin where
    these do, a few millimeters of which a part that falls fast, or is pressed against them, would get through.
    """

    def __init__(self, stage: Usd.Stage, size: BinSize, thickness: float, first: Picture) -> None:
        self.size = size
        self._surface = _material(stage, "/World/Bin/Material")
        self._sides: list[Usd.Prim] = []
        self._mold: list[Usd.Prim] = []
        half = (size.width / 2.0, size.depth / 2.0)
        reach = (half[0] + thickness, half[1] + thickness, thickness / 2)
        self._sides.append(self._add(stage, "Floor", (0, 0, -thickness / 2), reach))
        high, deep = size.height * _MOLD_ABOVE, size.height * _MOLD_BELOW
        reach = (3.0 * half[0], 3.0 * half[1], deep / 2)
        self._mold.append(self._add(stage, "MoldFloor", (0, 0, -deep / 2), reach, visible=False))
        for name, axis, side in (("Left", 0, -1), ("Right", 0, 1), ("Front", 1, -1), ("Back", 1, 1)):
            extent = [half[0] + thickness, half[1] + thickness]
            extent[axis] = thickness / 2.0
            middle = [0.0, 0.0]
            middle[axis] = side * (half[axis] + thickness / 2.0)
            self._sides.append(self._add(stage, name, (*middle, size.height / 2), (*extent, size.height / 2)))
            # Walls of the mold overlap beyond the corners, which would be open otherwise.
            extent, middle[axis] = [3.0 * each for each in half], side * 2.0 * half[axis]
            extent[axis] = half[axis]
            place = (*middle, (size.height + high - deep) / 2)
            reach = (*extent, (size.height + high + deep) / 2)
            self._mold.append(self._add(stage, f"Mold{name}", place, reach, visible=False))
        width = _TABLE * size.width / 2.0
        self.table = TexturedPlane(
            stage.DefinePrim("/World/Table", "Xform"),
            (width, width),
            height=-thickness * 1.001,
            first=first,
            shines=False,
        )

    def _add(
        self, stage: Usd.Stage, name: str, middle: Sequence[float], half: Sequence[float], *, visible: bool = True
    ) -> Usd.Prim:
        prim = stage.DefinePrim(f"/World/Bin/{name}", "Cube")
        author_pose(prim, translate=middle, scale=half)  # the default size of a Cube is 2 units
        rigid_bodies.add_colliders(prim)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material(stage.GetPrimAtPath("/World/Bin/Material")))
        if not visible:
            UsdGeom.Imageable(prim).MakeInvisible()
        return prim

    def set_mold(self, enabled: bool) -> None:
        """Let parts collide with the mold, or with the bin itself."""
        for prims, collide in ((self._mold, enabled), (self._sides, not enabled)):
            for prim in prims:
                UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Set(collide)

    def paint(self, generator: np.random.Generator) -> None:
        """Draw the color of the bin: gray plastic mostly, or any other."""
        gray, color = generator.uniform(0.03, 0.6), generator.uniform(0.02, 0.6, 3)
        chosen = np.full(3, gray) if generator.random() < 0.6 else color
        self._surface.GetInput("diffuseColor").Set(Gf.Vec3f(*chosen.tolist()))
        self._surface.GetInput("roughness").Set(float(generator.uniform(0.3, 0.9)))


def _material(stage: Usd.Stage, path: str) -> UsdShade.Shader:
    material = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, f"{path}/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float)
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    return surface

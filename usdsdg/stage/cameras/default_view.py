"""What a picture needs and a stage may lack: a camera that sees everything, and light.

Both go to the session layer, so that the stage's own layers stay as they are.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdLux

from usdsdg.errors import StageError
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.poses.transforms import as_array, local_to_world, up_axis

ROOT = "/DefaultView"
CAMERA, SKY, SUN = (f"{ROOT}/{name}" for name in ("Camera", "Sky", "Sun"))

# Directions in (right, front, up) of the stage: to the camera, three quarters from the front and above, and to the sun.
_TO_CAMERA, _TO_SUN = (0.6, 1.0, 0.5), (-0.6, 0.7, 1.2)
# Millimeters of a 35 mm camera that distorts little; the share of the picture that the bounds fill.
_FOCAL_LENGTH, _APERTURE, _FILL = 50.0, 36.0, 0.96
# White in the sun is just below the white of a picture, 1,500 nits; in the shade it is a quarter of that.
_SKY_NITS, _SKY_COLOR, _SUN_LUX, _SUN_DEGREES = 350.0, (0.85, 0.93, 1.0), 3200.0, 2.0

_DRAWN = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render]


def cameras(stage: Usd.Stage) -> list[str]:
    """Paths of all cameras, in stage order."""
    return [str(prim.GetPath()) for prim in _prims(stage) if prim.IsA(UsdGeom.Camera)]


def has_light(stage: Usd.Stage) -> bool:
    """Whether there is any UsdLux light."""
    return any(prim.HasAPI(UsdLux.LightAPI) for prim in _prims(stage))


def add_camera(stage: Usd.Stage, aspect: float, time: Usd.TimeCode | None = None) -> str:
    """A camera that sees all visible geometry in a picture of `aspect` = width / height; returns its path.

    time: when to look; None is where an animated stage begins.

    Raises:
        StageError: there is no visible geometry.
    """
    low, high = world_bounds(stage, time)
    center, towards = (low + high) / 2, _direction(stage, _TO_CAMERA)
    to_world = as_array(look_at_matrix(towards, (0, 0, 0), up=_axes(stage)[2]))
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low
    in_camera = (corners - center) @ to_world[:3, :3].T
    half = _FILL * _APERTURE / _FOCAL_LENGTH / 2 * np.array([1.0, 1.0 / aspect])
    distance = float((in_camera[:, 2] + (np.abs(in_camera[:, :2]) / half).max(axis=1)).max())
    to_world[3, :3] = center + distance * towards
    nearest, farthest = distance - in_camera[:, 2].max(), distance - in_camera[:, 2].min()
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        camera = UsdGeom.Camera.Define(stage, CAMERA)
        camera.CreateFocalLengthAttr(_FOCAL_LENGTH)
        camera.CreateHorizontalApertureAttr(_APERTURE)
        camera.CreateVerticalApertureAttr(_APERTURE / aspect)
        camera.CreateFocusDistanceAttr(distance)
        camera.CreateClippingRangeAttr(Gf.Vec2f(nearest / 10, farthest * 10))
        camera.AddTransformOp().Set(Gf.Matrix4d(to_world.tolist()))
    return CAMERA


def add_sky(stage: Usd.Stage) -> None:
    """A plain sky and a sun, for pictures of 1,500 nits at white."""
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        sky = UsdLux.DomeLight.Define(stage, SKY)
        sky.CreateIntensityAttr(_SKY_NITS)
        sky.CreateColorAttr(Gf.Vec3f(*_SKY_COLOR))
        sun = UsdLux.DistantLight.Define(stage, SUN)
        sun.CreateIntensityAttr(_SUN_LUX)
        sun.CreateAngleAttr(_SUN_DEGREES)
        # A distant light shines along its -Z.
        sun.AddTransformOp().Set(look_at_matrix(_direction(stage, _TO_SUN), (0, 0, 0), up=_axes(stage)[2]))


def world_bounds(stage: Usd.Stage, time: Usd.TimeCode | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner (3,) of all visible geometry [stage units], at `time` or where an animation begins.

    Raises:
        StageError: there is none.
    """
    skinning = Skinning()
    for when in _times(stage) if time is None else [time]:
        cache = UsdGeom.BBoxCache(when, _DRAWN)
        found = [_bounds(prim, when, cache, skinning) for prim in _prims(stage) if _is_seen(prim, when)]
        boxes = np.array([box for box in found if box is not None]).reshape(-1, 2, 3)
        boxes = boxes[np.isfinite(boxes).all(axis=(1, 2))]
        if len(boxes):
            return boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    raise StageError(f"{stage.GetRootLayer().identifier} has no visible geometry, so there is nothing to look at")


def _bounds(prim: Usd.Prim, time: Usd.TimeCode, cache: UsdGeom.BBoxCache, skinning: Skinning) -> np.ndarray | None:
    """(2, 3) lowest and highest corner in the world; None of what is empty."""
    skinned = skinning.skin(prim, time)
    if skinned is not None:
        to_world = as_array(local_to_world(prim, time))
        points = skinned.points @ to_world[:3, :3] + to_world[3, :3]
        return np.stack([points.min(axis=0), points.max(axis=0)])
    box = cache.ComputeWorldBound(prim).ComputeAlignedRange()
    return None if box.IsEmpty() else np.array([box.GetMin(), box.GetMax()])


def _times(stage: Usd.Stage) -> list[Usd.TimeCode]:
    """When to look, the second time where there is nothing at the first."""
    first = [] if stage.HasAuthoredTimeCodeRange() else [Usd.TimeCode.Default()]
    return [*first, Usd.TimeCode.EarliestTime()]


def _is_seen(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    if not (prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdGeom.PointInstancer)):
        return False
    imageable = UsdGeom.Imageable(prim)
    return imageable.ComputePurpose() in _DRAWN and imageable.ComputeVisibility(time) != UsdGeom.Tokens.invisible


def _prims(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    yield from stage.Traverse(Usd.TraverseInstanceProxies())


def _axes(stage: Usd.Stage) -> np.ndarray:
    """(3, 3) right, front and up: things face +Z where Y is up, and -Y where Z is up."""
    identity = np.eye(3)
    return np.array([identity[0], -identity[1], identity[2]]) if up_axis(stage) == "Z" else identity[[0, 2, 1]]


def _direction(stage: Usd.Stage, parts: tuple[float, float, float]) -> np.ndarray:
    direction = np.asarray(parts) @ _axes(stage)
    return direction / np.linalg.norm(direction)

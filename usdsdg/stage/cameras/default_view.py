"""A camera that frames the whole scene, and default lights, for stages without them.

Both are authored in the session layer, so that the stage's own layers stay as they are.
"""

from collections.abc import Iterator

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdLux

from usdsdg.errors import StageError
from usdsdg.stage.geometry.drawn_box import DrawnBoxes
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.poses.transforms import as_array, local_to_world, up_axis

ROOT = "/DefaultView"
CAMERA, SKY, SUN = (f"{ROOT}/{name}" for name in ("Camera", "Sky", "Sun"))

# Directions in (right, front, up) of the stage: to the camera, a three-quarter view from above, and to the sun.
_TO_CAMERA, _TO_SUN = (0.6, 1.0, 0.5), (-0.6, 0.7, 1.2)
# Focal length and aperture of a 35 mm camera [mm], and the fraction of the image that the bounds fill.
_FOCAL_LENGTH, _APERTURE, _FILL = 50.0, 36.0, 0.96
# A white surface in the sun is just below the white of an image, 1,500 nits; in the shade it has a quarter of that.
_SKY_NITS, _SKY_COLOR, _SUN_LUX, _SUN_DEGREES = 350.0, (0.85, 0.93, 1.0), 3200.0, 2.0

_PURPOSES = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render]


def cameras(stage: Usd.Stage) -> list[str]:
    """Return the paths of all cameras, in stage order."""
    return [str(prim.GetPath()) for prim in _prims(stage) if prim.IsA(UsdGeom.Camera)]


def has_light(stage: Usd.Stage) -> bool:
    """Whether there is any UsdLux light."""
    return bool(lights(stage))


def lights(stage: Usd.Stage) -> list[str]:
    """Return the paths of all UsdLux lights, in stage order."""
    return [str(prim.GetPath()) for prim in _prims(stage) if prim.HasAPI(UsdLux.LightAPI)]


def add_camera(stage: Usd.Stage, aspect: float, time: Usd.TimeCode | None = None) -> str:
    """Define a camera that frames all visible geometry in an image of `aspect` = width / height; return its path.

    time: time of the geometry; None for the start of an animated stage.

    Raises:
        StageError: there is no visible geometry, or it has no size.
    """
    to_world, distance, (nearest, farthest) = looking_at_all(stage, aspect, time)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        camera = UsdGeom.Camera.Define(stage, CAMERA)
        camera.CreateFocalLengthAttr(_FOCAL_LENGTH)
        camera.CreateHorizontalApertureAttr(_APERTURE)
        camera.CreateVerticalApertureAttr(_APERTURE / aspect)
        camera.CreateFocusDistanceAttr(distance)
        camera.CreateClippingRangeAttr(Gf.Vec2f(nearest / 10, farthest * 10))
        camera.AddTransformOp().Set(Gf.Matrix4d(to_world.tolist()))
    return CAMERA


def looking_at_all(
    stage: Usd.Stage, aspect: float, time: Usd.TimeCode | None = None
) -> tuple[np.ndarray, float, tuple[float, float]]:
    """Return the pose (4, 4) of `add_camera`, its distance from the center, and those of the nearest and farthest.

    Raises:
        StageError: there is no visible geometry, or it has no size.
    """
    low, high = world_bounds(stage, time)
    center, to_camera = (low + high) / 2, _direction(stage, _TO_CAMERA)
    to_world = as_array(look_at_matrix(to_camera, (0, 0, 0), up=axes(stage)[2]))
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low
    in_camera = (corners - center) @ to_world[:3, :3].T
    half = _FILL * _APERTURE / _FOCAL_LENGTH / 2 * np.array([1.0, 1.0 / aspect])
    distance = float((in_camera[:, 2] + (np.abs(in_camera[:, :2]) / half).max(axis=1)).max())
    if distance <= 0:
        raise StageError(f"all visible geometry of {_name(stage)} is in one point; correct its points, size or scale")
    to_world[3, :3] = center + distance * to_camera
    return to_world, distance, (distance - in_camera[:, 2].max(), distance - in_camera[:, 2].min())


def add_sky(stage: Usd.Stage) -> None:
    """Define a uniform sky and a sun, for images with white at 1,500 nits."""
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        sky = UsdLux.DomeLight.Define(stage, SKY)
        sky.CreateIntensityAttr(_SKY_NITS)
        sky.CreateColorAttr(Gf.Vec3f(*_SKY_COLOR))
        sun = UsdLux.DistantLight.Define(stage, SUN)
        sun.CreateIntensityAttr(_SUN_LUX)
        sun.CreateAngleAttr(_SUN_DEGREES)
        # A distant light shines along its -Z.
        sun.AddTransformOp().Set(look_at_matrix(_direction(stage, _TO_SUN), (0, 0, 0), up=axes(stage)[2]))


def world_bounds(stage: Usd.Stage, time: Usd.TimeCode | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corners (3,) of all visible geometry [stage units], at `time` or the start.

    Raises:
        StageError: there is no visible geometry.
    """
    skinning = Skinning()
    for time_code in _times(stage) if time is None else [time]:
        drawn = DrawnBoxes(time_code, _PURPOSES)
        prims = (prim for prim in _drawn_alone(stage) if _is_visible(prim, time_code))
        found = [_bounds(prim, time_code, drawn, skinning) for prim in prims]
        boxes = np.array([box for box in found if box is not None]).reshape(-1, 2, 3)
        boxes = boxes[np.isfinite(boxes).all(axis=(1, 2))]
        if len(boxes):
            return boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    raise StageError(
        f"{_name(stage)} has no visible geometry, so there is nothing to look at; create or open something first"
    )


def _name(stage: Usd.Stage) -> str:
    layer = stage.GetRootLayer()
    return "the stage" if layer.anonymous else layer.identifier


def _bounds(prim: Usd.Prim, time: Usd.TimeCode, drawn: DrawnBoxes, skinning: Skinning) -> np.ndarray | None:
    """Return the lowest and highest corner (2, 3) in the world; None for empty geometry."""
    skinned = skinning.skin(prim, time)
    if skinned is not None:
        to_world = as_array(local_to_world(prim, time))
        points = skinned.points @ to_world[:3, :3] + to_world[3, :3]
        return np.stack([points.min(axis=0), points.max(axis=0)])
    return drawn.in_world(prim)


def _times(stage: Usd.Stage) -> list[Usd.TimeCode]:
    """Return the times to try, one after the other, until there is geometry."""
    first = [] if stage.HasAuthoredTimeCodeRange() else [Usd.TimeCode.Default()]
    return [*first, Usd.TimeCode.EarliestTime()]


def _is_visible(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    if not (prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdGeom.PointInstancer)):
        return False
    imageable = UsdGeom.Imageable(prim)
    return imageable.ComputePurpose() in _PURPOSES and imageable.ComputeVisibility(time) != UsdGeom.Tokens.invisible


def _prims(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    yield from stage.Traverse(Usd.TraverseInstanceProxies())


def _drawn_alone(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    """Yield the prims that are drawn where they are, or draw others: not those that only a point instancer draws."""
    prims = iter(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()))
    for prim in prims:
        if prim.IsA(UsdGeom.PointInstancer):
            prims.PruneChildren()
        yield prim


def axes(stage: Usd.Stage) -> np.ndarray:
    """Return (3, 3) right, front and up: assets face +Z where Y is up, and -Y where Z is up."""
    identity = np.eye(3)
    return np.array([identity[0], -identity[1], identity[2]]) if up_axis(stage) == "Z" else identity[[0, 2, 1]]


def _direction(stage: Usd.Stage, parts: tuple[float, float, float]) -> np.ndarray:
    direction = np.asarray(parts) @ axes(stage)
    return direction / np.linalg.norm(direction)

"""The cameras of the application's viewport: perspective, front, top and right, in the session layer of a stage."""

from __future__ import annotations

from collections.abc import Collection

from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis, up_vector

PERSPECTIVE = "/OmniverseKit_Persp"
ORTHOGRAPHIC = {name: f"/OmniverseKit_{name}" for name in ("Front", "Top", "Right")}
PATHS = (PERSPECTIVE, *ORTHOGRAPHIC.values())

# The perspective camera is 5 m from the origin along every axis, the others 500 m along one; distances in meters.
_PERSPECTIVE_DISTANCE, _ORTHOGRAPHIC_DISTANCE = 5.0, 500.0
_FOCAL_LENGTH, _APERTURES = 18.147562, (20.955, 15.2908)
_NEAR, _FAR = 0.01, 10_000_000.0
# Directions from the origin to each camera and their up, by the up axis of the stage.
_VIEWS = {
    "Z": {"Front": ((1, 0, 0), (0, 0, 1)), "Top": ((0, 0, 1), (0, 1, 0)), "Right": ((0, -1, 0), (0, 0, 1))},
    "Y": {"Front": ((0, 0, 1), (0, 1, 0)), "Top": ((0, 1, 0), (0, 0, -1)), "Right": ((1, 0, 0), (0, 1, 0))},
}


def author(stage: Usd.Stage) -> None:
    """Define the cameras where the stage has none of their paths.

    The perspective camera is where the stage's file says that it was (`customLayerData`, "cameraSettings"), else it
    looks at the origin from (5, 5, 5) meters.
    """
    unit = 1.0 / meters_per_unit(stage)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        if not stage.GetPrimAtPath(PERSPECTIVE):
            eye, target = _saved_view(stage) or (Gf.Vec3d(_PERSPECTIVE_DISTANCE * unit), Gf.Vec3d(0.0))
            camera = _camera(stage, PERSPECTIVE, UsdGeom.Tokens.perspective, unit)
            camera.CreateFocalLengthAttr(_FOCAL_LENGTH)
            camera.CreateFocusDistanceAttr((eye - target).GetLength())
            _place(camera, eye, target, up_vector(stage))
        for name, (direction, up) in _VIEWS[up_axis(stage)].items():
            if not stage.GetPrimAtPath(ORTHOGRAPHIC[name]):
                camera = _camera(stage, ORTHOGRAPHIC[name], UsdGeom.Tokens.orthographic, unit)
                _place(camera, Gf.Vec3d(*direction) * _ORTHOGRAPHIC_DISTANCE * unit, Gf.Vec3d(0.0), up)


def remove(layer: Sdf.Layer, *, keep: Collection[str] = ()) -> None:
    """Remove the cameras from a flattened layer, but those at the paths `keep`."""
    for path in PATHS:
        if path not in keep and layer.GetPrimAtPath(path):
            del layer.pseudoRoot.nameChildren[path[1:]]


def _camera(stage: Usd.Stage, path: str, projection: str, unit: float) -> UsdGeom.Camera:
    camera = UsdGeom.Camera.Define(stage, path)
    camera.CreateProjectionAttr(projection)
    camera.CreateHorizontalApertureAttr(_APERTURES[0])
    camera.CreateVerticalApertureAttr(_APERTURES[1])
    camera.CreateClippingRangeAttr(Gf.Vec2f(_NEAR * unit, _FAR))
    return camera


def _place(camera: UsdGeom.Camera, eye: Gf.Vec3d, target: Gf.Vec3d, up: tuple[float, float, float]) -> None:
    rotation = look_at_matrix(eye, target, up=up).ExtractRotation()
    angles = rotation.Decompose(Gf.Vec3d.ZAxis(), Gf.Vec3d.YAxis(), Gf.Vec3d.XAxis())
    camera.AddTranslateOp().Set(eye)
    camera.AddRotateXYZOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(angles[2], angles[1], angles[0]))
    camera.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(1.0))


def _saved_view(stage: Usd.Stage) -> tuple[Gf.Vec3d, Gf.Vec3d] | None:
    """Return eye and target of the perspective camera that the stage's file holds, None where it holds none."""
    settings = stage.GetRootLayer().customLayerData.get("cameraSettings", {})
    saved = settings.get("Perspective", {}) if isinstance(settings, dict) else {}
    if "position" not in saved or "target" not in saved:
        return None
    eye, target = Gf.Vec3d(saved["position"]), Gf.Vec3d(saved["target"])
    line = (eye - target).GetNormalized()
    parallel = abs(Gf.Dot(line, Gf.Vec3d(*up_vector(stage)))) > 1.0 - 1e-9
    return None if eye == target or parallel else (eye, target)

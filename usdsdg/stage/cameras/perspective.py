"""The camera that a viewport of Omniverse looks through by default."""

from pxr import Gf, Usd, UsdGeom

from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.poses.transforms import meters_per_unit, up_vector

PERSPECTIVE = "/OmniverseKit_Persp"

# Kit's: a lens of 60 degrees, 5 m from the origin along each axis.
_FOCAL_LENGTH, _APERTURE, _METERS = 18.147562, 20.955, 5.0
_CLIPPING_METERS = (0.01, 100_000.0)


def perspective_camera(stage: Usd.Stage) -> str:
    """Return the path of the viewport's camera; define it in the session layer, looking at the origin, if missing."""
    if stage.GetPrimAtPath(PERSPECTIVE):
        return PERSPECTIVE
    unit = meters_per_unit(stage)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        camera = UsdGeom.Camera.Define(stage, PERSPECTIVE)
        camera.CreateFocalLengthAttr(_FOCAL_LENGTH)
        camera.CreateHorizontalApertureAttr(_APERTURE)
        camera.CreateClippingRangeAttr(Gf.Vec2f(*(meters / unit for meters in _CLIPPING_METERS)))
        pose = look_at_matrix([_METERS / unit] * 3, (0, 0, 0), up=up_vector(stage))
        camera.AddTransformOp().Set(pose)
    return PERSPECTIVE

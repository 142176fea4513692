"""What a new stage holds: ours, or what Omniverse Code and Isaac Sim open with."""

import enum

from pxr import Gf, Usd, UsdGeom, UsdLux

DEFAULT_LIGHT = "/Environment/defaultLight"

# The light of a new stage of Kit and of Isaac Sim: from 45 degrees above, in front of the default camera.
LUX, DEGREES = 3000.0, 1.0


class NewStage(enum.Enum):
    """The kinds of new stages."""

    EMPTY = "empty"  # Z up, meters, /World
    KIT = "kit"  # Omniverse Code: Y up, centimeters, /World and a distant light
    ISAAC = "isaac"  # Isaac Sim: Z up, meters, /World and a distant light


def author(stage: Usd.Stage, kind: NewStage) -> None:
    """Author what a new stage of this kind holds: 60 time codes per second, /World as default prim, the light."""
    is_kit = kind is NewStage.KIT
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y if is_kit else UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01 if is_kit else 1.0)
    stage.SetTimeCodesPerSecond(60.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    if kind is not NewStage.EMPTY:
        add_light(stage, kind)


def add_light(stage: Usd.Stage, kind: NewStage) -> None:
    """Author the light of a new stage of this kind."""
    UsdGeom.Xform.Define(stage, DEFAULT_LIGHT.rsplit("/", 1)[0])
    light = UsdLux.DistantLight.Define(stage, DEFAULT_LIGHT)
    light.CreateAngleAttr(DEGREES)
    light.CreateIntensityAttr(LUX)
    pose = UsdGeom.Xformable(light)
    pose.AddTranslateOp().Set(Gf.Vec3d(0.0))
    if kind is NewStage.KIT:
        pose.AddRotateXYZOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(315.0, 0.0, 0.0))
    else:
        turn = Gf.Rotation(Gf.Vec3d(1, 0, 0), 45.0) * Gf.Rotation(Gf.Vec3d(0, 0, 1), 90.0)
        pose.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(turn.GetQuat()))
    pose.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(1.0))

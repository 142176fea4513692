"""Pairs of cameras as `create.stereo_camera` makes them: below one prim, `<name>_L` and `<name>_R`."""

from pxr import Usd, UsdGeom

# Ends of the names of the left and the right camera.
STEREO_SIDES = ("_L", "_R")


def stereo_pair(prim: Usd.Prim) -> list[str]:
    """Return the paths of the left and the right camera of a stereo pair; [] for other prims.

    The cameras are children of the prim, or of two children that have nothing else.
    """
    children = prim.GetChildren() if prim else []
    cameras = [camera for child in children if (camera := _camera_of(child))]
    sides = {each.GetName()[-2:]: each for each in cameras}
    if len(cameras) != 2 or sides.keys() != set(STEREO_SIDES) or len({each.GetName()[:-2] for each in cameras}) != 1:
        return []
    return [str(sides[side].GetPath()) for side in STEREO_SIDES]


def _camera_of(prim: Usd.Prim) -> Usd.Prim | None:
    if prim.IsA(UsdGeom.Camera):
        return prim
    children = prim.GetChildren()
    return children[0] if len(children) == 1 and children[0].IsA(UsdGeom.Camera) else None

"""Pairs of cameras as `create.stereo_camera` makes them: children of one prim, `<name>_L` and `<name>_R`."""

from pxr import Usd, UsdGeom

# Ends of the names of the left and the right camera.
STEREO_SIDES = ("_L", "_R")


def stereo_pair(prim: Usd.Prim) -> list[str]:
    """Return the paths of the left and the right camera of a stereo pair; [] for other prims."""
    cameras = [each for each in prim.GetChildren() if each.IsA(UsdGeom.Camera)] if prim else []
    sides = {each.GetName()[-2:]: each for each in cameras}
    if len(cameras) != 2 or sides.keys() != set(STEREO_SIDES) or len({each.GetName()[:-2] for each in cameras}) != 1:
        return []
    return [str(sides[side].GetPath()) for side in STEREO_SIDES]

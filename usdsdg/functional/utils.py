"""World transforms of prims: `rep.functional.utils`."""

from typing import Any

from pxr import Gf

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.prims import one_prim
from usdsdg.stage.poses.transforms import local_to_world


def get_world_transform(prim: Any) -> Gf.Transform:
    """Return the local-to-world transform of a prim, with `.GetMatrix()`, `.GetTranslation()`, `.GetRotation()` etc.

    Raises:
        BadPrim: the prim is not on the stage.
    """
    return Gf.Transform(local_to_world(one_prim("prim", prim)))


def get_world_position(prim: Any) -> Gf.Vec3d:
    """Return the world position of a prim's origin [stage units].

    Raises:
        BadPrim: the prim is not on the stage.
    """
    return local_to_world(one_prim("prim", prim)).ExtractTranslation()


name_parameters(globals())

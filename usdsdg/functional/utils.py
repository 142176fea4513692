"""Where prims are. Mirrors `rep.functional.utils`."""

from typing import Any

from pxr import Gf

from usdsdg.arguments.prims import one_prim
from usdsdg.stage.poses.transforms import local_to_world


def get_world_transform(prim: Any) -> Gf.Transform:
    """Where a prim is in the world, with `.GetMatrix()`, `.GetTranslation()`, `.GetRotation()`, `.GetScale()`.

    Raises:
        BadPrim: the prim is not on the stage.
    """
    return Gf.Transform(local_to_world(one_prim("prim", prim)))


def get_world_position(prim: Any) -> Gf.Vec3d:
    """The origin of a prim in the world [stage units].

    Raises:
        BadPrim: the prim is not on the stage.
    """
    return local_to_world(one_prim("prim", prim)).ExtractTranslation()

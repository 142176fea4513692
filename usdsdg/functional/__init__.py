"""Functions that take effect immediately, on pxr prims: `rep.functional`.

cube = rep.functional.create.cube(position=(0, 0, 1), semantics={"class": "cube"}, parent="/World")
rep.functional.modify.pose(cube, rotation_value=(0, 0, 45))
"""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.functional import create, create_batch, get, modify, physics, randomizer, utils
from usdsdg.writers.files import (
    read_exr,
    write_exr,
    write_image,
    write_jpeg,
    write_json,
    write_np,
    write_pickle,
    write_png,
)

__all__ = [
    "create", "create_batch", "get", "modify", "physics", "randomizer", "read_exr", "utils", "write_exr", "write_image",
    "write_jpeg", "write_json", "write_np", "write_pickle", "write_png",
]  # fmt: skip

name_parameters(globals())

"""Creation of single prims: `rep.functional.create`. Each function returns the new pxr prim.

`create_batch` documents the arguments and when they raise ArgumentError, AssetError, BadPrim or Unsupported; here each
of them has one value. `create.pyi` has the signatures for editors and type checkers.
"""

import functools
import inspect
from collections.abc import Callable
from typing import Any

from pxr import Usd

from usdsdg.arguments.parameters import name_parameters
from usdsdg.functional import create_batch


def _single(
    batch: Callable[..., list[Usd.Prim]], doc: str, last: tuple[str, ...] = (), named: tuple[str, ...] = ()
) -> Callable[..., Usd.Prim]:
    """Return a function that creates one prim by `batch` and takes the same arguments, without `count`.

    last: parameters that come after the others; named: those that are given by name only.
    """
    signature = inspect.signature(batch)
    every = {name: each for name, each in signature.parameters.items() if name != "count"}
    every |= {name: every[name].replace(kind=inspect.Parameter.KEYWORD_ONLY) for name in named}
    # Sorting keeps the order of equals.
    parameters = sorted(every.values(), key=lambda each: (each.kind, each.name in last))
    positional = [each.name for each in parameters if each.kind is each.POSITIONAL_OR_KEYWORD]

    @functools.wraps(batch, assigned=("__name__", "__qualname__"))
    def create(*values: Any, **arguments: Any) -> Usd.Prim:
        if len(values) > len(positional):
            raise TypeError(f"{batch.__name__}() takes {len(positional)} positional arguments, not {len(values)}")
        return batch(**dict(zip(positional, values)), **arguments, count=1)[0]

    create.__doc__ = doc
    create.__signature__ = signature.replace(parameters=parameters, return_annotation=Usd.Prim)  # type: ignore[attr-defined]
    return create


scope = _single(create_batch.scope, "A Scope, which groups prims and has no transform.")
xform = _single(create_batch.xform, "An empty transform.")
clone = _single(
    create_batch.clone, "A copy of the prim at `path` with everything below it.", named=("semantics", "visible")
)
reference = _single(create_batch.reference, "A reference to a USD file or to a prim of this stage.")
camera = _single(create_batch.camera, "A camera that looks along its own -Z with +Y up, whatever the stage's up axis.")
plane = _single(create_batch.plane, "A square with edges of one meter that faces the stage's up axis.")
sphere = _single(create_batch.sphere, "A sphere of one meter diameter.")
torus = _single(create_batch.torus, "A ring around the stage's up axis, one and a half meters across; always a mesh.")
disk = _single(create_batch.disk, "A flat disk of one meter diameter that faces the stage's up axis; always a mesh.")
cube = _single(create_batch.cube, "A cube with edges of one meter.")
cylinder = _single(create_batch.cylinder, "A cylinder of one meter height and diameter along the stage's up axis.")
cone = _single(create_batch.cone, "A cone of one meter height and base diameter along the stage's up axis.")
capsule = _single(
    create_batch.capsule,
    "A capsule of one meter height and half a meter diameter along the stage's up axis. Since 6.0.",
)
sphere_light = _single(create_batch.sphere_light, "A light that emits from the surface of a sphere.")
disk_light = _single(create_batch.disk_light, "A light that emits from a disk, toward -Z.")
rect_light = _single(create_batch.rect_light, "A light that emits from a rectangle, toward -Z.")
cylinder_light = _single(create_batch.cylinder_light, "A light that emits from a cylinder along x.")
distant_light = _single(create_batch.distant_light, "A light with parallel rays toward -Z.")
dome_light = _single(
    create_batch.dome_light,
    "An environment light, optionally with the image `texture`.",
    last=("position", "scale", "rotation", "look_at", "look_at_up_axis", "name", "parent"),
)
material = _single(
    create_batch.material,
    'An MDL material such as "OmniPBR.mdl" with the given `inputs`, bound to any number of prims.',
)
omni_lidar = _single(create_batch.omni_lidar, "Unsupported: usdsdg has no lidar model.")
omni_radar = _single(create_batch.omni_radar, "Unsupported: usdsdg has no radar model.")

name_parameters(globals())

"""The table of AOVs: each row is a Warp function of one pixel, decorated with what it reads and its value for a miss.

Whoever adds an AOV writes such a function. The struct of output images, their allocation and the calls in the kernels
are made from the table.
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from usdsdg_render.kernels.labels.label_module import LABELS

# What functions of the table may read, and with it the kernel that calls them (see `label_kernels`).
PIXEL = "pixel"  # also called where the ray hits nothing
MOTION = "motion"  # likewise, with the previous frame
HIT = "hit"
SURFACE = "surface"  # position, normals and UVs at the hit
MATERIAL = "material"  # and the values of all textures of its material
HEMISPHERE = "hemisphere"  # rays from the surface


@dataclass(frozen=True)
class Aov:
    """One output of the label pass, an array (height, width, *channels)."""

    value: wp.Function  # of one pixel; its docstring says what it means, and in which unit
    parameters: tuple[str, ...]  # of that function
    reads: str
    type: Any  # a Warp type
    miss: float  # value where the ray hits nothing

    @property
    def dtype(self) -> type[np.generic]:
        return np.int32 if self.type is wp.int32 else np.float32

    @property
    def channels(self) -> tuple[int, ...]:
        return getattr(self.type, "_shape_", ())


AOVS: dict[str, Aov] = {}


def aov(reads: str, *, miss: float = 0.0) -> Callable[[Callable], Any]:
    """Enter the decorated function into the table, under its name and with its return type.

    Its parameters are some of those of the `writer` for what it reads, by name.
    """

    def enter(function: Callable) -> Any:
        parameters = inspect.signature(function).parameters
        returned = inspect.get_annotations(function)["return"]
        entered = wp.func(function)
        AOVS[function.__name__] = Aov(entered, tuple(parameters), reads, returned, miss)
        return entered

    return enter


def struct_of_images(module: str) -> Any:
    """A Warp struct with the address of the images of each AOV, pixel by pixel; 0 = not asked for.

    Addresses, since functions on a CPU get structs as copies, and an array takes seven words of each.
    """
    addresses = {name: wp.uint64 for name in AOVS}
    sizes = {"width": wp.int32, "height": wp.int32}
    return wp.struct(type("AovImages", (), {"__module__": module, "__annotations__": addresses | sizes}))


def writer(images: Any, reads: str, **parameters: Any) -> Any:
    """A Warp function (images, view, y, x, *parameters) that writes the AOVs that read this, if asked for."""
    calls = {name: f"{name}({', '.join(each.parameters)})" for name, each in AOVS.items() if each.reads == reads}
    functions = {name: AOVS[name].value for name in calls}
    return _assigning(f"write_{reads}", images, parameters, calls, functions)


def miss_writer(images: Any, *reads: str) -> Any:
    """A Warp function (images, view, y, x) that writes the value for a miss to AOVs that read this."""
    values = {name: f"MISS_{name}" for name, each in AOVS.items() if each.reads in reads}
    misses = {values[name]: wp.constant(AOVS[name].type(AOVS[name].miss)) for name in values}
    return _assigning(f"write_misses_of_{'_'.join(reads)}", images, {}, values, misses)


def _assigning(
    name: str, images: Any, parameters: dict[str, Any], values: dict[str, str], namespace: dict[str, Any]
) -> Any:
    """A Warp function that assigns expressions to a pixel of images; made as source, which is what Warp compiles."""
    arguments = {"out": images, "v": int, "y": int, "x": int, **parameters}
    lines = [f"def {name}({', '.join(arguments)}):", "    pixel = (v * out.height + y) * out.width + x"]
    scope = {"wp": wp, **namespace}
    for image, value in values.items():
        scope[f"type_of_{image}"] = AOVS[image].type
        lines += [
            f"    if out.{image} != wp.uint64(0):",
            f"        {image}_values = wp.array(ptr=out.{image}, shape=(pixel + 1,), dtype=type_of_{image})",
            f"        {image}_values[pixel] = {value}",
        ]
    source = "\n".join(lines)
    exec(source, scope)
    function = scope[name]
    function.__annotations__ = arguments
    return wp.Function(function, key=name, namespace="", module=LABELS, source=source)

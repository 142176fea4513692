"""Materials as they are read from the stage: constants, textures, and primvars of the gprim."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg import errors
from usdsdg_render.images.textures import TextureUse
from usdsdg_render.usd.color_spaces import linear_colors

# Largest colors of surfaces and of emission [nits]: products of a dozen of them, denoised, stay within float32. The sun
# has 1.6e9 nits.
MAX_COLOR, MAX_EMISSION = 1e3, 1e10


class Input(NamedTuple):
    """A constant, multiplied by a texture where there is one.

    `fallback` is the value where the texture cannot be read; None means `value`.
    """

    value: tuple[float, ...]
    texture: TextureUse | None = None
    channel: int = 0  # of the texture, for inputs of one component
    fallback: tuple[float, ...] | None = None


class PrimvarInput(NamedTuple):
    """An input of a material that is read from a primvar of the gprim."""

    field: str  # of Material
    primvar: str
    fallback: tuple[float, ...]


@dataclass(frozen=True)
class Material:
    """A material read from the stage, with defaults: a row of `scene.MATERIAL` before its textures are loaded.

    See `scene.structs.Material` for the fields of the same names.
    """

    name: str = ""
    base_color: Input = Input((0.18, 0.18, 0.18))
    metallic: Input = Input((0.0,))
    roughness: Input = Input((0.5,))
    metal_f90: float = 0.0
    specular: Input = Input((0.04, 0.04, 0.04))
    opacity: Input = Input((1.0,))
    opacity_threshold: float = 0.0
    transmission: float = 0.0
    ior: float = 1.5
    thin: int = 0
    emission: Input = Input((0.0, 0.0, 0.0))
    normal: TextureUse | None = None
    normal_scale: float = 1.0
    detail: TextureUse | None = None
    detail_scale: float = 1.0
    coat_f0: float = 0.04
    clearcoat: Input = Input((0.0,))
    clearcoat_roughness: Input = Input((0.01,))
    uv_primvar: str = ""
    reads_display_color: bool = False  # as base_color
    primvar_inputs: tuple[PrimvarInput, ...] = ()

    @cached_property
    def textures(self) -> tuple[TextureUse, ...]:
        """All textures of the material."""
        inputs = (self.base_color, self.metallic, self.roughness, self.specular, self.opacity, self.emission)
        inputs += (self.clearcoat, self.clearcoat_roughness)
        return tuple(use for use in (*(i.texture for i in inputs), self.normal, self.detail) if use is not None)

    def with_primvars_of(self, prim: Usd.Prim, time: Usd.TimeCode) -> Material:
        """Return the material with `primvar_inputs` read from the gprim; of varying primvars their means."""
        found = {each.field: Input(_primvar(prim, each, time)) for each in self.primvar_inputs}
        return replace(self, primvar_inputs=(), **found)

    def with_fields(self, changed: dict[str, Any]) -> Material:
        """Return `replace(self, **changed)`, in a tenth of the time."""
        made = object.__new__(Material)
        made.__dict__.update(self.__dict__)
        made.__dict__.pop("textures", None)
        made.__dict__.update(changed)
        return made

    @staticmethod
    def set_fields(materials: Iterable[Material], name: str, values: Iterable[Input]) -> None:
        """Set an input in these very materials, to those with the same textures.

        For the one who holds them: most edits are of constants, and all holders would have to take over new materials.
        """
        for material, value in zip(materials, values):
            material.__dict__[name] = value

    def with_base_color(self, color: tuple[float, ...]) -> Material:
        return replace(self, base_color=Input(color))


def _primvar(prim: Usd.Prim, wanted: PrimvarInput, time: Usd.TimeCode) -> tuple[float, ...]:
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(wanted.primvar)
    if not primvar:
        _warn_of_points(prim, wanted)
    authored = primvar.Get(time) if primvar else None
    if authored is None or np.size(authored) == 0:
        return wanted.fallback
    width = len(wanted.fallback)
    array = _rows(primvar.ComputeFlattened(time), width, is_array=primvar.GetTypeName().isArray)
    if array is None or not np.isfinite(array).all():
        expected = "numbers" if width == 1 else f"rows of {width} numbers"
        errors.warn_once(
            f"{prim.GetPath()}: primvars:{wanted.primvar} does not hold {expected}, so {wanted.field} of its material "
            f"is the fallback {wanted.fallback}. Correct its type, values and indices."
        )
        return wanted.fallback
    if array.shape[1] == 3 and primvar.GetAttr().GetRoleName() == "Color":
        array = linear_colors(primvar.GetAttr(), array)
    if (array != array[0]).any():
        errors.warn_once(
            f"{prim.GetPath()}: primvars:{wanted.primvar} varies over the gprim; as {wanted.field} of its material its "
            f"mean is used. Only displayColor as diffuseColor may vary."
        )
    return tuple(np.broadcast_to(array.mean(axis=0), width).tolist())


def _rows(value: Any, width: int, *, is_array: bool) -> np.ndarray | None:
    """Return the values of a primvar as rows of `width`, or of one number each; None for those of other types."""
    numbers = np.asarray(value)
    if numbers.dtype.kind not in "biuf":
        return None
    columns = numbers.shape[1:] if is_array else numbers.shape
    if not columns:
        return numbers.astype(np.float64).reshape(-1, 1)
    if len(columns) != 1 or not 1 < width <= columns[0]:
        return None
    return numbers.astype(np.float64).reshape(-1, columns[0])[:, :width]


def _warn_of_points(prim: Usd.Prim, wanted: PrimvarInput) -> None:
    """Warn of a primvar that a point instancer has for each of its points, and its prototypes do not get."""
    above = prim.GetParent()
    while above:
        attribute = above.GetAttribute(f"primvars:{wanted.primvar}")
        if attribute and attribute.HasAuthoredValue() and above.IsA(UsdGeom.PointInstancer):
            errors.warn_once(
                f"{above.GetPath()}: primvars:{wanted.primvar} of each point is not supported; as {wanted.field} of "
                f"the material of {prim.GetPath()} the fallback {wanted.fallback} is used. Give points of another "
                "look a prototype of their own."
            )
            return
        above = above.GetParent()

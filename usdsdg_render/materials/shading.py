"""Materials and the UsdShade networks that they are read from: an input is a constant or another shader's output."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg import errors
from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.mdl_module import Preset
from usdsdg_render.usd.authored_values import as_floats
from usdsdg_render.usd.time_code import current_value

# Largest colors of surfaces and of emission [nits]: products of a dozen of them, denoised, stay within float32. The sun
# has 1.6e9 nits.
MAX_COLOR, MAX_EMISSION = 1e3, 1e10


@dataclass(frozen=True)
class Input:
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

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        """Cached, since the material table hashes all materials whenever one of them changes."""
        return hash(tuple(getattr(self, each.name) for each in fields(self)))

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

    def with_base_color(self, color: tuple[float, ...]) -> Material:
        return replace(self, base_color=Input(color))


def _primvar(prim: Usd.Prim, wanted: PrimvarInput, time: Usd.TimeCode) -> tuple[float, ...]:
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(wanted.primvar)
    value = primvar.Get(time) if primvar else None
    width = len(wanted.fallback)
    try:
        array = np.atleast_1d(np.asarray(value, np.float64))
        array = array.reshape(-1, width if array.size % width == 0 else 1)
    except (TypeError, ValueError):
        return wanted.fallback
    if not array.size or not np.isfinite(array).all():
        return wanted.fallback
    if (array != array[0]).any():
        errors.warn_once(
            f"{prim.GetPath()}: primvars:{wanted.primvar} varies over the gprim; as {wanted.field} of its material its "
            f"mean is used. Only displayColor as diffuseColor may vary."
        )
    return tuple(np.broadcast_to(array.mean(axis=0), width).tolist())


class Source(NamedTuple):
    """Where the value of an input comes from: `attribute` holds it, or `shader` computes it as `output`."""

    attribute: Usd.Attribute | None
    shader: UsdShade.Shader | None
    output: str


NOTHING = Source(None, None, "")


@dataclass
class Network:
    """The shading network of one material while it is read; `visited` collects the prims that it depends on."""

    material: Usd.Prim
    visited: set[Sdf.Path] = field(default_factory=set)
    uv_primvar: str | None = None
    reads_display_color: bool = False
    primvar_inputs: list[PrimvarInput] = field(default_factory=list)
    preset: Preset | None = None  # of inputs of the surface that are not authored
    _inputs: dict[Sdf.Path, dict[str, UsdShade.Input]] = field(default_factory=dict)

    def connected(self, shader: UsdShade.Shader) -> list[str]:
        """Return the inputs whose value another shader computes."""
        self.source(shader, "")
        return [name for name in self._inputs[shader.GetPath()] if self.source(shader, name).shader is not None]

    def warn(self, shader: UsdShade.Shader | Usd.Prim, message: str) -> None:
        prim = shader if isinstance(shader, Usd.Prim) else shader.GetPrim()
        errors.warn_once(f"{prim.GetPath()}: {message}")

    def source(self, shader: UsdShade.Shader, name: str) -> Source:
        """Follow an input through node graphs and the material's interface to what gives its value."""
        path = shader.GetPath()
        if path not in self._inputs:
            self._inputs[path] = {i.GetBaseName(): i for i in shader.GetInputs(onlyAuthored=True)}
        shader_input = self._inputs[path].get(name)
        if shader_input is None:
            return self._preset_value(path, name)
        attributes = shader_input.GetValueProducingAttributes()
        if not attributes:
            self._warn_of_dangling(shader, shader_input)
            return NOTHING
        attribute = attributes[0]
        prim = attribute.GetPrim()
        self.visited.add(prim.GetPath())
        base_name = attribute.GetName()
        if base_name.startswith("outputs:") and prim.GetTypeName() == "Shader":
            return Source(None, UsdShade.Shader(prim), base_name[len("outputs:") :])
        return Source(attribute, None, "")

    def _warn_of_dangling(self, shader: UsdShade.Shader, shader_input: UsdShade.Input) -> None:
        connections = shader_input.GetAttr().GetConnections()
        if connections:
            self.warn(
                shader,
                f"{shader_input.GetFullName()} is connected to {connections[0]}, which gives no value; the default is "
                f"used. Connect it to an output that exists, or author a value.",
            )

    def _preset_value(self, path: Sdf.Path, name: str) -> Source:
        if self.preset is None or path != self.preset.prim.GetPath():
            return NOTHING
        attribute = self.preset.prim.GetAttribute(f"inputs:{name}")
        return Source(attribute, None, "") if attribute else NOTHING

    def value(self, shader: UsdShade.Shader, name: str) -> Any:
        """Return the constant value of an input; None where there is none or a shader computes it."""
        attribute = self.source(shader, name).attribute
        return None if attribute is None else current_value(attribute)

    def floats(self, shader: UsdShade.Shader, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return the constant value as as many floats as the default has, or the default."""
        return self.as_floats(shader, name, self.value(shader, name), default)

    def number(self, shader: UsdShade.Shader, name: str, default: float) -> float:
        return self.floats(shader, name, (default,))[0]

    def flag(self, shader: UsdShade.Shader, name: str, default: bool) -> bool:
        value = self.value(shader, name)
        return default if value is None else bool(value)

    def as_floats(
        self, shader: UsdShade.Shader, name: str, value: Any, default: tuple[float, ...]
    ) -> tuple[float, ...]:
        if value is None:
            return default
        numbers = as_floats(value, len(default))
        if numbers is None or not all(map(math.isfinite, numbers)):
            self.warn(shader, f"inputs:{name} = {value} is not usable; {default} is used. Correct the value.")
            return default
        return numbers

    def use_uv(self, shader: UsdShade.Shader, primvar: str) -> None:
        """Note the primvar of a texture's coordinates; a material has one set of them, so a second one is warned of."""
        if self.uv_primvar is None:
            self.uv_primvar = primvar
        elif self.uv_primvar != primvar:
            self.warn(
                shader,
                f"this texture asks for primvars:{primvar}, others of {self.material.GetPath()} for "
                f"primvars:{self.uv_primvar}, which is used for all. Give them the same texture coordinates.",
            )


def shader_id(shader: UsdShade.Shader) -> str:
    return str(shader.GetIdAttr().Get() or "")

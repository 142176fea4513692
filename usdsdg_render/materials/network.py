"""The UsdShade network of a material while it is read: an input is a constant or another shader's output."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pxr import Sdf, Usd, UsdShade

from usdsdg import errors
from usdsdg_render.materials.mdl.module import Preset
from usdsdg_render.materials.shading import Material, PrimvarInput
from usdsdg_render.usd.authored_values import as_floats
from usdsdg_render.usd.color_spaces import current_color, is_converted


class Source(NamedTuple):
    """Where the value of an input comes from: `attribute` holds it, or `shader` computes it as `output`."""

    attribute: Usd.Attribute | None
    shader: UsdShade.Shader | None
    output: str


NOTHING = Source(None, None, "")
MakeFields = Callable[[Sequence[Any], Sequence[Any]], Sequence[Any]]


@dataclass(slots=True)
class Reading:
    """An attribute of a network, and the fields of the material for which it was read; "" stands for all of them."""

    attribute: Usd.Attribute
    value: Any
    fields: set[str] = field(default_factory=set)
    # Where its only field depends on nothing else: a function of values and of what is noted here for each of them.
    alone: MakeFields | None = None
    given: Any = None


@dataclass
class Network:
    """The shading network of one material while it is read; `visited` collects the prims that it depends on."""

    material: Usd.Prim
    visited: set[Sdf.Path] = field(default_factory=set)
    uv_primvar: str | None = None
    reads_display_color: bool = False
    primvar_inputs: list[PrimvarInput] = field(default_factory=list)
    preset: Preset | None = None  # of inputs of the surface that are not authored
    readings: dict[tuple[Sdf.Path, str], Reading] = field(default_factory=dict)  # by prim and name of the attribute
    _fields: dict[str, Callable[[], Any]] = field(default_factory=dict)
    _field: str = ""  # that is being read
    _alone: dict[str, Reading] = field(default_factory=dict)  # by the field
    _inputs: dict[Sdf.Path, dict[str, UsdShade.Input]] = field(default_factory=dict)
    # By id of the shader, which the value holds, and name: a look-up by path takes ten times as long.
    _sources: dict[tuple[int, str], tuple[Source, Reading | None, UsdShade.Shader]] = field(default_factory=dict)

    def read_fields(self, fields: dict[str, Callable[[], Any]]) -> Material:
        """Return a material of fields that are each read by a function, and remember which one reads what."""
        self._fields = fields
        return Material(**{name: self._read_field(name) for name in fields})

    def _read_field(self, name: str) -> Any:
        self._field = name
        if name in self._alone:
            self._alone.pop(name).alone = None
        try:
            return self._fields[name]()
        finally:
            self._field = ""

    def changed_fields(self, prim: Sdf.Path, names: Iterable[str]) -> dict[str, Any] | None:
        """Read the fields again that depend on attributes of a prim whose values changed.

        Returns:
            None where only reading the whole material again can tell: an attribute concerns more than `read_fields`
            knows, was not read before, or does not give its own value any more.
        """
        stale: set[str] = set()
        for name in names:
            reading = self.readings.get((prim, name))
            if reading is None or "" in reading.fields or not reading.attribute:
                return None
            if reading.attribute.HasAuthoredConnections():
                return None
            reading.value = current_color(reading.attribute)
            if reading.value is None:
                return None
            stale |= reading.fields
        return {name: self._read_field(name) for name in stale}

    def note_alone(self, shader: UsdShade.Shader, name: str, make: MakeFields, given: Any = None) -> None:
        """Note that the field that is being read depends on this input only, while the others are as they are.

        make: returns the field for each of some values of the input, and for what is `given` with each; None for those
            that are not usable.
        """
        reading = self._noted(shader, name)[1]
        if reading is None or reading.fields != {self._field}:
            return
        if not reading.attribute.HasColorSpace() and not is_converted(reading.attribute):
            reading.alone, reading.given = make, given
            self._alone[self._field] = reading

    def warn(self, shader: UsdShade.Shader | Usd.Prim, message: str) -> None:
        prim = shader if isinstance(shader, Usd.Prim) else shader.GetPrim()
        errors.warn_once(f"{prim.GetPath()}: {message}")

    def source(self, shader: UsdShade.Shader, name: str) -> Source:
        """Follow an input through node graphs and the material's interface to what gives its value."""
        return self._noted(shader, name)[0]

    def _noted(self, shader: UsdShade.Shader, name: str) -> tuple[Source, Reading | None, UsdShade.Shader]:
        """Look up an input, and note that the field that is being read depends on it."""
        found = self._sources.get((id(shader), name)) or self._look_up(shader, name)
        if found[1] is not None:
            found[1].fields.add(self._field)
        return found

    def _look_up(self, shader: UsdShade.Shader, name: str) -> tuple[Source, Reading | None, UsdShade.Shader]:
        """Return the source of an input, what is read there, and the shader."""
        source = self._find(shader, shader.GetPath(), name)
        reading = None if source.attribute is None else self._reading(source.attribute)
        found = self._sources[id(shader), name] = source, reading, shader
        return found

    def _reading(self, attribute: Usd.Attribute) -> Reading:
        key = attribute.GetPrimPath(), attribute.GetName()
        if key not in self.readings:
            # Those of a preset are not on the stage: they say nothing of attributes there of the same path.
            fields = set() if self.preset is None else {""}
            self.readings[key] = Reading(attribute, current_color(attribute), fields)
        return self.readings[key]

    def _find(self, shader: UsdShade.Shader, path: Sdf.Path, name: str) -> Source:
        if path not in self._inputs:
            self._inputs[path] = {i.GetBaseName(): i for i in shader.GetInputs(onlyAuthored=True)}
        shader_input = self._inputs[path].get(name)
        if shader_input is None:
            return self._preset_value(path, name)
        attributes = shader_input.GetValueProducingAttributes()
        if not attributes:
            self._warn_of_dangling(shader_input.GetAttr(), "the default is used")
            return NOTHING
        attribute = attributes[0]
        if attribute.HasAuthoredConnections():
            self._warn_of_dangling(attribute, "the value authored beside it is used")
        prim = attribute.GetPrim()
        self.visited.add(prim.GetPath())
        base_name = attribute.GetName()
        if base_name.startswith("outputs:") and prim.GetTypeName() == "Shader":
            return Source(None, UsdShade.Shader(prim), base_name[len("outputs:") :])
        return Source(attribute, None, "")

    def _warn_of_dangling(self, attribute: Usd.Attribute, used: str) -> None:
        """Warn of a connection to nothing, in whose place something else is used."""
        connections = attribute.GetConnections()
        if connections and not self._is_left_open(connections[0]):
            self.warn(
                attribute.GetPrim(),
                f"{attribute.GetName()} is connected to {connections[0]}, which gives no value; {used}. Connect it to "
                "an output that exists, or author a value.",
            )

    def _is_left_open(self, path: Sdf.Path) -> bool:
        """Whether an attribute is an input of a material or node graph without a value."""
        attribute = self.material.GetStage().GetAttributeAtPath(path)
        return bool(attribute) and UsdShade.Input.IsInput(attribute) and not attribute.HasAuthoredConnections()

    def _preset_value(self, path: Sdf.Path, name: str) -> Source:
        if self.preset is None or path != self.preset.prim.GetPath():
            return NOTHING
        attribute = self.preset.prim.GetAttribute(f"inputs:{name}")
        return Source(attribute, None, "") if attribute else NOTHING

    def value(self, shader: UsdShade.Shader, name: str) -> Any:
        """Return the constant value of an input; None where there is none, or (with a warning) a shader computes it."""
        source, reading, _ = self._noted(shader, name)
        self._warn_of_computed(shader, name, source)
        return None if reading is None else reading.value

    def constant(self, shader: UsdShade.Shader, name: str) -> Usd.Attribute | None:
        """Return the attribute with the constant value of an input; None where `value` is."""
        source = self.source(shader, name)
        self._warn_of_computed(shader, name, source)
        return source.attribute

    def _warn_of_computed(self, shader: UsdShade.Shader, name: str, source: Source) -> None:
        if source.shader is not None:
            self.warn(
                shader,
                f"inputs:{name} is connected to {source.shader.GetPath()}, but is read as a constant; the default is "
                "used. Author a value.",
            )

    def floats(self, shader: UsdShade.Shader, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return the constant value as as many floats as the default has, or the default."""
        return self.as_floats(shader, name, self.value(shader, name), default)

    def number(self, shader: UsdShade.Shader, name: str, default: float) -> float:
        return self.floats(shader, name, (default,))[0]

    def limited(self, shader: UsdShade.Shader, name: str, default: float, highest: float = 1.0) -> float:
        """Return `number` from 0 to `highest`, with a warning if it is not."""
        value = self.number(shader, name, default)
        limited = min(max(value, 0.0), highest)
        if limited != value:
            within = "0 or more" if highest == math.inf else f"a value from 0 to {highest:g}"
            errors.warn_once(
                f"{shader.GetPath()}: inputs:{name} is {value:g}, of which {limited:g} is used. Author {within}.",
                key=f"{shader.GetPath()}: inputs:{name} is out of range",  # whatever it is in other frames
            )
        return limited

    def ior(self, shader: UsdShade.Shader, name: str, default: float) -> float:
        """Return an index of refraction; of 0 for what is none, with a warning."""
        value = self.number(shader, name, default)
        if value <= 0.0:
            errors.warn_once(
                f"{shader.GetPath()}: inputs:{name} = {value:g} is no index of refraction: the surface is a mirror. "
                "Author 1 or more, such as 1.5 for glass.",
                key=f"{shader.GetPath()}: inputs:{name} is no index of refraction",
            )
        return max(value, 0.0)

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

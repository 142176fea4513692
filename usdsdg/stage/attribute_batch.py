"""Batched authoring of one attribute of many prims.

USD resolves and notifies at every `Set`; here the Sdf specs are looked up once and set within one ChangeBlock.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pxr import Sdf, Usd, Vt

# Conversion of NumPy rows to values of a type; attributes of other types are set one by one.
_CONVERTERS: dict[str, Callable[[np.ndarray], Sequence[Any]]] = {
    "float": lambda rows: rows.astype(np.float32).tolist(),
    "double": lambda rows: rows.tolist(),
    "float2": lambda rows: Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(rows, np.float32)),
    "float3": lambda rows: Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows, np.float32)),
    "double3": lambda rows: Vt.Vec3dArray.FromNumpy(np.ascontiguousarray(rows, np.float64)),
    "float[]": lambda rows: list(map(Vt.FloatArray.FromNumpy, np.ascontiguousarray(rows, np.float32))),
    "float2[]": lambda rows: list(map(Vt.Vec2fArray.FromNumpy, np.ascontiguousarray(rows, np.float32))),
    "float3[]": lambda rows: list(map(Vt.Vec3fArray.FromNumpy, np.ascontiguousarray(rows, np.float32))),
}
_SIZES = {"float2": 2, "float3": 3, "double3": 3, "float2[]": 2, "float3[]": 3}
# Types with a role, by the type that stores them.
_STORAGE = {
    f"{role}3f{array}": f"float3{array}" for role in ("color", "vector", "point", "normal") for array in ("", "[]")
}
_STORAGE["texCoord2f[]"] = "float2[]"


class Expired(Exception):
    """A spec of a batch is gone."""


def set_defaults(specs: Sequence[Sdf.AttributeSpec], values: Sequence[Any]) -> None:
    """Set the default value of each spec, in the `Sdf.ChangeBlock` of the caller.

    Raises:
        Expired: one is gone; those before it are set.
    """
    try:
        for spec, value in zip(specs, values):
            spec.default = value
    except (RuntimeError, TypeError) as error:  # pxr raises either of a spec that is gone
        if any(spec.expired for spec in specs):
            raise Expired from error
        raise


class AttributeBatch:
    """The specs of one attribute of many prims, in the edit target's layer; all attributes have one type."""

    def __init__(self, attributes: Sequence[Usd.Attribute]) -> None:
        """Look up the specs.

        Raises:
            ValueError: one does not exist, the type is not supported, types differ, or paths differ
                between stage and layer.
        """
        if not all(attributes):
            raise ValueError("no batch for attributes that do not exist")
        names = {str(attribute.GetTypeName()) for attribute in attributes}
        name = names.pop() if len(names) == 1 else ""
        self._type = _STORAGE.get(name, name)
        if self._type not in _CONVERTERS and self._type != "token":
            raise ValueError(f"no batch for attributes of type {name}")
        stage = attributes[0].GetStage()
        self._target = stage.GetEditTarget()
        if not self._target.GetMapFunction().isIdentity or len({a.GetPath() for a in attributes}) < len(attributes):
            raise ValueError("no batch for these prims")
        layer = self._target.GetLayer()
        with Sdf.ChangeBlock():
            self._specs = [_spec(layer, attribute) for attribute in attributes]
        self._stage = stage

    @property
    def is_current(self) -> bool:
        """Whether the edit target is unchanged."""
        return self._stage.GetEditTarget() == self._target

    def write(self, values: Any) -> bool:
        """Set one value per attribute; return False, with nothing written, for values that need `Usd.Attribute.Set`.

        Raises:
            Expired: an attribute was removed; others may be written.
        """
        converted = self._converted(values)
        if converted is None:
            return False
        with Sdf.ChangeBlock():
            set_defaults(self._specs, converted)
        return True

    def _converted(self, values: Any) -> Sequence[Any] | None:
        if self._type == "token":
            return values if all(isinstance(value, str) for value in values) else None
        try:
            rows = np.asarray(values, np.float64)
        except (TypeError, ValueError):
            return None
        size = _SIZES.get(self._type, 0)
        if self._type.endswith("[]"):
            return self._converted_arrays(rows, size)
        if size and rows.shape == (len(self._specs),):
            rows = np.repeat(rows[:, None], size, axis=1)
        wanted = (len(self._specs), size) if size else (len(self._specs),)
        return _CONVERTERS[self._type](rows) if rows.shape == wanted else None

    def _converted_arrays(self, rows: np.ndarray, size: int) -> Sequence[Any] | None:
        """Convert one array per prim, all of one length; one vector is an array of it."""
        if size and rows.ndim == 2:
            rows = rows[:, None]
        fits = rows.ndim == (3 if size else 2) and len(rows) == len(self._specs) and (not size or rows.shape[2] == size)
        return _CONVERTERS[self._type](rows) if fits else None


def _spec(layer: Sdf.Layer, attribute: Usd.Attribute) -> Sdf.AttributeSpec:
    path = attribute.GetPath()
    if not layer.GetAttributeAtPath(path):
        Sdf.JustCreatePrimAttributeInLayer(layer, path, attribute.GetTypeName(), isCustom=attribute.IsCustom())
    return layer.GetAttributeAtPath(path)


def write_batch(state: dict[str, Any], key: str, find: Callable[[], Sequence[Usd.Attribute]], values: Any) -> bool:
    """Write through the batch that is cached in `state[key]`, made of `find()` if it is missing or outdated.

    Returns:
        False, with nothing written, when there is no batch for these attributes or values.
    """
    batch = state.get(key)
    if isinstance(batch, AttributeBatch) and batch.is_current:
        try:
            return batch.write(values)
        except Expired:
            batch = None
    if batch is not False:
        try:
            batch = AttributeBatch(find())
        except ValueError:
            batch = False
        state[key] = batch
    return isinstance(batch, AttributeBatch) and batch.write(values)

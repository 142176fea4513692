"""Restore the opinions that layers had before the simulation wrote to them."""

from collections.abc import Collection
from dataclasses import dataclass

from pxr import Sdf, Ts, Usd

_ABSENT = object()


@dataclass(frozen=True)
class _SetAside:
    """What an attribute had in a layer in place of the default value that it was given."""

    value: object
    samples: dict[float, object]
    spline: Ts.Spline | None

    def put_back(self, spec: Sdf.AttributeSpec) -> None:
        _clear_samples(spec)
        for time, sample in self.samples.items():
            spec.SetTimeSample(time, sample)
        if self.spline is not None:
            spec.SetSpline(self.spline)


class Backup:
    """Remembered opinions of attributes; `restore` puts back exactly these, and removes what was not there.

    Specs are held and not their paths, for they follow prims that are renamed or moved.
    """

    def __init__(self) -> None:
        # Default values; _ABSENT of an attribute that was not there, None of one without a default.
        self._values: dict[Sdf.AttributeSpec, object] = {}
        self._created: list[Sdf.PrimSpec] = []
        self._set_aside: dict[Sdf.AttributeSpec, _SetAside] = {}
        # Of attributes and prims that have no spec yet, until `hold` finds that.
        self._absent: dict[tuple[Sdf.Layer, Sdf.Path], None] = {}

    def keep(self, layer: Sdf.Layer, path: Sdf.Path) -> bool:
        """Remember the opinion of an attribute, before it is written for the first time; return whether it is that."""
        spec = layer.GetAttributeAtPath(path)
        is_first = (layer, path) not in self._absent and spec not in self._values
        if spec is not None:
            if is_first:
                self._values[spec] = spec.default
            return is_first
        while path != Sdf.Path.absoluteRootPath and layer.GetObjectAtPath(path) is None:
            self._absent[layer, path] = None
            path = path.GetParentPath()
        return is_first

    def set_aside(self, spec: Sdf.AttributeSpec, value: object) -> None:
        """Give an attribute a default value in place of its samples and its spline, which `restore` puts back."""
        samples = {time: spec.QueryTimeSample(time) for time in spec.ListTimeSamples()}
        self._set_aside[spec] = _SetAside(value, samples, spec.GetSpline() if spec.HasSpline() else None)
        _clear_samples(spec)
        spec.default = Sdf.ValueBlock() if value is None else value

    def hold(self) -> None:
        """Find the specs of what was not there and has been made since; call it before a user can edit the stage."""
        for layer, path in self._absent:
            spec = layer.GetObjectAtPath(path)
            if isinstance(spec, Sdf.AttributeSpec):
                self._values.setdefault(spec, _ABSENT)
            elif isinstance(spec, Sdf.PrimSpec):
                self._created.append(spec)
        self._absent.clear()

    def restore_prims(self, prims: Collection[str]) -> None:
        """Restore the opinions of some prims but for what was set aside, and keep remembering them."""
        with Sdf.ChangeBlock():
            for spec, value in self._values.items():
                if not spec.expired and str(spec.path.GetPrimPath().StripAllVariantSelections()) in prims:
                    _restore(spec, self._set_aside[spec].value if spec in self._set_aside else value)

    def restore(self) -> None:
        """Restore every remembered opinion and forget it; layers that are gone need none."""
        with Sdf.ChangeBlock():
            for spec, value in self._values.items():
                if not spec.expired:
                    _restore(spec, value)
            for spec, aside in self._set_aside.items():
                if not spec.expired:
                    aside.put_back(spec)
            # What is deeper first, so that an over that held nothing but another is empty too.
            there = [spec for spec in self._created if not spec.expired]
            for spec in sorted(there, key=lambda spec: spec.path.pathElementCount, reverse=True):
                if _is_empty(spec):
                    del (spec.nameParent or spec.layer.pseudoRoot).nameChildren[spec.name]
        self._values.clear()
        self._set_aside.clear()
        self._created.clear()


def _clear_samples(spec: Sdf.AttributeSpec) -> None:
    spec.ClearInfo("timeSamples")
    spec.ClearSpline()


def _restore(spec: Sdf.AttributeSpec, value: object) -> None:
    if value is _ABSENT:
        spec.owner.RemoveProperty(spec)
    elif value is None:
        spec.ClearDefaultValue()
    else:
        spec.default = value


def _is_empty(spec: Sdf.PrimSpec) -> bool:
    """Return whether a prim spec is an over without opinions."""
    return (
        spec.specifier == Sdf.SpecifierOver
        and not spec.nameChildren
        and not spec.properties
        and set(spec.ListInfoKeys()) <= {"specifier"}
    )


def attribute_spec(target: Usd.EditTarget, attribute: Usd.Attribute) -> Sdf.AttributeSpec:
    """Return an attribute's spec in an edit target, created where it is missing."""
    path = target.MapToSpecPath(attribute.GetPath())
    layer = target.GetLayer()
    spec = layer.GetAttributeAtPath(path)
    if spec is None:
        owner = Sdf.CreatePrimInLayer(layer, path.GetPrimPath())
        spec = Sdf.AttributeSpec(owner, path.name, attribute.GetTypeName(), Sdf.VariabilityVarying)
        spec.custom = False
    return spec

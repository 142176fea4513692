"""What layers said before the simulation wrote to them."""

from __future__ import annotations

from collections.abc import Collection

from pxr import Sdf, Usd

_ABSENT = object()


class Backup:
    """Opinions of attributes in a layer, put back by `restore` exactly: an attribute without one loses it again."""

    def __init__(self) -> None:
        # (layer, spec path) -> default value; _ABSENT for no attribute at all, None for one without a default.
        self._values: dict[tuple[Sdf.Layer, Sdf.Path], object] = {}
        # Prim specs that were made to hold attributes.
        self._made: list[tuple[Sdf.Layer, Sdf.Path]] = []

    def keep(self, layer: Sdf.Layer, path: Sdf.Path) -> None:
        """Remember the opinion of an attribute, the first time that it is mentioned."""
        if (layer, path) in self._values:
            return
        spec = layer.GetAttributeAtPath(path)
        self._values[layer, path] = _ABSENT if spec is None else spec.default
        if spec is None:
            prim_path = path.GetPrimPath()
            while prim_path != Sdf.Path.absoluteRootPath and layer.GetPrimAtPath(prim_path) is None:
                self._made.append((layer, prim_path))
                prim_path = prim_path.GetParentPath()

    def put_back(self, prims: Collection[str]) -> None:
        """Put the remembered opinions of some prims back, and go on remembering them."""
        with Sdf.ChangeBlock():
            for layer, path in self._values:
                if str(path.GetPrimPath().StripAllVariantSelections()) in prims:
                    self._put_back(layer, path)

    def restore(self) -> None:
        """Put every remembered opinion back and forget it."""
        with Sdf.ChangeBlock():
            for layer, path in self._values:
                self._put_back(layer, path)
            for layer, path in self._made:
                spec = layer.GetPrimAtPath(path)
                if spec is not None and _says_nothing(spec):
                    del (spec.nameParent or layer.pseudoRoot).nameChildren[spec.name]
        self._values.clear()
        self._made.clear()

    def _put_back(self, layer: Sdf.Layer, path: Sdf.Path) -> None:
        value, spec = self._values[layer, path], layer.GetAttributeAtPath(path)
        if spec is None:
            return
        if value is _ABSENT:
            spec.owner.RemoveProperty(spec)
        elif value is None:
            spec.ClearDefaultValue()
        else:
            spec.default = value


def _says_nothing(spec: Sdf.PrimSpec) -> bool:
    return (
        spec.specifier == Sdf.SpecifierOver
        and not spec.nameChildren
        and not spec.properties
        and set(spec.ListInfoKeys()) <= {"specifier"}
    )


def attribute_spec(target: Usd.EditTarget, attribute: Usd.Attribute) -> Sdf.AttributeSpec:
    """The attribute's spec in an edit target, made where it is missing."""
    path = target.MapToSpecPath(attribute.GetPath())
    layer = target.GetLayer()
    spec = layer.GetAttributeAtPath(path)
    if spec is None:
        owner = Sdf.CreatePrimInLayer(layer, path.GetPrimPath())
        spec = Sdf.AttributeSpec(owner, path.name, attribute.GetTypeName(), Sdf.VariabilityVarying)
        spec.custom = False
    return spec

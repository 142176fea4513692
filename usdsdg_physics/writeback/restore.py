"""Restore the opinions that layers had before the simulation wrote to them."""

from collections.abc import Collection

from pxr import Sdf, Usd

_ABSENT = object()


class Backup:
    """Remembered opinions of attributes; `restore` puts back exactly these, and removes what was not there."""

    def __init__(self) -> None:
        # Default value by layer and spec path; _ABSENT for no attribute at all, None for one without a default.
        self._values: dict[tuple[Sdf.Layer, Sdf.Path], object] = {}
        # Prim specs that did not exist.
        self._created: list[tuple[Sdf.Layer, Sdf.Path]] = []

    def keep(self, layer: Sdf.Layer, path: Sdf.Path) -> None:
        """Remember the opinion of an attribute, before it is written for the first time."""
        if (layer, path) in self._values:
            return
        spec = layer.GetAttributeAtPath(path)
        self._values[layer, path] = _ABSENT if spec is None else spec.default
        if spec is None:
            prim_path = path.GetPrimPath()
            while prim_path != Sdf.Path.absoluteRootPath and layer.GetPrimAtPath(prim_path) is None:
                self._created.append((layer, prim_path))
                prim_path = prim_path.GetParentPath()

    def restore_prims(self, prims: Collection[str]) -> None:
        """Restore the opinions of some prims, and keep remembering them."""
        with Sdf.ChangeBlock():
            for layer, path in self._values:
                if str(path.GetPrimPath().StripAllVariantSelections()) in prims:
                    self._restore_attribute(layer, path)

    def restore(self) -> None:
        """Restore every remembered opinion and forget it; layers that are gone need none."""
        with Sdf.ChangeBlock():
            for layer, path in self._values:
                self._restore_attribute(layer, path)
            for layer, path in self._created:
                if layer.expired:
                    continue
                spec = layer.GetPrimAtPath(path)
                if spec is not None and _is_empty(spec):
                    del (spec.nameParent or layer.pseudoRoot).nameChildren[spec.name]
        self._values.clear()
        self._created.clear()

    def _restore_attribute(self, layer: Sdf.Layer, path: Sdf.Path) -> None:
        value = self._values[layer, path]
        spec = None if layer.expired else layer.GetAttributeAtPath(path)
        if spec is None:
            return
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

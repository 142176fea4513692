"""Python classes of codeless applied API schemas, generated from their plugInfo.json and generatedSchema.usda.

`prim.HasAPI(SomeAPI)` asks pxr for the Tf type of the class. That needs three things: plugInfo.json lists the
type under the class's full Python name, the class derives from `Usd.APISchemaBase`, and it is passed to
`Tf.Type.Define`. The base cannot be instantiated from Python, so `SomeAPI(prim)` returns an object of a second class,
which has the methods.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from pxr import Sdf, Tf, Usd

from usdsdg.stage.change_tracker import schemas_only

# Placeholder of the instance name in the property names of a multiple-apply schema.
_INSTANCE = "__INSTANCE_NAME__"


class Property(NamedTuple):
    """One attribute or relationship of a schema; `type_name` is None for a relationship."""

    name: str
    type_name: Sdf.ValueTypeName | None
    variability: Sdf.Variability

    def on(self, instance: str | None) -> str:
        """Return the full name of the property, for an instance of a multiple-apply schema."""
        return self.name.replace(_INSTANCE, instance) if instance else self.name


def make_classes(resources: Path, module: str) -> dict[str, type]:
    """Make a class for each schema that plugInfo.json in `resources` declares for `module`; return them by name."""
    info = json.loads((resources / "plugInfo.json").read_text())
    layer = Sdf.Layer.FindOrOpen(str(resources / "generatedSchema.usda"))
    classes = {}
    for full_name, kind in info["Plugins"][0]["Info"]["Types"].items():
        declared_in, _, name = full_name.rpartition(".")
        if declared_in == module:
            schema = layer.GetPrimAtPath(f"/{kind['schemaIdentifier']}")
            multiple = kind["schemaKind"] == "multipleApplyAPI"
            classes[name] = _make_class(name, module, kind["schemaIdentifier"], _properties(schema), multiple)
    return classes


def _properties(schema: Sdf.PrimSpec) -> dict[str, Property]:
    """Return the properties by API name, such as `TimeStepsPerSecond` of `physxScene:timeStepsPerSecond`."""
    found = {}
    for spec in schema.properties:
        api_name = spec.customData.get("apiName") or spec.name.rpartition(":")[2]
        type_name = spec.typeName if isinstance(spec, Sdf.AttributeSpec) else None
        found[api_name[0].upper() + api_name[1:]] = Property(spec.name, type_name, spec.variability)
    return found


class Schema:
    """A schema on one prim, as `SomeAPI(prim)` returns it, with its Get and Create methods; false if not applied."""

    _api: type
    _multiple = False
    _table: dict[str, Property] = {}

    def __init__(self, prim: Usd.Prim | Usd.SchemaBase | None = None, name: str = "") -> None:
        self._prim: Usd.Prim = (
            prim if isinstance(prim, Usd.Prim) else prim.GetPrim() if prim is not None else Usd.Prim()
        )
        self._name = name

    def GetPrim(self) -> Usd.Prim:
        return self._prim

    def GetPath(self) -> Sdf.Path:
        """Return the path of the prim; for a multiple-apply schema that of the instance's property namespace."""
        if not self._prim or not self._multiple:
            return self._prim.GetPath() if self._prim else Sdf.Path()
        namespace = next(iter(self._table.values())).name.split(_INSTANCE)[0] + self._name
        return self._prim.GetPath().AppendProperty(namespace)

    def GetName(self) -> str:
        """Return the instance name of a multiple-apply schema, else the empty string."""
        return self._name

    def __bool__(self) -> bool:
        if not self._prim:
            return False
        return self._prim.HasAPI(self._api, self._name) if self._multiple else self._prim.HasAPI(self._api)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Schema) and (self._api, self._prim, self._name) == (
            other._api,
            other._prim,
            other._name,
        )

    def __hash__(self) -> int:
        return hash((self._api, self._prim, self._name))

    def __repr__(self) -> str:
        instance = f", {self._name!r}" if self._multiple else ""
        return f"{self._api.__name__}({self._prim!r}{instance})"

    def _get(self, prop: Property) -> Usd.Attribute | Usd.Relationship:
        name = prop.on(self._name)
        return self._prim.GetAttribute(name) if prop.type_name else self._prim.GetRelationship(name)

    def _create(self, prop: Property, default: Any, sparsely: bool) -> Usd.Attribute | Usd.Relationship:
        name = prop.on(self._name)
        if prop.type_name is None:
            return self._prim.CreateRelationship(name, custom=False)
        if sparsely and default is not None and self._prim.GetAttribute(name).Get() == default:
            return self._prim.GetAttribute(name)
        attribute = self._prim.CreateAttribute(name, prop.type_name, False, prop.variability)
        if default is not None:
            attribute.Set(default)
        return attribute


def _make_class(name: str, module: str, identifier: str, table: dict[str, Property], multiple: bool) -> type:
    """Make the class that scripts import, and the class of the objects that it constructs."""
    methods: dict[str, Any] = {"_table": table, "_multiple": multiple, "__module__": module}
    for api_name, prop in table.items():
        suffix = "Attr" if prop.type_name else "Rel"
        methods[f"Get{api_name}{suffix}"] = _getter(prop)
        methods[f"Create{api_name}{suffix}"] = _creator(prop)
    objects = type(f"{name}Object", (Schema,), methods)

    def construct(cls: type, prim: Usd.Prim | None = None, name: str = "") -> Schema:
        return objects(prim, name)

    # Calls on the class (`SomeAPI.GetFooAttr(schema)`) work too, as with classes made by usdGenSchema.
    shared = {key: value for key, value in methods.items() if key.startswith(("Get", "Create"))}
    statics = _statics_multiple(identifier, table) if multiple else _statics_single()
    api = type(name, (Usd.APISchemaBase,), {"__new__": construct, "__module__": module, **shared, **statics})
    objects._api = api
    Tf.Type.Define(api)
    return api


def _getter(prop: Property) -> Callable[[Schema], Any]:
    return lambda self: self._get(prop)


def _creator(prop: Property) -> Callable[..., Any]:
    def create(self: Schema, defaultValue: Any = None, writeSparsely: bool = False) -> Any:
        return self._create(prop, defaultValue, writeSparsely)

    return create


def _statics_single() -> dict[str, Any]:
    def apply(cls: type, prim: Usd.Prim) -> Schema:
        with schemas_only():
            prim.ApplyAPI(cls)
        return cls(prim)

    def get(cls: type, stage: Usd.Stage, path: Sdf.Path | str) -> Schema:
        return cls(stage.GetPrimAtPath(path))

    def can_apply(cls: type, prim: Usd.Prim) -> Any:
        return prim.CanApplyAPI(cls)

    return {"Apply": classmethod(apply), "Get": classmethod(get), "CanApply": classmethod(can_apply)}


def _statics_multiple(identifier: str, table: dict[str, Property]) -> dict[str, Any]:
    prefix = next(iter(table.values())).name.split(_INSTANCE)[0]

    def apply(cls: type, prim: Usd.Prim, name: str) -> Schema:
        with schemas_only():
            prim.ApplyAPI(cls, name)
        return cls(prim, name)

    def get(cls: type, where: Usd.Stage | Usd.Prim, name: Sdf.Path | str) -> Schema:
        """Return the schema of (prim, instance name) or (stage, path of the instance, such as /World/a.semantic:x)."""
        if isinstance(where, Usd.Prim):
            return cls(where, str(name))
        path = Sdf.Path(name)
        return cls(where.GetPrimAtPath(path.GetPrimPath()), path.name.removeprefix(prefix))

    def get_all(cls: type, prim: Usd.Prim) -> list[Schema]:
        applied = (schema.partition(":") for schema in prim.GetAppliedSchemas())
        return [cls(prim, name) for schema, _, name in applied if schema == identifier]

    def can_apply(cls: type, prim: Usd.Prim, name: str) -> Any:
        return prim.CanApplyAPI(cls, name)

    def is_path(cls: type, path: Sdf.Path) -> bool:
        return path.IsPropertyPath() and path.name.startswith(prefix)

    found = {"Apply": apply, "Get": get, "GetAll": get_all, "CanApply": can_apply}
    return {key: classmethod(function) for key, function in found.items()} | {"_is_path": classmethod(is_path)}

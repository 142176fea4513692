"""Name, once for each kind, what is authored on a stage for physics and is not simulated."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

from pxr import Sdf, Tf, Usd

from usdsdg.errors import warn_once
from usdsdg.stage.time_code import current_value
from usdsdg_physics.parse.misplaced import (
    misplaced_attribute,
    misplaced_schema,
    partly_read,
    sampled_attribute,
)
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.parse.schema_table import (
    UNREAD_BUT_MET,
    Unread,
    is_physics_attribute,
    is_physics_schema,
    unread_attribute,
    unread_schema,
)

_LEADING_AXIS = ":referenceJointAxis"
_OF_ONE_AXIS = ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint")

# A property by name, of a prim at a path; the name of a schema where nothing of it is authored.
_Finding = tuple[str, str]


class UnreadNames:
    """Collects schemas and attributes that have no effect while the prims of a stage are visited."""

    def __init__(self) -> None:
        self._found: dict[Unread, list[_Finding]] = {}
        self._prototypes: set[Sdf.Path] = set()

    def visit(self, prim: Usd.Prim) -> None:
        """Look at one prim; of all instances of a prototype, only at the prims of the first."""
        if prim.IsInstanceProxy():
            original = prim.GetPrimInPrototype().GetPath()
            if original in self._prototypes:
                return
            self._prototypes.add(original)
        names = prim.GetAuthoredPropertyNames()
        self.visit_properties(prim, names)
        if (part := partly_read(prim, names)) is not None:
            self._add(part[1], prim, part[0])
        # Unlike `GetAppliedSchemas`, with those that are not registered.
        for schema in (str(prim.GetTypeName()), *prim.GetPrimTypeInfo().GetAppliedAPISchemas()):
            name = schema.partition(":")[0]
            if is_physics_schema(name) and (row := unread_schema(name) or misplaced_schema(prim, name)) is not None:
                self._add(row, prim, name)

    def visit_properties(self, prim: Usd.Prim, names: Iterable[str]) -> None:
        """Look at some properties of a prim."""
        for name in filter(is_physics_attribute, names):
            row = unread_attribute(name) or misplaced_attribute(prim, name)
            if row is not None:
                row = row if _differs(prim, name) else None
            elif attribute := prim.GetAttribute(name):
                row = sampled_attribute(attribute)
            if row is not None:
                self._add(row, prim, name)

    def warn(self) -> None:
        """Warn of each kind, once for a stage."""
        for row, findings in self._found.items():
            paths = list(dict.fromkeys(path for path, _ in findings))
            names = list(dict.fromkeys(name for _, name in findings))
            warn_once(f"{listed(paths)}: {listed(names)}: {row.follows}.", key=f"unread {row.follows}")

    def _add(self, row: Unread, prim: Usd.Prim, name: str) -> None:
        self._found.setdefault(row, []).append((str(prim.GetPath()), name))


def warn_unread(prim: Usd.Prim, names: Iterable[str]) -> None:
    """Warn of those of the properties that were just authored that have no effect."""
    if prim and any(map(is_physics_attribute, names)):
        found = UnreadNames()
        found.visit_properties(prim, names)
        found.warn()


def _differs(prim: Usd.Prim, name: str) -> bool:
    """Return whether a property has a value that is neither its schema's fallback nor met in any case."""
    attribute = prim.GetAttribute(name)
    if not attribute:
        return prim.GetRelationship(name).HasAuthoredTargets()
    if not attribute.HasAuthoredValue():
        return False
    if name.endswith(_LEADING_AXIS) and _has_one_axis(prim.GetRelationship(name.removesuffix("Axis"))):
        return False
    value = current_value(attribute)
    met = (_fallbacks().get(_without_instance(name)), *UNREAD_BUT_MET.get(name, ()))
    return value is None or value not in met


def _has_one_axis(leader: Usd.Relationship) -> bool:
    """Return whether the joint that another one mimics has one axis, which any name of an axis means."""
    prims = (leader.GetStage().GetPrimAtPath(path) for path in leader.GetTargets()[:1]) if leader else ()
    return any(prim and prim.GetTypeName() in _OF_ONE_AXIS for prim in prims)


def _without_instance(name: str) -> str:
    head, _, rest = name.partition(":")
    instance, _, last = rest.partition(":")
    return f"{head}:__INSTANCE_NAME__:{last}" if instance and last else name


@cache
def _fallbacks() -> dict[str, object]:
    """Return the value that each attribute of a registered physics schema has where none is authored."""
    registry = Usd.SchemaRegistry()
    found: dict[str, object] = {}
    for schema in map(Usd.SchemaRegistry.GetSchemaTypeName, Tf.Type.Find(Usd.SchemaBase).GetAllDerivedTypes()):
        if is_physics_schema(schema):
            definition = registry.FindAppliedAPIPrimDefinition(schema) or registry.FindConcretePrimDefinition(schema)
            names = definition.GetPropertyNames() if definition else ()
            found.update((name, definition.GetAttributeFallbackValue(name)) for name in names)
    return found

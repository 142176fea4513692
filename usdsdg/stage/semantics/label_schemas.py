"""The two schemas that hold labels on prims: what each of them has, and what is written to both.

New: `UsdSemantics.LabelsAPI`, one token array per type, `semantics:labels:<type>`. Old: Replicator's
`SemanticsAPI`, one instance per (type, label) pair. Each write also notes the labels in the prim's customData, so that
labels that one schema got by other means can be told from those that both have.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from pxr import Sdf, Tf, Usd, UsdSemantics, Vt

from usdsdg import errors
from usdsdg.stage.attributes import remove_value
from usdsdg.stage.change_tracker import schemas_only
from usdsdg.stage.schemas import semantics_schema

Labels = dict[str, list[str]]

_NEW, _OLD = "SemanticsLabelsAPI", "SemanticsAPI"
# What the names of properties of labels begin with, in the new schema and in the old one.
PREFIXES = ("semantics:", "semantic:")
_NOTED = "usdsdgLabels"  # key of the prim's customData: the labels by type that both schemas had when written last
_DEFAULT = Usd.TimeCode.Default()


def schemas_of_labels(prim: Usd.Prim) -> list[str]:
    """Return the applied schemas of labels, new and old, as `Schema:instance`."""
    return [schema for schema in prim.GetAppliedSchemas() if schema.startswith("Semantics")]


def label_attribute(schema: str) -> str:
    """Return the name of the attribute that holds the labels of a schema `Schema:instance`; "" for other schemas."""
    kind, _, instance = schema.partition(":")
    return _new_attribute(instance) if kind == _NEW else _old_attribute(instance) if kind == _OLD else ""


def schema_of_attribute(name: str) -> str:
    """Return the schema `Schema:instance` whose labels an attribute holds; "" for other attributes."""
    if name.startswith("semantics:labels:"):
        return f"{_NEW}:{name.removeprefix('semantics:labels:')}"
    if name.startswith("semantic:") and name.endswith(":params:semanticData"):
        return f"{_OLD}:{name.removeprefix('semantic:').removesuffix(':params:semanticData')}"
    return ""


def _new_attribute(semantic_type: str) -> str:
    return f"semantics:labels:{semantic_type}"


def _old_attribute(instance: str, part: str = "Data") -> str:
    return f"semantic:{instance}:params:semantic{part}"


def new_labels(prim: Usd.Prim, schemas: Iterable[str], time: Usd.TimeCode = _DEFAULT) -> Labels:
    """Return the labels of the new schema by type; an empty list where they are authored to be none, or blocked."""
    found: Labels = {}
    for kind, _, instance in (schema.partition(":") for schema in schemas):
        if kind == _NEW:
            attribute = prim.GetAttribute(_new_attribute(instance))
            tokens = _tokens(attribute, time)
            if tokens or is_authored(attribute):
                extend(found, instance, tokens)
    return found


def old_labels(prim: Usd.Prim, schemas: Iterable[str], time: Usd.TimeCode = _DEFAULT) -> Labels:
    """Return the labels of the old schema by type."""
    found: Labels = {}
    for kind, _, instance in (schema.partition(":") for schema in schemas):
        if kind == _OLD:
            semantic_type, label = old_pair(prim, instance, time)
            if semantic_type and label.strip():
                extend(found, semantic_type, (label,))
    return found


class HeldLabels(NamedTuple):
    """The labels of one prim by type: those of the new schema, of the old one, and the noted ones."""

    new: Labels
    old: Labels
    noted: Mapping[str, Sequence[str]]


def held_labels(prim: Usd.Prim, schemas: Sequence[str], time: Usd.TimeCode = _DEFAULT) -> HeldLabels:
    """Return what these schemas of a prim hold at a time."""
    return HeldLabels(new_labels(prim, schemas, time), old_labels(prim, schemas, time), noted_labels(prim))


def is_written(prim: Usd.Prim, semantic_type: str, labels: Sequence[str], held: HeldLabels) -> bool:
    """Whether `write` would change nothing: both schemas have these labels, authored where edits go, and the note."""
    new, old, noted = (each.get(semantic_type) or () for each in held)
    if not list(new) == list(labels) == list(noted) or set(old) != set(labels):
        return False
    here = prim.GetPath().AppendProperty(_new_attribute(semantic_type))
    spec = prim.GetStage().GetEditTarget().GetSpecForScenePath(here)
    return bool(spec) and spec.HasInfo("default")


def noted_labels(prim: Usd.Prim) -> Mapping[str, Sequence[str]]:
    """Return the labels by type that both schemas had when they were written last."""
    return prim.GetCustomDataByKey(_NOTED) or {}


def extend(found: Labels, semantic_type: str, labels: Iterable[str]) -> None:
    """Add labels of a type to those found before, each label once."""
    known = found.setdefault(semantic_type, [])
    known.extend(label for label in labels if label not in known)


def is_authored(attribute: Usd.Attribute) -> bool:
    """Whether a value is authored, or blocked."""
    return bool(attribute) and (attribute.HasAuthoredValue() or attribute.GetResolveInfo().ValueIsBlocked())


def _tokens(attribute: Usd.Attribute, time: Usd.TimeCode) -> tuple[str, ...]:
    """Return the tokens of an array, or a single token; nothing, with a warning, for a value of another type.

    Labels of nothing but spaces are none.
    """
    value = attribute.Get(time) if attribute else None
    if value is None:
        return ()
    if isinstance(value, str):
        value = [value]
    if not isinstance(value, (Vt.TokenArray, Vt.StringArray, list)):
        errors.warn_once(f"{attribute.GetPath()}: {value} is not a label. Author an array of tokens.")
        return ()
    return tuple(str(each) for each in value if str(each).strip())


def old_pair(prim: Usd.Prim, instance: str, time: Usd.TimeCode = _DEFAULT) -> tuple[str, str]:
    """Return the type and the label of an instance of the old schema; "" for what is not authored."""
    return _text(prim, _old_attribute(instance, "Type"), time), _text(prim, _old_attribute(instance), time)


def _text(prim: Usd.Prim, name: str, time: Usd.TimeCode) -> str:
    attribute = prim.GetAttribute(name)
    return str((attribute.Get(time) if attribute else None) or "")


def old_instances(prim: Usd.Prim, semantic_type: str | None = None) -> list[str]:
    """Return the names of the instances of the old schema: all, or those of one type."""
    names = [name.partition(":")[2] for name in prim.GetAppliedSchemas() if name.startswith(f"{_OLD}:")]
    return [name for name in names if semantic_type in (None, old_pair(prim, name)[0])]


def is_old_stronger(prim: Usd.Prim, semantic_type: str) -> bool:
    """Whether the old schema's labels of a type are authored in a stronger layer, or arc, than those of the new one."""
    place = _strength(prim)
    names = [_old_attribute(instance) for instance in old_instances(prim, semantic_type)]
    return min(map(place, names), default=0) < place(_new_attribute(semantic_type))


def _strength(prim: Usd.Prim) -> Callable[[str], int]:
    """Return a function from an attribute's name to the place of its strongest opinion, 0 for the strongest."""
    order = {(spec.layer, spec.path): place for place, spec in enumerate(prim.GetPrimStack())}

    def place(name: str) -> int:
        specs = prim.GetAttribute(name).GetPropertyStack()
        return min((order.get((spec.layer, spec.path.GetPrimPath()), len(order)) for spec in specs), default=len(order))

    return place


def write(prim: Usd.Prim, semantic_type: str, labels: list[str]) -> None:
    """Make these the labels of a type in both schemas, and note them."""
    # A type that is not an identifier cannot name an instance of the new schema; the old schema holds any string.
    if labels and Sdf.Path.IsValidNamespacedIdentifier(semantic_type):
        with schemas_only():
            UsdSemantics.LabelsAPI.Apply(prim, semantic_type).CreateLabelsAttr().Set(labels)
        _note(prim, {semantic_type: labels})
    held = {old_pair(prim, instance)[1]: instance for instance in old_instances(prim, semantic_type)}
    for label in held.keys() - set(labels):
        _drop_old(prim, held[label])
    for label in labels:
        if label not in held:
            instance = f"Semantics_{Tf.MakeValidIdentifier(semantic_type)}_{Tf.MakeValidIdentifier(label)}"
            write_old(prim, _free_instance(prim, instance), semantic_type, label)


def write_old(prim: Usd.Prim, instance: str, semantic_type: str, label: str) -> None:
    """Write a label to an instance of the old schema alone."""
    api = semantics_schema.SemanticsAPI.Apply(prim, instance)
    api.CreateSemanticTypeAttr().Set(semantic_type)
    api.CreateSemanticDataAttr().Set(label)


def _free_instance(prim: Usd.Prim, instance: str) -> str:
    """Return an unused instance name: different labels may give the same identifier ("a b" and "a_b")."""
    taken, count, name = set(old_instances(prim)), 0, instance
    while name in taken:
        count += 1
        name = f"{instance}_{count:02d}"
    return name


def _note(prim: Usd.Prim, labels: Mapping[str, Sequence[str]]) -> None:
    """Note the labels of some types as what both schemas have."""
    noted = dict(noted_labels(prim))
    noted.update({semantic_type: Vt.TokenArray(list(values)) for semantic_type, values in labels.items()})
    prim.SetCustomDataByKey(_NOTED, noted)


def forget_written(prim: Usd.Prim, types: Iterable[str]) -> None:
    """Forget what both schemas had of some types: what is authored counts, in whichever schema it is."""
    noted = noted_labels(prim)
    if left_out := noted.keys() & set(types):
        prim.SetCustomDataByKey(_NOTED, {each: labels for each, labels in noted.items() if each not in left_out})


def drop(prim: Usd.Prim, types: set[str] | None) -> None:
    """Remove the labels of some types (None: all) from both schemas, and note that there are none."""
    for schema in prim.GetAppliedSchemas():
        kind, _, instance = schema.partition(":")
        if kind == _NEW and (types is None or instance in types):
            with schemas_only():
                prim.RemoveAPI(UsdSemantics.LabelsAPI, instance)
            remove_value(prim, _new_attribute(instance))
        elif kind == _OLD and (types is None or old_pair(prim, instance)[0] in types):
            _drop_old(prim, instance)
    noted = noted_labels(prim)
    if gone := {each: [] for each, labels in noted.items() if len(labels) and (types is None or each in types)}:
        _note(prim, gone)


def _drop_old(prim: Usd.Prim, instance: str) -> None:
    with schemas_only():
        prim.RemoveAPI(semantics_schema.SemanticsAPI, instance)
    remove_value(prim, _old_attribute(instance, "Type"))
    remove_value(prim, _old_attribute(instance))

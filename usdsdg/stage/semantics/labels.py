"""Semantic labels on prims, in the two schemas that scripts and assets use.

New: `UsdSemantics.LabelsAPI`, one token array per type, `semantics:labels:<type>`. Old: Replicator's
`SemanticsAPI`, one instance per (type, label) pair. Labels are written in both, so that every version of
Isaac Sim reads a saved stage. Each write also stores the labels in the prim's customData (`WRITTEN`). If a script edits
one schema by other means, its labels differ from the stored ones and are read; the unedited copy in the other schema is
ignored. Without stored labels, the schema with the stronger opinion is read; in one layer, the new schema.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Literal

from pxr import Sdf, Tf, Usd, UsdSemantics, Vt

from usdsdg import errors
from usdsdg.stage.attributes import remove_value
from usdsdg.stage.change_tracker import schemas_only
from usdsdg.stage.schemas import semantics_schema

Labels = dict[str, list[str]]

_NEW, _OLD = "SemanticsLabelsAPI", "SemanticsAPI"
WRITTEN = "usdsdgLabels"  # key of the prim's customData: the labels by type that both schemas had when written last
_DEFAULT = Usd.TimeCode.Default()


def get_labels(prim: Usd.Prim, time: Usd.TimeCode = _DEFAULT) -> Labels:
    """Return the prim's own labels at a time by type, in the order authored; types without any are left out."""
    schemas = [schema for schema in prim.GetAppliedSchemas() if schema.startswith("Semantics")]
    if not schemas:
        return {}
    new, old = _new_labels(prim, schemas, time), _old_labels(prim, schemas, time)
    written = prim.GetCustomDataByKey(WRITTEN) or {}
    found = {each: _truth(prim, each, new.get(each), old.get(each), written.get(each)) for each in {**new, **old}}
    return {semantic_type: labels for semantic_type, labels in found.items() if labels}


def _truth(
    prim: Usd.Prim, semantic_type: str, new: list[str] | None, old: list[str] | None, written: Sequence[str] | None
) -> list[str]:
    """Return the labels of a type of which the schemas have `new` and `old`; None: nothing."""
    if written is not None:
        noted = list(written)
        if (new or []) == noted:
            return old or []
        if (old or []) == noted:
            return new or []
    if new is None or old is None:
        return new or old or []
    if set(new) == set(old) or not _is_old_stronger(prim, semantic_type):
        return new
    return old


def _new_labels(prim: Usd.Prim, schemas: Iterable[str], time: Usd.TimeCode) -> Labels:
    """Return the labels of the new schema by type; an empty list where they are authored to be none, or blocked."""
    found: Labels = {}
    for kind, _, instance in (schema.partition(":") for schema in schemas):
        if kind == _NEW:
            attribute = prim.GetAttribute(f"semantics:labels:{instance}")
            tokens = _tokens(attribute, time)
            if tokens or (attribute and attribute.HasAuthoredValue()) or _is_blocked(attribute):
                _extend(found, instance, tokens)
    return found


def _old_labels(prim: Usd.Prim, schemas: Iterable[str], time: Usd.TimeCode) -> Labels:
    """Return the labels of the old schema by type."""
    found: Labels = {}
    for kind, _, instance in (schema.partition(":") for schema in schemas):
        if kind == _OLD:
            semantic_type, label = _old_pair(prim, instance, time)
            if semantic_type and label.strip():
                _extend(found, semantic_type, (label,))
    return found


def _is_blocked(attribute: Usd.Attribute) -> bool:
    return bool(attribute) and attribute.GetResolveInfo().ValueIsBlocked()


def _is_old_stronger(prim: Usd.Prim, semantic_type: str) -> bool:
    """Whether the old schema's labels of a type are authored in a stronger layer, or arc, than those of the new one."""
    names = [f"semantic:{instance}:params:semanticData" for instance in _old_instances(prim, semantic_type)]
    return min(map(_strength(prim), names), default=0) < _strength(prim)(f"semantics:labels:{semantic_type}")


def _strength(prim: Usd.Prim) -> Callable[[str], int]:
    """Return a function from an attribute's name to the place of its strongest opinion, 0 for the strongest."""
    order = {(spec.layer, spec.path): place for place, spec in enumerate(prim.GetPrimStack())}

    def place(name: str) -> int:
        specs = prim.GetAttribute(name).GetPropertyStack()
        return min((order.get((spec.layer, spec.path.GetPrimPath()), len(order)) for spec in specs), default=len(order))

    return place


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


def is_labeled(prim: Usd.Prim) -> bool:
    """Return whether a prim has one of the schemas of labels, if only without a label."""
    return any(schema.startswith("Semantics") for schema in prim.GetAppliedSchemas())


def labels_without_schema(prim: Usd.Prim) -> list[tuple[str, str]]:
    """Return the (attribute, schema) pairs of labels that do not count, since the prim lacks the schema."""
    found = []
    for name in prim.GetAuthoredPropertyNames(lambda each: each.startswith("semantic")):
        if name.startswith("semantics:labels:"):
            schema = f"{_NEW}:{name.removeprefix('semantics:labels:')}"
        elif name.startswith("semantic:") and name.endswith(":params:semanticData"):
            schema = f"{_OLD}:{name.removeprefix('semantic:').removesuffix(':params:semanticData')}"
        else:
            continue
        # An attribute that another layer brings is left without a value where labels were removed.
        if schema not in prim.GetAppliedSchemas() and prim.GetAttribute(name).Get():
            found.append((name, schema))
    return found


def schemas_without_label(prim: Usd.Prim) -> list[tuple[str, str]]:
    """Return the (schema, attribute) pairs of schemas that a prim has and of whose labels nothing is authored.

    Labels that are authored to be none, or blocked, are meant so.
    """
    found = []
    for schema in prim.GetAppliedSchemas():
        kind, _, instance = schema.partition(":")
        if kind in (_NEW, _OLD):
            name = f"semantics:labels:{instance}" if kind == _NEW else f"semantic:{instance}:params:semanticData"
            attribute = prim.GetAttribute(name)
            if not (attribute and (attribute.HasAuthoredValue() or _is_blocked(attribute))):
                found.append((schema, name))
    return found


def vary_over_time(prim: Usd.Prim) -> bool:
    """Return whether the prim's own labels have time samples."""
    return is_labeled(prim) and any(
        attribute.GetName().startswith(("semantics:", "semantic:")) and attribute.GetNumTimeSamples()
        for attribute in prim.GetAuthoredAttributes()
    )


def merged(chain: Iterable[Mapping[str, Sequence[str]]]) -> Labels:
    """Return the labels of several prims together by type, each label once, in the order of the prims."""
    found: Labels = {}
    for each in chain:
        for semantic_type, labels in each.items():
            _extend(found, semantic_type, labels)
    return found


def add_labels(
    prim: Usd.Prim,
    labels: Mapping[str, str | Sequence[str]] | Iterable[tuple[str, str]],
    *,
    mode: Literal["add", "replace", "clear"] = "add",
) -> None:
    """Add labels to a prim, by type: {"class": ["mug"]} or [("class", "mug")].

    "add" keeps earlier labels; "replace" removes the earlier labels of the given types; "clear" removes all earlier
    ones.

    Raises:
        BadPrim: the prim cannot be edited.
        ValueError: unknown mode, or a type or label that is not a non-empty string.
    """
    wanted = _normalized(labels)
    _check_editable(prim)
    before = get_labels(prim)
    after = edited(before, wanted, mode=mode)
    if dropped := _dropped(before, wanted, mode):
        _drop(prim, dropped)
    for semantic_type in wanted:
        _write(prim, semantic_type, after[semantic_type])


def edited(before: Mapping[str, Sequence[str]], labels: Mapping[str, str | Sequence[str]], *, mode: str) -> Labels:
    """Return what `add_labels` makes of the labels `before`, by type.

    Raises:
        ValueError: as `add_labels`.
    """
    wanted = _normalized(labels)
    dropped = _dropped(before, wanted, mode)
    return merged([{each: labels for each, labels in before.items() if each not in dropped}, wanted])


def _dropped(before: Mapping[str, Sequence[str]], wanted: Labels, mode: str) -> set[str]:
    """Return the types whose labels a mode removes."""
    if mode not in ("add", "replace", "clear"):
        raise ValueError(f"unknown mode {mode!r} for labels; use 'add', 'replace' or 'clear'")
    return set(before) if mode == "clear" else set(wanted) & set(before) if mode == "replace" else set()


def add_update_semantics(prim: Usd.Prim, semantic_label: str, type_label: str = "class", suffix: str = "") -> None:
    """Set the prim's label of a type, replacing earlier ones, as Isaac Sim 4's helper of this name.

    With a `suffix` only the label that the same suffix set earlier is replaced, so that a prim can hold several.
    """
    if not suffix:
        add_labels(prim, {type_label: [semantic_label]}, mode="replace")
        return
    instance = f"Semantics{suffix}"
    if instance in _old_instances(prim):
        semantic_type, earlier = _old_pair(prim, instance)
        kept = [value for value in get_labels(prim).get(semantic_type, []) if value != earlier]
        _drop(prim, {semantic_type})
        _write(prim, semantic_type, kept)
    _write_old(prim, instance, type_label, semantic_label)
    add_labels(prim, {type_label: [semantic_label]})


def remove_labels(prim: Usd.Prim, *, recursive: bool = False) -> None:
    """Remove all labels of a prim, and with `recursive` of all prims below it, including referenced labels.

    An instance with labels inside is made editable for this (SetInstanceable(False)), with a warning.

    Raises:
        BadPrim: the prim lies inside an instance.
    """
    _check_editable(prim)
    if not recursive:
        _drop(prim, None)
        return
    for each in _editable_descendants(prim):
        _drop(each, None)


def _extend(found: Labels, semantic_type: str, labels: Iterable[str]) -> None:
    known = found.setdefault(semantic_type, [])
    known.extend(label for label in labels if label not in known)


def _old_pair(prim: Usd.Prim, instance: str, time: Usd.TimeCode = _DEFAULT) -> tuple[str, str]:
    attributes = (prim.GetAttribute(f"semantic:{instance}:params:semantic{part}") for part in ("Type", "Data"))
    values = (attribute.Get(time) if attribute else None for attribute in attributes)
    semantic_type, label = (str(value or "") for value in values)
    return semantic_type, label


def _normalized(labels: Mapping[str, str | Sequence[str]] | Iterable[tuple[str, str]]) -> Labels:
    pairs = labels.items() if isinstance(labels, Mapping) else labels
    wanted: Labels = {}
    for semantic_type, values in pairs:
        values = [values] if isinstance(values, str) else list(values)
        for text in (semantic_type, *values):
            if not isinstance(text, str) or not text.strip():
                raise ValueError(f"labels and their types are non-empty strings, not {text!r} (in {labels!r})")
        _extend(wanted, semantic_type, values)  # pyright: ignore[reportArgumentType]  # a str, checked above
    return wanted


def _check_editable(prim: Usd.Prim) -> None:
    if not isinstance(prim, Usd.Prim):
        hint = f"stage.GetPrimAtPath({str(prim)!r})" if str(prim).startswith("/") else "stage.GetPrimAtPath(path)"
        raise errors.BadPrim(f"labels are those of a prim, not of {prim!r}: pass {hint}")
    if not prim:
        raise errors.BadPrim(
            f"cannot label {prim}: it does not exist. There was nothing at the path that the script asked for, or it "
            "is not there any more"
        )
    if prim.IsInstanceProxy() or prim.IsInPrototype():
        raise errors.BadPrim(
            f"cannot edit labels of {prim.GetPath()}: it lies inside an instance; "
            "label the instance or SetInstanceable(False)"
        )


def _write(prim: Usd.Prim, semantic_type: str, labels: list[str]) -> None:
    # A type that is not an identifier cannot name an instance of the new schema; the old schema holds any string.
    if labels and Sdf.Path.IsValidNamespacedIdentifier(semantic_type):
        with schemas_only():
            UsdSemantics.LabelsAPI.Apply(prim, semantic_type).CreateLabelsAttr().Set(labels)
        _note(prim, {semantic_type: labels})
    held = {_old_pair(prim, instance)[1]: instance for instance in _old_instances(prim, semantic_type)}
    for label in held.keys() - set(labels):
        _drop_old(prim, held[label])
    for label in labels:
        if label not in held:
            instance = f"Semantics_{Tf.MakeValidIdentifier(semantic_type)}_{Tf.MakeValidIdentifier(label)}"
            _write_old(prim, _free_instance(prim, instance), semantic_type, label)


def _write_old(prim: Usd.Prim, instance: str, semantic_type: str, label: str) -> None:
    api = semantics_schema.SemanticsAPI.Apply(prim, instance)
    api.CreateSemanticTypeAttr().Set(semantic_type)
    api.CreateSemanticDataAttr().Set(label)


def _old_instances(prim: Usd.Prim, semantic_type: str | None = None) -> list[str]:
    """Return the names of the instances of the old schema: all, or those of one type."""
    names = [name.partition(":")[2] for name in prim.GetAppliedSchemas() if name.startswith(f"{_OLD}:")]
    return [name for name in names if semantic_type in (None, _old_pair(prim, name)[0])]


def _note(prim: Usd.Prim, labels: Mapping[str, Sequence[str]]) -> None:
    """Note the labels of some types as what both schemas have."""
    noted = dict(prim.GetCustomDataByKey(WRITTEN) or {})
    noted.update({semantic_type: Vt.TokenArray(list(values)) for semantic_type, values in labels.items()})
    prim.SetCustomDataByKey(WRITTEN, noted)


def forget_written(prim: Usd.Prim, types: Iterable[str]) -> None:
    """Forget what both schemas had of some types: what is authored counts, in whichever schema it is."""
    noted = dict(prim.GetCustomDataByKey(WRITTEN) or {})
    if left_out := noted.keys() & set(types):
        prim.SetCustomDataByKey(WRITTEN, {each: labels for each, labels in noted.items() if each not in left_out})


def _free_instance(prim: Usd.Prim, instance: str) -> str:
    """Return an unused instance name: different labels may give the same identifier ("a b" and "a_b")."""
    taken, count, name = set(_old_instances(prim)), 0, instance
    while name in taken:
        count += 1
        name = f"{instance}_{count:02d}"
    return name


def _drop(prim: Usd.Prim, types: set[str] | None) -> None:
    """Remove the labels of some types (None: all) from both schemas."""
    for schema in prim.GetAppliedSchemas():
        kind, _, instance = schema.partition(":")
        if kind == _NEW and (types is None or instance in types):
            with schemas_only():
                prim.RemoveAPI(UsdSemantics.LabelsAPI, instance)
            remove_value(prim, f"semantics:labels:{instance}")
        elif kind == _OLD and (types is None or _old_pair(prim, instance)[0] in types):
            _drop_old(prim, instance)
    noted = prim.GetCustomDataByKey(WRITTEN) or {}
    if gone := {each: [] for each, labels in noted.items() if len(labels) and (types is None or each in types)}:
        _note(prim, gone)


def _drop_old(prim: Usd.Prim, instance: str) -> None:
    with schemas_only():
        prim.RemoveAPI(semantics_schema.SemanticsAPI, instance)
    remove_value(prim, f"semantic:{instance}:params:semanticType")
    remove_value(prim, f"semantic:{instance}:params:semanticData")


def _editable_descendants(root: Usd.Prim) -> Iterator[Usd.Prim]:
    """Yield the prim and all below it; instances with labels inside are made ordinary prims first."""
    pending = [root]
    while pending:
        prim = pending.pop()
        if prim.IsInstance() and _has_labels_inside(prim):
            errors.warn_once(
                f"{prim.GetPath()} is an instance with labels inside; to remove them it is made an ordinary prim"
            )
            prim.SetInstanceable(False)
        yield prim
        pending.extend(prim.GetFilteredChildren(Usd.PrimAllPrimsPredicate))


def _has_labels_inside(instance: Usd.Prim) -> bool:
    inside = Usd.PrimRange(instance.GetPrototype(), Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
    return any(get_labels(prim) for prim in inside)

"""Semantic labels on prims, whichever of the two schemas (`label_schemas`) scripts and assets use.

Labels are written in both schemas, so that every version of Isaac Sim reads a saved stage, and noted. If a script edits
one schema by other means, its labels differ from the noted ones and are read; the unedited copy in the other schema is
ignored. Without noted labels, the schema with the stronger opinion is read; in one layer, the new schema.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Literal

from pxr import Usd

from usdsdg import errors
from usdsdg.stage.semantics import label_schemas
from usdsdg.stage.semantics.label_schemas import HeldLabels, Labels, extend

_DEFAULT = Usd.TimeCode.Default()


def get_labels(prim: Usd.Prim, time: Usd.TimeCode = _DEFAULT) -> Labels:
    """Return the prim's own labels at a time by type, in the order authored; types without any are left out."""
    schemas = label_schemas.schemas_of_labels(prim)
    return _counting(prim, label_schemas.held_labels(prim, schemas, time)) if schemas else {}


def _counting(prim: Usd.Prim, held: HeldLabels) -> Labels:
    """Return the labels that count, by type, of those that the schemas of a prim hold."""
    new, old, noted = held
    found = {each: _truth(prim, each, new.get(each), old.get(each), noted.get(each)) for each in {**new, **old}}
    return {semantic_type: labels for semantic_type, labels in found.items() if labels}


def _truth(
    prim: Usd.Prim, semantic_type: str, new: list[str] | None, old: list[str] | None, noted: Sequence[str] | None
) -> list[str]:
    """Return the labels of a type of which the schemas have `new` and `old`; None: nothing."""
    if noted is not None:
        if (new or []) == list(noted):
            return old or []
        if (old or []) == list(noted):
            return new or []
    if new is None or old is None:
        return new or old or []
    if set(new) == set(old) or not label_schemas.is_old_stronger(prim, semantic_type):
        return new
    return old


def is_labeled(prim: Usd.Prim) -> bool:
    """Return whether a prim has one of the schemas of labels, if only without a label."""
    return any(schema.startswith("Semantics") for schema in prim.GetAppliedSchemas())


def labels_without_schema(prim: Usd.Prim) -> list[tuple[str, str]]:
    """Return the (attribute, schema) pairs of labels that do not count, since the prim lacks the schema."""
    found = []
    for name in prim.GetAuthoredPropertyNames(lambda each: each.startswith("semantic")):
        schema = label_schemas.schema_of_attribute(name)
        # An attribute that another layer brings is left without a value where labels were removed.
        if schema and schema not in prim.GetAppliedSchemas() and prim.GetAttribute(name).Get():
            found.append((name, schema))
    return found


def schemas_without_label(prim: Usd.Prim) -> list[tuple[str, str]]:
    """Return the (schema, attribute) pairs of schemas that a prim has and of whose labels nothing is authored.

    Labels that are authored to be none, or blocked, are meant so.
    """
    pairs = ((schema, label_schemas.label_attribute(schema)) for schema in prim.GetAppliedSchemas())
    return [(schema, name) for schema, name in pairs if name and not label_schemas.is_authored(prim.GetAttribute(name))]


def vary_over_time(prim: Usd.Prim) -> bool:
    """Return whether the prim's own labels have time samples."""
    return is_labeled(prim) and any(
        attribute.GetName().startswith(label_schemas.PREFIXES) and attribute.GetNumTimeSamples()
        for attribute in prim.GetAuthoredAttributes()
    )


def merged(chain: Iterable[Mapping[str, Sequence[str]]]) -> Labels:
    """Return the labels of several prims together by type, each label once, in the order of the prims."""
    found: Labels = {}
    for each in chain:
        for semantic_type, labels in each.items():
            extend(found, semantic_type, labels)
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
    held = label_schemas.held_labels(prim, label_schemas.schemas_of_labels(prim))
    before = _counting(prim, held)
    after = edited(before, wanted, mode=mode)
    if after == before and all(label_schemas.is_written(prim, each, after[each], held) for each in wanted):
        return  # as in most frames, where a graph labels what it has labeled before
    if dropped := _dropped(before, wanted, mode):
        label_schemas.drop(prim, dropped)
    for semantic_type in wanted:
        label_schemas.write(prim, semantic_type, after[semantic_type])


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
    if instance in label_schemas.old_instances(prim):
        semantic_type, earlier = label_schemas.old_pair(prim, instance)
        kept = [value for value in get_labels(prim).get(semantic_type, []) if value != earlier]
        label_schemas.drop(prim, {semantic_type})
        label_schemas.write(prim, semantic_type, kept)
    label_schemas.write_old(prim, instance, type_label, semantic_label)
    add_labels(prim, {type_label: [semantic_label]})


def remove_labels(prim: Usd.Prim, *, recursive: bool = False) -> None:
    """Remove all labels of a prim, and with `recursive` of all prims below it, including referenced labels.

    An instance with labels inside is made editable for this (SetInstanceable(False)), with a warning.

    Raises:
        BadPrim: the prim lies inside an instance.
    """
    _check_editable(prim)
    if not recursive:
        label_schemas.drop(prim, None)
        return
    for each in _editable_descendants(prim):
        label_schemas.drop(each, None)


def _normalized(labels: Mapping[str, str | Sequence[str]] | Iterable[tuple[str, str]]) -> Labels:
    pairs = labels.items() if isinstance(labels, Mapping) else labels
    wanted: Labels = {}
    for semantic_type, values in pairs:
        values = [values] if isinstance(values, str) else list(values)
        for text in (semantic_type, *values):
            if not isinstance(text, str) or not text.strip():
                raise errors.BadValue(f"labels and their types are non-empty strings, not {text!r} (in {labels!r})")
        extend(wanted, semantic_type, values)  # pyright: ignore[reportArgumentType]  # a str, checked above
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

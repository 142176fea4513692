"""`isaacsim.core.experimental.utils.semantics`: labels of prims by taxonomy, such as "class"."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pxr import Usd, UsdSemantics

from usdsdg.compat.wrappers import labels as upgrades
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.stage.semantics import labels as semantics

_SCHEMA = "SemanticsLabelsAPI:"


def add_labels(prim: str | Usd.Prim, *, labels: str | Sequence[str], taxonomy: str = "class") -> None:
    """Add labels to those that the prim has."""
    semantics.add_labels(existing_prim(prim), {taxonomy: labels})


def get_labels(prim: str | Usd.Prim, *, include_descendants: bool = False) -> dict[str, list[str]]:
    """Return the labels of a prim by taxonomy; those of descendants follow in the order of the stage.

    Labels that are authored in the old schema alone are left out, as there: `upgrade_prim_semantics_to_labels` first.
    """
    found: dict[str, list[str]] = {}
    for each in _range(existing_prim(prim), include_descendants):
        own = semantics.get_labels(each)
        for taxonomy in _taxonomies(each):
            found.setdefault(taxonomy, []).extend(own.get(taxonomy, []))
    return found


def remove_labels(
    prim: str | Usd.Prim,
    *,
    labels: str | Sequence[str],
    taxonomy: str | None = None,
    include_descendants: bool = False,
) -> None:
    """Remove some labels, of one taxonomy or of all."""
    unwanted = {labels} if isinstance(labels, str) else set(labels)
    for each in _range(existing_prim(prim), include_descendants):
        own = semantics.get_labels(each)
        for kind in own if taxonomy is None else own.keys() & {taxonomy}:
            kept = [label for label in own[kind] if label not in unwanted]
            if kept != own[kind]:
                semantics.add_labels(each, {kind: kept}, mode="replace")
                _keep_taxonomies(each, [kind])


def remove_all_labels(
    prim: str | Usd.Prim, *, remove_taxonomies: bool = False, include_descendants: bool = False
) -> None:
    """Remove all labels; the taxonomies stay, without labels, unless `remove_taxonomies`."""
    root = existing_prim(prim)
    kept = {} if remove_taxonomies else {each: _taxonomies(each) for each in _range(root, include_descendants)}
    semantics.remove_labels(root, recursive=include_descendants)
    for each, taxonomies in kept.items():
        _keep_taxonomies(each, taxonomies)


def upgrade_prim_semantics_to_labels(prim: str | Usd.Prim, *, include_descendants: bool = False) -> list[str]:
    """Replace labels in the old schema by labels in the new one; return the paths of the prims that had some."""
    return [str(each.GetPath()) for each in _range(existing_prim(prim), include_descendants) if upgrades.upgrade(each)]


def _range(prim: Usd.Prim, include_descendants: bool) -> Iterable[Usd.Prim]:
    return list(Usd.PrimRange(prim)) if include_descendants else [prim]


def _taxonomies(prim: Usd.Prim) -> list[str]:
    return [name.removeprefix(_SCHEMA) for name in prim.GetAppliedSchemas() if name.startswith(_SCHEMA)]


def _keep_taxonomies(prim: Usd.Prim, taxonomies: Iterable[str]) -> None:
    for taxonomy in taxonomies:
        labels = UsdSemantics.LabelsAPI.Apply(prim, taxonomy)
        if not semantics.get_labels(prim).get(taxonomy):
            labels.CreateLabelsAttr().Set([])

"""`semantics.schema.editor`: labels of prims, with the functions of Omniverse's Semantics Schema Editor."""

import enum
from collections.abc import Mapping, Sequence

from pxr import Usd

from usdsdg.errors import ArgumentError
from usdsdg.stage.semantics import labels as semantics

__all__ = [
    "LabelWriteType", "PrimSemanticData", "add_prim_semantics", "add_semantics", "clear_semantics",
    "remove_prim_semantics",
]  # fmt: skip

Labels = str | Sequence[str] | Mapping[str, str | Sequence[str]]


class LabelWriteType(enum.Enum):
    """What happens to labels that a prim has: kept beside the new ones, replaced, or kept without new ones."""

    NEW = 0
    OVERWRITE = 1
    SKIP = 2


class PrimSemanticData:
    """The labels of one prim."""

    def __init__(self, prim: Usd.Prim) -> None:
        self._prim = prim

    def add_entry(self, inst: str = "class", labels: str = "") -> None:
        """Add labels, separated by commas, of the type `inst`.

        Raises:
            ArgumentError: the type or the labels are empty.
        """
        names = [label.strip() for label in labels.split(",") if label.strip()]
        if not inst or not names:
            raise ArgumentError(f"{self._prim.GetPath()}: add_entry({inst!r}, {labels!r}) needs a type and a label")
        semantics.add_labels(self._prim, {inst: names})

    def remove_entry(self, inst: str) -> None:
        """Remove all labels of the type `inst`.

        Raises:
            ArgumentError: the prim has none.
        """
        if inst not in semantics.get_labels(self._prim):
            raise ArgumentError(f"{self._prim.GetPath()} has no labels of type {inst!r}")
        clear_semantics(self._prim, inst)

    def get_entries(self) -> dict[str, list[str]]:
        """Return the labels by type."""
        return semantics.get_labels(self._prim)

    def clear(self) -> None:
        """Remove all labels."""
        semantics.remove_labels(self._prim)


def add_semantics(prim: Usd.Prim, instance: str, labels: str | Sequence[str], mode: str = "add") -> None:
    """Add labels of the type `instance` ("add"), or replace those that there are ("replace")."""
    names = [labels] if isinstance(labels, str) else list(labels)
    semantics.add_labels(prim, {instance: names}, mode="replace" if mode == "replace" else "add")


def clear_semantics(prim: Usd.Prim, instance: str | None = None) -> None:
    """Remove the labels of the type `instance`, or all."""
    kept = {kind: names for kind, names in semantics.get_labels(prim).items() if instance and kind != instance}
    semantics.remove_labels(prim)
    if kept:
        semantics.add_labels(prim, kept)


def add_prim_semantics(
    prims: Usd.Prim | Sequence[Usd.Prim],
    data: Labels,
    instance: str = "class",
    write_type: LabelWriteType = LabelWriteType.NEW,
    preview: bool = False,
    auto_convert_legacy: bool = True,
) -> str:
    """Add labels to prims; return a line for each prim and type. preview: write nothing.

    data: labels of the type `instance`, or labels by type. auto_convert_legacy is ignored: labels are always written in
        both schemas.
    """
    by_type = data if isinstance(data, Mapping) else {instance: data}
    lines = []
    for prim in prims if isinstance(prims, (list, tuple)) else [prims]:
        for kind, labels in by_type.items():
            names = [labels] if isinstance(labels, str) else list(labels)
            kept = write_type is LabelWriteType.SKIP and kind in semantics.get_labels(prim)
            lines.append(
                f"{'[PREVIEW]' if preview else ''}[{write_type.name}]: '{prim.GetPath()}' --> '{kind}':'{names}'"
            )
            if not preview and not kept:
                add_semantics(prim, kind, names, "replace" if write_type is LabelWriteType.OVERWRITE else "add")
    return "".join(f"{line}\n" for line in lines)


def remove_prim_semantics(
    prim: Usd.Prim, instance_name: str = "", prim_types: Sequence[str] = (), preview: bool = False
) -> str:
    """Remove the labels of a type, or all, of a prim that has one of the USD types `prim_types`; return the lines."""
    if prim_types and prim.GetTypeName() not in prim_types:
        return ""
    found = semantics.get_labels(prim).items()
    removed = {kind: names for kind, names in found if instance_name in ("", kind)}
    if removed and not preview:
        clear_semantics(prim, instance_name or None)
    flag = "[PREVIEW]" if preview else ""
    return "".join(f"{flag}[REMOVE]: '{prim.GetPath()}' --> '{kind}':'{names}'\n" for kind, names in removed.items())

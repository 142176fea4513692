"""`isaacsim.core.utils.semantics`: labels, with the functions of Isaac Sim 4 and of later versions."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Usd, UsdGeom

from usdsdg.compat import used_stage
from usdsdg.compat.wrappers import labels as upgrades
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.stage.semantics import labels as semantics
from usdsdg.stage.semantics.labels import add_update_semantics

__all__ = [
    "add_labels", "add_update_semantics", "check_incorrect_labels", "check_incorrect_semantics",
    "check_missing_labels", "check_missing_semantics", "count_labels_in_scene", "count_semantics_in_scene",
    "get_labels", "get_semantics", "remove_all_semantics", "remove_labels", "upgrade_prim_semantics_to_labels",
]  # fmt: skip


# --- names of Isaac Sim 5 and later ---
def add_labels(prim: Usd.Prim, labels: Sequence[str], instance_name: str = "class", overwrite: bool = True) -> None:
    """Label a prim; `overwrite` removes earlier labels of this type."""
    semantics.add_labels(prim, {instance_name: list(labels)}, mode="replace" if overwrite else "add")


def get_labels(prim: Usd.Prim) -> dict[str, list[str]]:
    """Return the prim's own labels by type."""
    return semantics.get_labels(prim)


def remove_labels(prim: Usd.Prim, instance_name: str | None = None, include_descendants: bool = False) -> None:
    """Remove the labels of one type, or all."""
    if instance_name is None:
        semantics.remove_labels(prim, recursive=include_descendants)
        return
    for each in Usd.PrimRange(prim) if include_descendants else [prim]:
        if instance_name in semantics.get_labels(each):
            semantics.add_labels(each, {instance_name: []}, mode="replace")


def check_missing_labels(prim_path: str | None = None) -> list[str]:
    """Return the paths of meshes without labels of their own, at and below a path or on the stage."""
    return [str(mesh.GetPath()) for mesh in _meshes(prim_path) if not semantics.get_labels(mesh)]


def check_incorrect_labels(prim_path: str | None = None, validate_against_prim_path: bool = False) -> list[list[str]]:
    """Return [path, label] of meshes with a label that is not part of their path, case and "_" or "-" apart.

    Without `validate_against_prim_path` no label is incorrect.
    """
    wrong = []
    for mesh in _meshes(prim_path) if validate_against_prim_path else []:
        path = str(mesh.GetPath())
        label = next((each for each in _labels(mesh) if not _is_part(each.lower(), path.lower())), None)
        if label is not None:
            wrong.append([path, label])
    return wrong


def count_labels_in_scene(prim_path: str | None = None) -> dict[str, int]:
    """Return the number of meshes with each label, and with none as "missing_labels"."""
    counts = {"missing_labels": 0}
    for mesh in _meshes(prim_path):
        for label in _labels(mesh) or ["missing_labels"]:
            counts[label] = counts.get(label, 0) + 1
    return counts


def upgrade_prim_semantics_to_labels(prim: Usd.Prim, include_descendants: bool = False) -> int:
    """Replace labels in the old schema by labels in the new one; return the number of old ones."""
    return sum(upgrades.upgrade(each) for each in (list(Usd.PrimRange(prim)) if include_descendants else [prim]))


# --- names of Isaac Sim 4 ---
def remove_all_semantics(prim: Usd.Prim, recursive: bool = False) -> None:
    """Remove all labels."""
    semantics.remove_labels(prim, recursive=recursive)


def get_semantics(prim: Usd.Prim) -> dict[str, tuple[str, str]]:
    """Return {instance name: (type, label)} of the prim's own labels."""
    return {
        f"Semantics_{kind}_{index}": (kind, label)
        for kind, labels in semantics.get_labels(prim).items()
        for index, label in enumerate(labels)
    }


def check_missing_semantics(prim_path: str | None = None) -> list[str]:
    """Return the paths of meshes without labels of their own."""
    return check_missing_labels(prim_path)


def check_incorrect_semantics(prim_path: str | None = None) -> list[list[str]]:
    """Return [path, label] of meshes with a label that is not part of their path."""
    return check_incorrect_labels(prim_path, validate_against_prim_path=True)


def count_semantics_in_scene(prim_path: str | None = None) -> dict[str, int]:
    """Return the number of meshes with each label, and with none as "missing_semantics"."""
    counts = count_labels_in_scene(prim_path)
    return {"missing_semantics": counts.pop("missing_labels"), **counts}


def _meshes(prim_path: str | None) -> list[Usd.Prim]:
    root = existing_prim(prim_path) if prim_path else used_stage.current_stage().GetPseudoRoot()
    return [prim for prim in Usd.PrimRange(root) if prim.IsA(UsdGeom.Mesh)]


def _labels(prim: Usd.Prim) -> list[str]:
    return [label for labels in semantics.get_labels(prim).values() for label in labels]


def _is_part(label: str, path: str) -> bool:
    return any(each in path for each in (label, label.replace("_", ""), label.replace("-", "")))

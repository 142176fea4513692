"""`omni.isaac.core.utils.semantics`: labels, in the words of Isaac Sim 4."""

from pxr import Usd

from usdsdg.stage.semantics import add_labels, get_labels, remove_labels


def add_update_semantics(prim: Usd.Prim, semantic_label: str, type_label: str = "class", suffix: str = "") -> None:
    """Give the prim one label of a type; any earlier label of that type goes."""
    add_labels(prim, {type_label: [semantic_label]}, mode="replace")


def remove_all_semantics(prim: Usd.Prim, recursive: bool = False) -> None:
    remove_labels(prim, recursive=recursive)


def get_semantics(prim: Usd.Prim) -> dict[str, tuple[str, str]]:
    """{instance name: (type, label)} of the prim's own labels."""
    return {
        f"Semantics_{kind}_{index}": (kind, label)
        for kind, labels in get_labels(prim).items()
        for index, label in enumerate(labels)
    }

"""`omni.isaac.core.utils.semantics`: labels, with the functions of Isaac Sim 4."""

from pxr import Usd

from usdsdg.stage.semantics.labels import add_update_semantics, get_labels, remove_labels

__all__ = ["add_update_semantics", "get_semantics", "remove_all_semantics"]


def remove_all_semantics(prim: Usd.Prim, recursive: bool = False) -> None:
    remove_labels(prim, recursive=recursive)


def get_semantics(prim: Usd.Prim) -> dict[str, tuple[str, str]]:
    """Return {instance name: (type, label)} of the prim's own labels."""
    return {
        f"Semantics_{kind}_{index}": (kind, label)
        for kind, labels in get_labels(prim).items()
        for index, label in enumerate(labels)
    }

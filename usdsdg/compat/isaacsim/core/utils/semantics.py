"""`isaacsim.core.utils.semantics`: labels, with the functions of Isaac Sim 4 and of later versions."""

from pxr import Usd

from usdsdg.compat.omni.isaac.core.utils.semantics import add_update_semantics, get_semantics, remove_all_semantics
from usdsdg.stage.semantics import labels as semantics

__all__ = ["add_labels", "add_update_semantics", "get_labels", "get_semantics", "remove_all_semantics"]


def add_labels(prim: Usd.Prim, labels: list[str], instance_name: str = "class", overwrite: bool = True) -> None:
    semantics.add_labels(prim, {instance_name: list(labels)}, mode="replace" if overwrite else "add")


def get_labels(prim: Usd.Prim) -> dict[str, list[str]]:
    return semantics.get_labels(prim)

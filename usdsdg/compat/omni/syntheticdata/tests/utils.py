"""`omni.syntheticdata.tests.utils`: label a prim."""

from pxr import Usd

from usdsdg.stage.semantics import labels


def add_semantics(prim: Usd.Prim, semantic_label: str, semantic_type: str = "class") -> None:
    labels.add_labels(prim, {semantic_type: [semantic_label]})

"""Labels in the old schema, one instance per (type, label), rewritten in the new one."""

from __future__ import annotations

from pxr import Usd, UsdSemantics

from usdsdg.errors import warn_once
from usdsdg.stage.schemas.semantics_schema import SemanticsAPI
from usdsdg.stage.semantics.label_schemas import forget_written
from usdsdg.stage.semantics.labels import get_labels

_OLD = "SemanticsAPI:"


def upgrade(prim: Usd.Prim) -> int:
    """Move a prim's labels from the old schema to the new one; return the number of old instances.

    Instances without a type or a label are left as they are, with a warning.
    """
    instances = []
    for name in (each.removeprefix(_OLD) for each in prim.GetAppliedSchemas() if each.startswith(_OLD)):
        api = SemanticsAPI(prim, name)
        if api.GetSemanticTypeAttr().Get() and api.GetSemanticDataAttr().Get():
            instances.append(name)
        else:
            warn_once(f"{prim.GetPath()}: the label {name!r} in the old schema has no type or no text and is not moved")
    labels = get_labels(prim) if instances else {}
    for instance in instances:
        prim.RemoveAPI(SemanticsAPI, instance)
        for part in ("Type", "Data"):
            prim.RemoveProperty(f"semantic:{instance}:params:semantic{part}")
    forget_written(prim, labels)
    for taxonomy, values in labels.items():
        UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr().Set(values)
    return len(instances)

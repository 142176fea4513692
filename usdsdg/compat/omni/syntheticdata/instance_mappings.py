"""The labeled prims of the stage and the gprims below each, with the ids that the segmentations of `sensors` have."""

from typing import NamedTuple

from usdsdg.annotators.colors import FIRST_LABELED
from usdsdg.annotators.ownership import LabeledStage, Owner
from usdsdg.session import engines
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.semantics.labels import get_labels


class InstanceMapping(NamedTuple):
    """A prim with a label of type "class"."""

    unique_id: int  # from 1
    path: str
    semantic_id: int  # from 1; equal for equal labels
    label: str
    instance_ids: list[int]  # of all gprims below the prim, also of those below labeled prims inside it
    metadata: list[tuple[str, str]]  # (type, label) of its other labels


def gprim_ids() -> dict[str, int]:
    """Return the id of each gprim that is drawn, by path: its value in the segmentation of gprims."""
    renderer = engines.renderer()
    renderer.sync()
    reader = current().orchestrator.capture.labeled_prims()
    ids = reader.numbers_of(renderer.gprims, time=renderer.time) + FIRST_LABELED
    return dict(zip(renderer.gprims, ids.tolist(), strict=True))


def instance_mappings() -> list[InstanceMapping]:
    """Return the prims with a label of type "class" that have gprims, inner ones before those that they are in."""
    ids = gprim_ids()
    stage = current_stage()
    owned: dict[Owner, list[int]] = {}
    for number, (_, chain) in zip(ids.values(), LabeledStage(stage).chains(list(ids)), strict=True):
        for owner, labels in chain:
            if labels.get("class"):
                owned.setdefault(owner, []).append(number)
    semantic_ids: dict[str, int] = {}
    rows = []
    for owner in sorted(owned, key=lambda each: -each.path.pathElementCount):
        labels = dict(get_labels(stage.GetPrimAtPath(owner.path)))
        label = ",".join(labels.pop("class"))
        semantic_id = semantic_ids.setdefault(label, len(semantic_ids) + 1)
        metadata = [(kind, each) for kind, values in labels.items() for each in values]
        rows.append(InstanceMapping(len(rows) + 1, owner.name, semantic_id, label, owned[owner], metadata))
    return rows

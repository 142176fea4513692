"""Labels, visibility and variants: `rep.modify.semantics`, `visibility` and `variant`."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import labels_of, labels_per_prim, refuse_drawn_parts, shown
from usdsdg.distribution import Distribution, draw, draw_scalars, one_of, options_of
from usdsdg.errors import ArgumentError
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act, act_now
from usdsdg.graph.label_sources import LabelSources, brings_labels
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify.prims import target_prims
from usdsdg.stage.attribute_batch import write_batch
from usdsdg.stage.prims.variants import select_variant
from usdsdg.stage.semantics import labels
from usdsdg.stage.semantics.label_copies import label_all


def semantics(semantics: Any = None, input_prims: Any = None, mode: str = "add") -> ReplicatorItem:
    """Set semantic labels of prims; `mode` is add, replace or clear.

    Outside a trigger the labels are written immediately, those of a distribution at each execution. `semantics` is a
    list of (type, label) pairs, a mapping of type to label or labels, one pair, texts ["class:cube", ...], one text
    "class:cube;color:red", a list of one of these per prim, or a distribution over these.

    Raises:
        ArgumentError: it is something else, a distribution is in place of a label, or the mode does not exist.
    """
    lowered = str(mode).lower()
    if lowered not in ("add", "replace", "clear"):
        raise ArgumentError(f"modify.semantics: mode={mode!r}; known: add, replace, clear")
    mode = lowered
    if isinstance(semantics, Distribution):
        return act("OgnWriteSemantics", input_prims, semantics=semantics, mode=mode)
    refuse_drawn_parts(semantics)
    return act_now("OgnWriteSemantics", input_prims, semantics=semantics, mode=mode)


@action("OgnWriteSemantics", "semantics")
def _write_semantics(node: Node, execution: int) -> None:
    given, mode = node.inputs.get("semantics") or {}, node.inputs["mode"]
    if isinstance(given, Distribution):
        per_prim = [labels_of(each) for each in draw(given, node, execution, "semantics")]
    else:
        per_prim = labels_per_prim(given, len(node.prims))
    if mode == "add" and len(per_prim) > 1 and all(given == per_prim[0] for given in per_prim):
        label_all([prim_at(path) for path in node.prims], per_prim[0])
        return
    for path, given in zip(node.prims, per_prim):
        labels.add_labels(prim_at(path), given, mode=mode)


@brings_labels("OgnWriteSemantics")
def _labels_to_write(node: Node, sources: LabelSources) -> None:
    given = node.inputs.get("semantics") or {}
    if isinstance(given, Distribution):
        drawn = [labels_of(each) for each in given.options()]
        edits = [(path, labels_of_one) for path in node.prims for labels_of_one in drawn]
    else:
        edits = list(zip(node.prims, labels_per_prim(given, len(node.prims))))
    for path, given in edits:
        sources.add_edit(path, partial(labels.edited, labels=given, mode=node.inputs["mode"]))


def visibility(value: Any = None, input_prims: Any = None, name: str | None = None) -> ReplicatorItem:
    """Show or hide prims.

    Args:
        value: True, False, a list with one per prim or one for all, or a distribution over these; None samples True or
            False for each. A distribution over lists with one per prim draws one list per execution.

    Raises:
        ArgumentError: `value` is something else.
        GraphError: at execution, a distribution has sampled something else.
    """
    from usdsdg.distribution import choice

    chosen = choice([True, False]) if value is None else value
    if isinstance(chosen, list) and len(chosen) == 1:
        chosen = chosen[0]
    if isinstance(chosen, Distribution):
        return act("OgnWriteVisibility", input_prims, name=name, value=chosen)
    return act_now("OgnWriteVisibility", input_prims, value=chosen)


@action("OgnWriteVisibility")
def _write_visibility(node: Node, execution: int) -> None:
    value = node.inputs["value"]
    # `draw` would take a list of three ones and zeros for one vector.
    per_prim = (
        value
        if isinstance(value, list) and len(value) == len(node.prims)
        else draw_scalars(value, node, execution, "value")
    )
    if not all(isinstance(visible, (bool, np.bool_)) or visible in (0, 1) for visible in per_prim):
        raise ArgumentError(
            f"visibility is {shown(value)} (visible, in rep.create); expected True, False, or a list with one per prim"
        )
    prims = target_prims(node)
    if are_apart(prims):
        tokens = [UsdGeom.Tokens.inherited if visible else UsdGeom.Tokens.invisible for visible in per_prim]
        if write_batch(node.state, "visibility", lambda: [prim.GetAttribute("visibility") for prim in prims], tokens):
            return
    for prim, visible in zip(prims, per_prim):
        imageable = UsdGeom.Imageable(prim)
        (imageable.MakeVisible if visible else imageable.MakeInvisible)()


def are_apart(prims: Sequence[Usd.Prim]) -> bool:
    """Whether showing one of the prims changes no other prim: none is hidden by one above, or below another one."""
    paths = {prim.GetPath() for prim in prims}
    parents = {parent.GetPath(): parent for prim in prims if (parent := prim.GetParent())}
    above = {ancestor for path in parents for ancestor in path.GetPrefixes()}
    shown = (UsdGeom.Imageable(parent) for parent in parents.values())
    return above.isdisjoint(paths) and all(
        not each or each.ComputeVisibility() != UsdGeom.Tokens.invisible for each in shown
    )


def variant(name: str, value: Any, input_prims: Any = None) -> ReplicatorItem:
    """Select a variant of each prim at each firing.

    Args:
        name: of the variant set.
        value: name of the variant, a list of names of which one is drawn for each prim, or a distribution over names.

    Raises:
        GraphError: at execution, a prim has no such variant set, or the set no such variant; lists the existing ones.
    """
    drawn = one_of(list(value), None) if isinstance(value, (list, tuple)) and len(value) > 1 else value
    chosen = drawn[0] if isinstance(drawn, (list, tuple)) and len(drawn) == 1 else drawn
    return act("OgnWriteVariant", input_prims, attribute=name, value=chosen)


@action("OgnWriteVariant")
def _write_variant(node: Node, execution: int) -> None:
    name = node.inputs["attribute"]
    for path, chosen in zip(node.prims, draw(node.inputs["value"], node, execution, "value")):
        select_variant(_with_variant_set(prim_at(path), name), name, chosen)


def _with_variant_set(prim: Usd.Prim, name: str) -> Usd.Prim:
    """Return the prim that has a variant set: that one, or what `create.from_usd` has put into the Xform that it is."""
    inner = prim.GetChildren()
    if name in prim.GetVariantSets().GetNames() or len(inner) != 1 or prim.GetTypeName() != "Xform":
        return prim
    return inner[0] if name in inner[0].GetVariantSets().GetNames() else prim


@brings_labels("OgnWriteVariant")
def _variants_to_select(node: Node, sources: LabelSources) -> None:
    name, options = node.inputs["attribute"], options_of(node.inputs["value"])
    for prim in map(prim_at, node.prims):
        path = _with_variant_set(prim, name).GetPath()
        for option in options:
            sources.add_content(path.GetParentPath(), _with_variant(str(path), name, option), str(path))


def _with_variant(path: str, name: str, option: str) -> Usd.Stage:
    """Return a stage on which a prim is as it is with another variant selected."""
    layer, stage = Sdf.Layer.CreateAnonymous(), prim_at(path).GetStage()
    layer.subLayerPaths = [stage.GetRootLayer().identifier]
    Sdf.CreatePrimInLayer(layer, path).variantSelections[name] = option
    return Usd.Stage.OpenMasked(layer, Usd.StagePopulationMask([path]))

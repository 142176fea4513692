"""References to files of other units or another up axis, which USD composes as if they were the stage's."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg import errors

_UP = {"Y": np.array([0.0, 1.0, 0.0]), "Z": np.array([0.0, 0.0, 1.0])}
_SAME = 1e-3  # relative difference of units that are the same, as 0.3048 and 0.304801
_TURNED = math.cos(math.radians(45.0))  # of the up axis; prims that stand are turned by less


class Metrics(NamedTuple):
    """What a layer says of its units and of its up axis; None for nothing that is usable."""

    meters: float | None
    up: str | None


def metrics(layer: Sdf.Layer) -> Metrics:
    """Return the authored metersPerUnit and upAxis of a layer."""
    root = layer.pseudoRoot
    meters = root.GetInfo("metersPerUnit") if root.HasInfo("metersPerUnit") else None
    up = str(root.GetInfo("upAxis")) if root.HasInfo("upAxis") else None
    meters = float(meters) if isinstance(meters, (int, float)) and math.isfinite(meters) and meters > 0.0 else None
    return Metrics(meters, up if up in _UP else None)


def name_other_metrics(stage: Usd.Stage) -> None:
    """Warn once for each file that the stage's own layers refer to as if it were in other units or another up axis.

    What a scale or a rotation of the referring prim, or of one above it, corrects is not named; nor is a file in which
    nothing is drawn.
    """
    own = metrics(stage.GetRootLayer())
    others = [layer for layer in stage.GetUsedLayers() if _differ(own, metrics(layer))]
    if not others:
        return  # so that most stages are not traversed
    named, layers = set(), set(stage.GetLayerStack())
    for prim in stage.Traverse():
        for layer in referenced_layers(prim, layers):
            if layer in layers or layer in named or not _differ(own, theirs := metrics(layer)):
                continue
            meters, up = _uncorrected(prim, own, theirs)
            if (meters or up) and any(each.IsA(UsdGeom.Boundable) for each in _below(prim)):
                named.add(layer)
                errors.warn_once(_message(prim, layer, own, theirs, meters=meters, up=up), key=f"metrics {layer}")


def _differ(own: Metrics, theirs: Metrics) -> bool:
    return _other_meters(own, theirs) or (None not in (own.up, theirs.up) and own.up != theirs.up)


def _other_meters(own: Metrics, theirs: Metrics) -> bool:
    return bool(own.meters and theirs.meters and abs(theirs.meters / own.meters - 1.0) > _SAME)


def _below(prim: Usd.Prim) -> Iterator[Usd.Prim]:
    return iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))


def referenced_layers(prim: Usd.Prim, layers: Collection[Sdf.Layer] | None = None) -> list[Sdf.Layer]:
    """Return the root layers of files that references and payloads of this very prim bring, the strongest first.

    layers: those that refer to them; None for any.
    """
    if not (prim.HasAuthoredReferences() or prim.HasAuthoredPayloads()):
        return []
    query = Usd.PrimCompositionQuery
    wanted = query.Filter()
    wanted.arcTypeFilter = query.ArcTypeFilter.ReferenceOrPayload
    wanted.dependencyTypeFilter = query.DependencyTypeFilter.Direct
    arcs = query(prim, wanted).GetCompositionArcs()
    arcs = [arc for arc in arcs if layers is None or arc.GetIntroducingLayer() in layers]
    return [arc.GetTargetNode().layerStack.identifier.rootLayer for arc in arcs]


def _uncorrected(prim: Usd.Prim, own: Metrics, theirs: Metrics) -> tuple[bool, bool]:
    """Whether no scale makes up for other units, and whether no rotation does for another up axis."""
    meters = _other_meters(own, theirs)
    up = own.up != theirs.up and None not in (own.up, theirs.up)
    cache, above = UsdGeom.XformCache(Usd.TimeCode.EarliestTime()), prim
    while above and not above.IsPseudoRoot() and (meters or up):
        above = above.GetParent()
        matrix = np.array(cache.ComputeRelativeTransform(prim, above)[0])[:3, :3]
        size = np.cbrt(abs(np.linalg.det(matrix)))
        if meters and size > 0.0 and own.meters and theirs.meters:
            # A scale that is nearer to the ratio of the units than to 1 knows of them.
            ratio = math.log(theirs.meters / own.meters)
            meters = abs(math.log(size) - ratio) > abs(math.log(size))
        if up and theirs.up is not None:
            axis = _UP[theirs.up]
            turned = axis @ matrix
            up = float(turned @ axis) > _TURNED * float(np.linalg.norm(turned))
    return meters, up


def _message(prim: Usd.Prim, layer: Sdf.Layer, own: Metrics, theirs: Metrics, *, meters: bool, up: bool) -> str:
    says, does, remedies = [], [], []
    if meters and own.meters and theirs.meters:
        says.append((f"units of {theirs.meters:g} m", f"units of {own.meters:g} m"))
        does.append(f"it is {own.meters / theirs.meters:.4g} times as large as it says")
        remedies.append(f"scale the prim by {theirs.meters / own.meters:.4g}")
    if up:
        says.append((f"{theirs.up} up", f"{own.up} up"))
        does.append("it lies on its side")
        remedies.append(f"rotate the prim by {90 if theirs.up == 'Y' else -90} degrees about X")
    its, stages = (" and ".join(each) for each in zip(*says))
    remedy = " and ".join(remedies)
    return (
        f"{prim.GetPath()} refers to {Path(layer.realPath or layer.identifier).name}, which has {its}, where the stage "
        f"has {stages}. USD does not convert them, so {' and '.join(does)}. {remedy[:1].upper()}{remedy[1:]}, or "
        "give the file those of the stage."
    )

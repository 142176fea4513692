"""Annotators of values read from the stage at the time of the frame: attributes, prim paths, times."""

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pxr import Usd

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import AnnotatorError, ArgumentError
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import prim_at

Params = Mapping[str, Any]

# NumPy types of scalar attributes, which USD returns as Python numbers.
_SCALARS = {"half": np.float16, "float": np.float32, "int": np.int32, "uint": np.uint32, "uchar": np.uint8}


_NO_ATTRIBUTE = (
    "Annotator 'Attribute' needs prims and an attribute: annotators.get('Attribute', init_params={'prims': [path], "
    "'attribute': name})."
)


def _check_attribute(annotator: Any) -> None:
    given = annotator.parameters
    if not _listed(given["prims"]) or not given["attribute"]:
        raise ArgumentError(_NO_ATTRIBUTE)


@define("Attribute", params={"prims": (), "attribute": ""}, dtype=np.float32, on_attach=_check_attribute)
def attribute(frame: Frame, params: Params) -> Annotation:
    """Values of the attribute named `attribute` of `prims` (paths or prims), concatenated in one flat array.

    Vectors and arrays are flattened; texts are strings. Time samples are read at the time of the frame.

    Raises:
        ArgumentError: (a ValueError) at attach(): `prims` or `attribute` was not given.
        AnnotatorError: a prim has no such attribute or no value for it; of a writer, also if they were not given.
        BadPrim: one of the prims does not exist.
    """
    prims, name = _listed(params["prims"]), params["attribute"]
    if not prims or not name:
        raise AnnotatorError(_NO_ATTRIBUTE)
    stage, code = current_stage(), frame.queries.time
    return Annotation(np.concatenate([_values(prim_at(stage, path), name, code) for path in prims]))


@define("primPaths", info={"primPaths": []})
def prim_paths(frame: Frame, params: Params) -> Annotation:
    """{"primPaths"}: paths of the labeled prims that own gprims, in the order of their instance ids."""
    rows = frame.selection(None).rows
    return Annotation(None, {"primPaths": [frame.labeled_prims.prim_paths[row] for row in rows]})


@define("fabricTime", "rpFabricTime", info={"fabricFrameTimeNumerator": 0, "fabricFrameTimeDenominator": 0})
def fabric_time(frame: Frame, params: Params) -> Annotation:
    """{"fabricFrameTimeNumerator", "fabricFrameTimeDenominator"}: timeline time of the frame, a fraction of seconds."""
    numerator, denominator = frame.reference_time
    return Annotation(
        None, {"fabricFrameTimeNumerator": int(numerator), "fabricFrameTimeDenominator": int(denominator)}
    )


# Annotators of Isaac Sim


@define("IsaacNoop")
def isaac_noop(frame: Frame, params: Params) -> Annotation:
    """No output: {}."""
    return Annotation(None)


@define("IsaacReadSimulationTime", params={"resetOnStop": False}, info={"simulationTime": 0.0})
def isaac_read_simulation_time(frame: Frame, params: Params) -> Annotation:
    """{"simulationTime"}: timeline time of the frame [s].

    resetOnStop: accepted and ignored: the time is the timeline's, which restarts when it is stopped.
    """
    numerator, denominator = frame.reference_time
    return Annotation(None, {"simulationTime": numerator / denominator})


@define("IsaacReadSystemTime", info={"systemTime": 0.0})
def isaac_read_system_time(frame: Frame, params: Params) -> Annotation:
    """{"systemTime"}: when the frame was annotated [s since 1970]; the only annotator that differs between runs."""
    return Annotation(None, {"systemTime": frame.derive("system time", time.time)})


def _listed(prims: Any) -> list[str]:
    items = list(prims) if isinstance(prims, Sequence) and not isinstance(prims, str) else [prims] if prims else []
    return [str(item.GetPath()) if hasattr(item, "GetPath") else str(item) for item in items]


def _values(prim: Usd.Prim, name: str, code: Usd.TimeCode) -> np.ndarray:
    found = prim.GetAttribute(name)
    if not found:
        names = [each.GetName() for each in prim.GetAttributes()]
        close = near_misses(name, names)
        hint = f"Did you mean {' or '.join(map(repr, close))}?" if close else f"It has: {', '.join(names[:12])}."
        raise AnnotatorError(f"{prim.GetPath()} has no attribute {name!r}. {hint}")
    value = found.Get(code)
    if value is None:
        raise AnnotatorError(f"{prim.GetPath()}: attribute {name!r} has no value.")
    values = np.asarray(value, _SCALARS.get(str(found.GetTypeName())))
    return np.array([str(value)]) if values.dtype == object else values.reshape(-1)

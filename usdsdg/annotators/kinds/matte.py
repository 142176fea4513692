"""Mattes by id: one mask channel for each multimatte id, for compositing."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.pixels.look_up_table import LookUpTable
from usdsdg.annotators.point_instances import prim_path
from usdsdg.errors import warn_once
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage

# Number of matte images, and channels of each.
IMAGES, CHANNELS = 8, 3
_ID = "multimatte_id"
_SETTINGS = "/rtx/pathtracing/multimatte"
# The id of prims without one, and of channels that are switched off.
NONE = -1


def _define(number: int) -> None:
    @define(f"PtMultiMatte{number}", aovs=["instance"], dtype=np.float16)
    def matte(frame: Frame, params: Mapping[str, Any]) -> Annotation:
        """Mattes of three ids, float16 (H, W, 4).

        Each of the first three channels is 1 where the pixel's center shows a gprim with the channel's id and 0
        elsewhere, so edges are not anti-aliased; the fourth channel is 1.

        The id of a gprim is its primvar `multimatte_id`, its own or inherited, or else the attribute `multimatte_id` of
        its material; -1 is none. Channel c of image n is number 3 * n + c of
        `/rtx/pathtracing/multimatte/channelCount`, at most 24; further channels are 0. It shows the id that is set in
        `/rtx/pathtracing/multimatte/channel<number>`, default that number. Ids per face are not supported. Mirrors the
        RTX renderer's "Multi Matte".
        """
        return Annotation(_matte(frame, number))


def _matte(frame: Frame, number: int) -> np.ndarray:
    settings = get_settings()
    count = min(settings.get_as_int(f"{_SETTINGS}/channelCount"), IMAGES * CHANNELS)
    if count <= number * CHANNELS:
        warn_once(
            f"PtMultiMatte{number} shows nothing: {_SETTINGS}/channelCount is {count}; set it to "
            f"{number * CHANNELS + 1} or more."
        )
        return frame.black
    ids = frame.derive("matte ids", lambda: np.append(_ids_of_gprims(frame), NONE))
    colors = np.zeros((len(ids), 4), np.float16)
    colors[:, 3] = 1
    for channel in range(number * CHANNELS, min((number + 1) * CHANNELS, count)):
        authored = settings.get(f"{_SETTINGS}/channel{channel}")
        wanted = channel if authored is None else int(authored)
        colors[:, channel % CHANNELS] = (ids == wanted) & (wanted != NONE)
    return frame.look_up(LookUpTable(colors))


for _number in range(IMAGES):
    _define(_number)


def _ids_of_gprims(frame: Frame) -> np.ndarray:
    """Return (G,) int64: the id of every gprim, -1 where it has none."""
    stage, code = current_stage(), frame.queries.time
    prims = {path: stage.GetPrimAtPath(path) for path in map(prim_path, frame.gprims)}
    ids = {path: _own_id(prim, code) for path, prim in prims.items()}
    without = [path for path, found in ids.items() if found == NONE and prims[path]]
    materials, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials([prims[path] for path in without])
    for path, material in zip(without, materials):
        _warn_of_faces(prims[path])
        ids[path] = _material_id(material.GetPrim(), code)
    return np.array([ids[prim_path(gprim)] for gprim in frame.gprims], np.int64)


def _own_id(prim: Usd.Prim, code: Usd.TimeCode) -> int:
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(_ID) if prim else None
    if not primvar or (value := primvar.Get(code)) is None:
        return NONE
    values = np.unique(value)
    if len(values) == 1:
        return int(values[0])
    warn_once(f"{primvar.GetAttr().GetPath()} has several ids; mattes take one for a whole prim. Split the mesh.")
    return NONE


def _material_id(material: Usd.Prim, code: Usd.TimeCode) -> int:
    value = material.GetAttribute(_ID).Get(code) if material and material.HasAttribute(_ID) else None
    return NONE if value is None else int(value)


def _warn_of_faces(mesh: Usd.Prim) -> None:
    for subset in UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets():
        material, _ = UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial()
        if material and material.GetPrim().HasAttribute(_ID):
            warn_once(
                f"{subset.GetPath()}: the {_ID} of {material.GetPath()} does not reach single faces; mattes take one "
                f"for a whole prim. Set primvars:{_ID} on {mesh.GetPath()}, or split it."
            )

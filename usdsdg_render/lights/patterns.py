"""IES profiles and pictures of lights to `scene.LightPattern`."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.images import image_files
from usdsdg_render.lights import ies
from usdsdg_render.lights.light_images import linear_rgb
from usdsdg_render.lights.light_values import light_number, light_value
from usdsdg_render.scene.scene import LightPattern


def read_pattern(prim: Usd.Prim) -> LightPattern | None:
    """The pattern of a light, the same object for as long as its files and inputs stay; None if it shines evenly."""
    profile, picture = (), ()
    if file := _file(prim, "inputs:shaping:ies:file"):
        scale = light_number(prim, "shaping:ies:angleScale", 0.0)
        normalize = bool(light_value(prim, "shaping:ies:normalize", False))
        profile = (file, image_files.modified(file), scale, normalize)
    if prim.GetTypeName() == "RectLight" and (file := _file(prim, "inputs:texture:file")):
        picture = (file, image_files.modified(file))
    if profile and not _is_readable(prim, "the IES profile", _profile, profile):
        profile = ()
    if picture and not _is_readable(prim, "the light's texture", _picture, picture):
        picture = ()
    return _pattern(profile, picture) if profile or picture else None


def _file(prim: Usd.Prim, name: str) -> str:
    attribute = prim.GetAttribute(name)
    authored, file = image_files.asset_file(attribute) if attribute else ("", "")
    if authored and not file:
        errors.warn_once(
            f"{prim.GetPath()}: {name} names {authored}, which does not exist; it is ignored. Correct the path."
        )
    return file


def _is_readable(prim: Usd.Prim, what: str, read: Callable, arguments: tuple) -> bool:
    try:
        read(*arguments)
    except errors.AssetUnreadable as error:
        errors.warn_once(f"{prim.GetPath()}: {what} cannot be read ({error}); it is ignored. Correct the file.")
        return False
    return True


@lru_cache(maxsize=64)
def _pattern(profile: tuple, picture: tuple) -> LightPattern:
    return LightPattern(_profile(*profile) if profile else None, _picture(*picture) if picture else None)


@lru_cache(maxsize=64)
def _profile(file: str, _modified: tuple[int, int], angle_scale: float, normalize: bool) -> np.ndarray:
    photometry = ies.parse(image_files.read_bytes(file).decode("latin-1"), name=file)
    return ies.profile(photometry, angle_scale=angle_scale, normalize=normalize)


@lru_cache(maxsize=16)
def _picture(file: str, _modified: tuple[int, int]) -> np.ndarray:
    return linear_rgb(image_files.read_rgb(file))

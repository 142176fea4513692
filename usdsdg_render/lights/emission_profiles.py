"""IES profiles and textures of lights, read to `scene.EmissionProfile`."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.images import image_files
from usdsdg_render.lights import ies
from usdsdg_render.lights.light_textures import linear_rgb
from usdsdg_render.lights.light_values import light_number, light_value
from usdsdg_render.scene.scene import EmissionProfile


def read_emission_profile(prim: Usd.Prim) -> EmissionProfile | None:
    """Read the emission profile of a light; None for uniform emission.

    It is the same object for as long as its files and inputs stay the same.
    """
    ies_key, texture_key = (), ()
    if file := _file(prim, "inputs:shaping:ies:file"):
        scale = light_number(prim, "shaping:ies:angleScale", 0.0)
        normalize = bool(light_value(prim, "shaping:ies:normalize", False))
        ies_key = (file, image_files.modified(file), scale, normalize)
    if prim.GetTypeName() == "RectLight" and (file := _file(prim, "inputs:texture:file")):
        texture_key = (file, image_files.modified(file))
    if ies_key and not _is_readable(prim, "the IES profile", _ies_profile, ies_key):
        ies_key = ()
    if texture_key and not _is_readable(prim, "the light's texture", _texture, texture_key):
        texture_key = ()
    return _emission_profile(ies_key, texture_key) if ies_key or texture_key else None


def profile_files(prim: Usd.Prim) -> tuple[str, ...]:
    """Return the files that `read_emission_profile` reads."""
    names = ("inputs:shaping:ies:file", *(["inputs:texture:file"] if prim.GetTypeName() == "RectLight" else []))
    return tuple(file for name in names if (file := _file(prim, name)))


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
def _emission_profile(ies_key: tuple, texture_key: tuple) -> EmissionProfile:
    return EmissionProfile(_ies_profile(*ies_key) if ies_key else None, _texture(*texture_key) if texture_key else None)


@lru_cache(maxsize=64)
def _ies_profile(file: str, _modified: tuple[int, int], angle_scale: float, normalize: bool) -> np.ndarray:
    photometry = ies.parse(image_files.read_bytes(file).decode("latin-1"), name=file)
    return ies.profile(photometry, angle_scale=angle_scale, normalize=normalize)


@lru_cache(maxsize=16)
def _texture(file: str, _modified: tuple[int, int]) -> np.ndarray:
    return linear_rgb(image_files.read_rgb(file))

"""UsdLux dome lights to one lat-long picture, `scene.Dome`.

Orientation. A sky's pole is the stage's up axis: for `DomeLight_1` because its poleAxis says so, and for the older
`DomeLight`, whose text says +Y always, because Omniverse shows it so and scripts written for it turn nothing. A
`DomeLight` that carries UsdLux's own `orientToStageUpAxis` op was written for a +Y pole and is taken so.
Longitudes are UsdLux's: with a Y pole the centre of the picture lies towards +Z and a quarter to the left of it towards
+X; with a Z pole the centre lies towards -Y.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg import errors

from . import images
from .lights import emitted_colour, light_value, linear_rgb
from .scene import Dome

# Rows take a direction of the dome's own space to the frame of `scene.Dome`, where column u lies at angle 2 pi u.
POLE_FRAMES = {
    "Y": np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "Z": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
}

UNIFORM = np.ones((1, 2, 3), np.float32)


class DomeLight(NamedTuple):
    """One dome light, before its picture is loaded."""

    path: str
    file: str  # "" for a uniform dome
    modified: tuple[int, int]
    colour: tuple[float, float, float]  # what a texel of 1 radiates [nits]
    dome_from_world: bytes  # (3, 3) float64; bytes, so that domes can be compared
    visible: bool

    @property
    def frame(self) -> np.ndarray:
        return np.frombuffer(self.dome_from_world).reshape(3, 3)


def read_dome(prim: Usd.Prim, local_to_world: np.ndarray) -> DomeLight | None:
    """The dome light at `prim`; None when it gives no light."""
    colour = emitted_colour(prim)
    if colour is None or not colour.any():
        return None
    rotation = _rotation(local_to_world)
    if rotation is None:
        errors.warn_once(f"{prim.GetPath()}: the dome's transform is NaN or scaled to zero; it is off. Correct it.")
        return None
    frame = POLE_FRAMES[_pole(prim)] @ rotation
    picture_format = str(light_value(prim, "texture:format", "automatic"))
    if picture_format not in ("automatic", "latlong"):
        errors.warn_once(
            f"{prim.GetPath()}: texture format {picture_format} is not supported; the file is read as "
            f"latlong. Convert it."
        )
    file = _file(prim)
    visible = prim.GetAttribute("visibleInPrimaryRay")
    return DomeLight(
        path=str(prim.GetPath()),
        file=file,
        modified=images.modified(file) if file else (0, 0),
        colour=(float(colour[0]), float(colour[1]), float(colour[2])),
        dome_from_world=np.ascontiguousarray(frame, np.float64).tobytes(),
        visible=not (visible and visible.Get() is False),
    )


def _pole(prim: Usd.Prim) -> str:
    up = "Y" if UsdGeom.GetStageUpAxis(prim.GetStage()) == UsdGeom.Tokens.y else "Z"
    if prim.GetTypeName() == "DomeLight_1":
        pole = str(prim.GetAttribute("poleAxis").Get())
        return pole if pole in POLE_FRAMES else up
    if prim.HasAttribute("xformOp:rotateX:orientToStageUpAxis"):
        return "Y"
    return up


def _rotation(local_to_world: np.ndarray) -> np.ndarray | None:
    """(3, 3) that turns a world direction (column) into the prim's space: scale and shear left out."""
    linear = local_to_world[:3, :3]
    if not np.isfinite(linear).all():
        return None
    u, scale, v = np.linalg.svd(linear)
    # Row vectors: world = local @ linear, so local = linear @ world for a rotation.
    return u @ v if scale[2] > 1e-9 * scale[0] else None


def _file(prim: Usd.Prim) -> str:
    for name in ("inputs:texture:file", "texture:file"):
        attribute = prim.GetAttribute(name)
        authored, file = images.asset_file(attribute) if attribute else ("", "")
        if authored and not file:
            errors.warn_once(
                f"{prim.GetPath()}: {name} names {authored}, which does not exist; the dome is uniform. "
                f"Correct the path."
            )
        if authored:
            return file
    return ""


class DomeBuilder:
    """Keeps decoded pictures, so that a dome that only turns or dims costs no decoding."""

    # Decoded pictures are kept up to this size: a script that draws skies from a short list finds them again.
    KEPT_BYTES = 1 << 29

    def __init__(self) -> None:
        self._pictures: dict[tuple[str, tuple[int, int]], np.ndarray] = {}

    def build(self, domes: list[DomeLight]) -> Dome | None:
        """All domes added up in the first one's frame; None without any."""
        if not domes:
            return None
        pictures = [self._picture(dome) for dome in domes]
        height = max(picture.shape[0] for picture in pictures)
        width = max(picture.shape[1] for picture in pictures)
        first = domes[0]
        radiance = np.zeros((height, width, 3), np.float32)
        for dome, picture in zip(domes, pictures):
            if picture is UNIFORM:
                picture = picture[:, :1]
            elif dome.dome_from_world != first.dome_from_world or picture.shape[:2] != (height, width):
                picture = resample(picture, first.frame, dome.frame, (height, width))
            radiance += picture * np.array(dome.colour, np.float32)
        if len(domes) > 1 and len({dome.visible for dome in domes}) > 1:
            errors.warn_once(
                f"{first.path}: some dome lights are hidden from the camera and some are not; all are shown. "
                f"Give them the same visibleInPrimaryRay."
            )
        return Dome(
            radiance=radiance,
            dome_from_world=first.frame.astype(np.float32),
            visible=any(dome.visible for dome in domes),
        )

    def _picture(self, dome: DomeLight) -> np.ndarray:
        """(H, W, 3) linear; UNIFORM for a dome without a picture."""
        if not dome.file:
            return UNIFORM
        key = (dome.file, dome.modified)
        if key not in self._pictures:
            try:
                picture = linear_rgb(images.read(dome.file))
            except errors.AssetUnreadable as error:
                errors.warn_once(f"{dome.path}: the sky cannot be read ({error}); the dome is uniform.")
                picture = UNIFORM
            size = picture.nbytes + sum(kept.nbytes for kept in self._pictures.values())
            while self._pictures and size > self.KEPT_BYTES:
                size -= self._pictures.pop(next(iter(self._pictures))).nbytes
            self._pictures[key] = picture
        return self._pictures[key]


def directions(height: int, width: int) -> np.ndarray:
    """(height, width, 3) unit vectors through the texel centres, in the frame of `scene.Dome`."""
    theta = (np.arange(height) + 0.5) * (np.pi / height)
    phi = (np.arange(width) + 0.5) * (2.0 * np.pi / width)
    sine = np.sin(theta)[:, None]
    up = np.broadcast_to(np.cos(theta)[:, None], (height, width))
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), up], axis=-1)


def resample(picture: np.ndarray, to_frame: np.ndarray, from_frame: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """`picture`, given in `from_frame`, as seen in `to_frame` (both dome_from_world), bilinear."""
    wanted = directions(*shape) @ (to_frame @ from_frame.T)
    height, width = picture.shape[:2]
    row = np.arccos(np.clip(wanted[..., 2], -1.0, 1.0)) / np.pi * height - 0.5
    column = np.arctan2(wanted[..., 1], wanted[..., 0]) / (2.0 * np.pi) % 1.0 * width - 0.5
    top, left = np.floor(row).astype(int), np.floor(column).astype(int)
    down = (row - top)[..., None].astype(np.float32)
    right = (column - left)[..., None].astype(np.float32)
    rows = np.clip([top, top + 1], 0, height - 1)
    columns = np.array([left, left + 1]) % width
    upper = picture[rows[0], columns[0]] * (1 - right) + picture[rows[0], columns[1]] * right
    lower = picture[rows[1], columns[0]] * (1 - right) + picture[rows[1], columns[1]] * right
    return upper * (1 - down) + lower * down

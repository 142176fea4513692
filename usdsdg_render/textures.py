"""Texture files to the 8-bit RGBA that the kernels read, decoded once and shared."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from usdsdg import errors

from . import images
from .scene import WRAP_REPEAT, Texture

Progress = Callable[[str, int, int | None], None]
ONES = (1.0, 1.0, 1.0, 1.0)
ZEROS = (0.0, 0.0, 0.0, 0.0)
# Decoded textures that no material uses any more are kept up to this size, for scripts that swap textures.
IDLE_BYTES = 1 << 30

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


@dataclass(frozen=True)
class TextureUse:
    """How a shader looks at a file; equal uses share one `Texture`.

    Where `scale`, `bias` or `desaturation` differ from nothing they are baked into the texels: in linear values,
    `clamp(texel * scale + bias, 0, 1)`.
    """

    file: str  # resolved
    colour_space: str = "auto"  # auto | sRGB | raw
    colour: bool = True  # a colour for the eye (8 bits are then sRGB-coded), not data
    wrap_s: int = WRAP_REPEAT
    wrap_t: int = WRAP_REPEAT
    scale: tuple[float, ...] = ONES
    bias: tuple[float, ...] = ZEROS
    desaturation: float = 0.0
    shader: str = field(default="", compare=False)  # prim path, for messages

    @property
    def is_baked(self) -> bool:
        return self.scale != ONES or self.bias != ZEROS or self.desaturation != 0.0


class TexturePool:
    """Decoded textures by (use, file time stamp)."""

    def __init__(self) -> None:
        self._textures: OrderedDict[tuple[TextureUse, tuple[int, int]], Texture | None] = OrderedDict()
        self._table: list[Texture] = []

    def load(
        self, uses: Iterable[TextureUse], progress: Progress | None = None
    ) -> tuple[list[Texture], dict[TextureUse, int]]:
        """All textures of the pool, and where in that list those of `uses` are; new files are decoded on all cores.

        A file that cannot be read is missing from the result, with one warning. Textures keep their order, idle ones
        too until they are too large.
        """
        keys = {use: (use, images.modified(use.file)) for use in uses}
        by_file: dict[str, list[TextureUse]] = {}
        for use, key in keys.items():
            if key not in self._textures:
                by_file.setdefault(use.file, []).append(use)
        if by_file:
            self._decode(by_file, keys, progress)
        for key in keys.values():
            self._textures.move_to_end(key)
        self._forget_idle(set(keys.values()))
        place_of = self._arrange()
        textures = {use: self._textures[key] for use, key in keys.items()}
        return self._table, {use: place_of[_same(t)] for use, t in textures.items() if t is not None}

    def keep(self, use: TextureUse, texture: Texture) -> None:
        """Hold a texture that no file has."""
        self._textures[use, images.modified(use.file)] = texture

    def _arrange(self) -> dict[tuple, int]:
        """Put each different texture into the table once; where each is."""
        present = {_same(texture): texture for texture in self._textures.values() if texture is not None}
        listed = {_same(texture) for texture in self._table}
        kept = [texture for texture in self._table if _same(texture) in present]
        new = [texture for same, texture in present.items() if same not in listed]
        if new or len(kept) != len(self._table):
            self._table = kept + sorted(
                new, key=lambda texture: (texture.path, texture.srgb, texture.wrap_s, texture.wrap_t)
            )
        return {_same(texture): k for k, texture in enumerate(self._table)}

    def _decode(self, by_file, keys, progress: Progress | None) -> None:
        with ThreadPoolExecutor(min(len(by_file), os.cpu_count() or 1)) as pool:
            for done, (uses, result) in enumerate(zip(by_file.values(), pool.map(_textures_of, by_file.values()))):
                if isinstance(result, errors.AssetUnreadable):
                    errors.warn_once(
                        f"{uses[0].shader}: the texture cannot be read ({result}); the fallback colour is used."
                    )
                    result = [None] * len(uses)
                for use, texture in zip(uses, result):
                    self._textures[keys[use]] = texture
                if progress is not None:
                    progress("textures", done + 1, len(by_file))

    def _forget_idle(self, used: set) -> None:
        idle = [key for key in self._textures if key not in used]
        size = sum(_size(self._textures[key]) for key in idle)
        for key in idle:  # least recently used first
            if size <= IDLE_BYTES:
                break
            size -= _size(self._textures.pop(key))


def _same(texture: Texture) -> tuple:
    """Two uses that need no baking share their texels."""
    return id(texture.texels), texture.srgb, texture.wrap_s, texture.wrap_t


def _size(texture: Texture | None) -> int:
    return texture.texels.nbytes if texture is not None else 0


def _textures_of(uses: list[TextureUse]) -> list[Texture] | errors.AssetUnreadable:
    """Textures of several uses of one file; runs on a worker thread, so an error is returned, not raised."""
    try:
        picture = images.read(uses[0].file)
    except errors.AssetUnreadable as error:
        return error
    return [to_texture(picture, use) for use in uses]


def to_texture(picture: images.Picture, use: TextureUse) -> Texture:
    """8-bit texels of `picture` as `use` looks at it."""
    srgb = is_srgb(picture, use)
    texels = picture.texels
    if texels.dtype == np.uint8 and not use.is_baked:
        return _texture(use, texels, srgb)
    if texels.dtype == np.uint8 and not use.desaturation:
        return _texture(use, _bake_by_table(texels, srgb, use), srgb)
    linear = _linear(texels, srgb)
    if use.desaturation:
        grey = linear[..., :3] @ _LUMINANCE
        linear[..., :3] += use.desaturation * (grey[..., None] - linear[..., :3])
    linear = linear * np.array(use.scale, np.float32) + np.array(use.bias, np.float32)
    # Eight linear bits would band in the dark, so a colour is stored sRGB-coded whatever it was.
    return _texture(use, _to_bytes(linear, srgb or use.colour), srgb or use.colour)


def _texture(use: TextureUse, texels: np.ndarray, srgb: bool) -> Texture:
    return Texture(use.file, np.ascontiguousarray(texels), srgb, use.wrap_s, use.wrap_t)


def is_srgb(picture: images.Picture, use: TextureUse) -> bool:
    """Whether texels are sRGB-coded. `auto` is as UsdPreviewSurface defines it: 8-bit files with three or four channels
    are, all others hold linear values."""
    if use.colour_space == "auto":
        return picture.texels.dtype == np.uint8 and picture.channels >= 3
    return use.colour_space == "sRGB"


def srgb_to_linear(values: np.ndarray) -> np.ndarray:
    return np.where(values <= 0.04045, values / 12.92, ((np.maximum(values, 0.0) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(values: np.ndarray) -> np.ndarray:
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * np.maximum(values, 1e-9) ** (1 / 2.4) - 0.055)


def _linear(texels: np.ndarray, srgb: bool) -> np.ndarray:
    if texels.dtype.kind == "f":
        linear = np.nan_to_num(texels.astype(np.float32), nan=0.0, posinf=1.0, neginf=0.0)
    else:
        linear = texels.astype(np.float32) / np.iinfo(texels.dtype).max
    if srgb:
        linear[..., :3] = srgb_to_linear(linear[..., :3])
    return linear


def _to_bytes(linear: np.ndarray, srgb: bool) -> np.ndarray:
    values = np.clip(linear, 0.0, 1.0)
    if srgb:
        values[..., :3] = linear_to_srgb(values[..., :3])
    return np.round(values * 255.0).astype(np.uint8)


def _bake_by_table(texels: np.ndarray, srgb: bool, use: TextureUse) -> np.ndarray:
    """Scale and bias of 8-bit texels: 256 values a channel instead of all texels."""
    ramp = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 4, axis=1)[None]
    linear = _linear(ramp, srgb) * np.array(use.scale, np.float32) + np.array(use.bias, np.float32)
    table = _to_bytes(linear, srgb)[0]
    return np.stack([table[:, k][texels[..., k]] for k in range(4)], axis=-1)

"""Texture files to the texels that the kernels read, decoded once and shared.

Colors are kept in eight sRGB-coded bits, data in as many as the file has (8 or 16), and what does not fit either, such
as light brighter than one, in half floats.
"""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from usdsdg import errors
from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.images import image_files
from usdsdg_render.scene.scene import AS_IT_IS, WRAP_CLAMP, WRAP_REPEAT, Texture, UvTransform

Progress = Callable[[str, int, int | None], None]
ONES = (1.0, 1.0, 1.0, 1.0)
ZEROS = (0.0, 0.0, 0.0, 0.0)
# Decoded textures that no material uses any more are kept up to this size, for scripts that swap textures.
IDLE_BYTES = 1 << 30
IDLE_LEAST = 1 << 20  # that each counts for besides its own
MOST_HALF = 65504.0

_LUMINANCE = LUMINANCE.astype(np.float32)


class Decoding(NamedTuple):
    """What decides the texels of a use."""

    file: str
    color_space: str
    color: bool
    desaturation: float
    spread: int


@dataclass(frozen=True)
class TextureUse:
    """How a shader looks at a file; equal uses share one `Texture`, and those that differ in the last lines alone its
    texels.

    What is read is the linear texel, desaturated, times `scale` plus `bias`.
    """

    file: str  # resolved; with <UDIM> for a set of tiles
    color_space: str = "auto"  # auto | sRGB | raw
    color: bool = True  # a color for the eye (8 bits are then sRGB-coded), not data
    desaturation: float = 0.0
    spread: int = -1  # the channel (0-3) that stands for all of a color; -1 = none
    wrap_s: int = WRAP_REPEAT
    wrap_t: int = WRAP_REPEAT
    transform: UvTransform = AS_IT_IS
    scale: tuple[float, ...] = ONES
    bias: tuple[float, ...] = ZEROS
    beyond: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)  # where a set of tiles has none
    shader: str = field(default="", compare=False)  # prim path, for messages

    @property
    def decoding(self) -> Decoding:
        return Decoding(self.file, self.color_space, self.color, self.desaturation, self.spread)


class Tile(NamedTuple):
    """Decoded texels; those of a single picture have the place 0."""

    place: int
    texels: np.ndarray
    srgb: bool


_Key = tuple[Decoding, tuple[int, int]]


class TexturePool:
    """Decoded texels by (what decides them, file time stamp), and the textures that look at them."""

    def __init__(self) -> None:
        self._decoded: OrderedDict[_Key, list[Tile] | None] = OrderedDict()
        self._kept: dict[TextureUse, Texture] = {}
        self._table: list[Texture] = []

    def load(
        self, uses: Iterable[TextureUse], progress: Progress | None = None
    ) -> tuple[list[Texture], dict[TextureUse, int]]:
        """All textures of the pool, and where in that list those of `uses` are; new files are decoded on all cores.

        A file that cannot be read is missing from the result, with one warning. Textures keep their order, idle ones
        too until they are too large.
        """
        uses = list(uses)
        self._kept = {use: self._kept[use] for use in uses if use in self._kept}
        keys = {use: (use.decoding, image_files.modified(use.file)) for use in uses if use not in self._kept}
        by_file: dict[str, dict[_Key, TextureUse]] = {}
        for use, key in keys.items():
            if key not in self._decoded:
                by_file.setdefault(use.file, {}).setdefault(key, use)
        if by_file:
            self._decode(list(by_file.values()), progress)
        for key in keys.values():
            self._decoded.move_to_end(key)
        self._forget_idle(set(keys.values()))
        textures = dict(self._kept)
        for use, key in keys.items():
            tiles = self._decoded[key]
            if tiles is not None:
                textures[use] = _texture(use, tiles)
        place_of = self._arrange(textures.values())
        return self._table, {use: place_of[_same(texture)] for use, texture in textures.items()}

    def keep(self, use: TextureUse, texture: Texture) -> None:
        """Hold a texture that no file has, for as long as every `load` asks for it."""
        self._kept[use] = texture

    def _arrange(self, textures: Iterable[Texture]) -> dict[tuple, int]:
        """Put each different texture into the table once; where each is.

        Idle ones stay while their texels are held, unless something else looks at those now.
        """
        present = {_same(texture): texture for texture in textures}
        listed = {_same(texture) for texture in self._table}
        seen = {id(texels) for texture in present.values() for texels in _texels(texture)}
        idle = {id(tile.texels) for tiles in self._decoded.values() for tile in tiles or ()} - seen
        kept = [
            texture
            for texture in self._table
            if _same(texture) in present or all(id(texels) in idle for texels in _texels(texture))
        ]
        new = [texture for same, texture in present.items() if same not in listed]
        if new or len(kept) != len(self._table):
            self._table = kept + sorted(new, key=lambda texture: (texture.path, *_look(texture)))
        return {_same(texture): k for k, texture in enumerate(self._table)}

    def _decode(self, files: list[dict[_Key, TextureUse]], progress: Progress | None) -> None:
        with ThreadPoolExecutor(min(len(files), os.cpu_count() or 1)) as pool:
            # For one file a thread costs more than it saves.
            results = (pool.map if len(files) > 1 else map)(_tiles_of, [list(file.values()) for file in files])
            for done, (file, result) in enumerate(zip(files, results)):
                if isinstance(result, errors.AssetUnreadable):
                    shader = next(iter(file.values())).shader
                    errors.warn_once(f"{shader}: the texture cannot be read ({result}); the fallback color is used.")
                    result = [None] * len(file)
                for key, tiles in zip(file, result):
                    self._decoded[key] = tiles
                if progress is not None:
                    progress("textures", done + 1, len(files))

    def _forget_idle(self, used: set[_Key]) -> None:
        idle = [key for key in self._decoded if key not in used]
        size = sum(IDLE_LEAST + _size(self._decoded[key]) for key in idle)
        for key in idle:  # least recently used first
            if size <= IDLE_BYTES:
                break
            size -= IDLE_LEAST + _size(self._decoded.pop(key))


def _same(texture: Texture) -> tuple:
    """Equal uses share their record."""
    return *map(id, _texels(texture)), *_look(texture)


def _texels(texture: Texture) -> list[np.ndarray]:
    return [tile.texels for _, tile in texture.tiles] if texture.tiles else [texture.texels]


def _look(texture: Texture) -> tuple:
    first = texture.tiles[0][1] if texture.tiles else texture
    beyond = tuple(map(float, texture.texels[0, 0])) if texture.tiles else ()
    return first.srgb, first.wrap_s, first.wrap_t, texture.transform, first.scale, first.bias, beyond


def _size(tiles: list[Tile] | None) -> int:
    return sum(tile.texels.nbytes for tile in tiles or ())


def _tiles_of(uses: list[TextureUse]) -> list[list[Tile]] | errors.AssetUnreadable:
    """Texels of several uses of one file; runs on a worker thread, so an error is returned, not raised."""
    try:
        pictures = [(place, image_files.read(file)) for place, file in image_files.tiles(uses[0].file)]
    except errors.AssetUnreadable as error:
        return error
    return [[Tile(place, *to_texels(picture, use)) for place, picture in pictures] for use in uses]


def _texture(use: TextureUse, tiles: list[Tile]) -> Texture:
    if "<UDIM>" not in use.file:
        _, texels, srgb = tiles[0]
        return Texture(use.file, texels, srgb, use.wrap_s, use.wrap_t, use.transform, use.scale, use.bias)
    parts = tuple(
        (place, Texture(use.file, texels, srgb, WRAP_CLAMP, WRAP_CLAMP, scale=use.scale, bias=use.bias))
        for place, texels, srgb in tiles
    )
    beyond = np.array(use.beyond, np.float16).reshape(1, 1, 4)
    return Texture(use.file, beyond, False, WRAP_CLAMP, WRAP_CLAMP, use.transform, tiles=parts)


def to_texels(picture: image_files.Picture, use: TextureUse) -> tuple[np.ndarray, bool]:
    """(H, W, 4) texels of `picture` as `use` looks at it, and whether they are sRGB-coded."""
    srgb = is_srgb(picture, use)
    texels = picture.texels
    if use.spread >= 0:
        srgb = srgb and use.spread != 3  # alpha is never coded
        texels = np.concatenate([np.repeat(texels[..., use.spread, None], 3, axis=-1), texels[..., 3:]], axis=-1)
    if texels.dtype == np.uint8 and not use.desaturation:
        return np.ascontiguousarray(texels), srgb
    if texels.dtype == np.uint16 and not (use.color or srgb):
        return np.ascontiguousarray(texels), False
    linear = _linear(texels, srgb)
    if use.desaturation:
        gray = linear[..., :3] @ _LUMINANCE
        linear[..., :3] += use.desaturation * (gray[..., None] - linear[..., :3])
    if texels.dtype == np.uint16 and not use.color:
        return np.round(linear * 65535.0).astype(np.uint16), False
    if use.color and linear.min(initial=0.0) >= 0.0 and linear.max(initial=0.0) <= 1.0:
        # Eight linear bits would band in the dark, so a color is stored sRGB-coded whatever it was.
        return _to_bytes(linear), True
    return linear.astype(np.float16), False


def is_srgb(picture: image_files.Picture, use: TextureUse) -> bool:
    """Whether texels are sRGB-coded. `auto` is as UsdPreviewSurface defines it: 8-bit files with three or four channels
    are, all others hold linear values."""
    if use.color_space == "auto":
        return picture.texels.dtype == np.uint8 and picture.channels >= 3
    return use.color_space == "sRGB"


def srgb_to_linear(values: np.ndarray) -> np.ndarray:
    return np.where(values <= 0.04045, values / 12.92, ((np.maximum(values, 0.0) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(values: np.ndarray) -> np.ndarray:
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * np.maximum(values, 1e-9) ** (1 / 2.4) - 0.055)


def _linear(texels: np.ndarray, srgb: bool) -> np.ndarray:
    if texels.dtype.kind == "f":
        linear = np.nan_to_num(texels.astype(np.float32), nan=0.0, posinf=MOST_HALF, neginf=-MOST_HALF)
        linear = np.clip(linear, -MOST_HALF, MOST_HALF)
    else:
        linear = texels.astype(np.float32) / np.iinfo(texels.dtype).max
    if srgb:
        linear[..., :3] = srgb_to_linear(linear[..., :3])
    return linear


def _to_bytes(linear: np.ndarray) -> np.ndarray:
    values = np.clip(linear, 0.0, 1.0)
    values[..., :3] = linear_to_srgb(values[..., :3])
    return np.round(values * 255.0).astype(np.uint8)

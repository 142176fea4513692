"""Load texture files to texels, decoded once and shared.

Colors are stored in 8 sRGB-coded bits, data in as many bits as the file has (8 or 16), and values that fit neither,
such as colors above 1, in half floats.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from usdsdg import errors
from usdsdg.parallel import available_threads
from usdsdg.stage.colors import LUMINANCE, linear_to_srgb, srgb_to_linear
from usdsdg_render.images import image_files
from usdsdg_render.scene.scene import IDENTITY_UV, WRAP_CLAMP, WRAP_REPEAT, Texture, UvTransform

Progress = Callable[[str, int, int | None], None]
ONES = (1.0, 1.0, 1.0, 1.0)
ZEROS = (0.0, 0.0, 0.0, 0.0)
# Scale and bias that make (normal + 1) / 2 of a normal.
HALVED, RAISED = (0.5, 0.5, 0.5, 1.0), (0.5, 0.5, 0.5, 0.0)
# Decoded textures that no material uses are kept up to this size, for scripts that swap textures.
MAX_IDLE_BYTES = 1 << 30
IDLE_OVERHEAD = 1 << 20  # bytes that each of them counts for beside its own
MAX_HALF = 65504.0

_LUMINANCE = LUMINANCE.astype(np.float32)


class Decoding(NamedTuple):
    """What determines the texels of a `TextureUse`."""

    file: str
    color_space: str
    color: bool
    desaturation: float
    broadcast: int
    mono: str


@dataclass(frozen=True)
class TextureUse:
    """How a shader samples a file: the linear texel, desaturated, times `scale` plus `bias`.

    Equal uses share one `Texture`; uses of equal `decoding` share the texels.
    """

    file: str  # resolved; with <UDIM> for a set of tiles
    color_space: str = "auto"  # auto | sRGB | raw
    color: bool = True  # not data; stored sRGB-coded
    desaturation: float = 0.0
    broadcast: int = -1  # channel (0-3) that is read as all three of a color; -1 = none
    mono: str = ""  # number that a color counts as: average, luminance or maximum; "" = its channels stay
    wrap_s: int = WRAP_REPEAT
    wrap_t: int = WRAP_REPEAT
    transform: UvTransform = IDENTITY_UV
    scale: tuple[float, ...] = ONES
    bias: tuple[float, ...] = ZEROS
    fallback: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)  # outside of the existing UDIM tiles
    is_normal: bool = False  # whether shaders take (normal + 1) / 2, which files of floats hold the normals of
    shader: str = field(default="", compare=False)  # prim path, for messages

    @property
    def decoding(self) -> Decoding:
        return Decoding(self.file, self.color_space, self.color, self.desaturation, self.broadcast, self.mono)


class Tile(NamedTuple):
    """Decoded texels of one UDIM tile, see `udim_tiles`; a single image is tile 0."""

    number: int
    texels: np.ndarray
    srgb: bool


_Key = tuple[Decoding, tuple[int, int]]


class TexturePool:
    """Cache of decoded texels, by `Decoding` and modification time of the file, and of the textures that use them."""

    def __init__(self) -> None:
        self._decoded: OrderedDict[_Key, list[Tile] | None] = OrderedDict()
        self._kept: dict[TextureUse, Texture] = {}
        self._table: list[Texture] = []
        self._stamps: dict[tuple[str, ...], tuple[int, int]] = {}  # of the files of textures, when they were loaded
        # Then too, by the path of each set of UDIM tiles: the stamp of its folder, and its files.
        self._tiles: dict[str, tuple[tuple[int, int], tuple[str, ...]]] = {}

    def is_stale(self) -> bool:
        """Return whether a file has changed since the last `load` that asked for it."""
        if any(image_files.stamp(files) != stamp for files, stamp in self._stamps.items()):
            return True
        for path, (before, files) in self._tiles.items():
            if (now := image_files.folder_stamp(path)) != before:
                if image_files.files_of(path) != files:
                    return True
                self._tiles[path] = now, files  # other files have come into the folder
        return False

    def load(
        self, uses: Iterable[TextureUse], progress: Progress | None = None
    ) -> tuple[list[Texture], dict[TextureUse, int]]:
        """Return all textures of the pool, and the indices of those of `uses`; new files are decoded on all cores.

        Uses of a file that cannot be read have no index; a warning names it. Textures keep their order, unused ones
        too while they are kept.
        """
        uses = list(uses)
        self._kept = {use: self._kept[use] for use in uses if use in self._kept}
        sets = {use.file for use in uses if use not in self._kept and image_files.UDIM in use.file}
        self._tiles = {path: (image_files.folder_stamp(path), image_files.files_of(path)) for path in sets}
        keys = {use: (use.decoding, image_files.modified(use.file)) for use in uses if use not in self._kept}
        self._stamps = {image_files.files_of(decoding.file): stamp for decoding, stamp in keys.values()}
        self._forget_replaced(set(keys.values()))
        by_file: dict[str, dict[_Key, TextureUse]] = {}
        for use, key in keys.items():
            if key not in self._decoded:
                by_file.setdefault(use.file, {}).setdefault(key, use)
        if by_file:
            self._decode(list(by_file.values()), progress)
        for key in keys.values():
            self._decoded.move_to_end(key)
        self._drop_idle(set(keys.values()))
        textures = dict(self._kept)
        for use, key in keys.items():
            tiles = self._decoded[key]
            if tiles is not None:
                textures[use] = _texture(use, tiles)
        index_of = self._list(textures.values())
        return self._table, {use: index_of[_identity(texture)] for use, texture in textures.items()}

    def keep(self, use: TextureUse, texture: Texture) -> None:
        """Add a texture that has no file. It is dropped by the first `load` that does not ask for it."""
        self._kept[use] = texture

    def _list(self, textures: Iterable[Texture]) -> dict[tuple, int]:
        """List each different texture once; return its index by `_identity`.

        Unused textures stay listed while their texels are cached, unless another texture uses those now.
        """
        present = {_identity(texture): texture for texture in textures}
        listed = {_identity(texture) for texture in self._table}
        seen = {id(texels) for texture in present.values() for texels in _texels(texture)}
        idle = {id(tile.texels) for tiles in self._decoded.values() for tile in tiles or ()} - seen
        kept = [
            texture
            for texture in self._table
            if _identity(texture) in present or all(id(texels) in idle for texels in _texels(texture))
        ]
        new = [texture for identity, texture in present.items() if identity not in listed]
        if new or len(kept) != len(self._table):
            self._table = kept + sorted(new, key=lambda texture: (texture.path, *_sampling(texture)))
        return {_identity(texture): k for k, texture in enumerate(self._table)}

    def _decode(self, files: list[dict[_Key, TextureUse]], progress: Progress | None) -> None:
        with ThreadPoolExecutor(min(len(files), available_threads())) as pool:
            # For one file a thread costs more than it saves.
            results = (pool.map if len(files) > 1 else map)(_tiles_of, [list(file.values()) for file in files])
            for done, (file, result) in enumerate(zip(files, results)):
                if isinstance(result, errors.AssetUnreadable):
                    shader = next(iter(file.values())).shader
                    errors.warn_once(f"{shader}: the texture cannot be read ({result}); the fallback is used.")
                    result = [None] * len(file)
                for key, tiles in zip(file, result):
                    self._decoded[key] = tiles
                if progress is not None:
                    progress("textures", done + 1, len(files))

    def _forget_replaced(self, used: set[_Key]) -> None:
        """Drop the texels of what files held before: nothing asks for them again."""
        decodings = {decoding for decoding, _ in used}
        for key in [key for key in self._decoded if key[0] in decodings and key not in used]:
            del self._decoded[key]

    def _drop_idle(self, used: set[_Key]) -> None:
        idle = [key for key in self._decoded if key not in used]
        size = sum(IDLE_OVERHEAD + _size(self._decoded[key]) for key in idle)
        for key in idle:  # least recently used first
            if size <= MAX_IDLE_BYTES:
                break
            size -= IDLE_OVERHEAD + _size(self._decoded.pop(key))


def _identity(texture: Texture) -> tuple:
    """What distinguishes textures: their texels, by id, and how these are sampled."""
    return *map(id, _texels(texture)), *_sampling(texture)


def _texels(texture: Texture) -> list[np.ndarray]:
    return [tile.texels for _, tile in texture.tiles] if texture.tiles else [texture.texels]


def _sampling(texture: Texture) -> tuple:
    first = texture.tiles[0][1] if texture.tiles else texture
    fallback = tuple(map(float, texture.texels[0, 0])) if texture.tiles else ()
    return first.srgb, first.wrap_s, first.wrap_t, texture.transform, first.scale, first.bias, fallback


def _size(tiles: list[Tile] | None) -> int:
    return sum(tile.texels.nbytes for tile in tiles or ())


def _tiles_of(uses: list[TextureUse]) -> list[list[Tile]] | errors.AssetUnreadable:
    """Texels of several uses of one file. Runs on a worker thread, so it returns errors instead of raising them."""
    try:
        images = [(tile, image_files.read(file)) for tile, file in image_files.udim_tiles(uses[0].file)]
    except errors.AssetUnreadable as error:
        return error
    return [[Tile(tile, *to_texels(image, use)) for tile, image in images] for use in uses]


def _texture(use: TextureUse, tiles: list[Tile]) -> Texture:
    if "<UDIM>" not in use.file:
        _, texels, srgb = tiles[0]
        return Texture(use.file, texels, srgb, use.wrap_s, use.wrap_t, use.transform, *_scale_and_bias(use, texels))
    parts = tuple(
        (number, Texture(use.file, texels, srgb, WRAP_CLAMP, WRAP_CLAMP, IDENTITY_UV, *_scale_and_bias(use, texels)))
        for number, texels, srgb in tiles
    )
    fallback = np.array(use.fallback, np.float16).reshape(1, 1, 4)
    return Texture(use.file, fallback, False, WRAP_CLAMP, WRAP_CLAMP, use.transform, tiles=parts)


def _scale_and_bias(use: TextureUse, texels: np.ndarray) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if use.is_normal and texels.dtype.kind == "f":
        return HALVED, RAISED
    return use.scale, use.bias


def to_texels(image: image_files.DecodedImage, use: TextureUse) -> tuple[np.ndarray, bool]:
    """Return (H, W, 4) texels of an image as `use` needs them, and whether they are sRGB-coded."""
    srgb = is_srgb(image, use)
    texels = image.texels
    if use.broadcast >= 0:
        srgb = srgb and use.broadcast != 3  # alpha is never sRGB-coded
        texels = np.concatenate([np.repeat(texels[..., use.broadcast, None], 3, axis=-1), texels[..., 3:]], axis=-1)
    if use.mono and not _is_gray(texels):
        return _mono(_linear(texels, srgb), use.mono), False
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
        # 8 linear bits would show banding in dark colors, so all colors are stored sRGB-coded.
        return _to_bytes(linear), True
    return linear.astype(np.float16), False


def _is_gray(texels: np.ndarray) -> bool:
    return bool((texels[..., 1] == texels[..., 0]).all() and (texels[..., 2] == texels[..., 0]).all())


def _mono(linear: np.ndarray, mono: str) -> np.ndarray:
    """Return texels of one number for each color, as three: of 16 bits where these hold it."""
    if mono == "maximum":
        number = linear[..., :3].max(axis=-1)
    else:
        number = linear[..., :3] @ (_LUMINANCE if mono == "luminance" else np.full(3, 1.0 / 3.0, np.float32))
    values = np.concatenate([np.repeat(number[..., None], 3, axis=-1), linear[..., 3:]], axis=-1)
    if values.min(initial=0.0) >= 0.0 and values.max(initial=0.0) <= 1.0 + 1e-5:
        return np.round(np.clip(values, 0.0, 1.0) * 65535.0).astype(np.uint16)
    return values.astype(np.float16)


def is_srgb(image: image_files.DecodedImage, use: TextureUse) -> bool:
    """Whether texels are sRGB-coded: by `auto`, as UsdPreviewSurface defines it, 8-bit files of 3 or 4 channels are."""
    if use.color_space == "auto":
        return image.texels.dtype == np.uint8 and image.channels >= 3
    return use.color_space == "sRGB"


def _linear(texels: np.ndarray, srgb: bool) -> np.ndarray:
    if texels.dtype.kind == "f":
        linear = np.nan_to_num(texels.astype(np.float32), nan=0.0, posinf=MAX_HALF, neginf=-MAX_HALF)
        linear = np.clip(linear, -MAX_HALF, MAX_HALF)
    else:
        linear = texels.astype(np.float32) / np.iinfo(texels.dtype).max
    if srgb:
        linear[..., :3] = srgb_to_linear(linear[..., :3])
    return linear


def _to_bytes(linear: np.ndarray) -> np.ndarray:
    values = np.clip(linear, 0.0, 1.0)
    values[..., :3] = linear_to_srgb(values[..., :3])
    return np.round(values * 255.0).astype(np.uint8)

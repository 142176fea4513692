"""Render a room as a panorama: rays against boxes, lamps and one diffuse bounce in small lightmaps."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from usdsdg.demo.skies.room import Block, Lamp, Pattern, Room

_ROOM_CELLS, _BLOCK_CELLS = 24, 6
_LAMP_SAMPLES = 3
_BOUNCE_PATCHES = 4
_SUPERSAMPLING = 2
# Average radiance over the sphere, and the largest.
_MEAN, _MAX_RADIANCE = 0.4, 50.0
_LEAST_RADIANCE = 1e-3
# Edges between radiances with a larger difference of logarithms are those of lamps.
_CONTRAST = 1.6

# The pattern of each face by (axis, upper), and the lowest and highest corner of the box.
_Solid = tuple[Callable[[int, bool], Pattern], np.ndarray, np.ndarray]


@dataclass(frozen=True)
class _Emitters:
    """Small flat emitters: centers (n, 3), facing (n, 3), power = radiance x area (n, 3)."""

    centers: np.ndarray
    facing: np.ndarray
    power: np.ndarray


def panorama(room: Room, width: int = 1024) -> np.ndarray:
    """Return a lat-long panorama of linear radiance, float32 (width / 2, width, 3), +z at the top.

    Scaled so that the average is about `_MEAN` and nothing exceeds `_MAX_RADIANCE`. Every pixel averages
    `_SUPERSAMPLING` squared rays, since cameras see a small part of a panorama, where aliasing would show.
    """
    directions = _directions(width * _SUPERSAMPLING)
    solids = list(_solids(room))
    maps = _lightmaps(room)
    bands = [_radiance(room, solids, maps, band) for band in np.array_split(directions, max(1, width // 128))]
    fine = np.concatenate(bands).reshape(width // 2, _SUPERSAMPLING, width, _SUPERSAMPLING, 3)
    pixels = _softened(fine.mean(axis=(1, 3))).reshape(-1, 3)
    return _scaled_to_mean(pixels).reshape(width // 2, width, 3).astype(np.float32)


def _softened(image: np.ndarray) -> np.ndarray:
    """Return an image with edges of lamps that fall off over some pixels, as glare lets them in a lens.

    A hard edge between radiances that a picture shows as white and as a wall is a staircase, whatever its pixels hold:
    all mixtures of the two are white.
    """
    soft = low = high = np.log(np.maximum(image, _LEAST_RADIANCE))
    for axis in (0, 1):
        for _ in range(2):
            soft = 0.5 * soft + 0.25 * (_shifted(soft, -1, axis) + _shifted(soft, 1, axis))
            low = np.minimum.reduce([_shifted(low, by, axis) for by in (-1, 0, 1)])
            high = np.maximum.reduce([_shifted(high, by, axis) for by in (-1, 0, 1)])
    return np.where((high - low).max(axis=2, keepdims=True) > _CONTRAST, np.exp(soft), image)


def _shifted(image: np.ndarray, by: int, axis: int) -> np.ndarray:
    """Return the neighbors of all pixels; a panorama goes on behind its sides, and repeats its first and last row."""
    if axis == 1:
        return np.roll(image, by, axis=1)
    return np.take(image, np.clip(np.arange(len(image)) - by, 0, len(image) - 1), axis=0)


def _radiance(room: Room, solids: list[_Solid], maps: dict, directions: np.ndarray) -> np.ndarray:
    """Return the radiance (n, 3) that arrives at the room's eye from directions (n, 3)."""
    distance, body, axis, upper = _first_hit(room, directions)
    points = np.asarray(room.eye, np.float32) + directions * distance[:, None]
    pixels = np.zeros_like(points)
    # One number per solid, axis and side, so that one sort groups the pixels by face.
    face = (body.astype(np.int64) * 3 + axis) * 2 + upper
    order = np.argsort(face, kind="stable")
    present, starts = np.unique(face[order], return_index=True)
    for number, at in zip(present.tolist(), np.split(order, starts[1:])):
        solid, face_axis, side = number // 6, number // 2 % 3, bool(number % 2)
        pattern_of, low, high = solids[solid]
        u, v = _surface_coordinates(points[at], face_axis)
        light = _sample_lightmap(maps[solid, face_axis, side], points[at], face_axis, low, high)
        pixels[at] = pattern_of(face_axis, side)(u, v) * light / np.pi
    for lamp in room.lamps:
        at = _hits_lamp(points, lamp) & (body == 0)
        pixels[at] = _lamp_radiance(points[at], lamp)
    return pixels


def _directions(width: int) -> np.ndarray:
    height = width // 2
    longitude = np.pi - (np.arange(width) + 0.5) / width * 2.0 * np.pi
    latitude = np.pi / 2.0 - (np.arange(height) + 0.5) / height * np.pi
    flat = np.cos(latitude)[:, None]
    parts = (flat * np.cos(longitude), flat * np.sin(longitude), np.sin(latitude)[:, None])
    return np.stack(np.broadcast_arrays(*parts), axis=-1).reshape(-1, 3).astype(np.float32)


def _solids(room: Room) -> Iterator[_Solid]:
    """Yield the room itself first, then its blocks."""
    yield room.face_pattern, np.asarray(room.low), np.asarray(room.high)
    for block in room.blocks:
        yield (lambda axis, upper, pattern=block.pattern: pattern), np.asarray(block.low), np.asarray(block.high)


def _first_hit(room: Room, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return distance, solid number, axis of the hit face and whether it is the upper one; every ray hits."""
    eye = np.asarray(room.eye, np.float32)
    # One row per axis: NumPy reduces over a leading axis many times faster than over a trailing one.
    inverse = _inverse(directions.T)
    walls = np.where(inverse > 0.0, _column(room.high) - eye[:, None], _column(room.low) - eye[:, None]) * inverse
    axis, distance = walls.argmin(axis=0), walls.min(axis=0)
    upper = np.take_along_axis(inverse, axis[None], axis=0)[0] > 0.0
    body = np.zeros(len(directions), np.int16)
    for number, block in enumerate(room.blocks, start=1):
        near_faces, near, far = _slabs(block, eye[:, None], inverse)
        hit = np.flatnonzero((near < far) & (near > 1e-3) & (near < distance))
        face = near_faces[:, hit].argmax(axis=0)
        distance[hit], body[hit], axis[hit] = near[hit], number, face
        upper[hit] = inverse[face, hit] < 0.0
    return distance, body, axis, upper


def _column(point: tuple[float, float, float]) -> np.ndarray:
    return np.asarray(point, np.float32)[:, None]


def _inverse(directions: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(1.0 / np.where(np.abs(directions) < 1e-7, np.float32(1e-7), directions))


def _slabs(block: Block, origins: np.ndarray, inverse: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slab test: entry per axis (3, n), entry and exit (n,) of rays, in units of the ray's direction."""
    first = (_column(block.low) - origins) * inverse
    second = (_column(block.high) - origins) * inverse
    near_faces = np.minimum(first, second)
    return near_faces, near_faces.max(axis=0), np.maximum(first, second, out=first).min(axis=0)


def _surface_coordinates(points: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    first, second = [other for other in range(3) if other != axis]
    return points[:, first], points[:, second]


def _lightmaps(room: Room) -> dict[tuple[int, int, bool], np.ndarray]:
    """Return irradiance (cells, cells, 3) by solid, axis and side: from lamps, and one bounce off the walls."""
    lamps = _lamp_emitters(room)
    direct = {}
    for number, (_, low, high) in enumerate(_solids(room)):
        cells = _ROOM_CELLS if number == 0 else _BLOCK_CELLS
        for axis in range(3):
            for upper in (False, True):
                centers, normal = _cell_centers(low, high, axis, upper, cells, inward=number == 0)
                direct[number, axis, upper] = (centers, normal, _irradiance(centers, normal, lamps, room.blocks))
    walls = _bounce_emitters(room, direct)
    return {
        key: (light + _irradiance(centers, normal, walls, room.blocks)).reshape(_side(light), _side(light), 3)
        for key, (centers, normal, light) in direct.items()
    }


def _side(light: np.ndarray) -> int:
    return round(len(light) ** 0.5)


def _cell_centers(
    low: np.ndarray, high: np.ndarray, axis: int, upper: bool, cells: int, *, inward: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return cell centers (cells², 3), second coordinate varying slowest, and the unit normal of a face."""
    first, second = [other for other in range(3) if other != axis]
    middle = (np.arange(cells) + 0.5) / cells
    normal = np.zeros(3)
    normal[axis] = (1.0 if upper else -1.0) * (-1.0 if inward else 1.0)
    centers = np.empty((cells, cells, 3))
    centers[..., first] = (low + (high - low) * middle[:, None])[None, :, first]
    centers[..., second] = (low + (high - low) * middle[:, None])[:, None, second]
    centers[..., axis] = (high if upper else low)[axis]
    return (centers + 1e-3 * normal).reshape(-1, 3).astype(np.float32), normal.astype(np.float32)


def _lamp_emitters(room: Room) -> _Emitters:
    centers, facing, power = [], [], []
    for lamp in room.lamps:
        low, high = np.asarray(lamp.low), np.asarray(lamp.high)
        spread = [np.arange(_LAMP_SAMPLES) + 0.5 if extent > 0 else np.zeros(1) for extent in high - low]
        grid = np.stack(np.meshgrid(*spread, indexing="ij"), axis=-1).reshape(-1, 3) / _LAMP_SAMPLES
        extents = (high - low)[high > low]
        centers.append(low + grid * (high - low) + 1e-3 * np.asarray(lamp.facing))
        facing.append(np.tile(lamp.facing, (len(grid), 1)))
        power.append(np.tile(np.asarray(lamp.radiance) * extents.prod() / len(grid), (len(grid), 1)))
    return _Emitters(*(np.concatenate(part).astype(np.float32) for part in (centers, facing, power)))


def _bounce_emitters(room: Room, direct: dict) -> _Emitters:
    """Return the room's faces as coarse emitters of the lamp light that they reflect."""
    centers, facing, power = [], [], []
    extent = np.asarray(room.high) - np.asarray(room.low)
    block = _ROOM_CELLS // _BOUNCE_PATCHES
    for axis in range(3):
        for upper in (False, True):
            points, normal, light = direct[0, axis, upper]
            albedo = room.face_pattern(axis, upper)(*_surface_coordinates(points, axis))
            sent = _patch_means(albedo * light / np.pi, block)
            area = np.delete(extent, axis).prod() / len(sent)
            centers.append(_patch_means(points, block))
            facing.append(np.tile(normal, (len(sent), 1)))
            power.append(sent * area)
    return _Emitters(*(np.concatenate(part).astype(np.float32) for part in (centers, facing, power)))


def _patch_means(values: np.ndarray, block: int) -> np.ndarray:
    side = _side(values)
    return values.reshape(side // block, block, side // block, block, -1).mean(axis=(1, 3)).reshape(-1, values.shape[1])


def _irradiance(points: np.ndarray, normal: np.ndarray, lights: _Emitters, blocks: Sequence[Block]) -> np.ndarray:
    """Return the irradiance (n, 3) at points (n, 3) of one normal, with shadows of blocks."""
    to_light = lights.centers[None] - points[:, None]
    squared = np.maximum(np.einsum("pli,pli->pl", to_light, to_light), 0.04)
    leaving = np.maximum(-np.einsum("pli,li->pl", to_light, lights.facing), 0.0)
    arriving = np.maximum(to_light @ normal, 0.0)
    form = leaving * arriving / squared**2
    pairs = np.nonzero(form > 1e-6)
    form[pairs] *= ~_blocked(points[pairs[0]], to_light[pairs], blocks)
    return form @ lights.power


def _blocked(origins: np.ndarray, spans: np.ndarray, blocks: Sequence[Block]) -> np.ndarray:
    inverse, starts = _inverse(spans.T), np.ascontiguousarray(origins.T)
    hidden = np.zeros(len(origins), bool)
    for block in blocks:
        _, near, far = _slabs(block, starts, inverse)
        hidden |= (near < far) & (far > 1e-3) & (near < 0.999)
    return hidden


def _sample_lightmap(light: np.ndarray, points: np.ndarray, axis: int, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Interpolate a lightmap bilinearly at points of its face."""
    first, second = [other for other in range(3) if other != axis]
    cells = light.shape[0]
    column = np.clip((points[:, first] - low[first]) / (high - low)[first] * cells - 0.5, 0.0, cells - 1.001)
    row = np.clip((points[:, second] - low[second]) / (high - low)[second] * cells - 0.5, 0.0, cells - 1.001)
    left, top = column.astype(int), row.astype(int)
    x, y = (column - left)[:, None], (row - top)[:, None]
    upper = light[top, left] * (1 - x) + light[top, left + 1] * x
    lower = light[top + 1, left] * (1 - x) + light[top + 1, left + 1] * x
    return upper * (1 - y) + lower * y


def _hits_lamp(points: np.ndarray, lamp: Lamp) -> np.ndarray:
    low, high = np.asarray(lamp.low), np.asarray(lamp.high)
    # A lamp lies slightly in front of the wall that the ray has hit.
    slack = np.where(high > low, 0.0, 0.12)
    inside = np.ones(len(points), bool)
    for axis in range(3):
        inside &= np.abs(points[:, axis] - (low + high)[axis] / 2.0) < (high - low)[axis] / 2.0 + slack[axis]
    return inside


def _lamp_radiance(points: np.ndarray, lamp: Lamp) -> np.ndarray:
    """Return a lamp's radiance: uniform, or for a window a pale sky over a dark horizon, crossed by its frame."""
    radiance = np.tile(np.asarray(lamp.radiance), (len(points), 1))
    if not lamp.sky:
        return radiance
    low, high = np.asarray(lamp.low), np.asarray(lamp.high)
    flat = int(np.argmin(high - low))
    along = 1 - flat
    height = (points[:, 2] - low[2]) / (high - low)[2]
    across = (points[:, along] - low[along]) / (high - low)[along]
    skyline = 0.30 + 0.05 * np.sin(9.0 * across) + 0.03 * np.sin(31.0 * across + 1.0)
    trees = 1.0 / (1.0 + np.exp((skyline - height) * 60.0))
    radiance *= (0.12 + 0.88 * trees * (0.75 + 0.25 * height))[:, None]
    panes = np.minimum(np.abs(across * 2.0 % 1.0 - 0.5), np.abs(height * 2.0 % 1.0 - 0.5))
    return np.where((panes > 0.47)[:, None] | (np.abs(across - 0.5) < 0.02)[:, None], 0.25, radiance)


def _scaled_to_mean(pixels: np.ndarray) -> np.ndarray:
    """Scale and clip radiance until its mean over the sphere is `_MEAN`, in a few iterations."""
    rows = round((len(pixels) / 2) ** 0.5)
    weight = np.cos((np.arange(rows) + 0.5) / rows * np.pi - np.pi / 2.0)
    weight = np.repeat(weight / weight.sum() / (2 * rows), 2 * rows)
    scaled = pixels
    for _ in range(4):
        scaled = np.minimum(scaled * (_MEAN / max(float(weight @ scaled.mean(axis=1)), 1e-9)), _MAX_RADIANCE)
    return scaled

"""Light textures: decoding to linear radiance, and conversion of dome layouts to latitude-longitude maps."""

import numpy as np

from usdsdg.stage.colors import srgb_to_linear

# Times any intensity this fits into float32; the sun has 1.6e9 nits.
BRIGHTEST_TEXEL = 1e12


def linear_rgb(texels: np.ndarray) -> np.ndarray:
    """Decode texels to (H, W, 3) float32 linear; NaN, infinite and negative values are replaced."""
    if texels.dtype.kind == "f":
        if texels.min(initial=0.0) >= 0.0 and texels.max(initial=0.0) <= BRIGHTEST_TEXEL:  # false for NaN
            return np.ascontiguousarray(texels)
        clean = np.nan_to_num(texels, nan=0.0, posinf=65504.0, neginf=0.0)
        return np.clip(clean, 0.0, BRIGHTEST_TEXEL)
    values = np.arange(np.iinfo(texels.dtype).max + 1, dtype=np.float32) / np.iinfo(texels.dtype).max
    table = srgb_to_linear(values) if texels.dtype == np.uint8 else values
    return table.astype(np.float32)[texels]


def directions(height: int, width: int) -> np.ndarray:
    """(height, width, 3) unit vectors through the texel centers of a lat-long map, in the frame of `scene.Dome`."""
    theta = (np.arange(height) + 0.5) * (np.pi / height)
    phi = (np.arange(width) + 0.5) * (2.0 * np.pi / width)
    sine = np.sin(theta)[:, None]
    up = np.broadcast_to(np.cos(theta)[:, None], (height, width))
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), up], axis=-1)


def resample(texture: np.ndarray, to_frame: np.ndarray, from_frame: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Resample a lat-long map from `from_frame` to `to_frame` (both dome_from_world), bilinear."""
    wanted = directions(*shape) @ (to_frame @ from_frame.T)
    height, width = texture.shape[:2]
    row = np.arccos(np.clip(wanted[..., 2], -1.0, 1.0)) / np.pi * height - 0.5
    column = np.arctan2(wanted[..., 1], wanted[..., 0]) / (2.0 * np.pi) % 1.0 * width - 0.5
    top, left = np.floor(row).astype(int), np.floor(column).astype(int)
    down = (row - top)[..., None].astype(np.float32)
    right = (column - left)[..., None].astype(np.float32)
    rows = np.clip([top, top + 1], 0, height - 1)
    columns = np.array([left, left + 1]) % width
    upper = texture[rows[0], columns[0]] * (1 - right) + texture[rows[0], columns[1]] * right
    lower = texture[rows[1], columns[0]] * (1 - right) + texture[rows[1], columns[1]] * right
    return upper * (1 - down) + lower * down


def layout_of(texture: np.ndarray) -> str:
    """Return the layout that `automatic` means: a cross if width to height is 3 to 4, else latlong."""
    height, width = texture.shape[:2]
    return "cubeMapVerticalCross" if 4 * width == 3 * height else "latlong"


def to_latlong(texture: np.ndarray, layout: str) -> np.ndarray:
    """Convert a dome texture of one of UsdLux's formats to a lat-long map, both (H, W, 3).

    The center of each layout is the center of the lat-long map. A mirrored ball is seen from outside, so its image is
    flipped; the angular map and the cross are seen from inside.
    """
    if layout == "latlong":
        return texture
    height = texture.shape[0] // (2 if layout == "cubeMapVerticalCross" else 1)
    d = directions(height, 2 * height)
    # Ahead is the middle column, half a turn from the first; right is the direction of growing columns.
    ahead, right, up = -d[..., 0], -d[..., 1], d[..., 2]
    if layout == "cubeMapVerticalCross":
        x, y = _on_cross(ahead, right, up, texture.shape)
    else:
        sideways = np.maximum(np.hypot(right, up), 1e-12)
        if layout == "mirroredBall":
            # The ball's normal is the half vector between viewer and direction.
            radius, right = np.sqrt(np.clip((1.0 - ahead) / 2.0, 0.0, 1.0)), -right
        else:
            radius = np.arccos(np.clip(ahead, -1.0, 1.0)) / np.pi
        x = (0.5 + 0.5 * radius * right / sideways) * texture.shape[1] - 0.5
        y = (0.5 - 0.5 * radius * up / sideways) * texture.shape[0] - 0.5
    return bilinear(texture, x, y)


def _on_cross(ahead: np.ndarray, right: np.ndarray, up: np.ndarray, shape: tuple[int, ...]) -> tuple:
    """Return texel coordinates on a cross: ahead is in the middle of the second row, behind at the bottom, flipped."""
    side_x, side_y = shape[1] / 3, shape[0] / 4
    largest = np.maximum(np.maximum(np.abs(ahead), np.abs(right)), np.abs(up))
    faces = [
        (ahead == largest, 1, 1, right, -up),
        (-ahead == largest, 1, 3, right, up),
        (right == largest, 2, 1, -ahead, -up),
        (-right == largest, 0, 1, ahead, -up),
        (up == largest, 1, 0, right, ahead),
        (-up == largest, 1, 2, right, -ahead),
    ]
    x, y = np.zeros((2, *ahead.shape))
    for here, column, row, across, down in faces:
        # Half a texel inside of the face, so that faces that are adjacent only on the cross do not bleed in.
        u = np.clip((across / largest + 1) / 2 * side_x - 0.5, 0.0, side_x - 1.0) + column * side_x
        v = np.clip((down / largest + 1) / 2 * side_y - 0.5, 0.0, side_y - 1.0) + row * side_y
        x, y = np.where(here, u, x), np.where(here, v, y)
    return x, y


def bilinear(texture: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Interpolate at texel coordinates (0 = center of the first texel), clamped at the edges."""
    height, width = texture.shape[:2]
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    right, bottom = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    fx, fy = (x - left)[..., None].astype(np.float32), (y - top)[..., None].astype(np.float32)
    upper = texture[top, left] * (1 - fx) + texture[top, right] * fx
    lower = texture[bottom, left] * (1 - fx) + texture[bottom, right] * fx
    return upper * (1 - fy) + lower * fy

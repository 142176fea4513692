"""Pictures of lights: decoded to linear light, and skies of other layouts turned into latitude and longitude."""

from __future__ import annotations

import numpy as np

from usdsdg_render.images.textures import srgb_to_linear

# Times any intensity this stays within 32-bit numbers; the sun has 1.6e9 nits.
BRIGHTEST_TEXEL = 1e12


def linear_rgb(texels: np.ndarray) -> np.ndarray:
    """(H, W, 3) float32 linear, NaN, infinite and negative texels replaced."""
    if texels.dtype.kind == "f":
        if texels.min(initial=0.0) >= 0.0 and texels.max(initial=0.0) <= BRIGHTEST_TEXEL:  # not of NaN
            return np.ascontiguousarray(texels)
        clean = np.nan_to_num(texels, nan=0.0, posinf=65504.0, neginf=0.0)
        return np.clip(clean, 0.0, BRIGHTEST_TEXEL)
    values = np.arange(np.iinfo(texels.dtype).max + 1, dtype=np.float32) / np.iinfo(texels.dtype).max
    table = srgb_to_linear(values) if texels.dtype == np.uint8 else values
    return table.astype(np.float32)[texels]


def directions(height: int, width: int) -> np.ndarray:
    """(height, width, 3) unit vectors through the texel centres of a lat-long picture, in the frame of `scene.Dome`."""
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


def layout_of(picture: np.ndarray) -> str:
    """What `automatic` means: a cross where the sides are as three to four, else latitude and longitude."""
    height, width = picture.shape[:2]
    return "cubeMapVerticalCross" if 4 * width == 3 * height else "latlong"


def to_latlong(picture: np.ndarray, layout: str) -> np.ndarray:
    """A sky of one of UsdLux's texture formats as a lat-long picture, both (H, W, 3).

    The middle of each layout is the middle of the lat-long picture. A mirrored ball is seen from outside, so that its
    picture is the wrong way round; the angular map and the cross are seen from inside.
    """
    if layout == "latlong":
        return picture
    height = picture.shape[0] // (2 if layout == "cubeMapVerticalCross" else 1)
    d = directions(height, 2 * height)
    # Ahead is the middle column, half a turn from the first; the picture's right is where columns grow.
    ahead, right, up = -d[..., 0], -d[..., 1], d[..., 2]
    if layout == "cubeMapVerticalCross":
        x, y = _on_cross(ahead, right, up, picture.shape)
    else:
        sideways = np.maximum(np.hypot(right, up), 1e-12)
        if layout == "mirroredBall":
            # The ball's normal halves the way between the viewer and the direction.
            radius, right = np.sqrt(np.clip((1.0 - ahead) / 2.0, 0.0, 1.0)), -right
        else:
            radius = np.arccos(np.clip(ahead, -1.0, 1.0)) / np.pi
        x = (0.5 + 0.5 * radius * right / sideways) * picture.shape[1] - 0.5
        y = (0.5 - 0.5 * radius * up / sideways) * picture.shape[0] - 0.5
    return bilinear(picture, x, y)


def _on_cross(ahead: np.ndarray, right: np.ndarray, up: np.ndarray, shape: tuple[int, ...]) -> tuple:
    """Where directions lie on a cross: ahead in the middle of the second row, behind upside down at the bottom."""
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
        # Half a texel inside the face, so that no neighbour on the picture, which is none in the sky, bleeds in.
        u = np.clip((across / largest + 1) / 2 * side_x - 0.5, 0.0, side_x - 1.0) + column * side_x
        v = np.clip((down / largest + 1) / 2 * side_y - 0.5, 0.0, side_y - 1.0) + row * side_y
        x, y = np.where(here, u, x), np.where(here, v, y)
    return x, y


def bilinear(picture: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Values at texel coordinates (0 = the first texel's centre), the edges going on outside."""
    height, width = picture.shape[:2]
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    right, bottom = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    fx, fy = (x - left)[..., None].astype(np.float32), (y - top)[..., None].astype(np.float32)
    upper = picture[top, left] * (1 - fx) + picture[top, right] * fx
    lower = picture[bottom, left] * (1 - fx) + picture[bottom, right] * fx
    return upper * (1 - fy) + lower * fy

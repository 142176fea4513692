"""Brushes for the pictures of the stand-ins: noise, text, bars, symbols. All colours are sRGB 0…255."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

Colour = tuple[int, int, int]
WHITE: Colour = (250, 250, 246)
BLACK: Colour = (28, 28, 30)


def generator(name: str) -> np.random.Generator:
    """The same numbers on every machine for the same name."""
    return np.random.default_rng(zlib.crc32(name.encode()))


def noise(size: tuple[int, int], cells: tuple[int, int], name: str) -> np.ndarray:
    """(height, width) float32 in 0…1: smooth random hills, `cells` of them down and across."""
    hills = generator(name).integers(0, 256, cells, dtype=np.uint8)
    picture = Image.fromarray(hills).resize((size[1], size[0]), Image.Resampling.BICUBIC)
    return np.asarray(picture, dtype=np.float32) / 255.0


def fractal(size: tuple[int, int], cells: tuple[int, int], name: str, octaves: int = 4) -> np.ndarray:
    """(height, width) float32 around 0.5: noise with ever finer detail of half the strength."""
    total, weight = np.zeros(size, np.float32), 0.0
    for octave in range(octaves):
        finer = (min(cells[0] << octave, size[0]), min(cells[1] << octave, size[1]))
        total += noise(size, finer, f"{name}/{octave}") * 0.5**octave
        weight += 0.5**octave
    return total / weight


def tinted(size: tuple[int, int], colour: Colour, shade: np.ndarray | float = 0.0) -> Image.Image:
    """A picture of one colour, made lighter or darker by `shade` (-1…1) per pixel."""
    plane = np.broadcast_to(np.asarray(shade, dtype=np.float32), size)[..., None]
    pixels = np.asarray(colour, dtype=np.float32) * (1.0 + plane)
    return Image.fromarray(np.clip(pixels, 0, 255).astype(np.uint8))


def gradient(size: tuple[int, int], top: Colour, bottom: Colour) -> Image.Image:
    """A vertical run between two colours; size is (height, width)."""
    weight = np.linspace(0.0, 1.0, size[0], dtype=np.float32)[:, None, None]
    column = (1.0 - weight) * np.asarray(top, np.float32) + weight * np.asarray(bottom, np.float32)
    return Image.fromarray(np.broadcast_to(column, (*size, 3)).astype(np.uint8))


@lru_cache(maxsize=64)
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's built-in typeface, so that no font of the machine changes a picture."""
    return ImageFont.load_default(size)


def write(
    picture: Image.Image,
    text: str,
    centre: tuple[float, float],
    height: float,
    colour: Colour,
    *,
    width: float | None = None,
    bold: float = 0.0,
    outline: Colour | None = None,
) -> None:
    """Text centred at a fraction of the picture, `height` a fraction of its height; shrinks to fit `width`.

    `bold` thickens the strokes by that fraction of the letter height.
    """
    draw = ImageDraw.Draw(picture)
    size = max(6, round(height * picture.height))
    if width is not None:
        length = draw.textlength(text, font=font(size))
        size = max(6, min(size, int(size * width * picture.width / max(length, 1.0))))
    draw.text(
        (centre[0] * picture.width, centre[1] * picture.height),
        text,
        fill=colour,
        font=font(size),
        anchor="mm",
        stroke_width=round(bold * size),
        stroke_fill=outline or colour,
    )


def rectangle(
    picture: Image.Image, box: tuple[float, float, float, float], fill: Colour, *, corner: float = 0.0
) -> None:
    """A filled rectangle, (left, top, right, bottom) and the corner radius as fractions of width and height."""
    width, height = picture.size
    corners = (box[0] * width, box[1] * height, box[2] * width, box[3] * height)
    ImageDraw.Draw(picture).rounded_rectangle(corners, radius=corner * min(width, height), fill=fill)


def ellipse(picture: Image.Image, centre: tuple[float, float], radii: tuple[float, float], fill: Colour) -> None:
    width, height = picture.size
    box = (
        (centre[0] - radii[0]) * width,
        (centre[1] - radii[1]) * height,
        (centre[0] + radii[0]) * width,
        (centre[1] + radii[1]) * height,
    )
    ImageDraw.Draw(picture).ellipse(box, fill=fill)


def polygon(picture: Image.Image, corners: Sequence[tuple[float, float]], fill: Colour) -> None:
    width, height = picture.size
    ImageDraw.Draw(picture).polygon([(x * width, y * height) for x, y in corners], fill=fill)


def line(picture: Image.Image, path: Sequence[tuple[float, float]], fill: Colour, width: float) -> None:
    """A polyline through fractions of the picture; `width` is a fraction of its height."""
    across, down = picture.size
    ImageDraw.Draw(picture).line(
        [(x * across, y * down) for x, y in path], fill=fill, width=max(1, round(width * down)), joint="curve"
    )


def barcode(picture: Image.Image, box: tuple[float, float, float, float], name: str) -> None:
    """Black bars on white in (left, top, right, bottom) fractions."""
    rectangle(picture, box, (255, 255, 255))
    left, right = box[0] + 0.02, box[2] - 0.02
    widths = generator(name).integers(1, 4, 60).cumsum()
    edges = left + (right - left) * widths / widths[-1]
    for start, end in zip(edges[:-1:2], edges[1::2]):
        rectangle(picture, (start, box[1] + 0.01, end, box[3] - 0.03), BLACK)


def small_print(
    picture: Image.Image, box: tuple[float, float, float, float], lines: int, colour: Colour, name: str
) -> None:
    """Grey lines of unreadable text, ragged on the right."""
    lengths = generator(name).uniform(0.6, 1.0, lines)
    step = (box[3] - box[1]) / lines
    for row, length in enumerate(lengths):
        top = box[1] + row * step
        rectangle(picture, (box[0], top, box[0] + (box[2] - box[0]) * length, top + 0.42 * step), colour)


def cross(picture: Image.Image, centre: tuple[float, float], size: float, colour: Colour) -> None:
    """An upright cross with equal arms; `size` is a fraction of the picture's height."""
    across, down = size * picture.height / picture.width / 2.0, size / 2.0
    x, y = centre
    rectangle(picture, (x - across / 3, y - down, x + across / 3, y + down), colour)
    rectangle(picture, (x - across, y - down / 3, x + across, y + down / 3), colour)


def pasted(picture: Image.Image, top: Image.Image, box: tuple[float, float, float, float]) -> None:
    """Put another picture into (left, top, right, bottom) fractions of this one."""
    width, height = picture.size
    corners = [round(box[0] * width), round(box[1] * height), round(box[2] * width), round(box[3] * height)]
    fitted = top.resize((max(1, corners[2] - corners[0]), max(1, corners[3] - corners[1])), Image.Resampling.LANCZOS)
    picture.paste(fitted, (corners[0], corners[1]))


def six_faces(faces: dict[str, Image.Image], *, cell: int = 384) -> Image.Image:
    """The picture of a box: each face's picture in its cell (see `box.atlas_cell`)."""
    from usdsdg.demo.shapes.box import ATLAS_COLUMNS, ATLAS_ROWS, atlas_cell

    atlas = Image.new("RGB", (ATLAS_COLUMNS * cell, ATLAS_ROWS * cell))
    for face, picture in faces.items():
        column, row = atlas_cell(face)
        atlas.paste(picture.resize((cell, cell), Image.Resampling.LANCZOS), (column * cell, row * cell))
    return atlas

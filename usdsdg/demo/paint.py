"""Drawing primitives for textures: noise, text, bars, symbols. All colors are sRGB 0…255."""

import zlib
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

Color = tuple[int, int, int]
WHITE: Color = (250, 250, 246)
BLACK: Color = (28, 28, 30)


def generator(name: str) -> np.random.Generator:
    """Return a random generator seeded by `name`: the same numbers on every machine."""
    return np.random.default_rng(zlib.crc32(name.encode()))


def noise(size: tuple[int, int], cells: tuple[int, int], name: str) -> np.ndarray:
    """Value noise, float32 (height, width) in 0…1, interpolated between `cells` (rows, columns) random values."""
    values = generator(name).integers(0, 256, cells, dtype=np.uint8)
    image = Image.fromarray(values).resize((size[1], size[0]), Image.Resampling.BICUBIC)
    return np.asarray(image, dtype=np.float32) / 255.0


def fractal(size: tuple[int, int], cells: tuple[int, int], name: str, octaves: int = 4) -> np.ndarray:
    """Fractal noise, float32 (height, width) around 0.5: each octave has twice the frequency and half the amplitude."""
    total, weight = np.zeros(size, np.float32), 0.0
    for octave in range(octaves):
        finer = (min(cells[0] << octave, size[0]), min(cells[1] << octave, size[1]))
        total += noise(size, finer, f"{name}/{octave}") * 0.5**octave
        weight += 0.5**octave
    return total / weight


def tinted(size: tuple[int, int], color: Color, shade: np.ndarray | float = 0.0) -> Image.Image:
    """An image of one color, made lighter or darker by `shade` (-1…1) per pixel."""
    plane = np.broadcast_to(np.asarray(shade, dtype=np.float32), size)[..., None]
    pixels = np.asarray(color, dtype=np.float32) * (1.0 + plane)
    return Image.fromarray(np.clip(pixels, 0, 255).astype(np.uint8))


def gradient(size: tuple[int, int], top: Color, bottom: Color) -> Image.Image:
    """A vertical gradient between two colors; size is (height, width)."""
    weight = np.linspace(0.0, 1.0, size[0], dtype=np.float32)[:, None, None]
    column = (1.0 - weight) * np.asarray(top, np.float32) + weight * np.asarray(bottom, np.float32)
    return Image.fromarray(np.broadcast_to(column, (*size, 3)).astype(np.uint8))


@lru_cache(maxsize=64)
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's built-in typeface, so that images do not depend on installed fonts."""
    return ImageFont.load_default(size)


def write(
    image: Image.Image,
    text: str,
    center: tuple[float, float],
    height: float,
    color: Color,
    *,
    width: float | None = None,
    bold: float = 0.0,
    outline: Color | None = None,
) -> None:
    """Draw text around `center`; shrinks to fit `width`.

    `center`, `height` and `width` are fractions of the image's size; `bold` thickens the strokes by that fraction of
    the letter height.
    """
    draw = ImageDraw.Draw(image)
    size = max(6, round(height * image.height))
    if width is not None:
        length = draw.textlength(text, font=font(size))
        size = max(6, min(size, int(size * width * image.width / max(length, 1.0))))
    draw.text(
        (center[0] * image.width, center[1] * image.height),
        text,
        fill=color,
        font=font(size),
        anchor="mm",
        stroke_width=round(bold * size),
        stroke_fill=outline or color,
    )


def rectangle(image: Image.Image, box: tuple[float, float, float, float], fill: Color, *, corner: float = 0.0) -> None:
    """Draw a filled rectangle: (left, top, right, bottom) and corner radius as fractions of width and height."""
    width, height = image.size
    corners = (box[0] * width, box[1] * height, box[2] * width, box[3] * height)
    ImageDraw.Draw(image).rounded_rectangle(corners, radius=corner * min(width, height), fill=fill)


def ellipse(image: Image.Image, center: tuple[float, float], radii: tuple[float, float], fill: Color) -> None:
    width, height = image.size
    box = (
        (center[0] - radii[0]) * width,
        (center[1] - radii[1]) * height,
        (center[0] + radii[0]) * width,
        (center[1] + radii[1]) * height,
    )
    ImageDraw.Draw(image).ellipse(box, fill=fill)


def polygon(image: Image.Image, corners: Sequence[tuple[float, float]], fill: Color) -> None:
    width, height = image.size
    ImageDraw.Draw(image).polygon([(x * width, y * height) for x, y in corners], fill=fill)


def line(image: Image.Image, path: Sequence[tuple[float, float]], fill: Color, width: float) -> None:
    """Draw a polyline; points are fractions of the image's size, `width` a fraction of its height."""
    across, down = image.size
    ImageDraw.Draw(image).line(
        [(x * across, y * down) for x, y in path], fill=fill, width=max(1, round(width * down)), joint="curve"
    )


def barcode(image: Image.Image, box: tuple[float, float, float, float], name: str) -> None:
    """Draw black bars on white in the box (left, top, right, bottom), fractions of the image's size."""
    rectangle(image, box, (255, 255, 255))
    left, right = box[0] + 0.02, box[2] - 0.02
    widths = generator(name).integers(1, 4, 60).cumsum()
    edges = left + (right - left) * widths / widths[-1]
    for start, end in zip(edges[:-1:2], edges[1::2]):
        rectangle(image, (start, box[1] + 0.01, end, box[3] - 0.03), BLACK)


def small_print(
    image: Image.Image, box: tuple[float, float, float, float], lines: int, color: Color, name: str
) -> None:
    """Draw bars that look like lines of small ragged-right text."""
    lengths = generator(name).uniform(0.6, 1.0, lines)
    step = (box[3] - box[1]) / lines
    for row, length in enumerate(lengths):
        top = box[1] + row * step
        rectangle(image, (box[0], top, box[0] + (box[2] - box[0]) * length, top + 0.42 * step), color)


def cross(image: Image.Image, center: tuple[float, float], size: float, color: Color) -> None:
    """Draw an upright cross with equal arms; `size` is a fraction of the image's height."""
    across, down = size * image.height / image.width / 2.0, size / 2.0
    x, y = center
    rectangle(image, (x - across / 3, y - down, x + across / 3, y + down), color)
    rectangle(image, (x - across, y - down / 3, x + across, y + down / 3), color)


def pasted(image: Image.Image, top: Image.Image, box: tuple[float, float, float, float]) -> None:
    """Paste another image into the box (left, top, right, bottom), fractions of this image's size."""
    width, height = image.size
    corners = [round(box[0] * width), round(box[1] * height), round(box[2] * width), round(box[3] * height)]
    fitted = top.resize((max(1, corners[2] - corners[0]), max(1, corners[3] - corners[1])), Image.Resampling.LANCZOS)
    image.paste(fitted, (corners[0], corners[1]))


def six_faces(faces: dict[str, Image.Image], *, cell: int = 384) -> Image.Image:
    """Return the texture atlas of a box: each face's image in its cell (see `box.atlas_cell`)."""
    from usdsdg.demo.shapes.box import ATLAS_COLUMNS, ATLAS_ROWS, atlas_cell

    atlas = Image.new("RGB", (ATLAS_COLUMNS * cell, ATLAS_ROWS * cell))
    for face, image in faces.items():
        column, row = atlas_cell(face)
        atlas.paste(image.resize((cell, cell), Image.Resampling.LANCZOS), (column * cell, row * cell))
    return atlas

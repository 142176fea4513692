"""Textures of the props: cardboard, paper, cork, plastic, signs."""

import numpy as np
from PIL import Image

from usdsdg.demo import paint
from usdsdg.demo.paint import BLACK, WHITE, Color

KRAFT: Color = (186, 140, 92)
SAFETY_GREEN: Color = (0, 122, 84)


def cardboard(name: str, code: str) -> Image.Image:
    """Atlas of a shipping carton: flaps and tape on top and bottom, a label and marks on the sides."""
    sides = {face: _kraft(f"{name}{face}") for face in ("+x", "-x", "+y", "-y")}
    for face in ("+x", "-x"):
        paint.rectangle(sides[face], (0.435, 0.0, 0.565, 0.22), _tape())
    _shipping_label(sides["-y"], (0.52, 0.12, 0.93, 0.5), code)
    _arrows(sides["-y"], (0.16, 0.74))
    _fragile(sides["+y"])
    _arrows(sides["+x"], (0.2, 0.8))
    return paint.six_faces({**sides, "+z": _flaps(f"{name}+z"), "-z": _flaps(f"{name}-z")})


def traffic_cone() -> Image.Image:
    """Orange with two white reflective stripes and dirt toward the foot; t goes from foot to tip."""
    size = (512, 256)
    image = paint.tinted(size, (238, 86, 22), 0.12 * (paint.fractal(size, (6, 6), "cone") - 0.5))
    for top, bottom in ((0.22, 0.40), (0.53, 0.68)):
        paint.rectangle(image, (0.0, top, 1.0, bottom), (238, 238, 234))
        mesh = paint.noise(size, (128, 64), "beads") * 10.0
        rows = slice(int(top * size[0]), int(bottom * size[0]))
        pixels = np.asarray(image).astype(np.float32)
        pixels[rows] -= mesh[rows, :, None]
        image = Image.fromarray(pixels.clip(0, 255).astype(np.uint8))
    return _worn(image, "cone", 0.35)


def floor_sign() -> Image.Image:
    yellow = (250, 206, 24)
    image = paint.tinted((560, 300), yellow, 0.05 * (paint.fractal((560, 300), (4, 3), "sign") - 0.5))
    paint.rectangle(image, (0.06, 0.14, 0.94, 0.285), BLACK, corner=0.03)
    paint.write(image, "CAUTION", (0.5, 0.212), 0.1, yellow, width=0.76, bold=0.04)
    _slipping_person(image)
    paint.write(image, "WET FLOOR", (0.5, 0.865), 0.09, BLACK, width=0.8, bold=0.04)
    paint.rectangle(image, (0.36, 0.035, 0.64, 0.09), (70, 58, 10), corner=0.08)
    return image


def plastic_barrel() -> Image.Image:
    size = (512, 512)
    image = paint.tinted(size, (18, 74, 152), 0.10 * (paint.fractal(size, (5, 5), "barrel") - 0.5))
    label = paint.tinted((130, 190), WHITE)
    paint.rectangle(label, (0.0, 0.0, 1.0, 0.24), (206, 40, 40))
    paint.write(label, "INDUSTRIAL OIL", (0.5, 0.12), 0.14, WHITE, width=0.85, bold=0.03)
    paint.polygon(label, [(0.2, 0.36), (0.36, 0.62), (0.2, 0.88), (0.04, 0.62)], (206, 40, 40))
    paint.polygon(label, [(0.2, 0.43), (0.32, 0.62), (0.2, 0.81), (0.08, 0.62)], WHITE)
    paint.write(label, "!", (0.2, 0.62), 0.26, BLACK, bold=0.06)
    paint.small_print(label, (0.44, 0.36, 0.94, 0.9), 6, (90, 90, 96), "oil")
    paint.pasted(image, label, (0.32, 0.40, 0.68, 0.62))
    return _worn(image, "barrel", 0.2)


def cork_board() -> Image.Image:
    """The front of a notice board: notes, a chart and a calendar pinned to cork."""
    size = (450, 640)
    grain = 0.5 * (paint.noise(size, (225, 320), "cork") - 0.5) + 0.3 * (paint.fractal(size, (40, 60), "cork2") - 0.5)
    image = paint.tinted(size, (192, 146, 96), grain)
    notes = [
        (0.06, 0.08, (255, 240, 130)),
        (0.24, 0.12, (255, 176, 190)),
        (0.07, 0.42, (170, 226, 255)),
        (0.25, 0.46, (186, 240, 170)),
        (0.08, 0.72, (255, 240, 130)),
    ]
    for index, (left, top, color) in enumerate(notes):
        box = (left, top, left + 0.15, top + 0.21)
        paint.rectangle(image, (box[0] + 0.006, box[1] + 0.01, box[2] + 0.006, box[3] + 0.01), (120, 86, 50))
        paint.rectangle(image, box, color)
        paint.small_print(image, (left + 0.02, top + 0.05, left + 0.13, top + 0.18), 4, (80, 80, 90), f"note{index}")
        paint.ellipse(image, (left + 0.075, top + 0.02), (0.011, 0.015), (206, 40, 40))
    paint.pasted(image, _chart(), (0.47, 0.08, 0.72, 0.46))
    paint.pasted(image, _calendar(), (0.76, 0.10, 0.95, 0.48))
    paint.pasted(image, _memo(), (0.46, 0.54, 0.66, 0.93))
    paint.rectangle(image, (0.71, 0.58, 0.95, 0.88), (40, 92, 150))
    paint.write(image, "SAFETY", (0.83, 0.67), 0.06, WHITE, width=0.2, bold=0.04)
    paint.write(image, "FIRST", (0.83, 0.78), 0.06, (250, 214, 60), width=0.2, bold=0.04)
    return image


def book_cover(color: Color, title: tuple[str, str], accent: Color) -> Image.Image:
    """Front in the left two fifths, spine in the middle fifth, back on the right: from +z over -x to -z."""
    size = (300, 500)
    image = paint.tinted(size, color, 0.08 * (paint.noise(size, (150, 250), title[0]) - 0.5))
    paint.rectangle(image, (0.03, 0.06, 0.37, 0.94), accent, corner=0.01)
    paint.rectangle(image, (0.04, 0.075, 0.36, 0.925), color, corner=0.01)
    paint.write(image, title[0], (0.2, 0.26), 0.12, accent, width=0.26, bold=0.03)
    paint.write(image, title[1], (0.2, 0.38), 0.07, accent, width=0.26)
    paint.ellipse(image, (0.2, 0.62), (0.075, 0.125), accent)
    paint.ellipse(image, (0.2, 0.62), (0.055, 0.092), color)
    for edge in (0.12, 0.84):
        paint.rectangle(image, (0.4, edge, 0.6, edge + 0.03), accent)
    paint.small_print(image, (0.66, 0.2, 0.94, 0.6), 8, accent, title[1])
    return image


def page_edges() -> Image.Image:
    size = (128, 128)
    stripes = 0.16 * (paint.noise((size[0], 1), (96, 1), "edges") - 0.6)
    return paint.tinted(size, (240, 232, 212), np.broadcast_to(stripes, size))


def open_pages() -> Image.Image:
    """Two printed pages side by side."""
    image = paint.tinted((360, 480), (246, 240, 224), 0.03 * (paint.noise((360, 480), (60, 80), "paper") - 0.5))
    paint.write(image, "CHAPTER 7", (0.25, 0.12), 0.05, BLACK, bold=0.03)
    paint.small_print(image, (0.07, 0.2, 0.43, 0.92), 20, (96, 92, 88), "left")
    paint.pasted(image, _chart(), (0.58, 0.08, 0.92, 0.42))
    paint.small_print(image, (0.57, 0.48, 0.93, 0.92), 13, (96, 92, 88), "right")
    shade = np.abs(np.linspace(-1.0, 1.0, 480)) ** 0.35
    pixels = np.asarray(image).astype(np.float32) * (0.62 + 0.38 * shade)[None, :, None]
    return Image.fromarray(pixels.astype(np.uint8))


def leather(color: Color, name: str) -> Image.Image:
    size = (256, 256)
    grain = 0.35 * (paint.noise(size, (90, 90), name) - 0.5) + 0.15 * (paint.fractal(size, (8, 8), name) - 0.5)
    return paint.tinted(size, color, grain)


def extinguisher_wrap() -> Image.Image:
    image = paint.tinted((512, 512), (196, 18, 24))
    label = paint.tinted((260, 220), (246, 244, 236))
    paint.rectangle(label, (0.0, 0.0, 1.0, 0.2), (230, 190, 30))
    paint.write(label, "FIRE", (0.5, 0.1), 0.14, BLACK, width=0.6, bold=0.05)
    paint.write(label, "EXTINGUISHER", (0.5, 0.28), 0.09, (190, 20, 26), width=0.85, bold=0.03)
    for index, step in enumerate(("PULL PIN", "AIM LOW", "SQUEEZE", "SWEEP")):
        top = 0.4 + 0.14 * index
        paint.ellipse(label, (0.16, top + 0.04), (0.06, 0.05), (190, 20, 26))
        paint.write(label, str(index + 1), (0.16, top + 0.04), 0.07, WHITE)
        paint.write(label, step, (0.58, top + 0.04), 0.065, BLACK)
    paint.pasted(image, label, (0.30, 0.30, 0.70, 0.80))
    return image


def first_aid(color: Color, mark: Color, words: str, name: str) -> Image.Image:
    """Atlas of a box in one color; the two broad faces (-y, +y) carry a cross and words."""
    plain = paint.tinted((256, 256), color, 0.06 * (paint.noise((256, 256), (128, 128), name) - 0.5))
    front = plain.copy()
    paint.ellipse(front, (0.5, 0.42), (0.2, 0.27), mark)
    paint.cross(front, (0.5, 0.42), 0.36, color)
    paint.write(front, words, (0.5, 0.79), 0.11, mark, width=0.6, bold=0.04)
    return paint.six_faces({face: plain for face in ("+x", "-x", "+z", "-z")} | {"+y": front, "-y": front}, cell=256)


def gas_label() -> Image.Image:
    image = paint.tinted((512, 512), (40, 96, 62), 0.05 * (paint.fractal((512, 512), (4, 4), "gas") - 0.5))
    paint.rectangle(image, (0.0, 0.0, 1.0, 0.16), (238, 238, 234))
    for middle in (0.1, 0.5):
        paint.rectangle(image, (middle - 0.10, 0.34, middle + 0.10, 0.52), (244, 244, 240), corner=0.02)
        paint.write(image, "OXYGEN", (middle, 0.40), 0.05, SAFETY_GREEN, width=0.17, bold=0.05)
        paint.small_print(image, (middle - 0.08, 0.45, middle + 0.08, 0.5), 3, (90, 90, 90), "gas")
    return _worn(image, "gas", 0.25)


def _kraft(name: str) -> Image.Image:
    size = (384, 384)
    flutes = 0.04 * np.sin(np.arange(size[1]) * 0.9)[None, :]
    fibers = 0.10 * (paint.noise(size, (192, 48), name) - 0.5) + 0.12 * (paint.fractal(size, (4, 4), name) - 0.5)
    return paint.tinted(size, KRAFT, fibers + flutes)


def _tape() -> Color:
    return (208, 176, 126)


def _flaps(name: str) -> Image.Image:
    image = _kraft(name)
    paint.rectangle(image, (0.0, 0.494, 1.0, 0.506), (104, 74, 44))
    paint.rectangle(image, (0.0, 0.435, 1.0, 0.565), _tape())
    for edge in (0.435, 0.561):
        paint.rectangle(image, (0.0, edge, 1.0, edge + 0.005), (174, 140, 92))
    return image


def _shipping_label(image: Image.Image, box: tuple[float, float, float, float], code: str) -> None:
    label = paint.tinted((150, 200), WHITE)
    paint.write(label, code, (0.5, 0.12), 0.14, BLACK, width=0.85, bold=0.02)
    paint.rectangle(label, (0.0, 0.22, 1.0, 0.235), BLACK)
    paint.small_print(label, (0.06, 0.3, 0.5, 0.56), 4, (80, 80, 80), code)
    paint.write(label, code[-2:], (0.76, 0.42), 0.24, BLACK, bold=0.04)
    paint.barcode(label, (0.06, 0.62, 0.94, 0.96), code)
    paint.pasted(image, label, box)


def _arrows(image: Image.Image, center: tuple[float, float]) -> None:
    x, y = center
    ink = (104, 66, 40)
    for shift in (-0.055, 0.055):
        paint.polygon(image, [(x + shift - 0.05, y - 0.03), (x + shift, y - 0.11), (x + shift + 0.05, y - 0.03)], ink)
        paint.rectangle(image, (x + shift - 0.018, y - 0.04, x + shift + 0.018, y + 0.07), ink)
    paint.rectangle(image, (x - 0.13, y + 0.09, x + 0.13, y + 0.11), ink)


def _fragile(image: Image.Image) -> None:
    paint.rectangle(image, (0.2, 0.34, 0.8, 0.6), (196, 46, 34), corner=0.03)
    paint.write(image, "FRAGILE", (0.5, 0.44), 0.13, WHITE, width=0.5, bold=0.04)
    paint.write(image, "HANDLE WITH CARE", (0.5, 0.545), 0.05, WHITE, width=0.5)


def _slipping_person(image: Image.Image) -> None:
    paint.ellipse(image, (0.40, 0.375), (0.062, 0.033), BLACK)
    paint.line(image, [(0.44, 0.43), (0.53, 0.575)], BLACK, 0.062)
    paint.line(image, [(0.45, 0.445), (0.30, 0.475), (0.21, 0.43)], BLACK, 0.026)
    paint.line(image, [(0.46, 0.45), (0.61, 0.44), (0.70, 0.38)], BLACK, 0.026)
    paint.line(image, [(0.53, 0.575), (0.68, 0.625), (0.80, 0.565)], BLACK, 0.034)
    paint.line(image, [(0.52, 0.575), (0.45, 0.665), (0.29, 0.695)], BLACK, 0.034)
    for left in (0.2, 0.42, 0.64):
        wave = [(left + step * 0.02, 0.755 + 0.008 * (-1) ** step) for step in range(9)]
        paint.line(image, wave, BLACK, 0.012)


def _chart() -> Image.Image:
    image = paint.tinted((120, 130), WHITE)
    paint.write(image, "OUTPUT", (0.5, 0.1), 0.1, BLACK)
    for index, height in enumerate((0.3, 0.45, 0.38, 0.6, 0.68)):
        left = 0.12 + 0.16 * index
        paint.rectangle(image, (left, 0.9 - height, left + 0.11, 0.9), (60, 120 + 20 * index, 190))
    paint.rectangle(image, (0.06, 0.9, 0.94, 0.92), BLACK)
    return image


def _calendar() -> Image.Image:
    image = paint.tinted((160, 120), WHITE)
    paint.rectangle(image, (0.0, 0.0, 1.0, 0.24), (200, 46, 46))
    paint.write(image, "MAY", (0.5, 0.12), 0.14, WHITE, bold=0.04)
    for day in range(30):
        column, row = day % 7, day // 7
        paint.rectangle(
            image,
            (0.06 + 0.13 * column, 0.32 + 0.125 * row, 0.15 + 0.13 * column, 0.4 + 0.125 * row),
            (120, 120, 126) if column < 5 else (200, 90, 90),
        )
    return image


def _memo() -> Image.Image:
    image = paint.tinted((170, 120), WHITE)
    paint.write(image, "MEMO", (0.5, 0.1), 0.1, BLACK, bold=0.03)
    paint.small_print(image, (0.1, 0.22, 0.9, 0.92), 12, (110, 110, 116), "memo")
    return image


def _worn(image: Image.Image, name: str, strength: float) -> Image.Image:
    """Add patches of dirt that get stronger toward the bottom row."""
    height, width = image.height, image.width
    patches = np.clip(paint.fractal((height, width), (6, 8), f"{name}/dirt") * 2.0 - 0.7, 0.0, 1.0)
    depth = strength * patches * np.linspace(0.15, 1.0, height)[:, None] ** 2
    dirt = np.array([64, 56, 48], dtype=np.float32)
    pixels = np.asarray(image).astype(np.float32)
    return Image.fromarray((pixels * (1 - depth[..., None]) + dirt * depth[..., None]).astype(np.uint8))

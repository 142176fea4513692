"""Textures of groceries: faces of boxes, and labels around cans and bottles. No real brand is shown."""

import numpy as np
from PIL import Image

from usdsdg.demo import paint
from usdsdg.demo.paint import BLACK, WHITE, Color

CREAM: Color = (250, 238, 208)


def pudding_box() -> Image.Image:
    brown, red = (92, 48, 26), (196, 32, 44)
    front = paint.gradient((384, 306), brown, (150, 86, 44))
    _burst(front, (0.5, 0.64), 0.42, (176, 110, 62))
    _bowl(front, (0.5, 0.7))
    paint.rectangle(front, (0.06, 0.05, 0.94, 0.30), red, corner=0.08)
    paint.write(front, "CHOCO", (0.5, 0.115), 0.13, WHITE, width=0.72, bold=0.05)
    paint.write(front, "PUDDING", (0.5, 0.225), 0.11, CREAM, width=0.74, bold=0.03)
    paint.write(front, "INSTANT  ·  4 SERVINGS", (0.5, 0.36), 0.05, CREAM, width=0.7)
    paint.write(front, "NET WT 96 g", (0.28, 0.955), 0.04, CREAM)
    back = paint.tinted((384, 306), CREAM)
    paint.rectangle(back, (0.0, 0.0, 1.0, 0.2), red)
    paint.write(back, "CHOCO PUDDING", (0.5, 0.1), 0.09, WHITE, width=0.85, bold=0.04)
    paint.small_print(back, (0.08, 0.27, 0.56, 0.9), 13, (120, 84, 60), "pudding")
    _nutrition(back, (0.62, 0.26, 0.94, 0.72))
    paint.barcode(back, (0.62, 0.77, 0.94, 0.93), "pudding")
    side = paint.tinted((130, 384), brown)
    paint.write(side, "CHOCO PUDDING", (0.5, 0.5), 0.45, CREAM, width=0.8, bold=0.03)
    end = paint.tinted((130, 306), red)
    paint.write(end, "PUDDING", (0.5, 0.5), 0.5, WHITE, width=0.8, bold=0.04)
    return paint.six_faces({"+z": front, "-z": back, "+x": side, "-x": side, "+y": end, "-y": end})


def cracker_box() -> Image.Image:
    red, yellow = (190, 24, 36), (250, 204, 58)
    front = paint.gradient((512, 392), red, (140, 12, 26))
    paint.ellipse(front, (0.5, 0.26), (0.44, 0.17), yellow)
    paint.ellipse(front, (0.5, 0.26), (0.42, 0.155), red)
    paint.write(front, "Golden", (0.5, 0.20), 0.09, yellow, bold=0.03)
    paint.write(front, "CRACKERS", (0.5, 0.30), 0.11, WHITE, width=0.72, bold=0.05)
    for row in range(3):
        for column in range(3):
            _cracker(front, (0.22 + 0.28 * column + 0.04 * (row % 2), 0.56 + 0.14 * row))
    paint.write(front, "BAKED CRISP", (0.5, 0.455), 0.045, yellow)
    side = paint.tinted((512, 172), yellow)
    paint.rectangle(side, (0.0, 0.0, 1.0, 0.14), red)
    paint.write(side, "CRACKERS", (0.5, 0.07), 0.06, WHITE, width=0.85)
    _nutrition(side, (0.12, 0.2, 0.88, 0.6))
    paint.small_print(side, (0.12, 0.66, 0.88, 0.94), 9, (120, 90, 20), "cracker")
    lid = paint.tinted((172, 392), red)
    paint.write(lid, "CRACKERS", (0.5, 0.5), 0.4, yellow, width=0.8, bold=0.03)
    base = paint.tinted((172, 392), (206, 178, 140))
    paint.barcode(base, (0.3, 0.2, 0.7, 0.8), "cracker")
    return paint.six_faces({"+x": front, "-x": front, "+y": side, "-y": side, "+z": lid, "-z": base}, cell=512)


def sugar_box() -> Image.Image:
    yellow, blue = (252, 214, 70), (30, 62, 140)
    front = paint.gradient((512, 268), yellow, (250, 236, 160))
    paint.polygon(front, [(0, 0.16), (1, 0.08), (1, 0.40), (0, 0.48)], blue)
    paint.write(front, "PURE", (0.5, 0.20), 0.08, yellow, bold=0.03)
    paint.write(front, "SUGAR", (0.5, 0.325), 0.15, WHITE, width=0.84, bold=0.05)
    _heap(front, (0.5, 0.78))
    paint.write(front, "GRANULATED", (0.5, 0.53), 0.05, blue, width=0.8)
    paint.write(front, "454 g", (0.8, 0.95), 0.045, blue)
    side = paint.tinted((512, 132), WHITE)
    paint.rectangle(side, (0.0, 0.0, 1.0, 0.16), blue)
    paint.small_print(side, (0.14, 0.24, 0.86, 0.66), 12, (90, 96, 130), "sugar")
    paint.barcode(side, (0.14, 0.74, 0.86, 0.9), "sugar")
    lid = paint.tinted((132, 268), yellow)
    return paint.six_faces({"+x": front, "-x": front, "+y": side, "-y": side, "+z": lid, "-z": lid}, cell=512)


def soup_wrap() -> Image.Image:
    """Label once around the can, with the front twice; the metal rims are above and below it."""
    red = (200, 22, 34)
    wrap = paint.gradient((384, 1024), red, (176, 14, 26))
    paint.rectangle(wrap, (0.0, 0.52, 1.0, 1.0), WHITE)
    for middle in (0.0, 0.5, 1.0):
        paint.write(wrap, "Tomato", (middle, 0.24), 0.22, WHITE, bold=0.02)
        paint.ellipse(wrap, (middle, 0.52), (0.075, 0.2), (226, 180, 70))
        paint.ellipse(wrap, (middle, 0.53), (0.055, 0.145), (214, 40, 30))
        paint.polygon(wrap, _star((middle, 0.42), 0.032, 0.085, 5), (40, 128, 50))
        paint.write(wrap, "SOUP", (middle, 0.83), 0.17, red, bold=0.04)
    for middle in (0.25, 0.75):
        _nutrition(wrap, (middle - 0.05, 0.57, middle + 0.05, 0.94))
        paint.small_print(wrap, (middle - 0.06, 0.12, middle + 0.06, 0.44), 7, (240, 200, 190), "soup")
    return wrap


def mustard_wrap() -> Image.Image:
    """Around a flat bottle: labels on the two broad sides (s = 0.5 and at the seam), plain yellow between them."""
    yellow, green = (246, 198, 22), (22, 92, 52)
    wrap = paint.tinted((512, 1024), yellow, 0.06 * (paint.fractal((512, 1024), (4, 8), "mustard") - 0.5))
    label = paint.gradient((300, 330), (255, 246, 196), (252, 226, 120))
    paint.rectangle(label, (0.0, 0.0, 1.0, 0.06), green)
    paint.rectangle(label, (0.0, 0.94, 1.0, 1.0), green)
    paint.ellipse(label, (0.5, 0.36), (0.46, 0.25), green)
    paint.ellipse(label, (0.5, 0.36), (0.43, 0.225), (204, 30, 36))
    paint.write(label, "YELLOW", (0.5, 0.27), 0.09, CREAM, width=0.5)
    paint.write(label, "MUSTARD", (0.5, 0.40), 0.17, WHITE, width=0.76, bold=0.05)
    paint.write(label, "smooth & tangy", (0.5, 0.71), 0.085, green, width=0.8)
    paint.write(label, "NET WT 397 g", (0.5, 0.85), 0.06, BLACK, width=0.6)
    paint.pasted(wrap, label, (0.36, 0.30, 0.64, 0.84))
    back = paint.tinted((300, 330), CREAM)
    paint.rectangle(back, (0.0, 0.0, 1.0, 0.16), green)
    _nutrition(back, (0.08, 0.24, 0.48, 0.9))
    paint.small_print(back, (0.54, 0.24, 0.92, 0.6), 8, (110, 100, 60), "mustard")
    paint.barcode(back, (0.54, 0.68, 0.92, 0.9), "mustard")
    _at_seam(wrap, back, 0.14, 0.30, 0.84)
    return wrap


def meat_wrap() -> Image.Image:
    """Around a rectangular can: fronts at s = 0.5 and at the seam, nutrition facts on the narrow sides."""
    blue, yellow = (24, 58, 134), (250, 206, 62)
    wrap = paint.gradient((310, 1240), blue, (16, 36, 92))
    front = paint.gradient((310, 384), blue, (16, 36, 92))
    paint.write(front, "POTTED", (0.5, 0.2), 0.17, WHITE, width=0.7)
    paint.write(front, "MEAT", (0.5, 0.42), 0.28, yellow, width=0.8, bold=0.05)
    _slices(front, (0.5, 0.76))
    paint.pasted(wrap, front, (0.345, 0.0, 0.655, 1.0))
    _at_seam(wrap, front, 0.155, 0.0, 1.0)
    for middle in (0.25, 0.75):
        _nutrition(wrap, (middle - 0.05, 0.2, middle + 0.05, 0.8))
    return wrap


def banana_skin() -> Image.Image:
    size = (256, 512)
    speckle = np.where(paint.noise(size, (64, 96), "banana") > 0.9, -0.45, 0.0)
    skin = np.asarray(paint.tinted(size, (244, 208, 62), 0.10 * (paint.fractal(size, (6, 6), "skin") - 0.5) + speckle))
    along = np.linspace(1.0, 0.0, size[0])[:, None, None]
    green = np.clip((along - 0.86) / 0.08, 0.0, 1.0) + np.clip((0.04 - along) / 0.02, 0.0, 1.0)
    stem = np.array([96, 88, 38], dtype=float)
    return Image.fromarray((skin * (1.0 - 0.8 * green) + stem * 0.8 * green).clip(0, 255).astype(np.uint8))


def _at_seam(wrap: Image.Image, label: Image.Image, half_width: float, top: float, bottom: float) -> None:
    """Paste a label across the seam of a wrap: its right half at the left end, its left half at the right end."""
    half = label.width // 2
    paint.pasted(wrap, label.crop((half, 0, label.width, label.height)), (0.0, top, half_width, bottom))
    paint.pasted(wrap, label.crop((0, 0, half, label.height)), (1.0 - half_width, top, 1.0, bottom))


def _bowl(image: Image.Image, center: tuple[float, float]) -> None:
    x, y = center
    paint.ellipse(image, (x, y + 0.10), (0.34, 0.15), WHITE)
    paint.rectangle(image, (x - 0.12, y + 0.2, x + 0.12, y + 0.27), WHITE, corner=0.03)
    paint.ellipse(image, (x, y + 0.04), (0.34, 0.09), (228, 224, 214))
    paint.ellipse(image, (x, y + 0.035), (0.30, 0.07), (84, 42, 22))
    for shift, lift in ((-0.06, 0.0), (0.06, 0.0), (0.0, -0.05)):
        paint.ellipse(image, (x + shift, y - 0.01 + lift), (0.10, 0.05), (255, 248, 232))
    paint.ellipse(image, (x + 0.01, y - 0.10), (0.035, 0.027), (206, 24, 38))


def _burst(image: Image.Image, center: tuple[float, float], radius: float, color: Color) -> None:
    paint.polygon(image, _star(center, radius * 1.2, radius, 18), color)


def _star(center: tuple[float, float], across: float, down: float, rays: int) -> list[tuple[float, float]]:
    angle = np.linspace(-np.pi / 2, 1.5 * np.pi, 2 * rays, endpoint=False)
    reach = np.where(np.arange(2 * rays) % 2 == 0, 1.0, 0.72 if rays > 8 else 0.42)
    return [(center[0] + across * r * np.cos(a), center[1] + down * r * np.sin(a)) for a, r in zip(angle, reach)]


def _cracker(image: Image.Image, center: tuple[float, float]) -> None:
    x, y = center
    paint.rectangle(image, (x - 0.10, y - 0.052, x + 0.105, y + 0.064), (112, 20, 20), corner=0.02)
    paint.rectangle(image, (x - 0.10, y - 0.058, x + 0.10, y + 0.058), (232, 178, 96), corner=0.02)
    for row in (-0.034, 0.0, 0.034):
        for column in (-0.06, 0.0, 0.06):
            paint.ellipse(image, (x + column, y + row), (0.011, 0.008), (168, 112, 48))


def _heap(image: Image.Image, center: tuple[float, float]) -> None:
    x, y = center
    paint.ellipse(image, (x, y), (0.36, 0.12), (232, 226, 214))
    paint.polygon(image, [(x - 0.3, y), (x - 0.06, y - 0.17), (x + 0.04, y - 0.18), (x + 0.3, y)], WHITE)
    paint.ellipse(image, (x, y), (0.3, 0.07), WHITE)


def _slices(image: Image.Image, center: tuple[float, float]) -> None:
    for shift in (-0.2, 0.0, 0.2):
        x = center[0] + shift
        paint.rectangle(image, (x - 0.13, center[1] - 0.14, x + 0.13, center[1] + 0.14), (150, 60, 56), corner=0.05)
        paint.rectangle(image, (x - 0.11, center[1] - 0.12, x + 0.11, center[1] + 0.1), (222, 128, 118), corner=0.05)


def _nutrition(image: Image.Image, box: tuple[float, float, float, float]) -> None:
    left, top, right, bottom = box
    height = bottom - top
    paint.rectangle(image, box, WHITE)
    for edge in (top, top + 0.16 * height, bottom - 0.01 * height):
        paint.rectangle(image, (left, edge, right, edge + 0.012), BLACK)
    inner = (right - left) * 0.08
    paint.rectangle(image, (left + inner, top + 0.05 * height, right - inner, top + 0.12 * height), BLACK)
    paint.small_print(image, (left + inner, top + 0.22 * height, right - inner, bottom), 9, (70, 70, 70), "facts")

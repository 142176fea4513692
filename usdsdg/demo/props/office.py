"""Props of an office; the origin is the center of the bottom."""

from dataclasses import replace
from functools import partial

import numpy as np

from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.paint import Color
from usdsdg.demo.props import prop_textures
from usdsdg.demo.shapes.box import box
from usdsdg.demo.shapes.lathe import cylinder, lathe, rounded_profile
from usdsdg.demo.shapes.surface import Surface, from_grid, joined
from usdsdg.demo.shapes.sweep import arc, prism, tube

PAPER = Material(texture=prop_textures.page_edges, roughness=0.9)
BRASS = Material(color=(0.72, 0.52, 0.22), roughness=0.3, metallic=1.0)
CHROME = Material(color=(0.6, 0.6, 0.62), roughness=0.25, metallic=1.0)


def board() -> Asset:
    """A framed notice board, 1.2 m x 0.85 m, standing upright; the notes are on its -y side."""
    width, height, bar = 1.2, 0.85, 0.035
    panel = prism([(-0.59, 0.01), (0.59, 0.01), (0.59, 0.84), (-0.59, 0.84)], 0.012, "cork")
    rails = [box((width, 0.024, bar), "frame", rounding=0.004, atlas=False).moved(z=z) for z in (0.0175, 0.8325)]
    posts = [
        box((bar, 0.024, height), "frame", rounding=0.004, atlas=False).moved(x=x, z=height / 2)
        for x in (-0.5825, 0.5825)
    ]
    return Asset(
        bodies={"board": [panel, *rails, *posts]},
        materials={
            "cork": Material(texture=prop_textures.cork_board, roughness=0.9),
            "frame": Material(color=(0.48, 0.30, 0.15), roughness=0.55),
        },
        mass=4.0,
    )


def book_03() -> Asset:
    return _book((0.155, 0.215, 0.034), (24, 58, 92), ("VECTORS", "and matrices"), (232, 206, 140))


def book_34() -> Asset:
    return _book((0.135, 0.190, 0.048), (132, 28, 40), ("RAYS", "a field guide"), (244, 232, 210))


def book_open() -> Asset:
    """Two arched stacks of pages on an open cover."""
    pages = _arched_pages(half_width=0.148, depth=0.215, rise=0.022)
    covers = [
        box((0.155, 0.225, 0.004), "cover", rounding=0.0015, atlas=False).moved(x=side * 0.0785, z=0.002)
        for side in (-1, 1)
    ]
    return Asset(
        bodies={"pages": pages, "cover": covers},
        materials={
            "print": Material(texture=prop_textures.open_pages, roughness=0.85),
            "edges": PAPER,
            "cover": Material(texture=partial(prop_textures.leather, (36, 70, 52), "open"), roughness=0.6),
        },
        mass=0.7,
    )


def briefcase() -> Asset:
    """0.43 m wide, upright, with a handle and two locks on the -y side."""
    shell = box((0.43, 0.105, 0.31), "leather", rounding=0.022, atlas=False).moved(z=0.155)
    seam = box((0.434, 0.010, 0.314), "brass", rounding=0.004, atlas=False).moved(z=0.155)
    locks = [
        box((0.038, 0.012, 0.026), "brass", rounding=0.003, atlas=False).moved(x=x, y=-0.052, z=0.268)
        for x in (-0.13, 0.13)
    ]
    grip = tube(_handle_path(0.065, 0.305, 0.043), 0.0085, "handle", sides=12)
    corners = [
        box((0.040, 0.109, 0.040), "trim", rounding=0.018, atlas=False).moved(x=x, z=z)
        for x in (-0.197, 0.197)
        for z in (0.019, 0.291)
    ]
    return Asset(
        bodies={"case": [shell, seam, *locks, *corners], "grip": [grip]},
        materials={
            "leather": Material(
                texture=partial(prop_textures.leather, (104, 62, 34), "case"), roughness=0.5, clearcoat=0.15
            ),
            "trim": Material(texture=partial(prop_textures.leather, (70, 40, 22), "trim"), roughness=0.5),
            "handle": Material(color=(0.07, 0.03, 0.015), roughness=0.5),
            "brass": BRASS,
        },
        mass=2.4,
    )


def extinguisher() -> Asset:
    """0.54 m tall: cylinder, valve with two levers, gauge, hose with horn."""
    wall = [(0.0, 0.012), (0.055, 0.0), (0.078, 0.0), (0.080, 0.020), (0.080, 0.370), (0.070, 0.425), (0.026, 0.452)]
    body = lathe(rounded_profile([*wall, (0.022, 0.470)], 0.03), "red", segments=40)
    valve = cylinder(0.024, 0.042, "chrome", rim=0.003).moved(z=0.462)
    levers = [
        box((0.130, 0.018, 0.008), "black", rounding=0.003, atlas=False).rotated("y", tilt).moved(x=0.045, z=z)
        for tilt, z in ((0.0, 0.503), (-11.0, 0.524))
    ]
    gauge = cylinder(0.014, 0.010, "white", rim=0.002).rotated("x", 90.0).moved(y=-0.022, z=0.482)
    hose = tube(_hose_path(), 0.009, "black", sides=10)
    horn = lathe(rounded_profile([(0.0, 0.0), (0.021, 0.0), (0.012, 0.090), (0.0, 0.090)], 0.002), "black").moved(
        -0.100, 0.0, 0.105
    )
    return Asset(
        bodies={"cylinder": [body], "valve": [valve, *levers, gauge], "hose": [hose, horn]},
        materials={
            "red": Material(texture=prop_textures.extinguisher_wrap, roughness=0.25, clearcoat=0.6),
            "black": Material(color=(0.02, 0.02, 0.02), roughness=0.6),
            "white": Material(color=(0.85, 0.85, 0.85), roughness=0.3),
            "chrome": CHROME,
        },
        mass=7.5,
    )


def _book(size: tuple[float, float, float], color: Color, title: tuple[str, str], accent: Color) -> Asset:
    width, depth, height = size
    cover = Material(texture=partial(prop_textures.book_cover, color, title, accent), roughness=0.5, clearcoat=0.1)
    board = box((width, depth, 0.003), "cover", rounding=0.001, steps=1, atlas=False)
    lid = _texture_strip(board, (0.0, 0.4)).moved(z=height - 0.0015)
    base = _texture_strip(board, (0.6, 1.0)).moved(z=0.0015)
    spine = _texture_strip(box((0.004, depth, height), "cover", rounding=0.0015, steps=1, atlas=False), (0.4, 0.6))
    block = box((width - 0.008, depth - 0.008, height - 0.005), "pages", atlas=False)
    return Asset(
        bodies={
            "book": [lid, base, spine.moved(x=-(width - 0.004) / 2, z=height / 2), block.moved(x=-0.001, z=height / 2)]
        },
        materials={"cover": cover, "pages": PAPER},
        mass=0.6,
    )


def _texture_strip(surface: Surface, columns: tuple[float, float]) -> Surface:
    """The same faces with s mapped to columns[0] … columns[1] of the texture."""
    st = surface.st * (columns[1] - columns[0], 1.0) + (columns[0], 0.0)
    return replace(surface, st=st)


def _arched_pages(half_width: float, depth: float, rise: float) -> list[Surface]:
    across = np.linspace(-1.0, 1.0, 33)
    height = 0.006 + rise * np.sin(np.pi * np.clip(np.abs(across), 0.0, 1.0)) ** 0.8 * (1.0 - 0.35 * np.abs(across))
    slope = np.gradient(height, across * half_width)
    normal = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    rows = np.array([-depth / 2, depth / 2])
    points = np.stack(np.broadcast_arrays(across[None, :] * half_width, rows[:, None], height[None, :]), axis=-1)
    st = np.stack(np.broadcast_arrays((across[None, :] + 1) / 2, np.array([[0.0], [1.0]])), axis=-1)
    top = from_grid(points, np.broadcast_to(normal, points.shape), st, "print")
    return [top, joined([_page_wall(points[0], True), _page_wall(points[1], False)]), *_page_ends(half_width, depth)]


def _page_wall(edge: np.ndarray, front: bool) -> Surface:
    foot = edge * (1.0, 1.0, 0.0) + (0.0, 0.0, 0.004)
    rows = np.stack([foot, edge] if front else [edge, foot])
    outward = np.broadcast_to(np.array([0.0, -1.0 if front else 1.0, 0.0]), rows.shape)
    across = np.linspace(0.0, 1.0, len(edge))
    st = np.stack(np.broadcast_arrays(across[None, :], np.array([[0.0], [0.3]])), axis=-1)
    return from_grid(rows, outward, st, "edges")


def _page_ends(half_width: float, depth: float) -> list[Surface]:
    return [
        box((0.001, depth, 0.004), "edges", atlas=False).moved(x=side * (half_width - 0.0005), z=0.005)
        for side in (-1, 1)
    ]


def _handle_path(half_width: float, foot: float, rise: float) -> np.ndarray:
    left = arc((-half_width + 0.02, 0.0, foot + rise - 0.02), 0.02, 180.0, 90.0, steps=5)
    right = arc((half_width - 0.02, 0.0, foot + rise - 0.02), 0.02, 90.0, 0.0, steps=5)
    return np.vstack([(-half_width, 0.0, foot), left, right, (half_width, 0.0, foot)])


def _hose_path() -> np.ndarray:
    corners = np.array([(-0.015, 0.0, 0.490), (-0.120, 0.0, 0.500), (-0.135, 0.0, 0.330), (-0.100, 0.0, 0.180)])
    weight = np.linspace(0.0, 1.0, 21)[:, None]
    terms = [(1 - weight) ** 3, 3 * weight * (1 - weight) ** 2, 3 * weight**2 * (1 - weight), weight**3]
    return np.concatenate(terms, axis=1) @ corners

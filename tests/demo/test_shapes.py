"""Polygon shapes: volumes against formulas, winding and normals against each other."""

from __future__ import annotations

import numpy as np
import pytest

from usdsdg.demo.shapes.box import box
from usdsdg.demo.shapes.lathe import cylinder, lathe, superellipse
from usdsdg.demo.shapes.surface import Surface, joined, rotation
from usdsdg.demo.shapes.sweep import arc, prism, tube


def triangles(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3, 3) and corner normals of all faces, triangulated as fans."""
    starts = np.concatenate([[0], np.cumsum(surface.counts)[:-1]])
    corners = [
        (start, start + step, start + step + 1)
        for start, count in zip(starts, surface.counts)
        for step in range(1, count - 1)
    ]
    at = np.array(corners)
    return surface.points[surface.indices[at]], surface.normals[at]


def volume(surface: Surface) -> float:
    """Volume by the divergence theorem; negative where faces look inwards."""
    corners, _ = triangles(surface)
    return float(np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0)


BALL = [(np.cos(a), np.sin(a)) for a in np.linspace(-np.pi / 2, np.pi / 2, 49)]
SHAPES = {
    "box": box((0.3, 0.2, 0.1), "m"),
    "rounded box": box((0.3, 0.2, 0.1), "m", rounding=0.02),
    "cylinder": cylinder(0.5, 2.0, "m", segments=64),
    "superelliptic cylinder": superellipse(cylinder(1.0, 2.0, "m", segments=64), 5.0),
    "stretched ball": lathe(BALL, "m", segments=64, crease=60.0).scaled(2.0, 0.5, 1.0),
    "tube": tube(arc((0, 0, 0), 1.0, 0.0, 120.0), 0.1, "m"),
    "prism": prism([(0, 0), (2, 0), (2, 1), (0, 1)], 0.5, "m"),
    "turned prism": prism([(0, 0), (2, 0), (0, 1)], 0.5, "m").rotated("x", 70.0).rotated("z", -20.0),
}


@pytest.mark.parametrize("name", SHAPES)
def test_faces_wind_outwards_and_normals_agree_with_them(name):
    surface = SHAPES[name]
    corners, normals = triangles(surface)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(facing, axis=1)
    agreement = np.einsum("ni,nci->nc", facing, normals)[area > 1e-9]
    assert volume(surface) > 0.0
    assert (agreement > 0.0).all()
    assert np.linalg.norm(surface.normals, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize("name", SHAPES)
def test_texture_coordinates_stay_within_the_texture(name):
    assert SHAPES[name].st.min() >= -1e-9
    assert SHAPES[name].st.max() <= 1.0 + 1e-9


# Facets of a circle of n segments lose sin(2π/n)/(2π/n): 0.2 % at 64 segments, more for short tubes.
@pytest.mark.parametrize(
    ("surface", "expected", "tolerance"),
    [
        (SHAPES["box"], 0.006, 1e-9),
        (SHAPES["cylinder"], np.pi * 0.25 * 2.0, 0.003),
        (SHAPES["stretched ball"], 4.0 / 3.0 * np.pi, 0.005),
        (SHAPES["prism"], 1.0, 1e-9),
        (SHAPES["turned prism"], 0.5, 1e-9),
        (tube([(0, 0, 0), (0, 0, 1)], 0.2, "m", sides=64), np.pi * 0.04, 0.003),
    ],
)
def test_shapes_have_the_volumes_of_their_formulas(surface, expected, tolerance):
    assert volume(surface) == pytest.approx(expected, rel=tolerance)


def test_rounding_removes_only_the_edges():
    size, radius = np.array([0.3, 0.2, 0.1]), 0.02
    inner = size - 2 * radius
    # Steiner's formula for a box grown by a ball.
    faces = 2.0 * (inner[0] * inner[1] + inner[1] * inner[2] + inner[0] * inner[2])
    exact = inner.prod() + faces * radius + np.pi * radius**2 * inner.sum() + 4 / 3 * np.pi * radius**3
    made = box(tuple(size), "m", rounding=radius, steps=8)
    assert volume(made) == pytest.approx(exact, rel=1e-3)
    assert np.ptp(made.points, axis=0) == pytest.approx(size)


def test_a_superellipse_lies_between_circle_and_square():
    area = volume(SHAPES["superelliptic cylinder"]) / 2.0
    assert np.pi < area < 4.0
    assert np.ptp(SHAPES["superelliptic cylinder"].points, axis=0) == pytest.approx([2.0, 2.0, 2.0])


def test_each_face_of_a_box_shows_its_own_cell_upright():
    surface = box((2.0, 2.0, 2.0), "m")
    top = surface.normals[:, 2] > 0.9
    # The top's cell is the third of the upper row; its texture's right is +x, its up is +y.
    assert surface.st[top].min(axis=0) == pytest.approx([2 / 3, 1 / 2], abs=0.01)
    corner = surface.points[surface.indices[top]]
    assert np.corrcoef(corner[:, 0], surface.st[top][:, 0])[0, 1] == pytest.approx(1.0)
    assert np.corrcoef(corner[:, 1], surface.st[top][:, 1])[0, 1] == pytest.approx(1.0)


def test_a_label_on_a_lathe_reads_from_left_to_right():
    can = cylinder(1.0, 1.0, "m", segments=64)
    points = can.points[can.indices]
    front = (points[:, 1] > 0.9) & (np.abs(can.normals[:, 2]) < 0.1)
    # Seen from +y, -x is to the right.
    assert np.corrcoef(-points[front, 0], can.st[front, 0])[0, 1] > 0.99


def test_merging_keeps_every_face():
    both = joined([SHAPES["box"], SHAPES["prism"].moved(5.0)])
    assert volume(both) == pytest.approx(0.006 + 1.0)
    assert len(both.counts) == len(SHAPES["box"].counts) + len(SHAPES["prism"].counts)


def test_rotation_is_right_handed():
    assert rotation("z", 90.0) @ [1, 0, 0] == pytest.approx([0, 1, 0])
    assert rotation("x", 90.0) @ [0, 1, 0] == pytest.approx([0, 0, 1])
    assert rotation("y", 90.0) @ [0, 0, 1] == pytest.approx([1, 0, 0])

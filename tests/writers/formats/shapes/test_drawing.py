import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from usdsdg.writers.formats.shapes.clipping import clip_to_rectangle
from usdsdg.writers.formats.shapes.drawing import Canvas

WHITE = (255, 255, 255)
positions = st.tuples(st.floats(-60, 120), st.floats(-60, 120))


def coverage(draw) -> np.ndarray:
    canvas = Canvas(np.zeros((50, 60, 3), np.uint8))
    draw(canvas)
    return canvas.image()[..., 0] / 255


def distance_to_segment(a, b) -> np.ndarray:
    y, x = np.mgrid[0:50, 0:60] + 0.5
    along = np.subtract(b, a)
    t = np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / max(along @ along, 1e-12), 0, 1)
    return np.hypot(x - a[0] - t * along[0], y - a[1] - t * along[1])


@given(a=positions, b=positions, width=st.floats(1, 6))
def test_a_line_covers_what_is_near_it_and_nothing_else(a, b, width):
    drawn = coverage(lambda canvas: canvas.line(np.array(a), np.array(b), WHITE, width=width))
    expected = np.clip(width / 2 + 0.5 - distance_to_segment(a, b), 0, 1)
    np.testing.assert_allclose(drawn, expected, atol=0.01)


def test_a_disc_has_its_area():
    drawn = coverage(lambda canvas: canvas.disc(np.array([30.3, 25.6]), WHITE, radius=10))
    # The edge is a linear ramp, whose error is of second order.
    np.testing.assert_allclose(drawn.sum(), np.pi * 100, rtol=0.01)


def test_opacity_mixes():
    drawn = coverage(lambda canvas: canvas.disc(np.array([30, 25]), WHITE, radius=10, opacity=0.5))
    assert abs(drawn[25, 30] - 0.5) < 0.01


def test_far_away_lines_and_discs_cost_and_change_nothing():
    def draw(canvas):
        canvas.line(np.array([1e9, 5e8]), np.array([2e9, 7e8]), WHITE, width=2)
        canvas.disc(np.array([1e12, -1e12]), WHITE, radius=4)

    assert not coverage(draw).any()


def test_a_line_between_distant_points_still_passes_through():
    drawn = coverage(lambda canvas: canvas.line(np.array([-1e7, 25.0]), np.array([1e7, 25.0]), WHITE, width=2))
    np.testing.assert_allclose(drawn[24:26], 1, atol=0.01)


def test_alpha_is_left_alone():
    canvas = Canvas(np.full((10, 10, 4), 7, np.uint8))
    canvas.line(np.array([0, 5]), np.array([10, 5]), WHITE, width=3)
    assert (canvas.image()[..., 3] == 7).all()
    assert canvas.image()[5, 5, 0] == 255


@given(a=positions, b=positions)
def test_clipping_keeps_the_inside(a, b):
    segment = np.array([a, b])
    part = clip_to_rectangle(segment, 0, 0, 60, 50)
    samples = segment[0] + np.linspace(0, 1, 101)[:, None] * (segment[1] - segment[0])
    # Segments shorter than rounding, on the border, may go either way.
    inside = ((samples >= 1e-6) & (samples <= (60 - 1e-6, 50 - 1e-6))).all(axis=1)
    if part is None:
        assert not inside.any()
        return
    assert (part >= -1e-6).all()
    assert (part <= np.array([60, 50]) + 1e-6).all()
    for sample in samples[inside]:
        assert distance(sample, part) < 1e-6


def distance(point, segment) -> float:
    along = segment[1] - segment[0]
    t = np.clip((point - segment[0]) @ along / max(along @ along, 1e-30), 0, 1)
    return float(np.linalg.norm(point - segment[0] - t * along))

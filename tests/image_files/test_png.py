import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from usdsdg.image_files import png

sides = st.integers(1, 40)
shapes = st.one_of(
    st.tuples(sides, sides),
    st.tuples(sides, sides, st.sampled_from([1, 3, 4])),
)


@given(hnp.arrays(np.uint8, shapes))
@settings(deadline=None)
def test_pillow_reads_what_was_written(image):
    decoded = Image.open(io.BytesIO(png.encode_png(image)))
    decoded.load()
    np.testing.assert_array_equal(
        np.array(decoded), image[..., 0] if image.ndim == 3 and image.shape[2] == 1 else image
    )


@given(hnp.arrays(np.uint16, st.tuples(sides, sides)))
@settings(deadline=None)
def test_sixteen_bit_gray(image):
    np.testing.assert_array_equal(np.array(Image.open(io.BytesIO(png.encode_png(image)))).astype(np.uint16), image)


def test_views_that_are_not_contiguous():
    image = np.random.default_rng(0).integers(0, 255, (30, 40, 4), np.uint8)[::2, ::-1, :3]
    np.testing.assert_array_equal(np.array(Image.open(io.BytesIO(png.encode_png(image)))), image)


@pytest.mark.parametrize(
    "image",
    [np.zeros((4, 4), np.float32), np.zeros((4, 4, 2), np.uint8), np.zeros((0, 4), np.uint8), np.zeros(4, np.uint8)],
)
def test_what_png_cannot_hold_is_refused(image):
    with pytest.raises(ValueError, match="PNG cannot hold"):
        png.encode_png(image)

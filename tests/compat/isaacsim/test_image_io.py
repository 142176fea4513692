"""Pictures of `isaacsim.test.utils`."""

import numpy as np
import pytest

from usdsdg.compat.isaacsim.test.utils import read_image_as_array, save_depth_image, save_rgb_image
from usdsdg.errors import BadValue

DEPTHS = np.array([[1.0, 2.0], [np.inf, 3.0]], np.float32)


def saved(save, folder, name, values, **options):
    save(values, str(folder / "new"), name, **options)
    return read_image_as_array(str(folder / "new" / name))


def test_tiff_files_have_the_depths_themselves(tmp_path):
    np.testing.assert_array_equal(saved(save_depth_image, tmp_path, "depth.tiff", DEPTHS), DEPTHS)


def test_gray_files_go_from_the_nearest_to_the_farthest(tmp_path):
    gray = saved(save_depth_image, tmp_path, "depth.png", DEPTHS[:, :, np.newaxis], normalize=True)
    assert gray.dtype == np.uint8
    np.testing.assert_array_equal(gray, [[0, 127], [0, 255]])
    assert (saved(save_depth_image, tmp_path, "one.png", np.full((2, 2), 5.0), normalize=True) == 128).all()


def test_without_normalize_depths_from_0_to_1_are_shown(tmp_path):
    np.testing.assert_array_equal(
        saved(save_depth_image, tmp_path, "depth.png", np.array([[0.0, 0.5], [2.0, np.nan]])), [[0, 127], [255, 0]]
    )


@pytest.mark.parametrize("channels", [3, 4])
def test_colors_are_read_as_they_were_saved(tmp_path, channels):
    colors = np.arange(2 * 2 * channels, dtype=np.uint8).reshape(2, 2, channels)
    np.testing.assert_array_equal(saved(save_rgb_image, tmp_path, "rgb.png", colors), colors)


def test_a_channel_of_its_own_for_gray_on_request(tmp_path):
    save_depth_image(DEPTHS, str(tmp_path), "depth.png")
    assert read_image_as_array(str(tmp_path / "depth.png"), squeeze_singleton_channel=False).shape == (2, 2, 1)


def test_other_shapes_are_errors(tmp_path):
    with pytest.raises(BadValue, match=r"\(2, 2, 2\)"):
        save_depth_image(np.zeros((2, 2, 2)), str(tmp_path), "depth.png")
    with pytest.raises(BadValue, match=r"\(2, 2\)"):
        save_rgb_image(np.zeros((2, 2)), str(tmp_path), "rgb.png")

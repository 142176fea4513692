import json

import numpy as np
import pytest
from PIL import Image

from usdsdg.errors import Unsupported, WriterError
from usdsdg.writers import DiskBackend, files


@pytest.fixture
def backend(tmp_path):
    return DiskBackend(tmp_path)


@pytest.fixture
def image():
    x, y = np.meshgrid(np.arange(64), np.arange(48))
    return np.stack([x * 4, y * 4, x + y, np.full_like(x, 255)], axis=-1).astype(np.uint8)


def test_a_png_is_read_back_exactly(backend, tmp_path, image):
    files.write_image("a/rgb.png", image, backend)
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "a/rgb.png")), image)


@pytest.mark.parametrize("suffix", ["jpg", "jpeg", "JPG"])
def test_a_jpeg_is_close_and_has_no_alpha(backend, tmp_path, image, suffix):
    files.write_image(f"rgb.{suffix}", image, backend, quality=95)
    back = np.array(Image.open(tmp_path / f"rgb.{suffix}"))
    assert back.shape == (48, 64, 3)
    # Smooth picture at quality 95: a few levels of 255.
    assert np.abs(back.astype(int) - image[..., :3]).mean() < 3


@pytest.mark.parametrize("dtype", [np.uint16, np.uint32, np.int64])
def test_ids_become_sixteen_bit_gray(backend, tmp_path, dtype):
    ids = np.arange(60000, 60000 + 48 * 64).astype(dtype).reshape(48, 64)
    files.write_image("ids.png", ids, backend)
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "ids.png")).astype(dtype), ids)


def test_ids_that_do_not_fit_are_refused(backend):
    with pytest.raises(WriterError, match="70000"):
        files.write_image("ids.png", np.array([[70000]], np.uint32), backend)


def test_floats_are_refused_with_a_remedy(backend):
    with pytest.raises(WriterError, match="uint8 or uint16"):
        files.write_image("depth.png", np.zeros((2, 2), np.float32), backend)


def test_unknown_and_unsupported_formats(backend, image):
    with pytest.raises(WriterError, match=r"\.png, \.jpg"):
        files.write_image("rgb.bmp", image, backend)
    with pytest.raises(WriterError, match="linear floats"):
        files.write_image("rgb.exr", image, backend)
    with pytest.raises(Unsupported, match="'exr'"):
        files.checked_image_format("exr")
    with pytest.raises(WriterError, match=r"use 'png', 'jpg', 'jpeg'\.$"):
        files.checked_image_format("bmp")


@pytest.mark.parametrize("half", [False, True])
def test_floats_come_back_from_exr(backend, tmp_path, half):
    depth = np.random.default_rng(0).uniform(0, 100, (20, 30)).astype(np.float32)
    files.write_image("depth.exr", depth, backend, half_precision=half)
    np.testing.assert_allclose(files.read_exr("depth.exr", backend), depth, rtol=1e-3 if half else 0)
    np.testing.assert_array_equal(files.read_exr(str(tmp_path / "depth.exr")), files.read_exr("depth.exr", backend))


def test_pillow_images_are_taken(backend, tmp_path, image):
    files.write_image("rgb.png", Image.fromarray(image), backend)
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "rgb.png")), image)


def test_json_keeps_order_and_takes_numpy(backend, tmp_path):
    data = {"z": np.float32(1.5), "a": np.arange(3), "m": {"k": np.int64(2)}, "p": tmp_path}
    files.write_json("x.json", data, backend, indent=2)
    text = (tmp_path / "x.json").read_text()
    assert json.loads(text) == {"z": 1.5, "a": [0, 1, 2], "m": {"k": 2}, "p": str(tmp_path)}
    assert text.index('"z"') < text.index('"a"') < text.index('"m"')


def test_arrays_come_back(backend, tmp_path):
    data = np.array([(1, 2.5)], np.dtype([("id", "<u4"), ("x", "<f4")]))
    files.write_np("x.npy", data, backend)
    back = np.load(tmp_path / "x.npy")
    assert back.dtype == data.dtype
    assert back.tolist() == data.tolist()


def test_without_a_backend_paths_are_plain(tmp_path, image):
    files.write_png(str(tmp_path / "rgb.png"), image)
    files.write_json(str(tmp_path / "x.json"), {}, backend_instance=DiskBackend)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["rgb.png", "x.json"]

"""Round trips of the functions that write files."""

import json
import pickle

import numpy as np
import pytest

import usdsdg as rep


def test_images_and_arrays_are_read_back_unchanged(tmp_path):
    image = np.random.default_rng(0).integers(0, 255, (4, 5, 3), np.uint8)
    from PIL import Image

    for name in ("a.png", "b.jpg"):
        rep.functional.write_image(path=str(tmp_path / name), data=image)
    rep.functional.write_png(str(tmp_path / "c.png"), image)
    rep.functional.write_jpeg(str(tmp_path / "d.jpeg"), image, quality=100)
    for name in ("a.png", "c.png"):
        np.testing.assert_array_equal(np.array(Image.open(tmp_path / name)), image)
    for name in ("b.jpg", "d.jpeg"):
        assert np.array(Image.open(tmp_path / name)).shape == image.shape
    rep.functional.write_np(str(tmp_path / "e.npy"), image)
    np.testing.assert_array_equal(np.load(tmp_path / "e.npy"), image)


def test_file_options_are_applied(tmp_path):
    image = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
    sizes, errors = [], []
    from PIL import Image

    for quality in (10, 75, 95):
        path = tmp_path / f"{quality}.jpg"
        rep.functional.write_jpeg(str(path), image, quality=quality)
        sizes.append(path.stat().st_size)
        errors.append(np.abs(np.array(Image.open(path)).astype(int) - image).mean())
    assert sizes == sorted(sizes)
    assert errors == sorted(errors, reverse=True)
    rep.functional.write_image(str(tmp_path / "default.jpg"), image)
    assert (tmp_path / "default.jpg").read_bytes() == (tmp_path / "75.jpg").read_bytes()
    rep.functional.write_json(str(tmp_path / "a.json"), {"b": 1, "a": 2}, indent=1, sort_keys=True)
    assert (tmp_path / "a.json").read_text() == '{\n "a": 2,\n "b": 1\n}'
    rep.functional.write_pickle(str(tmp_path / "b.pkl"), {"x": 1}, protocol=0)
    assert b"\x80" not in (tmp_path / "b.pkl").read_bytes()
    things = np.array([{"a": 1}, None], dtype=object)
    with pytest.raises(ValueError, match="allow_pickle"):
        rep.functional.write_np(str(tmp_path / "c.npy"), things, allow_pickle=False)
    rep.functional.write_np(str(tmp_path / "c.npy"), things)
    assert np.load(tmp_path / "c.npy", allow_pickle=True)[0] == {"a": 1}


def test_half_precision_loses_precision(tmp_path):
    depth = np.full((2, 2), 1 / 3, np.float32)
    rep.functional.write_exr(str(tmp_path / "half.exr"), depth, half_precision=True)
    found = rep.functional.read_exr(str(tmp_path / "half.exr"))
    assert found[0, 0] == np.float16(1 / 3) != np.float32(1 / 3)


def test_values_are_read_back_unchanged(tmp_path):
    rep.functional.write_json(path=str(tmp_path / "a.json"), data={"x": np.float32(1), "y": np.arange(2)})
    assert json.loads((tmp_path / "a.json").read_text()) == {"x": 1, "y": [0, 1]}
    rep.functional.write_pickle(str(tmp_path / "b.pkl"), {"x": 1})
    assert pickle.loads((tmp_path / "b.pkl").read_bytes()) == {"x": 1}


def test_files_are_written_through_a_backend(tmp_path):
    backend = rep.backends.DiskBackend(output_dir=str(tmp_path / "out"))
    backend.schedule(rep.functional.write_image, path="a.png", data=np.zeros((2, 2), np.uint8))
    backend.wait_until_done()
    assert (tmp_path / "out" / "a.png").is_file()


def test_exr_files_are_read_back_unchanged(tmp_path):
    depth = np.random.default_rng(0).normal(size=(4, 5)).astype(np.float32)
    rep.functional.write_exr(str(tmp_path / "a.exr"), depth)
    np.testing.assert_array_equal(rep.functional.read_exr(str(tmp_path / "a.exr")), depth)
    rep.functional.write_image(str(tmp_path / "b.exr"), np.stack([depth] * 4, -1), half_precision=True)
    assert rep.functional.read_exr(str(tmp_path / "b.exr")).shape == (4, 5, 4)
    with pytest.raises(FileNotFoundError):
        rep.functional.read_exr(str(tmp_path / "none.exr"))

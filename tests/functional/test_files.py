"""Round trips of the functions that write files."""

import json
import pickle

import numpy as np
import pytest

import usdsdg as rep
from usdsdg.errors import WriterError


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


def test_options_of_pillow_are_applied(tmp_path):
    from PIL import Image

    image = np.random.default_rng(0).integers(0, 255, (64, 48, 3), np.uint8)
    rep.functional.write_jpeg(str(tmp_path / "a.jpg"), image, progressive=True, optimize=True, dpi=(72, 36))
    rep.functional.write_image(str(tmp_path / "b.jpg"), image, subsampling=0)
    opened = Image.open(tmp_path / "a.jpg")
    assert (opened.info["progressive"], opened.info["dpi"]) == (1, (72, 36))
    assert (tmp_path / "b.jpg").stat().st_size > (tmp_path / "a.jpg").stat().st_size
    ids = np.arange(48 * 64, dtype=np.uint16).reshape(64, 48) * 20
    of_pillow = {"rgb": image, "gray": image[..., :1], "alpha": np.dstack([image, image[..., 0]]), "ids": ids}
    for name, data in of_pillow.items():
        rep.functional.write_png(str(tmp_path / f"{name}.png"), data, compress_level=9, optimize=True, dpi=(100, 50))
        opened = Image.open(tmp_path / f"{name}.png")
        np.testing.assert_array_equal(np.array(opened), data.squeeze())
        np.testing.assert_allclose(opened.info["dpi"], (100, 50), atol=0.1)
    rep.functional.write_png(str(tmp_path / "deep.png"), image.astype(np.uint16) * 257, optimize=True)
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "deep.png"))[..., :3], image)
    with pytest.raises(WriterError, match="shape \\(2, 2, 5\\)"):
        rep.functional.write_png(str(tmp_path / "five.png"), np.zeros((2, 2, 5), np.uint8), optimize=True)
    with pytest.raises(TypeError, match="'qualty'; did you mean 'quality'"):
        rep.functional.write_image(str(tmp_path / "c.jpg"), image, qualty=5)
    with pytest.raises(TypeError, match="'speed'; it has compress_level, bits"):
        rep.functional.write_png(str(tmp_path / "c.png"), image, speed=5)


def test_texts_have_the_encoding_that_is_asked_for(tmp_path):
    rep.functional.write_json(str(tmp_path / "a.json"), {"é": 1}, encoding="latin-1", ensure_ascii=False)
    assert (tmp_path / "a.json").read_bytes() == b'{"\xe9": 1}'
    rep.functional.write_json(
        str(tmp_path / "b.json"), {"☃": 1}, encoding="ascii", errors="xmlcharrefreplace", ensure_ascii=False
    )
    assert (tmp_path / "b.json").read_text() == '{"&#9731;": 1}'
    things = {"numbers": np.arange(2), "path": tmp_path, "set": {3}}
    rep.functional.write_json(str(tmp_path / "c.json"), things, default=lambda thing: [type(thing).__name__])
    written = json.loads((tmp_path / "c.json").read_text())
    assert written == {"numbers": [0, 1], "path": str(tmp_path), "set": ["set"]}


def test_options_of_older_scripts_lose_no_data(tmp_path):
    depth = np.random.default_rng(0).uniform(0, 1e5, (3, 4)).astype(np.float32)
    rep.functional.write_exr(str(tmp_path / "a.exr"), depth, exr_flag=4)
    rep.functional.write_image(str(tmp_path / "b.exr"), depth, compression="PIZ")
    rep.functional.write_np(str(tmp_path / "c.npy"), depth, fix_imports=False)
    backend = rep.BackendDispatch(output_dir=str(tmp_path))
    backend.write_exr(path="d.exr", data=depth, exr_flag=1)
    backend.wait_until_done()
    for name in "abd":
        np.testing.assert_array_equal(rep.functional.read_exr(str(tmp_path / f"{name}.exr")), depth)
    np.testing.assert_array_equal(np.load(tmp_path / "c.npy"), depth)


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

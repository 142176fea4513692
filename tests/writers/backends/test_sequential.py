"""Sequences of functions that run when a file is written."""

import dataclasses
import threading

import numpy as np
import pytest
from PIL import Image

from usdsdg import backends, functional
from usdsdg.errors import WriterError


def brighter(image):
    return image + 1


@pytest.fixture
def backend(tmp_path):
    return backends.get("DiskBackend", init_params={"output_dir": str(tmp_path)})


def test_each_function_gets_what_the_one_before_returned():
    sequence = backends.Sequential(brighter, backends.Sequential(brighter, lambda x: x * 10))
    assert sequence(1)() == 30
    assert sequence.run(1) == 30


def test_tuples_and_dictionaries_become_arguments():
    seen = []
    backends.Sequential(
        lambda path, data: (path.upper(), data), lambda path, data: {"data": data, "path": path},
        lambda *, path, data: seen.append((path, data)),
    )("a", data=3)()  # fmt: skip
    assert seen == [("A", 3)]


def test_arguments_are_computed_when_the_file_is_written(backend, tmp_path):
    threads = []
    image = np.full((2, 3), 7, np.uint8)
    note = backends.Sequential(lambda x: threads.append(threading.current_thread()) or x, brighter)
    backend.schedule(functional.write_image, path=backends.Sequential("a_{}".format)("b.png"), data=note(image))
    backend.wait_until_done()
    assert threads != [threading.current_thread()]
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "a_b.png")), image + 1)


def test_a_sequence_is_scheduled_and_its_last_function_writes(backend, tmp_path):
    image = np.full((2, 3), 7, np.uint8)
    sequence = backends.Sequential(lambda path, data: {"path": f"sub/{path}", "data": data + 1}, functional.write_image)
    backend.schedule(sequence, path="x.png", data=image)
    backend.wait_until_done()
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "sub" / "x.png")), image + 1)


def test_an_error_in_a_sequence_is_raised_by_the_wait(backend):
    backend.schedule(functional.write_image, path="x.png", data=backends.Sequential(lambda x: x / 0)(1))
    with pytest.raises(WriterError, match=r"x\.png could not be written: ZeroDivisionError"):
        backend.wait_until_done()


def test_a_wrapper_of_a_writing_function_writes_to_the_backend(backend, tmp_path, monkeypatch):
    """Scheduled as it is or at the end of a sequence; it has no parameter of the name, but passes all on."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")

    def save(path, data, **options):
        functional.write_image(path, data, **options)

    image = np.full((2, 3), 7, np.uint8)
    inner = backends.Sequential(lambda path, data: (path, brighter(data)), save)
    backend.schedule(save, path="plain.png", data=image)
    backend.schedule(backends.Sequential(inner), path="nested.png", data=image)
    backend.wait_until_done()
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "plain.png")), image)
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "nested.png")), image + 1)


def test_transforms_in_a_sequence_get_their_data_only(backend, tmp_path):
    """As those of albumentations and torch, whose calls take `**kwargs`; a dataclass has no hash."""

    @dataclasses.dataclass
    class Transform:
        offset: int

        def __call__(self, **data):
            assert set(data) == {"path", "data"}
            return {**data, "data": data["data"] + self.offset}

    image = np.full((2, 3), 7, np.uint8)
    inner = backends.Sequential(Transform(1))
    backend.schedule(backends.Sequential(inner, Transform(2), functional.write_image), path="x.png", data=image)
    backend.wait_until_done()
    np.testing.assert_array_equal(np.array(Image.open(tmp_path / "x.png")), image + 3)

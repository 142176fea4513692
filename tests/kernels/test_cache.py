"""Compiled kernels that a full disk or a crash has damaged are compiled again, and too little space is named."""

import os
import shutil
from pathlib import Path

import pytest
import warp as wp

from tests import forked
from tests.sampled_cases import sampled
from usdsdg import errors
from usdsdg.kernels import cache

PROGRAM = """
import warp as wp

from usdsdg.warp_start import quiet_warp

quiet_warp()


@wp.kernel
def count(numbers: wp.array[int]):
    numbers[wp.tid()] = wp.tid()


numbers = wp.zeros(4, dtype=int, device="cpu")
wp.launch(count, 4, [numbers], device="cpu")
print(numbers.numpy())
"""


def run(folder):
    """Run the program with the cache in a folder; return its output and its warnings."""
    file = folder / "program.py"
    file.write_text(PROGRAM)
    environment = {**os.environ, "WARP_CACHE_PATH": str(folder / "cache"), "PYTHONPATH": str(Path(__file__).parents[2])}
    done = forked.run([str(file)], cwd=folder, env=environment, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """A folder with a cache that one program has filled, and what that has printed."""
    folder = tmp_path_factory.mktemp("compiled")
    return folder, run(folder)


@pytest.fixture
def made(compiled, tmp_path):
    """What the program prints whose cache is copied to the folder of the test."""
    folder, printed = compiled
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    return printed


@pytest.mark.parametrize(("suffix", "part"), sampled([("*.o", 0.5), ("*.meta", 0.5), ("*.o", 0), ("*.meta", 0)], 2))
def test_a_cut_file_of_the_cache_is_made_again(made, tmp_path, suffix, part):
    assert made == ("[0 1 2 3]\n", "")
    (file,) = (tmp_path / "cache").rglob(suffix)
    whole = file.read_bytes()
    file.write_bytes(whole[: int(part * len(whole))])
    again, warning = run(tmp_path)
    assert again == made[0]
    assert f"compiled kernels were damaged, and are compiled again: {file.parent}" in warning
    assert file.stat().st_size == len(whole)
    assert run(tmp_path) == made


@pytest.mark.parametrize("place", sampled([0.3, 0.6]))
def test_a_file_of_the_cache_with_a_flipped_bit_is_made_again(made, tmp_path, place):
    (file,) = (tmp_path / "cache").rglob("*.o")
    whole = file.read_bytes()
    position = int(place * len(whole))
    file.write_bytes(whole[:position] + bytes([whole[position] ^ 4]) + whole[position + 1 :])
    again, warning = run(tmp_path)
    assert again == made[0]
    assert f"compiled kernels were damaged, and are compiled again: {file.parent}" in warning
    assert file.read_bytes() == whole
    assert run(tmp_path) == made


def test_kernels_of_programs_without_checksums_are_loaded(made, tmp_path):
    (kept,) = (tmp_path / "cache").rglob("*.crc32")
    kept.unlink()
    assert run(tmp_path) == made
    kept.write_text("")  # as a full disk leaves it
    assert "compiled again" in run(tmp_path)[1]


def test_kernels_that_another_process_removes_as_damaged_meanwhile_are_compiled_again(monkeypatch):
    cache.compile_what_is_damaged()
    removed = []

    def remove(file: str, *, is_new: bool) -> None:
        if not removed:
            removed.append(shutil.rmtree(Path(file).parent))

    monkeypatch.setattr(cache, "check_sum", remove)

    @wp.kernel(module="unique")
    def nine(numbers: wp.array[int]):
        numbers[wp.tid()] = 9

    numbers = wp.zeros(1, dtype=int, device="cpu")
    wp.launch(nine, 1, [numbers], device="cpu")
    assert numbers.numpy().tolist() == [9]
    assert removed


def test_an_error_of_a_kernel_is_that_of_its_compilation(monkeypatch):
    cache.compile_what_is_damaged()
    raised = []

    def build(*_: object) -> None:
        raised.append(True)
        raise RuntimeError("no such function")

    monkeypatch.setattr(wp.Module, "_run_codegen", build)

    @wp.kernel(module="unique")
    def eight(numbers: wp.array[int]):
        numbers[wp.tid()] = 8

    with pytest.raises(RuntimeError, match=r"^no such function$"):
        wp.launch(eight, 1, [wp.zeros(1, dtype=int, device="cpu")], device="cpu")
    assert len(raised) == 1


def test_a_disk_without_room_is_named_before_anything_compiles(monkeypatch):
    wp.init()
    usage = shutil.disk_usage(wp.config.kernel_cache_dir)._replace(free=3_000_000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    with pytest.raises(errors.OutputNotWritable, match=r"has room for 3\.0 MB.*export WARP_CACHE_PATH=FOLDER"):
        cache.check_space()


def test_a_folder_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    cache.compile_what_is_damaged()
    monkeypatch.setattr(wp.Module, "_compile", lambda *_, **__: (tmp_path / "missing" / "file").write_text(""))

    @wp.kernel(module="unique")
    def nothing(numbers: wp.array[int]):
        numbers[wp.tid()] = 7

    with pytest.raises(errors.OutputNotWritable, match=r"cannot be kept in .*No such file.*export WARP_CACHE_PATH"):
        wp.launch(nothing, 1, [wp.zeros(1, dtype=int, device="cpu")], device="cpu")

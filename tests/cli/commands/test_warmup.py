"""`usdsdg warmup` says what was compiled and where, and knows every room that has kernels."""

from pathlib import Path

from tests.cli.options.test_options import output_of
from usdsdg.cli.commands import warmup


def compile_into(folder: Path, *names: str):
    for name in names:
        (folder / f"wp_{name}").mkdir()
        (folder / f"wp_{name}" / f"{name}.o").touch()
        (folder / f"wp_{name}" / f"{name}.cpp").touch()


def test_each_room_says_how_many_modules_it_compiled_and_where_they_are(tmp_path):
    rooms = {"render": lambda: compile_into(tmp_path, "a", "b"), "physics": lambda: None}
    assert warmup.compile_ahead(rooms, tmp_path) == [
        "render kernels: 2 modules compiled in 0 s", f"kernel cache: {tmp_path}"
    ]  # fmt: skip
    assert warmup.compile_ahead({"physics": lambda: None}, tmp_path) == [
        "nothing to compile",
        f"kernel cache: {tmp_path}",
    ]


def test_a_binary_for_another_device_is_one_more(tmp_path):
    compile_into(tmp_path, "a")
    rooms = {"render": lambda: (tmp_path / "wp_a" / "a.sm90.cubin").touch()}
    assert warmup.compile_ahead(rooms, tmp_path)[0] == "render kernels: 1 module compiled in 0 s"


def test_the_help_has_an_example():
    text = output_of("warmup", "--help")
    assert "RUN usdsdg warmup --device cpu" in text
    assert "WARP_CACHE_PATH" in text

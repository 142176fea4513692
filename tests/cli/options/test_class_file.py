"""`--semantic-classes` takes names or a file, and tells them apart."""

import errno
from pathlib import Path

import pytest

from usdsdg.cli.options.class_file import class_file


@pytest.mark.parametrize(
    "given",
    ["mug", "mug,bowl", "bolt_m3.5", "bolt_m3.5,nut", "tv/monitor,mug", ",".join(f"class_{n}" for n in range(99))],
)
def test_names_are_names_even_where_they_are_longer_than_a_path(given):
    assert class_file(given) is None


@pytest.mark.parametrize("given", ["classes.json", "a/classes.YAML", "a,b.txt", "datasets/mugs"])
def test_a_file_that_is_missing_is_still_a_file(given):
    assert class_file(given) == Path(given)


def test_what_exists_is_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mugs").mkdir()
    assert class_file("mugs") == Path("mugs")


def test_a_folder_that_this_user_may_not_enter_is_no_name_of_a_class(monkeypatch):
    def refused(path):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(Path, "exists", refused)
    assert class_file("/locked/mugs") == Path("/locked/mugs")

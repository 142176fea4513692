"""No key of a blob leaves what a backend writes to."""

import os
from functools import partial
from pathlib import Path, PurePosixPath

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from usdsdg.errors import UsdsdgWarning, WriterError
from usdsdg.stores.paths import checked_path
from usdsdg.writers import CocoWriter, DiskBackend, files
from usdsdg.writers.files import checked_padding

LEAVING = ["../x", "a/../../x", "/etc/x", "a/../x", "..", "", ".", "/", "//x", "x\0y", "a/.."]
PARTS = st.sampled_from(["..", ".", "", "a", "b.png", "...", "~", "$HOME", "C:", "a b", "ä", "\\", "..\\x"])


@pytest.fixture
def backend(tmp_path):
    return DiskBackend(tmp_path / "out")


@pytest.mark.parametrize("path", LEAVING)
def test_paths_that_leave_the_folder_are_refused(backend, tmp_path, path):
    for use in (partial(backend.write_blob, data=b"1"), backend.read_blob, backend.resolve_path):
        with pytest.raises(WriterError, match=r"would leave|no name of a file"):
            use(path)
    assert [each for each in tmp_path.rglob("*") if each.is_file()] == []


def test_functions_that_write_through_a_backend_are_held_to_its_folder(backend, tmp_path):
    for write in (files.write_json, files.write_pickle, files.write_np, files.write_text):
        for path in ("../x", str(tmp_path / "x")):
            with pytest.raises(WriterError, match="would leave"):
                write(path, "1", backend_instance=backend)
    assert list(tmp_path.glob("x*")) == []


def test_absolute_paths_in_the_folder_are_what_scripts_join_themselves(backend, tmp_path):
    backend.write_blob(os.path.join(backend.output_dir, "a", "b"), b"1")
    assert (tmp_path / "out/a/b").read_bytes() == b"1" == backend.read_blob("a/b")
    with pytest.raises(WriterError, match="would leave"):
        backend.write_blob(f"{backend.output_dir}/../x", b"1")
    with pytest.raises(WriterError, match="would leave"):
        backend.write_blob(f"{backend.output_dir}2/x", b"1")


def test_the_folder_may_be_a_link_and_links_below_it_may_not_lead_out(tmp_path):
    (tmp_path / "real" / "inner").mkdir(parents=True)
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "real")
    (tmp_path / "real" / "same").symlink_to("inner")
    (tmp_path / "real" / "away").symlink_to(tmp_path / "elsewhere")
    with pytest.warns(UsdsdgWarning, match="not empty"):
        backend = DiskBackend(tmp_path / "out")
    backend.write_blob("same/x", b"1")
    assert (tmp_path / "real/inner/x").read_bytes() == b"1"
    with pytest.raises(WriterError, match="symbolic link"):
        backend.write_blob("away/x", b"1")
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_a_folder_that_becomes_a_link_is_checked_again(backend, tmp_path):
    folder = Path(backend.output_dir, "a")
    (tmp_path / "elsewhere").mkdir()
    backend.write_blob("a/x", b"1")
    folder.rename(tmp_path / "moved")
    folder.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(WriterError, match="symbolic link"):
        backend.write_blob("a/x", b"2")
    folder.unlink()
    backend.write_blob("a/x", b"3")
    assert folder.is_dir()
    assert (folder / "x").read_bytes() == b"3"
    assert (tmp_path / "moved" / "x").read_bytes() == b"1"
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_a_link_in_place_of_a_file_is_replaced_not_followed(backend, tmp_path):
    (tmp_path / "secret").write_bytes(b"keep")
    Path(backend.output_dir, "x").symlink_to(tmp_path / "secret")
    backend.write_blob("x", b"new")
    assert (tmp_path / "secret").read_bytes() == b"keep"
    assert backend.read_blob("x") == b"new"


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(parts=st.lists(PARTS, max_size=5), absolute=st.booleans())
def test_whatever_the_path_a_file_lies_below_the_folder_or_there_is_none(tmp_path, parts, absolute):
    folder = tmp_path / "fuzz" / "out"
    path = ("/" if absolute else "") + "/".join(parts)
    try:
        file = DiskBackend(folder).resolve_path(path)
    except WriterError:
        return
    assert Path(os.path.normpath(file)).is_relative_to(folder)
    assert Path(os.path.normpath(file)) != folder


@given(st.text(max_size=20))
def test_keys_are_relative_and_have_no_way_up(text):
    try:
        key = checked_path(text, "here")
    except WriterError:
        return
    assert not key.startswith("/")
    assert ".." not in PurePosixPath(key).parts
    assert key not in ("", ".")


@pytest.mark.parametrize("name", ["../../../up/ID", "/up", "a/b", "..\\x", "", "x" * 300, "a\0"])
def test_an_id_of_a_dataset_is_a_part_of_a_file_name(tmp_path, name):
    with pytest.raises(WriterError, match="dataset_id"):
        CocoWriter(output_dir=tmp_path / "out", dataset_id=name)


def test_a_number_in_a_file_name_has_a_length_that_file_names_have():
    with pytest.raises(WriterError, match="0 to 100 digits"):
        checked_padding(10**9)

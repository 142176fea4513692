"""Which files a folder of assets has."""

import os
import shutil

import pytest

from usdsdg.errors import AssetUnreadable
from usdsdg.stage.assets import folder_files
from usdsdg.stage.assets.folder_files import files_in


@pytest.fixture
def folder(tmp_path):
    for file in ("shelf/mug.obj", "shelf/deep/bowl.OBJ", "shelf/note.txt", "elsewhere/jug.obj"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
    (tmp_path / "shelf/linked").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "shelf/again").symlink_to(tmp_path / "shelf")
    (tmp_path / "shelf/gone.obj").symlink_to(tmp_path / "nothing")
    (tmp_path / "shelf/folder.obj").mkdir()
    os.mkfifo(tmp_path / "shelf/pipe.obj")
    return tmp_path / "shelf"


def test_links_are_followed_once_and_what_is_no_file_is_left_out(folder):
    """pathlib's rglob leaves linked folders out, so that a class would be missing."""
    names = ["deep/bowl.OBJ", "gone.obj", "linked/jug.obj", "mug.obj"]
    assert files_in(folder, (".obj",)) == [str(folder / name) for name in names]
    assert files_in(folder, (".obj",), recursive=False) == [str(folder / "gone.obj"), str(folder / "mug.obj")]


def test_hidden_files_and_folders_are_left_out(folder):
    """Each would be a class of its own: previews, notes of macOS, and what a conversion has left that was killed."""
    for name in ("._mug.obj", ".thumbnails/mug.obj", "deep/.cup-1a2b3c4d/cup.obj"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).touch()
    names = ["deep/bowl.OBJ", "gone.obj", "linked/jug.obj", "mug.obj"]
    assert files_in(folder, (".obj",)) == [str(folder / name) for name in names]
    hidden = folder.parent / ".hidden"
    folder.rename(hidden)
    assert str(hidden / "mug.obj") in files_in(hidden, (".obj",))


def test_a_name_that_is_no_utf8_is_told(folder):
    """As in an archive of another system; USD has no such paths."""
    (folder / os.fsdecode(b"caf\xe9.obj")).touch()
    with pytest.raises(AssetUnreadable, match=r"caf\\udce9.obj' is not UTF-8, .* Rename the file"):
        files_in(folder, (".obj",))
    assert files_in(folder, (".png",)) == []


def test_a_folder_that_is_removed_meanwhile_is_left_out(folder, monkeypatch):
    isfile = os.path.isfile

    def removing(path):
        shutil.rmtree(folder / "deep", ignore_errors=True)
        return isfile(path)

    monkeypatch.setattr(folder_files.os.path, "isfile", removing)
    assert str(folder / "mug.obj") in files_in(folder, (".obj",))


def test_a_folder_that_may_not_be_read_is_named(folder, monkeypatch):
    scandir = os.scandir

    def refusing(path):
        if str(path).endswith("deep"):
            raise PermissionError(13, "Permission denied", str(path))
        return scandir(path)

    monkeypatch.setattr(folder_files.os, "scandir", refusing)
    with pytest.raises(AssetUnreadable, match=r"shelf/deep cannot be searched for files: Permission denied"):
        files_in(folder, (".obj",))


def test_a_whole_disk_is_not_searched(folder):
    with pytest.raises(AssetUnreadable, match="give the folder that the files are in"):
        files_in(os.path.abspath(os.sep), (".obj",))


def test_a_search_ends_at_more_files_than_assets_are(folder, monkeypatch):
    monkeypatch.setattr(folder_files, "MOST_FILES", 3)
    with pytest.raises(AssetUnreadable, match="more than 3 files"):
        files_in(folder, (".obj",))

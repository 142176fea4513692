"""Files in a local folder."""

import os
from collections.abc import Iterable
from pathlib import Path

from usdsdg.errors import ALLOW_OUTSIDE, OutputNotWritable, StoreError, WriterError, warn_once
from usdsdg.operating_system import home_folder
from usdsdg.session.session import current
from usdsdg.stores.addresses import address_of, is_url
from usdsdg.stores.paths import name_below, path_below
from usdsdg.stores.whole_file import check_writable, write_whole, write_whole_with_hash
from usdsdg.writers.backends.backend import BaseBackend, checked_blob
from usdsdg.writers.journal.places.numbered import next_writers_folder
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.recipe import FILE as RECIPE
from usdsdg.writers.sharing import warn_of_sharing


def set_disk_root(path: str | os.PathLike | None) -> None:
    """Set the root of relative output folders (setting /omni/replicator/backends/disk/root_dir)."""
    current().disk_root = None if path is None else Path(os.path.expanduser(path))


def disk_root() -> Path:
    """Return the root of relative output folders; without a setting ~/omni.replicator_out.

    Raises:
        OutputNotWritable: there is no setting, and the home folder of this user is not known.
    """
    if (root := known_disk_root()) is None:
        raise OutputNotWritable(
            "Relative output folders are below ~/omni.replicator_out, and the home folder of this user is not known: "
            "give an absolute output_dir, or export HOME=FOLDER."
        )
    return root


def known_disk_root() -> Path | None:
    """As `disk_root`; None where that is an error."""
    if (root := current().disk_root) is not None:
        return root
    return home / "omni.replicator_out" if (home := home_folder()) is not None else None


class DiskBackend(BaseBackend):
    """A backend that writes files into a local folder. Mirrors `rep.backends.DiskBackend`."""

    ends_run = False  # it writes for all writers of a folder, at the end

    def __init__(self, output_dir: str | os.PathLike, overwrite: bool = True) -> None:
        """Create the folder; warn if it is not empty.

        output_dir: a relative path is below `disk_root()`; "file:///folder" is a path, too.
        overwrite: False writes into a new folder next to an existing one, with _0001 (and so on) appended.

        Raises:
            OutputNotWritable: the folder cannot be created or written to.
        """
        folder = Path(os.path.expanduser(_path_of(output_dir)))
        folder = folder if folder.is_absolute() else disk_root() / folder
        _check_confined(folder)
        folder = current().run.placed(folder)
        self._folder = folder if overwrite else next_writers_folder(current().run, folder)
        current().run.check(self._folder)
        check_writable(self._folder)
        _warn_of_leftovers(self._folder)

    @property
    def output_dir(self) -> str:
        """The absolute path of the folder.

        Raises:
            WriterError: the backend was not initialized.
        """
        folder = self.__dict__.get("_folder")
        if folder is None:
            raise WriterError("This DiskBackend has no folder yet: call initialize(output_dir=...) first.")
        return str(folder)

    def _place(self) -> str:
        return self.output_dir

    def resolve_path(self, path: str) -> str:
        """Return the absolute path of a file of this backend.

        Raises:
            WriterError: `path` is not below the output folder, as an absolute path elsewhere or one with `..`.
        """
        return str(path_below(Path(self.output_dir), path))

    def write_blob(self, path: str, data: bytes) -> None:
        """Store `data` in the file `path` below the output folder, which appears whole or not at all.

        Raises:
            WriterError: as `resolve_path`, and for data that are no bytes.
            OutputNotWritable: the file cannot be written.
        """
        self._write(path, [checked_blob(path, data)])

    def write_chunks(self, path: str, chunks: Iterable[bytes | memoryview]) -> None:
        """As `write_blob`, without a copy of all chunks in one piece."""
        if type(self).write_blob is not _OWN_WRITE_BLOB:
            super().write_chunks(path, chunks)  # to that of a subclass
        else:
            self._write(path, chunks)

    def _write(self, path: str, chunks: Iterable[bytes | memoryview]) -> None:
        folder, session = self.output_dir, current()
        name = name_below(folder, path)
        file = os.path.join(folder, name)
        _warn_of_sharing(self)
        session.written_folders.setdefault(folder)
        if session.run.claim(folder) is None:
            write_whole(file, chunks)
            return
        facts = write_whole_with_hash(file, chunks)
        session.run.note(folder, name, facts, session.io_queue.files_in_hand())

    def read_blob(self, path: str) -> bytes:
        """Return the bytes of the file `path` below the output folder; errors are those of `resolve_path`."""
        return path_below(Path(self.output_dir), path).read_bytes()


def _path_of(output_dir: str | os.PathLike) -> str | os.PathLike:
    """Return the path of a folder that may be named by a URL.

    Raises:
        OutputNotWritable: it names no folder, or no system has such a name.
    """
    if "\0" in str(output_dir):
        raise OutputNotWritable(f"{str(output_dir)!r} has a null character, which no folder's name has.")
    if not is_url(output_dir):
        return output_dir
    try:
        address = address_of(output_dir)
    except StoreError as error:
        raise OutputNotWritable(str(error)) from error
    if address.kind != "folder":
        raise OutputNotWritable(
            f"{output_dir} is no folder. Give it to the writer as output_dir, or write to a StoreBackend."
        )
    return address.path


def _check_confined(folder: Path) -> None:
    """Check where output goes while a file that is no program says so; raises OutputNotWritable."""
    limit = current().confined_to
    if limit is not None and not Path(os.path.realpath(folder)).is_relative_to(os.path.realpath(limit)):
        raise OutputNotWritable(
            f"{folder} is outside of {limit}, below which the output of such files goes. {ALLOW_OUTSIDE}"
        )


_OWN_WRITE_BLOB = DiskBackend.write_blob


def _warn_of_leftovers(folder: Path) -> None:
    """Warn that files of an earlier, longer run would remain among the new ones."""
    if not (folder / RECIPE).exists() and FolderPlace(folder).has_files():
        warn_once(
            f"{folder} is not empty: files of the same names are replaced, the others stay. "
            "Empty it or give another output_dir to keep runs apart."
        )


def _warn_of_sharing(backend: DiskBackend) -> None:
    """Warn that writers with the same folder replace each other's files."""
    if not backend.ends_run and current().backends.setdefault(backend.output_dir, backend) is not backend:
        warn_of_sharing(backend.output_dir)

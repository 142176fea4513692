"""The datasets that a run writes to: each with its recipe, its journal and a lock while the run writes there."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from usdsdg.errors import UsdsdgError, warn_once
from usdsdg.session.progress import say_once
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.locks import FileLock, Locked
from usdsdg.stores.whole_file import not_writable, write_whole
from usdsdg.writers.journal import lines, recipe
from usdsdg.writers.journal.copied_folders import copies_of, watch
from usdsdg.writers.journal.earlier_files import (
    end_removal,
    forget_names,
    remove_part,
    remove_run,
    remove_unfinished,
    warn_of_lost,
    warn_of_lost_about_all,
)
from usdsdg.writers.journal.earlier_run import Mode, check_place
from usdsdg.writers.journal.facts import ASSETS, Facts, changed_assets, joined
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.growth import MoreFrames
from usdsdg.writers.journal.journal import NAME, Journal
from usdsdg.writers.journal.places.place import JOINED, LATEST, PARTS, SHARING, FolderPlace, Lock, Place
from usdsdg.writers.journal.places.place_locks import COPY, in_use, not_locked
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import Recipe
from usdsdg.writers.journal.spool_hashes import AGGREGATES, ONCE, SpoolHashes


class DatasetFolder:
    """The place of one dataset while a run writes there."""

    def __init__(
        self,
        place: Place,
        wanted: Recipe,
        mode: Mode,
        portion: Portion | None,
        *,
        before: Callable[[], object] = lambda: None,
        with_parts: bool = False,
        growth: MoreFrames | None = None,
        shares_out: bool = False,
    ) -> None:
        """Claim a place for a run.

        before: called with the lock, before the journal is read. with_parts: parts that are there are resumed, by
        other processes, or joined. growth: lets one with fewer frames be resumed. shares_out: other processes make
        the frames; until `end_sharing` no other one plans them, also where this one has released the folder.

        Raises:
            DatasetInTheWay: another run is there, or writes there now; the message says how to go on.
            OutputNotWritable, StoreError: the place cannot be written to.
            WriterError: the journal or a spool that is resumed was damaged.
        """
        self.place, self.path, self._recipe, self.portion = place, place.path, wanted, portion
        self.goes_on = mode is Mode.RESUME  # spools and journal have what an earlier process has left
        self._home = self.path / PARTS / portion.name if portion is not None else self.path / BESIDE
        self.has_moved = False  # whether the script has moved it, which `follow` has found
        self.spools = SpoolHashes(self._home / AGGREGATES)
        self._sharing: Lock | None = None
        self._lock(shares_out=shares_out, with_parts=with_parts)
        try:
            place.pull(portion)
            check_place(place, wanted, mode, portion, with_parts=with_parts, growth=growth)
            if growth is not None and mode is Mode.RESUME:
                growth.begin(place, wanted)
            before()
            self._make_room(mode)
            if portion is None and not with_parts:
                shutil.rmtree(self.path / PARTS, ignore_errors=True)  # which have no frames
                if self._sharing is None:  # and the lock of a process that was killed
                    (self.path / BESIDE / SHARING).unlink(missing_ok=True)
            self.journal = Journal(self._home / NAME)
            self.was_complete = self.journal.was_complete
            if mode is Mode.RESUME:
                # Of the dataset only where no process of another part can be writing.
                remove_unfinished(self.path if portion is None else self._home)
                self._go_on_with_spools()
                warn_of_lost(place, self._home / NAME)
            self._write_recipe()
            forget_names(self._home)
            place.push(whole=True)
        except BaseException as error:
            self.release()
            self.end_sharing()
            if isinstance(error, UsdsdgError) or not isinstance(error, OSError):
                raise
            # Such as a file of an earlier run that this user may not remove.
            raise not_writable(Path(str(error.filename or self.path)), error) from error
        self.end = self.journal.contents.end  # the frame after those that were whole then
        self._shared: dict[str, FileFacts] = {}
        self._facts: Facts = {}
        self.first: int | None = None  # the frame at which a writer is due first, whoever makes it
        self._latest: dict[Path, bytes] = {}  # files of the part that wait to be written
        self._keeping = threading.Lock()  # the capture tells of files, and threads that write files do

    def _lock(self, *, shares_out: bool, with_parts: bool) -> None:
        path = self.path
        try:
            self._home.mkdir(parents=True, exist_ok=True)
            self._sharing = self.place.sharing_lock() if shares_out else None
            self._locks = self.place.locks(self.portion)
            self._real_path = path.resolve()  # with the lock, so that it is there
            watch()
        except Locked as held:
            self.end_sharing()
            raise in_use(self.place, held) from None
        except OSError as error:
            self.end_sharing()
            raise (not_locked(path, error, elsewhere=COPY) if with_parts else not_locked(path, error)) from error

    def _write_recipe(self) -> None:
        """Write the recipe of the dataset, unless it has that of this run, and that of the part."""
        there = recipe.read(self.path)
        # That of a part is another one than the dataset's where the part was replaced.
        if there is None or (self.portion is not None and self._recipe.differences(there)):
            self._recipe.write(self.path)
        if self.portion is not None:
            self._recipe.write_identity(self._home)

    @property
    def aggregates(self) -> Path:
        """The folder of the spools of aggregate files."""
        return self.spools.folder

    def has(self, frame: int) -> bool:
        """Return whether a frame was whole when the folder was claimed."""
        return frame in self.journal.contents.frames

    def see_due(self, frame: int) -> None:
        """Tell that a writer is due at a frame, whoever makes it."""
        if self.first is None:
            self.first = frame

    def keep_classes(self, table: str) -> None:
        """As `keep_latest`, of the class file."""
        self._keep(self._home / recipe.CLASS_FILE, table.encode())

    def keep_latest(self, path: str, data: bytes) -> None:
        """Tell the content of a file about all frames, of which those who join parts need that of the last frames.

        Processes that make other parts write the same file of the dataset.
        """
        self._keep(self._home / LATEST / path, data)

    def _keep(self, file: Path, data: bytes) -> None:
        if self.portion is not None:
            with self._keeping:
                self._latest[file] = data

    def note_shared(self, path: str, facts: FileFacts) -> None:
        """Tell that a file has been written that belongs to no frame."""
        with self._keeping:
            self._shared[path] = facts

    def note_facts(self, section: str, values: Mapping[str, Any]) -> None:
        """Tell what the recipe gets in the end; what is known already is left out."""
        known = self.journal.contents.facts.get(section, {})
        new = {name: value for name, value in values.items() if known.get(name) != value}
        if new:
            with self._keeping:
                self._facts = joined([self._facts, {section: new}])

    def note_assets(self, values: Mapping[str, Any]) -> None:
        """As `note_facts`, of assets; warns of those that were changed since earlier frames were made."""
        known = self.journal.contents.facts.get(ASSETS, {})
        for name in changed_assets(known, values) if self.goes_on else ():
            warn_once(
                f"{self.place.name}: the asset {name} has other content than when earlier frames were made, so "
                "that the dataset has frames of two versions of it; --overwrite makes all frames again."
            )
        self.note_facts(ASSETS, values)

    def append(self, frames: list[dict[str, Any]]) -> None:
        """Append frames to the journal, after their files and spools are on the disk; errors are those of `Journal`."""
        shared, facts = dict(self._shared), self._facts  # they stay until they are in the journal
        spools = self.spools.facts()  # before the sync, after which all of these bytes are on the disk
        names = [*shared, *(name for line in frames for name in line[lines.FILES])]
        self.place.sync([*names, *(each.relative_to(self.path).as_posix() for each in self.spools.files())])
        with self._keeping:
            latest = dict(self._latest)
        for file, data in latest.items():
            write_whole(file, data)
        self.place.push()
        self.journal.append(frames, shared, facts, spools=spools)
        with self._keeping:
            if self._facts is facts:  # else the capture has noted facts meanwhile; then all are appended again
                self._facts = {}
            _forget(self._shared, shared)
            _forget(self._latest, latest)
        self.place.push()

    def close(self, *, complete: bool) -> None:
        """Write the recipe, which parts leave to those who join them, and the closing line, and release the folder.

        complete: the run has come to its end. A dataset that was complete before, and has no new frames, stays so.
        """
        complete |= self.was_complete and self.journal.count == len(self.journal.contents.frames)
        try:
            self.append([])
            spools = self.spools.facts_of_files()
            if self.portion is None:
                classes, contents = self.place.read(recipe.CLASSES), self.journal.contents
                # Where the class table was lost, the recipe of a run that was complete has the names of its classes.
                there = recipe.read(self.path) if classes is None and self.was_complete else None
                made = self._recipe.completed(classes, self.journal.count, contents.facts, there or {})
                written = made.write(self.path)
                kept = {name: facts for name, facts in spools.items() if not name.startswith(f"{ONCE}/")}
                self.journal.close(complete=complete, recipe=written, kept=kept, spools=kept if complete else spools)
                if complete and self.goes_on:
                    warn_of_lost_about_all(self.place, contents.shared)
                if complete:
                    shutil.rmtree(self.aggregates / ONCE, ignore_errors=True)
                    shutil.rmtree(self.path / JOINED, ignore_errors=True)
            else:
                self.journal.close(complete=complete, spools=spools, first=self.first)
            self.place.push(whole=True)
        finally:
            self.release()

    def follow(self, *, tells: bool = True) -> bool:
        """Where a script has moved the folder, go on with the dataset there; return whether that is known.

        It is not known if the folder was removed, if another program has moved it to another disk, or if the system
        does not give the path of an open file. tells: say so on stderr.
        """
        first = self._locks[0]
        journal_now = (first.path_now() or self._copied_journal(first)) if isinstance(first, FileLock) else None
        if journal_now is None:
            if tells:
                say_once(
                    f"{self.place.name} is not there any more, so its journal has no end: "
                    "usdsdg verify calls a copy of it unfinished"
                )
            return False
        before, now = self.path, journal_now.parent.parent
        self.place, self.path, self._home = FolderPlace(now), now, now / self._home.relative_to(before)
        self.spools.folder, self.journal.path = self._home / AGGREGATES, self._home / NAME
        self.has_moved = True
        return True

    def _copied_journal(self, own: FileLock) -> Path | None:
        """Return the journal of a copy of the folder, as on another disk, with its lock in place of `own`; None: none.

        What is copied while it is appended to is no copy.
        """
        for copy in copies_of(self._real_path) if self.portion is None else ():
            file = copy / BESIDE / NAME
            if file.is_file() and file.read_bytes() == own.content():
                try:
                    self._locks = [FileLock(file)]
                except OSError:  # also where another process goes on with it
                    return None
                own.release()
                return file
        return None

    def release(self) -> None:
        """Let other processes write there."""
        for lock in self._locks:
            lock.release()

    def end_sharing(self) -> None:
        """Let other processes share frames out."""
        if self._sharing is not None:
            self._sharing.release()

    def _make_room(self, mode: Mode) -> None:
        """Remove what an earlier run has left, unless it is resumed: then only what another one had begun to."""
        if mode is Mode.RESUME:
            end_removal(self.place, self._home)
        elif self.portion is None:
            remove_run(self.place, is_told=mode is not Mode.OVERWRITE)
        else:
            remove_part(self.place, self._home)

    def _go_on_with_spools(self) -> None:
        """Check the spools, and drop the records of frames that are not whole; errors are those of the constructor."""
        contents = self.journal.contents
        self.spools.go_on(contents.spools, contents.frames)
        if self.spools.facts() != contents.spools:
            # Before they are cut, since a process that dies in between leaves spools that are longer than told.
            self.journal.append((), {}, spools=self.spools.facts())
            self.place.push()
        self.spools.shorten()


def _forget(waiting: dict[Any, Any], told: Mapping[Any, Any]) -> None:
    """Remove what was told, unless it is told anew."""
    for name, value in told.items():
        if waiting.get(name) == value:
            del waiting[name]

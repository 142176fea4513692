"""What this process makes: the recipe of its run, the frames that are its own, and the folders that it writes to."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pxr import Usd

from usdsdg.errors import DatasetInTheWay, UsdsdgError, counted, warn_once
from usdsdg.session import devices
from usdsdg.session.progress import say_once
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.stores.whole_file import facts_of
from usdsdg.writers.journal import moved_folders
from usdsdg.writers.journal import recipe as recipe_file
from usdsdg.writers.journal.earlier_run import Mode, check_place
from usdsdg.writers.journal.facts import SETTINGS, WRITERS, AssetFacts, plain, settings_facts
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.frames import FileFacts, FrameFiles, FramesInHand
from usdsdg.writers.journal.growth import MoreFrames
from usdsdg.writers.journal.main_script import main_script, started_source
from usdsdg.writers.journal.places import place_locks
from usdsdg.writers.journal.places.numbered import NumberedPlaces
from usdsdg.writers.journal.places.place import Place, place_of
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import SCRIPT, Recipe, Source

# Arguments of writers that say where files go.
_PLACES = ("output_dir", "backend", "s3_bucket", "s3_region", "s3_endpoint")
ANEW = "what it did not write is not made again: once it is corrected, make the dataset anew with --overwrite"
# Frames are appended to journals when so many are whole, or after so many seconds.
MANY, SECONDS = 500, 2.0


class Run:
    """The run of this process; without a recipe, as in tests and notebooks, no journal is kept."""

    def __init__(self) -> None:
        self.recipe: Recipe | None = None
        self._source: Source | None = None
        self.mode = Mode.REPLACE
        self.portion: Portion | None = None
        self.growth: MoreFrames | None = None  # lets a run with fewer frames be resumed
        self.aggregates_wait = False  # until the end of the run; else they are written when a run of frames ends
        self.ends_early = False  # because of an error, Ctrl-C or a signal
        self.is_at_exit = False  # the program ends: other threads get no more frames
        self.counts_only = False  # frames are counted here, and made by other processes
        self.shares_out = False  # other processes make the frames
        self.captures = 0  # at which a writer was due
        self.made = 0  # frames of which this process made files
        self.scratch: Path | None = None  # folder below which all files go that would go to other places
        self.keeps_folders = False  # these places are made nevertheless, for files that a script writes itself
        self.numbered = NumberedPlaces()
        self._places: dict[str, Place] = {}
        self._folders: dict[str, DatasetFolder] = {}
        self._claiming = threading.RLock()  # threads that write files claim folders, too
        self._in_hand = FramesInHand()
        self._ended: set[str] = set()  # folders whose journals could not be told of a frame, nor are of later ones
        self._assets, self._known_assets = AssetFacts(current().note_before), {}
        self._settings: dict[str, Any] = {}  # at the frame at which a folder was new last
        self._appended_at = time.monotonic()
        self._is_main_script_known = False
        self._is_closed = False
        self.process = os.getpid()  # that makes it

    def begin(
        self,
        recipe: Recipe,
        mode: Mode,
        portion: Portion | None,
        source: Path | None = None,
        growth: MoreFrames | None = None,
    ) -> None:
        """Say what this process makes, before any writer is created.

        source: the configuration or script, of which a copy is kept beside the data. growth: lets a run with fewer
        frames be resumed.
        """
        self.recipe, self.mode, self.portion = recipe, mode, portion
        self._source, self._assets.source = (Source.read(source), source.absolute()) if source else (None, None)
        self.growth = growth

    def content_of(self, file: Path) -> bytes:
        """Return the content of a file; of the configuration or script, that with which the run began."""
        kept = self._source.content if self._source is not None and self._source.file == file.absolute() else None
        return file.read_bytes() if kept is None else kept

    # Folders

    def set_aside(self, scratch: Path, *, keeps_folders: bool) -> None:
        """Let no file reach the folders that writers name, which are made or not, and keep no journal."""
        self.scratch, self.keeps_folders = scratch, keeps_folders
        self.recipe, self._is_main_script_known = None, True

    def placed(self, folder: Path) -> Path:
        """Return where a writer's files go: to the folder itself, or below `scratch`."""
        if self.scratch is None:
            return folder
        if self.keeps_folders:
            with suppress(OSError):
                folder.mkdir(parents=True, exist_ok=True)
        folder = folder.absolute()
        return self.scratch.joinpath(*folder.parts[1:])

    def check(self, folder: str | os.PathLike[str]) -> None:
        """Check that the run may write to a folder; raises DatasetInTheWay otherwise.

        Where the script has removed or moved what it has written there before, it makes another dataset.
        """
        with self._claiming:
            if moved_folders.leave(str(folder), self._folders, self._in_hand):
                self._ended.discard(str(folder))
                current().writers_turns.pop(str(folder), None)  # who wrote there shares no files with who will
        if self._has_recipe() and str(folder) not in self._folders:
            assert self.recipe is not None
            place = self._place(os.fspath(folder))
            place.pull(self.portion)
            parts, of_place = self._with_parts, self.recipe.of(place.name, self.numbered.copy_of(place.name))
            try:
                check_place(place, of_place, self.mode, self.portion, with_parts=parts, growth=self.growth)
            except DatasetInTheWay:
                place_locks.check_unused(place, self.portion)  # such a run looks unfinished, and cannot be resumed
                raise

    @property
    def may_go_on(self) -> bool:
        """Whether this process resumes a run, or makes a part of one that others make, too."""
        return self._has_recipe() and (self.mode is Mode.RESUME or self.portion is not None)

    def first_of_this(self, places: Iterable[Place], copy: int) -> Place | None:
        """Return the first place with a run of this recipe, else of one with another number of frames; None: none is.

        To the latter frames are added, or it is said why this cannot be. copy: as in a recipe.
        """
        others = []
        for place in places:
            earlier = recipe_file.parsed(place.read(recipe_file.FILE), place.name)
            if self.recipe is None or earlier is None or earlier.get("copy", 0) != copy:
                continue
            wanted = self.recipe.of(place.name, copy)
            if not wanted.differences(earlier):
                return place
            others.append((place, wanted, earlier))
        growth = self.growth if self.mode is Mode.RESUME else None
        for place, wanted, earlier in others if growth is not None else ():
            place.pull(self.portion)
            assert growth is not None
            if growth.obstacle(place, wanted, earlier, self.portion) is not None:
                return place
        return None

    def know(self, place: Place) -> None:
        """Tell of a place that its name alone does not open, such as a bucket of a server of one's own."""
        self._places[place.name] = place

    def claim(self, folder: str) -> DatasetFolder | None:
        """Return a folder that the run writes to, with its lock; None where no journal is kept. Raises as `check`."""
        with self._claiming:
            if folder not in self._folders and self._has_recipe() and not self._is_closed:
                assert self.recipe is not None
                place = self._place(folder)
                of_place = self.recipe.of(place.name, self.numbered.copy_of(place.name))
                claimed = DatasetFolder(
                    place,
                    of_place,
                    self.mode,
                    self.portion,
                    with_parts=self._with_parts,
                    growth=self.growth,
                    shares_out=self._with_parts,
                )
                self._folders[folder] = claimed
                if self.mode is Mode.RESUME and (there := len(claimed.journal.contents.frames)):
                    have = counted(there, "frame, which is", "frames, which are")
                    say_once(f"{place.name} has {have} not made again")
                if self.mode is Mode.RESUME and (failed := claimed.journal.contents.failed):
                    more = f" and {len(failed) - 1} more" if len(failed) > 1 else ""
                    warn_once(f"{place.name}: a writer failed at frame {failed[0]}{more}; {ANEW}")
                if self._source is not None and (kept := self._source.keep(place.path)):
                    claimed.note_shared(kept, facts_of(place.path / kept))
            return self._folders.get(folder)

    @property
    def folders(self) -> tuple[DatasetFolder, ...]:
        """The folders that the run writes to."""
        return tuple(self._folders.values())

    @property
    def is_over(self) -> bool:
        """Whether all later frames are made by other processes, or have been made."""
        if self._folders and all(folder.was_complete for folder in self.folders):
            return True
        return self.portion is not None and self.portion.is_over(self.captures)

    def own_frames(self, frames: int) -> int:
        """Return how many of the first `frames` frames of the run this process makes, for progress reports."""
        return frames if self.portion is None else self.portion.count(frames)

    def adopt(self, folder: DatasetFolder) -> None:
        """Write to a folder that has been claimed."""
        self._folders[folder.place.name] = folder

    @property
    def is_part(self) -> bool:
        """Whether other processes make other frames, so that files about all frames are made when all are there."""
        return self.portion is not None or self.counts_only

    @property
    def is_closed(self) -> bool:
        """Whether the journals are closed."""
        return self._is_closed

    @property
    def is_copy(self) -> bool:
        """Whether another process makes it, of which this one is a copy by fork, and which closes the journals."""
        return self.process != os.getpid()

    # Frames

    def begin_frame(self, output_folders: Sequence[str | None]) -> tuple[int, list[bool]]:
        """Count a capture at which writers are due; return its number, and for each whether its files are to be made.

        output_folders: of the writers that are due; None: not known.
        """
        self.process = os.getpid()  # a copy that captures goes on with the run, as a daemon does
        number, self.captures = self.captures, self.captures + 1
        claimed = [found for each in output_folders if each is not None and (found := self.claim(each)) is not None]
        if any(each.first is None for each in claimed):
            seed = {recipe_file.SEED_SETTING: current().global_seed.value}  # which may have been drawn
            self._settings = settings_facts(get_settings().changed() | seed)
        for each in claimed:
            each.see_due(number)
        return number, [self._is_wanted(folder, number) for folder in output_folders]

    def is_made(self, folder: str | None, number: int) -> bool:
        """Return whether a frame was whole when a writer's folder was claimed."""
        claimed = self.claim(folder) if folder is not None else None
        return claimed is not None and claimed.has(number)

    def take_kept(self, folder: str | None, writer: str, number: int) -> dict[str, Any]:
        """Return, once, what a writer kept after the last frame that was made before; writer: its key.

        number: of the frame that follows; at one before that last frame, as of another part, nothing is returned.
        """
        claimed = self.claim(folder) if folder is not None else None
        if claimed is None or number < claimed.end:
            return {}
        return claimed.journal.contents.states.pop(writer, {})

    def is_behind(self, folder: str) -> bool:
        """Return whether the run goes on in a folder, and ends before it has come to all frames that are there."""
        claimed = self._folders.get(folder)
        return self.ends_early and claimed is not None and claimed.goes_on and self.captures < claimed.end

    def is_wanted_soon(self, folder: str | None, number: int, ahead: int) -> bool:
        """Return whether a writer's files of a capture, or of one of so many that follow it, are to be made."""
        return any(self._is_wanted(folder, each) for each in range(number, number + ahead + 1))

    def hand(self, number: int) -> FrameFiles:
        """Begin a frame of which files are made; the capture ends it with `release`."""
        self.made += 1
        return self._in_hand.begin(number)

    def take_back(self, number: int, frame: FrameFiles | None) -> None:
        """Undo `begin_frame` and `hand` of the last capture, of which no writer was told: it will be captured again."""
        self.captures = number
        if frame is not None:
            self.made -= 1
            frame.take_back()

    def note(self, folder: str, path: str, facts: FileFacts, frame: FrameFiles | None) -> None:
        """Tell that a file has been written; frame: to which it belongs, if to one."""
        claimed = self._folders.get(folder)
        if claimed is None:
            return
        if frame is not None:
            frame.note(folder, path, facts)
        else:
            claimed.note_shared(path, facts)

    def see_stage(self, stage: Usd.Stage) -> None:
        """Note the assets that a stage is made of, and those that were read to show it."""
        if self._folders:
            self._assets.see(stage)

    def see_writer(self, folder: str | None, key: str, parameters: Mapping[str, Any]) -> None:
        """Note a writer; key: its name among those of the frame. parameters: those that it was initialized with."""
        claimed = self.claim(folder) if folder is not None else None
        if claimed is None:
            return
        arguments = {name: plain(value) for name, value in parameters.items() if name not in _PLACES}
        claimed.note_facts(WRITERS, {key: arguments})
        # Whoever makes the folder's first frame tells, since settings may change from frame to frame.
        if claimed.first == self.captures - 1:
            claimed.note_facts(SETTINGS, self._settings)

    def is_due(self) -> bool:
        """Return whether `append` should be called."""
        if not self._folders:
            return False
        return self._in_hand.count_whole() >= (1 if time.monotonic() - self._appended_at > SECONDS else MANY)

    def append(self) -> None:
        """Append the frames that are whole to the journals of their folders.

        Raises:
            OutputNotWritable: a folder cannot be written to. Its journal ends there; those of others go on.
        """
        self._appended_at = time.monotonic()
        frames = self._in_hand.whole()  # until they are in all journals, since Ctrl-C may come meanwhile
        self._known_assets |= self._assets.take()
        failures = []
        for name, folder in self._folders.copy().items():  # other threads may claim folders meanwhile
            folder.note_assets(self._known_assets)
            new = [each for each, where in frames if where == name and not folder.journal.has(each.number)]
            try:
                if new and name not in self._ended:
                    folder.append([each.line(name) for each in new])
            except UsdsdgError as error:
                self._ended.add(name)
                failures.append(error)
        self._in_hand.forget(frames)
        if failures:
            raise failures[0]

    def close(self, *, complete: bool) -> None:
        """Close all journals, once nothing waits to be written; frames after this are in no journal.

        complete: the run has come to its end.

        Raises:
            UsdsdgError: the first failure; the other folders are closed.
        """
        if self._is_closed or not self._folders or self.is_copy:
            return
        self._is_closed = True
        failures = []
        if complete:
            self._in_hand.accept_failed()
        try:
            self.append()
        except UsdsdgError as error:
            failures.append(error)
        for name, folder in tuple(self._folders.items()):
            try:
                is_whole = name not in self._ended and not self._in_hand.lacks(name)
                folder.close(complete=complete and is_whole)
            except UsdsdgError as error:
                failures.append(error)
        if failures:
            raise failures[0]

    def follow_moved(self, *, in_use: Collection[str | None] = ()) -> None:
        """Find folders that are not `in_use` and that a script has moved itself; forget those that it has removed."""
        with self._claiming:
            idle = [each for each in self._folders if each not in in_use and not self._in_hand.has_open(each)]
            moved_folders.follow(idle, self._folders)

    def release(self) -> None:
        """Give all folders back as they are; what is claimed later is claimed anew."""
        for folder in self._folders.values():
            folder.release()
        self._folders.clear()

    @property
    def _with_parts(self) -> bool:
        return self.counts_only or self.shares_out

    def _place(self, name: str) -> Place:
        if name not in self._places:
            self._places[name] = place_of(name)
        return self._places[name]

    def _is_wanted(self, folder: str | None, number: int) -> bool:
        if self.counts_only or (self.portion is not None and not self.portion.has(number)):
            return False
        claimed = self.claim(folder) if folder is not None else None
        return claimed is None or not claimed.has(number)

    def _has_recipe(self) -> bool:
        if self.recipe is None and not self._is_main_script_known:
            self._is_main_script_known = True
            if (script := main_script()) is not None:
                self._source, self._assets.source = started_source(script), script
                self.recipe = Recipe(SCRIPT, self._source.facts(), arguments=sys.argv[1:])
        if self.recipe is not None and not self.recipe.device:
            self.recipe.device = devices.renderer_device_kind()
        return self.recipe is not None


def get_run() -> Run:
    """Return the run of the session."""
    return current().run

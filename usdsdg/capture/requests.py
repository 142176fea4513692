"""The render products that annotators and writers request for one frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile

from usdsdg.annotators.annotator import Annotator, attached_annotators
from usdsdg.annotators.requirements import Requirements, requirements
from usdsdg.capture.records import frames as frame_records
from usdsdg.capture.records.pictures import AOVS as RECORDED_AOVS
from usdsdg.capture.tap import Tap, history_of
from usdsdg.errors import DatasetInTheWay, Unsupported, WriterError, warn_once
from usdsdg.operating_system import is_importing_main_again
from usdsdg.session.render_products import HydraTexture, products
from usdsdg.session.session import current
from usdsdg.writers import counters
from usdsdg.writers.base import Writer, attached_writers
from usdsdg.writers.journal.copies import check_copy
from usdsdg.writers.journal.frames import FrameFiles
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.sharing import note_writer
from usdsdg_render.settings import LIGHT_AOVS


@dataclass(frozen=True)
class Skipped:
    """A writer that is due at a frame whose files are made by another process, or were made before."""

    writer: Writer
    is_made: bool  # before the run went on
    key: str = ""  # its name among the writers of the frame
    folder: str | None = None
    number: int = 0  # of the frame


def writer_key(writer: Writer, due: Sequence[Writer]) -> str:
    """Return the name of a writer among those that are due at a frame."""
    same = [each for each in due if type(each).__name__ == type(writer).__name__]
    return f"{type(writer).__name__}-{same.index(writer)}"


@dataclass
class Requests:
    """The annotators and writers that take part in one frame."""

    annotators: dict[str, list[Annotator]] = field(default_factory=dict)  # by product path; also those of `writers`
    writers: list[Writer] = field(default_factory=list)  # those that are due at this frame
    skipped: list[Skipped] = field(default_factory=list)  # those that are due, whose files are not to be made here
    files: FrameFiles | None = None  # those of the frame, where writers are due
    skips_pictures: bool = False  # whether products would be rendered for `skipped`
    skipped_filters: dict[str | None, None] = field(default_factory=dict)  # of labels that `skipped` read
    keys: dict[int, tuple[str, str | None]] = field(default_factory=dict)  # key and folder of writers by their id
    tapped: list[str] = field(default_factory=list)  # paths of products whose views are handed out in their place
    _recorded: set[str] = field(default_factory=set)  # paths of products of which writers get a record
    # By product path, those of writers whose files were made before: a frame is rendered as it was for them, since the
    # records of the others have what was rendered.
    _made: dict[str, list[Annotator]] = field(default_factory=dict)
    _number: int | None = None  # of the frame among those of the run, where writers are due
    _requirements: dict[str, Requirements] = field(default_factory=dict)  # of `annotators`, where asked for

    @classmethod
    def collect(cls, frame: int) -> Requests:
        """Collect the requests of all attached annotators and writers for a frame of the job.

        Raises:
            Unsupported: an annotator that needs one camera is attached to a tiled product.
        """
        requests = cls()
        for annotator in attached_annotators():
            requests._add(annotator.render_product, [annotator], f"annotator {annotator.get_name()!r}")
        if current().companion is not None:
            current().companion.follow()
        # Called once per frame: a writer's own trigger function may have state.
        due = [writer for writer in attached_writers() if writer.is_due()]
        if (tap := current().tap) is not None:
            requests._divert(tap, due, frame)
            return requests
        try:
            requests._share_out(due)
            for writer in requests.writers:
                for path in writer.render_products:
                    requests._add(path, writer.annotators_of(path), type(writer).__name__)
        except BaseException:
            requests.take_back()
            raise
        return requests

    def take_back(self) -> None:
        """Let the frame be one that has not begun, as no writer has had it: the next one has its number."""
        if self._number is not None:
            get_run().take_back(self._number, self.files)
            self._number = self.files = None

    def _share_out(self, due: list[Writer]) -> None:
        """Keep the writers that are due, apart from those whose files of this frame are not this process's to make."""
        if not due:
            return
        if is_importing_main_again():
            raise DatasetInTheWay(
                "multiprocessing has started this process, and imports the program's file in it, which captures frames "
                "at its top level: they would replace those of the process that has started it. Put what the program "
                "runs below `if __name__ == '__main__':`, and leave above it the functions that other processes call."
            )
        run, folders = get_run(), [frame_records.folder_of(writer) for writer in due]
        if run.is_closed:
            raise WriterError(
                "the program ends, and its datasets are closed: frames that a function of atexit captures would be in "
                "none of them. Capture them before."
            )
        check_copy(run, folders)
        for writer, folder in zip(due, folders):
            if folder is not None:
                note_writer(folder, writer)
        self._number = run.captures
        number, wanted = run.begin_frame(folders)
        self.writers = [writer for writer, is_wanted in zip(due, wanted) if is_wanted]
        self.keys = {id(writer): (writer_key(writer, due), folder) for writer, folder in zip(due, folders)}
        for writer in self.writers:
            key, folder = self.keys[id(writer)]
            run.see_writer(folder, key, writer.parameters)
        if self.writers:
            self.files = run.hand(number)
            for folder in (folder for folder, is_wanted in zip(folders, wanted) if is_wanted and folder):
                self.files.expect(folder)
        for writer, folder, is_wanted in zip(due, folders, wanted):
            if not run.is_made(folder, number):
                counters.restore(writer, run.take_kept(folder, self.keys[id(writer)][0], number))
            if frame_records.is_on() and frame_records.sink_of(writer) is not None:
                self._recorded.update(writer.render_products)
            if is_wanted:
                continue
            skipped = Skipped(writer, run.is_made(folder, number), self.keys[id(writer)][0], folder, number)
            self.skipped.append(skipped)
            enabled = {product.path for product in products() if product.updates_enabled}
            for path in writer.render_products:
                read = writer.annotators_of(path)
                if path in enabled:
                    self.skips_pictures = True
                    self.skipped_filters |= dict.fromkeys(requirements(read).filters)
                    self._made.setdefault(path, []).extend(read if skipped.is_made else [])
                ahead = max(map(history_of, read), default=0)
                # Those of other writers, too: their records have what this writer reads.
                sharing = {each for other, each in zip(due, folders) if path in other.render_products}
                if not (ahead and any(run.is_wanted_soon(each, number + 1, ahead - 1) for each in sharing)):
                    # Else a later frame is compared with what this one shows.
                    read = writer.annotators_to_skip() if not skipped.is_made else []
                if read:
                    self._add(path, read, type(writer).__name__)

    def _divert(self, tap: Tap, due: list[Writer], frame: int) -> None:
        """Request for the tap what writers that are due would be given; where none is attached, all products."""
        for writer in due:
            writer.pass_over()
        written = {path for writer in due for path in writer.render_products}
        shown = [
            product.path
            for product in products()
            if product.updates_enabled and (product.path in written or not attached_writers())
        ]
        if not tap.needs(frame):
            # Classes are numbered at the same frames in all processes that share out the frames.
            self.skips_pictures = bool(shown)
            self.skipped_filters |= dict.fromkeys(requirements(tap.annotators).filters if shown else ())
            return
        for path in shown:
            self._add(path, tap.annotators, "the stream")
            self.tapped.append(path)

    @classmethod
    def of_product(cls, path: str) -> Requests:
        """Collect the requests of the annotators that users have attached to one product; none if it is destroyed.

        Raises:
            Unsupported: an annotator that needs one camera is attached to a tiled product.
        """
        requests = cls()
        for annotator in attached_annotators():
            if annotator.render_product == path:
                requests._add(path, [annotator], f"annotator {annotator.get_name()!r}")
        return requests

    def _add(self, path: str | None, annotators: list[Annotator], who: str) -> None:
        product = next((product for product in products() if product.path == path), None)
        if product is None:
            warn_once(
                f"{who} is attached to {path}, which has been destroyed, and gets no frames of it. Detach it, or "
                "attach it to another render product."
            )
        elif product.updates_enabled:
            _check_tiles(product, annotators, who)
            self.annotators.setdefault(product.path, []).extend(annotators)
            self._requirements.pop(product.path, None)

    @property
    def is_recorded(self) -> bool:
        """Whether any writer gets a record of its frames."""
        return bool(self._recorded)

    def made_of(self, path: str) -> list[Annotator]:
        """Return the annotators of the product at `path` that writers read whose files were made before."""
        return self._made.get(path, [])

    def products(self) -> list[HydraTexture]:
        """Return the requested render products, oldest first."""
        return [product for product in products() if product.path in self.annotators]

    def traced(self) -> list[HydraTexture]:
        """Return the requested render products whose color images are."""
        return [product for product in self.products() if self.requirements(product.path).path_tracing]

    def requirements(self, path: str) -> Requirements:
        """Return what the annotators of the product at `path`, and the record of its frame, need rendered."""
        if path not in self._requirements:
            self._requirements[path] = requirements([*self.annotators[path], *self.made_of(path)])
        needs = self._requirements[path]
        if path in self._recorded and needs.aovs.difference(LIGHT_AOVS):
            return replace(needs, aovs=needs.aovs | RECORDED_AOVS, poses=True)
        return needs


def count_unwanted(writers: Sequence[Writer], first: int, most: int) -> int:
    """Return of how many frames from `first` of the job on, up to `most`, nothing is made in this process.

    The tap, or the writers, only count these, and compare no later frame with them.
    """
    if (tap := current().tap) is not None:
        return sum(1 for _ in takewhile(lambda frame: not tap.needs(frame), range(first, first + most)))
    if not writers or any(not each.is_always_due or each.annotators_to_skip() for each in writers):
        return 0
    annotators = [each for writer in writers for each in writer.annotators if not isinstance(each, str)]
    ahead = max(map(history_of, annotators), default=0)
    run, folders = get_run(), {frame_records.folder_of(writer) for writer in writers}

    def is_unwanted(number: int) -> bool:
        return not any(run.is_wanted_soon(folder, number, ahead) for folder in folders)

    return sum(1 for _ in takewhile(is_unwanted, range(run.captures, run.captures + most)))


def is_watched() -> bool:
    """Return whether a render product whose updates are enabled has a writer, or an annotator that watches plays."""
    on = [product for product in products() if product.updates_enabled]
    written = {path for writer in attached_writers() for path in writer.render_products}
    read = {annotator.render_product for annotator in attached_annotators()}
    return any(product.path in written or (product.captured_on_play and product.path in read) for product in on)


def _check_tiles(product: HydraTexture, annotators: list[Annotator], who: str) -> None:
    needing = [annotator.get_name() for annotator in annotators if annotator.spec.needs_amodal_masks]
    if product.tiles is not None and needing:
        raise Unsupported(
            f"{who}: {', '.join(needing)} cannot be computed for {product.path}, which has "
            f"{len(product.tiles.cameras)} cameras in tiles. Attach to a render product of "
            "each camera (create.render_product)."
        )

"""Capture one frame: collect requests, expose films, render labels, compute annotators, write.

Films are exposed once per sub-frame; labels are rendered once, from the state at the last exposure.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from usdsdg.annotators.annotator import attached_annotators
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.labeled_prims import LabeledPrimReader
from usdsdg.capture.exposure import Exposure
from usdsdg.capture.frame_scene import EarlierPoints, FrameScene
from usdsdg.capture.labels import render_labels
from usdsdg.capture.later_pictures import CopiedPictures, LaterPictures, later_pictures, may_be_later
from usdsdg.capture.observing import observe
from usdsdg.capture.output import WriterOutput, append_to_journals, in_spite_of_failures
from usdsdg.capture.pictures_ahead import PicturesAhead
from usdsdg.capture.records.frames import note_keypoints
from usdsdg.capture.records.stages import StageMoment, StageRecords
from usdsdg.capture.render_settings import RenderMode
from usdsdg.capture.requests import Requests, count_unwanted
from usdsdg.capture.tiles import view_of
from usdsdg.create import projections
from usdsdg.graph.sampling import get_global_seed
from usdsdg.session import engines
from usdsdg.session.progress import report_frames
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras.camera_reader import CameraReader
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg.stage.world_values import WorldValues
from usdsdg.writers.base import attached_writers
from usdsdg.writers.global_seed import set_global_seed
from usdsdg.writers.journal.frames import FrameFiles
from usdsdg.writers.journal.run import get_run

# Ticks per second of reference times.
TICKS = 1_000_000


class Capture:
    """Renders, frame by frame, the render products that annotators and writers are attached to."""

    def __init__(self, *, shared_prims: Callable[[], LabeledPrimReader] | None = None) -> None:
        """shared_prims: returns the reader of the labeled prims, so that ids are those of others that have it."""
        self._shared_prims = shared_prims
        self.expected_frames: int | None = None  # for progress reports; None: not known
        self.frames_before = 0  # those of the same job on earlier stages
        # Whether writers have the frame, also where one of them failed: it is not captured again, or they had it twice.
        self.is_handed_over = False
        self._output = WriterOutput()
        self._labeled_prims: LabeledPrimReader | None = None
        self._earlier = EarlierPoints()
        self._stages: StageRecords | None = None
        self._moment: StageMoment | None = None
        self._requests = Requests()
        self._files: FrameFiles | None = None  # of the frame that has begun
        self._cameras: CameraReader | None = None
        self._exposure: Exposure  # of the frame that has begun
        self._ahead: PicturesAhead | None = None
        self._frame = 0
        self._traced: Mapping[str, dict[str, Any]] = {}  # color images of this frame that are there, by product path
        self._later: RenderMode | None = None  # of images that are traced after the labels, beside what follows
        self._pictures: LaterPictures | CopiedPictures | None = None  # those, until they have begun

    def begin(self, frame: int, ahead: PicturesAhead | None = None) -> None:
        """Collect what annotators and writers request for this frame.

        ahead: this frame and others, whose color images are traced together at the first of them.
        """
        self._ahead, self._frame, self.is_handed_over = ahead, frame, False
        set_global_seed(get_global_seed())
        self._requests = Requests.collect(self.frames_before + frame)
        self._files = self._requests.files
        if self._requests.annotators:
            engines.renderer().look_at_files()
        try:
            self._exposure, self._later = Exposure(self._requests, frame, self._camera_reader()), None
        except BaseException:
            self.give_up()
            raise

    def open_shutter(self) -> None:
        """Read the poses at which a motion-blurred exposure begins."""
        if self._requests.annotators:
            self._exposure.open_shutter()

    def expose(self, mode: RenderMode) -> None:
        """Add samples to the film of every product whose path-traced image is requested."""
        if not self._requests.annotators:
            return
        if self._ahead is None:
            projections.follow()
        if self._ahead is not None and self._ahead.frame == self._frame:
            self._ahead.trace(self._requests, mode)
        traced = {} if self._ahead is None else self._ahead.pictures(self._frame)
        wanted = {each.path for each in self._requests.traced()}  # not at every frame, where writers have triggers
        is_whole = bool(wanted) and traced.keys() >= wanted
        self._traced = {path: traced[path] for path in wanted} if is_whole else {}
        if is_whole:
            self._exposure.open_shutter()
        elif may_be_later(self._requests, mode):
            self._later = mode
            self._exposure.open_shutter()
        else:
            self._exposure.add(mode)

    def finish(self, frame: int, seconds: float) -> None:
        """Render labels, compute annotators and call writers; `seconds` is the time on the timeline.

        A writer that fails does not keep the frame from the others; its error is raised after them.
        """
        if not self._requests.annotators:
            if self._requests.is_recorded:
                self._stages_of_record().follow()
            self.is_handed_over = True
            self._skip({})
            if self._files is not None:
                self._files.due.clear()  # the products of these writers are off
            current().observations.frames += bool(self._requests.skipped)
            current().observations.unseen += not self._requests.skipped
            self._end_files()
            append_to_journals()
            return
        self._moment = self._stage_moment()
        frames = self._frames(frame, seconds)
        observe(self._requests, frames)
        _compute(frames)
        handed = [self._output.payload(writer, frames) for writer in self._requests.writers]
        self._skip(frames)
        if handed:
            for path, each in frames.items():
                note_keypoints(each, self._requests.made_of(path))
        self._begin_pictures()  # after payloads: in a GPU's stream their copies would wait until pictures are traced
        self.is_handed_over = True
        if self._files is not None:
            get_run().see_stage(current_stage())  # before files are written, where Ctrl-C may end the frame
        before = [writer.num_written for writer in self._requests.writers]
        try:
            in_spite_of_failures(
                *(
                    partial(self._output.write, writer, payload, frames, self._requests, self._moment)
                    for writer, payload in zip(self._requests.writers, handed, strict=True)
                )
            )
        finally:
            for writer, payload, count in zip(self._requests.writers, handed, before, strict=True):
                if payload is not None and writer.num_written == count:  # Ctrl-C came before
                    self._output.miss(writer)
            self._remember(frames)
        if (tap := current().tap) is not None:
            tap.take(frames, self._requests.tapped, number=self.frames_before + frame)
        self._end_files()
        append_to_journals()
        if current().tap is None:  # who takes the frames counts them
            count, total = get_run().own_frames, self.expected_frames
            report_frames(count(self.frames_before + frame + 1), None if total is None else count(total))

    def give_up(self) -> None:
        """End a frame that has begun and is not finished, because of an error."""
        if self.is_handed_over:
            self._end_files()
        else:
            self._requests.take_back()
            self._files = None

    def _end_files(self) -> None:
        """Let the frame be whole once its files are written; it has none where all products are off."""
        if self._files is not None:
            self._files.release()
            self._files = None

    def pass_over(self, frame: int) -> None:
        """Count a frame of which no writer makes files here, without looking at the stage."""
        self.begin(frame)
        self._requests.skips_pictures = False
        self._skip({})
        current().observations.frames += bool(self._requests.skipped)
        if self._stages is not None:
            self._stages.pass_over()

    def count_unwanted(self, frame: int, most: int) -> int:
        """Return how many frames from `frame` on, up to `most`, need not be looked at: they are only counted here."""
        if most <= 0 or attached_annotators() or current().companion is not None or current().worlds is not None:
            return 0
        return count_unwanted(attached_writers(), self.frames_before + frame, most)

    def has_to_see(self, values: WorldValues) -> bool:
        """Return whether a writer reads of the stage what the next frames change, although it makes none of them."""
        return any(writer.has_to_see(values) for writer in attached_writers())

    def follow_unseen(self, values: WorldValues) -> bool:
        """Note what frames that are passed over change, for records of later ones.

        Return whether frames after these may change more than has been noted.
        """
        is_recorded = self._requests.is_recorded and not get_run().counts_only
        return is_recorded and self._stages_of_record().follow_unseen(values)

    def _skip(self, frames: Mapping[str, Frame]) -> None:
        if self._requests.skips_pictures:
            stage = current_stage()
            self.labeled_prims().survey(self._requests.skipped_filters, time=stage_time(stage))
        current().observations.goes_on |= any(each.is_made for each in self._requests.skipped)
        for skipped in self._requests.skipped:
            self._output.skip(skipped, frames)

    def labeled_prims(self) -> LabeledPrimReader:
        """Return the reader of the labeled prims of the stage, which numbers all that is in its pictures."""
        if self._shared_prims is not None:
            return self._shared_prims()
        if self._labeled_prims is None:
            self._labeled_prims = LabeledPrimReader(current_stage())
        return self._labeled_prims

    def show(self, path: str, mode: RenderMode, *, number: int, seconds: float) -> None:
        """Compute the attached annotators of the product at `path`, without capturing a frame.

        number: seed of the image's noise. seconds: time on the timeline.
        """
        self._requests, self._ahead = Requests.of_product(path), None
        engines.renderer().look_at_files()
        self._exposure, self._later = Exposure(self._requests, number, self._camera_reader()), None
        self.expose(mode)
        if self._requests.annotators:
            _compute(self._frames(number, seconds))

    def _remember(self, frames: Mapping[str, Frame]) -> None:
        """Keep the points that pictures show, for annotators that follow them in later captures."""
        for path, frame in frames.items():
            if captures := self._requests.requirements(path).earlier_captures:
                assert isinstance(frame.scene, FrameScene)
                self._earlier.remember(path, frame.scene.points(), captures)

    def _stage_moment(self) -> StageMoment | None:
        """Return the stage as it is now, where a writer's record needs it."""
        if not self._requests.is_recorded:
            return None
        return self._stages_of_record().take(engines.renderer().time)

    def _stages_of_record(self) -> StageRecords:
        if self._stages is None:
            self._stages = StageRecords(current_stage())
        return self._stages

    def _frames(self, index: int, seconds: float) -> dict[str, Frame]:
        """Return the frame of each product, the input of annotators, by product path."""
        renderer = engines.renderer()
        cameras = self._camera_reader()
        views = {product.path: view_of(product, cameras, renderer.time) for product in self._requests.products()}
        labels = render_labels(self._requests, views, self.labeled_prims())
        images = self._images(views)
        frames = {
            path: Frame(
                index=index, view=view, render_product=path, gprims=labels[path].table.gprims,
                aovs=labels[path].aovs | images.get(path, {}),
                labeled_prims=labels[path].labeled_prims, amodal_masks=labels[path].amodal_masks,
                reference_time=(round(seconds * TICKS), TICKS),
                scene=FrameScene(path, view, labels[path].table, labels[path].aovs, self._earlier, renderer),
            )
            for path, view in views.items()
        }  # fmt: skip
        for frame in frames.values():
            frame.together.extend(frames.values())
        return frames

    def _camera_reader(self) -> CameraReader:
        if self._cameras is None:
            self._cameras = CameraReader(current_stage())
        return self._cameras

    def _images(self, views: Mapping[str, CameraView | TiledView]) -> Mapping[str, dict[str, Any]]:
        """Return the color images of each product, by path; where they may be later, `_begin_pictures` follows."""
        current().tracing = self._pictures = None
        if self._traced:
            return {path: self._traced.get(path, {}) for path in views}
        if self._later is None:
            return {path: self._exposure.images(path, view) for path, view in views.items()}
        self._pictures = later_pictures(self._exposure, self._later, views)
        return self._pictures.images

    def _begin_pictures(self) -> None:
        """Let color images that may be later be traced."""
        if self._pictures is not None:
            self._pictures.begin()
            current().tracing, self._pictures = self._pictures.tracing, None


def _compute(frames: Mapping[str, Frame]) -> None:
    """Compute every attached annotator whose product is among `frames`, by product path."""
    for annotator in attached_annotators():
        if (frame := frames.get(annotator.render_product or "")) is not None:
            annotator.compute(frame)
            current().live.note(annotator)

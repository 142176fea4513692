"""Frames handed out in memory, in place of the writers of a job."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.base import Annotation
from usdsdg.annotators.delivery import delivered
from usdsdg.annotators.frame import Frame
from usdsdg.errors import ArgumentError
from usdsdg.session.session import current

# What one render product shows of one frame, by annotator name.
Receive = Callable[["TappedView"], None]


# A class table: labels by id.
ClassesById = Mapping[int, Mapping[str, str]]

# What is asked for: an annotator's name, or its name and init parameters.
Asked = str | tuple[str, Mapping[str, Any]]


def annotator_of(asked: Asked) -> Annotator:
    """Return a new annotator.

    Raises:
        ArgumentError: it is neither a name nor a name with parameters.
        AnnotatorRegistryError: there is no such annotator.
        AnnotatorError: it has no such parameter.
    """
    if isinstance(asked, str):
        return named_annotators.get(asked)
    if isinstance(asked, (tuple, list)) and len(asked) == 2 and isinstance(asked[0], str):
        return named_annotators.get(asked[0], init_params=asked[1])
    raise ArgumentError(f"annotators has {asked!r}; give names, or pairs of a name and a dictionary of its parameters")


@dataclass(frozen=True)
class TappedView:
    """The annotations of one render product in one frame."""

    frame: int  # index of the capture, from 0, over all stages of a job
    render_product: str  # its name
    camera: str  # prim path; of the first one of a tiled product
    annotations: Mapping[str, Annotation]  # by annotator name; NumPy arrays, shared, which must not be written into
    classes: ClassesById  # the class table of the dataset, for the label filter of the first annotator with labels
    class_tables: Mapping[str, ClassesById]  # by annotator with another label filter, the table of that one


class Tap:
    """Takes the frames of a job from the capture; while there is one, writers get none.

    Frames that are not wanted only run graph and physics, unless an annotator compares a frame with an earlier one:
    then all are rendered.
    """

    def __init__(self, annotators: Sequence[Asked], is_wanted: Callable[[int], bool], receive: Receive) -> None:
        self._annotators: list[Annotator] = [annotator_of(each) for each in annotators]
        self._is_wanted, self._receive = is_wanted, receive

    def needs(self, frame: int) -> bool:
        """Return whether a frame has to be rendered."""
        return self._is_wanted(frame) or any(history_of(annotator) for annotator in self._annotators)

    @property
    def annotators(self) -> list[Annotator]:
        """What is computed for every render product."""
        return list(self._annotators)

    def take(self, frames: Mapping[str, Frame], paths: Sequence[str], *, number: int) -> None:
        """Compute the annotations of the frames at the render products `paths`; hand them out, in this order.

        number: of the frame in its job.
        """
        for path in paths:
            frame = frames[path]
            computed = {annotator.get_name(): annotator.compute(frame) for annotator in self._annotators}
            # What is on a GPU comes from there in one go.
            frame.fetch(array for each in computed.values() for array in each.images)
            annotations = {
                name: delivered(each, None, copy=False, fetch=frame.on_host) for name, each in computed.items()
            }
            if self._is_wanted(number):
                name, camera = path.rsplit("/", 1)[-1], frame.view.prim_path
                self._receive(TappedView(number, name, camera, annotations, *self._class_tables()))

    def _class_tables(self) -> tuple[ClassesById, dict[str, ClassesById]]:
        reading = [annotator for annotator in self._annotators if annotator.reads_labels]
        if not reading:
            return {}, {}
        first, tables = reading[0].label_filter, current().class_tables
        others = {each.get_name(): each.label_filter for each in reading if each.label_filter != first}
        return tables.of(first).labels(), {name: tables.of(given).labels() for name, given in others.items()}


def history_of(annotator: Annotator) -> int:
    """Return how many captures before a frame decide on what it computes of it."""
    return max(annotator.earlier_captures, int("motion_vectors" in annotator.aovs))

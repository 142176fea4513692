"""What a writer is: it declares the annotators that it reads, and turns each payload into files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.payload import check_layout
from usdsdg.annotators.render_products import existing_products, render_product_paths
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import InvalidWriterError, Unsupported, WriterError, called_for_script
from usdsdg.session.session import current
from usdsdg.session.turns import in_turn
from usdsdg.stage.world_values import WorldValues
from usdsdg.writers import counters
from usdsdg.writers.class_file import ClassFile
from usdsdg.writers.files import write_json
from usdsdg.writers.global_seed import global_seed
from usdsdg.writers.options import check_names, named_only

# Write at every captured frame.
ON_FRAME = "omni.replicator.core.OgnOnFrame"
METADATA = "metadata.txt"


def attached_writers() -> tuple[Writer, ...]:
    """Return the attached writers, in the order in which they were attached."""
    return tuple(current().writers)


def detach_all() -> None:
    """Detach every writer, as for a new stage."""
    for writer in attached_writers():
        writer.detach()


class Writer(ABC):
    """Base of all writers. A subclass sets `annotators` (names or Annotators) and `backend`, and implements `write`.

    The registry creates instances without `__init__`; `initialize` runs it.
    """

    backend: Any = None  # a `BaseBackend`: to a type checker not one that may be None, for `write` does not ask
    version: str = "0.0.0"
    annotators: list[Any] = []
    metadata: dict[str, Any] = {}
    num_written: int = 0
    data_structure: str = "legacy"  # layout of the payload: "legacy", "annotator" or "renderProduct"
    # True: `write` never modifies the payload's arrays and tables of labels, so that they need not be copied.
    shares_arrays: bool = False
    # True, with a `write` of the same class: only jobs of its backend look at color images, which are traced meanwhile.
    only_stores_pictures: bool = False
    # Attributes that depend on what frames have shown, and are JSON: a run that goes on takes them from the journal.
    kept: tuple[str, ...] = ()

    _payload: dict[str, Any] | None
    _render_products: tuple[str, ...]
    _numbered_products: tuple[str, ...]  # as attached, before some were detached: what indices of annotators refer to
    _scheduled: bool
    _class_file: ClassFile
    _executions: Any
    _turn: object  # what is made between two calls of `initialize`
    _facts: dict[str, Any]  # entries of `metadata` that `get_metadata` has put there

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls.kept = (cls.kept,) if isinstance(cls.kept, str) else tuple(cls.kept)
        if "write" in vars(cls) and "shares_arrays" not in vars(cls):
            cls.shares_arrays = False  # a script's own `write` may modify them, whatever it inherits from

    def __new__(cls, *args: Any, **kwargs: Any) -> Writer:
        # Subclasses need not call super().__init__().
        writer = super().__new__(cls)
        writer.annotators, writer.metadata, writer._facts = list(cls.annotators), dict(cls.metadata), {}
        writer._render_products, writer._numbered_products, writer._trigger = (), (), ON_FRAME
        writer._payload, writer._scheduled, writer._executions = None, False, None
        writer._class_file, writer._turn, writer.parameters = ClassFile(), object(), {}
        return writer

    @abstractmethod
    def write(self, data: dict[str, Any]) -> None:
        """Write one payload to files."""

    def skip(self, data: dict[str, Any]) -> None:
        """Change the writer's own attributes as `write` would for a frame that another process makes.

        data: the frame's "trigger_outputs", "distribution_outputs" and "named_outputs", and its "renderProducts" by
            name, each with what the annotators of `annotators_to_skip` show there. By default the counters that the
            source of `write` tells of are advanced.

        Raises:
            Unsupported: `write` keeps more than counters from frame to frame.
        """
        counters.advance(self)

    def survey(self) -> None:  # noqa: B027 - optional
        """Note the objects of the current stage, which has each kind of them that frames may show.

        Jobs of several stages call it before the first frame, so that it does not decide on the numbers of models.
        """

    def has_to_see(self, values: WorldValues) -> bool:
        """Return whether `skip` reads of the stage what the graph changes in `values`, those of the next frames."""
        return False

    def on_final_frame(self) -> None:  # noqa: B027 - optional
        """Called when the run ends, after the last `write`."""

    # Lifecycle

    @named_only
    def initialize(self, **kwargs: Any) -> None:
        """Run `__init__` with `kwargs`.

        Raises:
            WriterError: an argument is unknown or has no name, or a required one is missing.
        """
        check_names(type(self).__name__, type(self).__init__, kwargs)
        self.annotators, self.metadata = list(type(self).annotators), dict(type(self).metadata)
        self.num_written, self._facts, self._turn = 0, {}, object()
        self._class_file = ClassFile()  # the folder may be another one
        self.parameters = dict(kwargs)
        self.__init__(**kwargs)
        current().observations.unattached.append(type(self).__name__)

    @in_turn
    def attach(self, render_products: Any, trigger: Any = ON_FRAME) -> None:
        """Receive the frames of `render_products` (handles, paths, or a list) from now on.

        trigger: the name of Replicator's on-frame node, a trigger item, a function that returns whether to write this
            frame, or None to write only after `schedule_write()`.

        Raises:
            WriterError: there are no annotators, as before `initialize`, or one is none; `data_structure` is none.
            BadPrim: one of the render products does not exist.
        """
        if not self.annotators:
            raise WriterError(
                f"{type(self).__name__} has no annotators; call initialize(...) before attach(), with what it shall "
                "write, such as rgb=True. A writer of your own lists them in self.annotators."
            )
        check_layout(self.data_structure, type(self).__name__)
        if isinstance(self.annotators, str):
            raise WriterError(f"{type(self).__name__}: annotators is the text {self.annotators!r}; set it to a list.")
        self.annotators = [_annotator(each) for each in self.annotators]
        self._render_products = tuple(dict.fromkeys(existing_products(render_products)))
        self._numbered_products = self._render_products
        for annotator in self.annotators:
            annotator.bind(self._first_of(annotator))
        self._trigger = _checked_trigger(trigger)
        self._executions = getattr(self._trigger, "executions", None)
        if self not in current().writers:
            current().writers.append(self)
        self._class_file.attach(self)
        current().observations.add_writer(type(self).__name__, waits_for_calls=trigger is None)

    async def attach_async(self, render_products: Any, trigger: Any = ON_FRAME) -> None:
        """As `attach`."""
        self.attach(render_products, trigger)

    @in_turn
    def detach(self) -> None:
        """Receive no more frames, and forget the last payload; queued files are still written."""
        for annotator in self.get_attached_annotators():
            annotator.bind(None)
        self._render_products = ()
        self._scheduled, self._payload = False, None
        if self in current().writers:
            current().writers.remove(self)

    @in_turn
    def detach_from(self, render_products: Any) -> None:
        """Receive no more frames of `render_products`; without remaining products the writer is detached."""
        removed = render_product_paths(render_products)
        remaining = tuple(path for path in self._render_products if path not in removed)
        if not remaining:
            self.detach()
        elif remaining != self._render_products:
            self._render_products = remaining
            for annotator in self.get_attached_annotators():
                annotator.bind(self._first_of(annotator))

    def _first_of(self, annotator: Annotator) -> str | None:
        """Return the first render product of which the writer reads an annotator."""
        chosen = annotator.chosen_of(self._numbered_products)
        return next((path for path in chosen if path in self._render_products), None)

    def reset(self) -> None:
        """Restart the count of written frames at 0."""
        self.num_written = 0

    @property
    def turn(self) -> object:
        """What stands for the writer since it was initialized, from when on it numbers its files."""
        return self._turn

    def schedule_write(self) -> None:
        """Write the next captured frame regardless of the trigger."""
        self._scheduled = True

    # For the capture

    @property
    def reads_numpy(self) -> bool:
        """Whether its `write` takes NumPy arrays only, of annotators without a device: that of the project's writers.

        Other writers receive Warp arrays of what Warp kernels have augmented, as in Replicator.
        """
        owner = next(each for each in type(self).__mro__ if "write" in vars(each))
        return bool(vars(owner).get("shares_arrays"))

    @property
    def render_products(self) -> tuple[str, ...]:
        """The paths of the render products that it is attached to."""
        return self._render_products

    def annotators_of(self, render_product: str) -> list[Annotator]:
        """Return the annotators that it reads of one of its render products."""
        return [each for each in self.annotators if render_product in each.chosen_of(self._numbered_products)]

    def annotators_to_skip(self) -> list[Annotator]:
        """Return the annotators that `skip` reads, which are computed of frames that another process makes."""
        return []

    def is_due(self) -> bool:
        """Return whether its trigger selects the frame that is about to be captured."""
        if self._scheduled or self._trigger == ON_FRAME:
            return True
        if self._trigger is None:
            return False
        if callable(self._trigger):
            with called_for_script(f"the trigger of {type(self).__name__}"):
                return bool(self._trigger())
        return self._trigger.executions != self._executions

    @property
    def is_always_due(self) -> bool:
        """Whether it is due at every frame."""
        return self._trigger == ON_FRAME

    def pass_over(self) -> None:
        """Note that the frame that it is due at has been handled: given to it, or to nobody."""
        self._scheduled = False
        self._executions = getattr(self._trigger, "executions", None)

    def receive(self, payload: dict[str, Any]) -> None:
        """Write a payload, after metadata.txt if it is the first; one that fails is counted, too."""
        self.pass_over()
        self._payload = payload
        if self.num_written == 0:
            self.write_metadata()
        with counters.counted(self):
            self.write(payload)
            if self.backend is not None:
                self._class_file.update(self.backend, self.annotators)

    def receive_skipped(self, data: dict[str, Any]) -> None:
        """Count a frame that another process makes; see `skip` for `data`."""
        self.pass_over()
        self.skip(data)
        counters.advance_own(self)
        self.num_written += 1

    def receive_made(self, data: dict[str, Any]) -> None:
        """Count a frame that was made before the run goes on; what is in `kept` comes from the journal."""
        self.pass_over()
        if self.kept:
            counters.advance_unkept(self)
        else:
            self.skip(data)
            counters.advance_own(self)
        self.num_written += 1

    # Data

    @in_turn
    def get_data(self) -> dict[str, Any] | None:
        """Return the last payload; None before the first, and when it is detached."""
        current().wait_for_pictures()
        return self._payload

    def get_annotators(self) -> dict[str, Annotator]:
        """Return the annotators that it reads, by their names.

        Raises:
            AnnotatorRegistryError: it names an annotator that does not exist.
        """
        return {name: self._annotator_called(name) for name in self._names()}

    def get_attached_annotators(self) -> list[Annotator]:
        """Return its annotators while it is attached, else none."""
        return list(self.annotators) if self._render_products else []

    def get_annotator(self, name: str) -> Annotator | None:
        """Return the annotator called `name`; None if the writer reads no such annotator."""
        return self._annotator_called(name) if name in self._names() else None

    def add_annotator(self, annotator: Annotator | str, name: str | None = None) -> None:
        """Add an annotator under `name` (default: its own), replacing one of that name.

        Raises:
            AnnotatorRegistryError: there is no annotator of that name.
            WriterError: `annotator` is neither an annotator nor a name.
        """
        found = _annotator(annotator)
        found = found.copy(name) if name else found
        names = self._names()
        if found.get_name() in names:
            self.annotators[names.index(found.get_name())] = found
        else:
            self.annotators.append(found)
        found.bind(self._first_of(found))

    def augment_annotator(self, annotator_name: str, augmentation: Any, **kwargs: Any) -> None:
        """Apply `augmentation` to the array of one of the writer's annotators, which keeps its name.

        augmentation: an Augmentation, its registered name, the type of a node, or a function.
        kwargs: its arguments; see `Annotator.augment` for errors.

        Raises:
            WriterError: the writer reads no such annotator.
        """
        index = self._index_of(annotator_name)
        # A copy: the annotator may be a script's own, or shared with another writer.
        copied = self.annotators[index].copy()
        self.add_annotator(copied.augment(augmentation, name=annotator_name, **kwargs))

    def _annotator_called(self, name: str) -> Annotator:
        return self.annotators[self._index_of(name)]

    def _index_of(self, name: str) -> int:
        names = self._names()
        if name not in names:
            close = near_misses(name, names) or names
            raise WriterError(f"{type(self).__name__} reads no annotator {name!r}; it reads {', '.join(close)}.")
        index = names.index(name)
        if isinstance(self.annotators[index], str):
            self.annotators[index] = named_annotators.get(name)
        return index

    def _names(self) -> list[str]:
        return [a if isinstance(a, str) else a.get_name() for a in self.annotators]

    # Metadata

    def get_metadata(self) -> dict[str, Any]:
        """Put the content of metadata.txt into `metadata`, and return it; entries that a writer adds are kept."""
        # The colon in the key is Replicator's.
        facts = {"name": type(self).__name__, "version": self.version, "replicator_global_seed:": global_seed()}
        added = {key: value for key, value in self.metadata.items() if self._facts.get(key, self) != value}
        self._facts, self.metadata = facts, {**facts, **added}
        return dict(self.metadata)

    def write_metadata(self) -> None:
        """Schedule metadata.txt."""
        if self.backend is not None:
            # In turn, since another writer of the folder may write it, too.
            with current().io_queue.of_all_frames():
                self.backend.schedule_in_turn(METADATA, write_json, path=METADATA, data=self.get_metadata())

    def get_node(self) -> Writer:
        """Return the writer itself as an opaque handle: there is no OmniGraph node behind it.

        Raises:
            InvalidWriterError: it is not attached.
        """
        if not self._render_products:
            raise InvalidWriterError(f"{type(self).__name__} is attached to no render product, so has no node.")
        return self


def trigger_of(writer: Writer) -> Any:
    """Return what selects a writer's frames: ON_FRAME, a trigger, a function, or None for `schedule_write` alone."""
    return writer._trigger


def _annotator(annotator: Any) -> Annotator:
    found = named_annotators.get(annotator) if isinstance(annotator, str) else annotator
    if not isinstance(found, Annotator):
        raise WriterError(f"{annotator!r} is no annotator: give a name, or what annotators.get(name) returns.")
    return found


def _checked_trigger(trigger: Any) -> Any:
    if trigger is None or callable(trigger):
        return trigger
    if isinstance(trigger, str):
        if trigger.rsplit(".", 1)[-1] != ON_FRAME.rsplit(".", 1)[-1]:
            raise Unsupported(f"Writer trigger {trigger!r}: there is no OmniGraph; give a function, or {ON_FRAME!r}.")
        return ON_FRAME
    if getattr(trigger, "_trigger", trigger) is None:
        raise WriterError(f"{trigger!r} is no trigger and never fires: give what trigger.on_frame or another returns.")
    counted = getattr(trigger, "trigger", None) or getattr(trigger, "_trigger", None) or trigger
    if not hasattr(counted, "executions"):
        raise WriterError(f"{trigger!r} is no writer trigger: give a function, what trigger.on_frame returns, or None.")
    return counted

"""A job of the I/O queue: what it runs, which jobs it waits for, and how its failure reads."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from usdsdg.errors import UsdsdgError, WriterError, note_line

if TYPE_CHECKING:
    from usdsdg.parallel import Later
    from usdsdg.readback import Arrival
    from usdsdg.writers.journal.frames import FrameFiles


@dataclass(eq=False)
class Job:
    """One call, with what the queue needs to know of it."""

    run: Callable[[], None]
    what: str  # file or function, for messages
    size: int  # bytes that it keeps alive
    owner: Any
    pixels: Later | Arrival | None = None  # the images that it writes have their pixels when this has ended
    number: int = 0  # in the order of submission
    frame: int | None = None  # captured frame that it belongs to
    files: FrameFiles | None = None  # those of the frame that it belongs to
    held: FrameFiles | None = None  # those of the frame that is not whole before it ends
    turn: Hashable = None  # jobs with the same turn run one after the other; None: in any order
    after_all: bool = False  # whether it waits for all earlier jobs of its owner, and is left out if one of them fails
    blockers: int = 0  # open jobs that it waits for
    followers: list[Job] = field(default_factory=list)  # those that wait for it
    is_left_out: bool = False

    @property
    def _place(self) -> str:
        return "" if self.frame is None else f"frame {self.frame}: "

    def of(self, files: FrameFiles | None, held: FrameFiles | None) -> None:
        """Write files of a frame, or only hold one, which is not whole before `end`."""
        self.files, self.held = files, files or held
        if self.held is not None:
            self.held.hold()

    def end(self, *, failed: bool) -> None:
        """Note that it has run, or never will."""
        if self.held is not None:
            backend = getattr(self.owner, "backend", self.owner)  # a writer's, or the owner itself
            self.held.release(failed=failed, folder=getattr(backend, "output_dir", None))

    def wait_for(self, earlier: Job) -> None:
        """Run only after `earlier`, which has not ended."""
        earlier.followers.append(self)
        self.blockers += 1

    def failure(self) -> UsdsdgError | None:
        """Run the call, and return its error, if any, with the frame and the file in its message."""
        try:
            if self.pixels is not None:
                self.pixels.wait()
        except Exception as error:  # noqa: BLE001 - raised again by the thread that waits
            # Each file has an error of its own, since the message of each names another file.
            failure = WriterError(f"{self._place}{self.what} could not be written, since its image failed: {error}")
            failure.__cause__ = error
            return failure
        try:
            self.run()
        except Exception as error:  # noqa: BLE001 - raised again by the thread that waits
            return self.failed(error)
        return None

    def failed(self, error: BaseException) -> UsdsdgError:
        """Return the failure that an error of the call is."""
        if isinstance(error, UsdsdgError):
            error.args = (f"{self._place}{error}", *error.args[1:])
            return error
        failure = WriterError(f"{self._place}{self.what} could not be written: {type(error).__name__}: {error}")
        failure.__cause__ = error
        note_line(failure, error)  # as of a function that a writer of a script has scheduled
        return failure

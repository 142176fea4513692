"""Output of captured frames: payloads for writers, and waiting for the queue of files."""

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from usdsdg.annotators.frame import Frame
from usdsdg.annotators.payload import build_payload
from usdsdg.capture.graph_outputs import graph_outputs
from usdsdg.capture.records.frames import FrameRecords, folder_of
from usdsdg.capture.records.stages import StageMoment
from usdsdg.capture.requests import Requests, Skipped
from usdsdg.errors import called_for_script, watch_foreign
from usdsdg.session.progress import report, say_once
from usdsdg.session.render_products import products
from usdsdg.session.session import current
from usdsdg.writers import counters
from usdsdg.writers.base import Writer, attached_writers
from usdsdg.writers.journal.run import get_run

# Interval at which `drain` polls the queue of files.
DRAIN_SECONDS = 0.02


class WriterOutput:
    """Passes frames to writers, and reports once the output folder of each."""

    def __init__(self) -> None:
        self._reported: set[tuple[str, str]] = set()
        self._records = FrameRecords()

    def payload(self, writer: Writer, frames: Mapping[str, Frame]) -> dict[str, Any] | None:
        """Return the payload of a writer's frames, and have on the host what their record needs; None without frames.

        frames: by product path.
        """
        attached = _attached(writer, frames)
        if not attached:
            return None
        self._report_folder(writer)
        payload = build_payload(writer, attached, **graph_outputs())
        self._records.fetch(writer, attached)
        return payload

    def write(
        self,
        writer: Writer,
        payload: dict[str, Any] | None,
        frames: Mapping[str, Frame],
        requests: Requests,
        moment: StageMoment | None,
    ) -> None:
        """Pass a writer the `payload` of its frames, and record them; `frames` is by product path.

        moment: the stage at this frame, for the record.
        """
        attached = _attached(writer, frames)
        key, folder = requests.keys[id(writer)]
        if payload is not None:
            number, frame = writer.num_written, next(iter(attached.values())).index
            amodal = {path: requests.requirements(path).amodal_masks for path in attached}
            with current().io_queue.frame(
                frame, pixels=current().tracing, files=requests.files, copies_arguments=not writer.shares_arrays
            ) as files:
                try:
                    writer.receive(payload)
                except Exception as error:
                    error.add_note(
                        f"(raised when {type(writer).__name__} was handed frame {frame}{_keys_of(payload, error)})"
                    )
                    if requests.files is not None and folder is not None:
                        said = f"{type(writer).__name__}: {type(error).__name__}: {error}"
                        requests.files.why.setdefault(folder, said)
                    watch_foreign(error)
                    raise
                finally:  # also of a frame that fails, which is counted
                    if writer.kept and requests.files is not None and folder is not None:
                        requests.files.keep(folder, key, counters.kept_of(writer))
                self._records.write(writer, attached, moment, number=number, files=tuple(files), amodal=amodal)
        if requests.files is not None and folder is not None:
            requests.files.arrive(folder)

    def miss(self, writer: Writer) -> None:
        """Let a writer count a frame that it was not handed, as handing over was interrupted."""
        writer.pass_over()
        counters.count(writer)

    def skip(self, skipped: Skipped, frames: Mapping[str, Frame]) -> None:
        """Tell a writer of a frame whose files it need not make, so that it counts it.

        frames: by product path, of those that were rendered nevertheless.
        """
        writer = skipped.writer
        enabled = {product.path for product in products() if product.updates_enabled}
        shown = {path: path.rsplit("/", 1)[-1] for path in writer.render_products if path in enabled}
        if not shown:
            return
        read = writer.annotators_to_skip() if not skipped.is_made else []
        seen = {
            name: {each.get_name(): each.compute(frames[path]).flat() for each in read} for path, name in shown.items()
        }
        receive = writer.receive_made if skipped.is_made else writer.receive_skipped
        receive({**graph_outputs(), "renderProducts": seen})
        if skipped.is_made:  # after the last one the run may be over, and the writer makes files about all frames
            counters.restore(writer, get_run().take_kept(skipped.folder, skipped.key, skipped.number + 1))

    def _report_folder(self, writer: Writer) -> None:
        name, folder = type(writer).__name__, getattr(writer.backend, "output_dir", None)
        if get_run().scratch is not None:
            return  # a temporary folder, in which frames are made again
        if folder is not None and (name, folder) not in self._reported:
            self._reported.add((name, folder))
            say_once(f"{name} writes to {folder}")


def _keys_of(payload: Mapping[str, Any], error: Exception) -> str:
    """Return which keys a payload has, where an error is about one that it has not; else ""."""
    is_unknown = isinstance(error, KeyError) and error.args and error.args[0] not in payload
    return f", whose data have the keys {', '.join(map(repr, payload))}" if is_unknown else ""


def _attached(writer: Writer, frames: Mapping[str, Frame]) -> dict[str, Frame]:
    return {path: frames[path] for path in writer.render_products if path in frames}


def append_to_journals() -> None:
    """Let the queue append frames that are whole to the journals of their folders, if it is time."""
    run = get_run()
    if run.is_due():
        run.follow_moved(in_use={folder_of(each) for each in attached_writers()})
        current().io_queue.submit(run.append, what="the journal", size=0, owner=run, turn="journal")


def drain() -> None:
    """Wait until every file has been written; raises the first failure."""
    queue = current().io_queue
    first = waiting = queue.open_jobs()
    while waiting:
        report("files written", first - waiting, first)
        time.sleep(DRAIN_SECONDS)
        waiting = queue.open_jobs()
    if first:
        report("files written", first, first)
    queue.wait_until_done()
    if (renderer := current().engines.renderer) is not None:
        renderer.finish()


def close_writers() -> None:
    """Notify every writer that the last frame has been written, and wait for the files that it then writes.

    Raises:
        the first failure, after all writers were notified.
    """
    if current().tap is not None:
        return  # they were given no frame
    told = [partial(_end, writer) for writer in attached_writers() if not _would_lose_frames(writer)]
    in_spite_of_failures(*told, current().io_queue.wait_until_done)


def _end(writer: Writer) -> None:
    with called_for_script(f"at the last frame of {type(writer).__name__}"):
        writer.on_final_frame()


def _would_lose_frames(writer: Writer) -> bool:
    """Whether files about all frames of a script's own writer would lack frames that are there.

    So it is where going on with a dataset ends early, as by Ctrl-C. Those of the project's writers have all frames.
    """
    owner = next(each for each in type(writer).__mro__ if "on_final_frame" in vars(each))
    folder = folder_of(writer) if owner.__module__.partition(".")[0] != "usdsdg" else None
    return folder is not None and get_run().is_behind(folder)


def _of_other_causes(errors: list[Exception]) -> list[Exception]:
    """Return the errors after the first one that have causes of their own."""
    first = getattr(errors[0], "cause", "")
    return [each for each in errors[1:] if not first or getattr(each, "cause", "") != first]


def in_spite_of_failures(*steps: Callable[[], None]) -> None:
    """Run all steps, then raise the first error."""
    errors = []
    for step in steps:
        try:
            step()
        except Exception as error:  # noqa: BLE001 - the first one is raised, and it tells of the others
            errors.append(error)
    if errors:
        for other in _of_other_causes(errors):
            errors[0].add_note(f"(then {type(other).__name__}: {other})")
        raise errors[0]

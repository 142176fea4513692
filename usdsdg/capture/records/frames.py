"""Records of captured frames, written beside each writer's files from the AOVs that its annotators read."""

from __future__ import annotations

import functools
import os
import weakref
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.class_table import ClassTable, ids_are_stable
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.keypoints import NAME as KEYPOINTS_ANNOTATOR
from usdsdg.annotators.kinds.keypoints import PRIMS as KEYPOINTS
from usdsdg.annotators.pixels.look_ups import PIXELS
from usdsdg.annotators.selection import Selection
from usdsdg.capture.records.pictures import pictures_of
from usdsdg.capture.records.stages import StageMoment
from usdsdg.capture.tiles import views_of
from usdsdg.graph.sampling import get_global_seed
from usdsdg.record import FRAMES, frame_record
from usdsdg.record.frame_record import FrameRecord, KeypointRecord, ProductRecord, SelectionRecord
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.assets import anchors
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg.stage.poses.transforms import up_axis
from usdsdg.stores.whole_file import write_whole_with_hash
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import BackendGroup
from usdsdg.writers.base import Writer, attached_writers
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.spool import place_of

SETTING = "/usdsdg/labels/record"
# Parameters of writers that say where files go, on which their content must not depend.
_PLACES = ("output_dir", "backend", "s3_bucket", "s3_region", "s3_endpoint", "s3_endpoint_url", "use_s3")


def is_on() -> bool:
    """Return whether frames are recorded."""
    return get_settings().get_as_bool(SETTING)


def sink_of(writer: Writer) -> BaseBackend | None:
    """Return where a writer's record goes: its backend, or the folder that it writes to itself; None: nowhere."""
    for name in ("backend", "_backend"):
        backend = getattr(writer, name, None)
        if isinstance(backend, BaseBackend):
            return backend if _can_write(backend) else None
    for name in ("output_dir", "_output_dir"):
        folder = getattr(writer, name, None)
        if isinstance(folder, (str, os.PathLike)) and os.path.isdir(folder):
            return _Folder(Path(folder))
    return None


def folder_of(writer: Writer) -> str | None:
    """Return the folder or URL that a writer writes to; None if there is none, or it is not known."""
    backend = sink_of(writer)
    if isinstance(backend, _Folder):
        return backend.output_dir
    return place_of(backend) if backend is not None else None


class FrameRecords:
    """Writes the records of all writers."""

    def __init__(self) -> None:
        # By id the backends, or writers without one, that a place has the file of a stage of.
        self._stages: dict[tuple[int, str, str], weakref.ref[Any]] = {}

    def fetch(self, writer: Writer, frames: Mapping[str, Frame]) -> None:
        """Copy the AOVs that the record of a writer's frames needs from the GPU; `write` finds them on the host."""
        if is_on() and sink_of(writer) is not None:
            for frame in frames.values():
                frame.hosted()

    def write(
        self,
        writer: Writer,
        frames: Mapping[str, Frame],
        moment: StageMoment | None,
        *,
        number: int,
        files: Sequence[str],
        amodal: Mapping[str, bool],
    ) -> None:
        """Schedule the record of a frame that a writer has received.

        moment: the stage at that frame; None: it is not recorded.

        frames: by product path. number: how many frames it had received before. files: those that it scheduled.
        amodal: by product path, whether amodal masks were rendered.
        """
        backend = sink_of(writer) if is_on() else None
        if backend is None:
            return
        facts: dict[str, Any] = {
            "number": number,
            "writer": type(writer).__name__,
            "writer_version": str(writer.version),
            "parameters": anchors.portable_value(
                {name: value for name, value in writer.parameters.items() if name not in _PLACES}
            ),
            "annotators": anchors.portable_value(_annotators(writer, frames)),
            "files": tuple(_relative(files, backend)),
            "seed": get_global_seed(),
            "up_axis": up_axis(current_stage()),
            "stable_ids": ids_are_stable(),
            "semantic_classes": _given_classes(),
        }
        if moment is not None:
            facts["stage"] = {"file": moment.base, **moment.facts}
            self._write_stage(writer if isinstance(backend, _Folder) else backend, backend, moment)
        content = _Content(facts, tuple(frames.values()), dict(amodal), moment)
        # The arrays are given to the queue, which bounds the memory of what waits.
        arrays = [frame.aovs for frame in content.frames]
        backend.schedule(_put, path=self._path(writer, backend, number), content=content, arrays=arrays)

    def _write_stage(self, owner: object, backend: BaseBackend, moment: StageMoment) -> None:
        """Schedule the file of the stage, once for each backend, or writer without one, that owns the records."""
        key = (id(owner), _place_of(backend), moment.base)
        if key not in self._stages or self._stages[key]() is not owner:  # of one that is gone, which had its id
            self._stages[key] = weakref.ref(owner)
            with current().io_queue.of_all_frames():
                backend.schedule(_put_bytes, path=moment.base, data=moment.content)

    def _path(self, writer: Writer, backend: BaseBackend, number: int) -> str:
        # Writers that share a folder count their frames alike, so all but the first have names of their own. The first
        # is the one that was attached first: which of them writes first differs from part to part.
        key = _place_of(backend)
        owners = [each for each in attached_writers() if (own := sink_of(each)) is not None and _place_of(own) == key]
        place = owners.index(writer) if writer in owners else 0
        return f"{FRAMES}/{f'{type(writer).__name__}-{place}-' if place else ''}{number:06d}.npz"


class _Folder(BaseBackend):
    """The folder of a writer that has no backend."""

    def __init__(self, folder: Path) -> None:
        self.output_dir = str(folder)

    def write_blob(self, path: str, data: bytes) -> None:
        facts = write_whole_with_hash(Path(self.output_dir) / path, [data])
        get_run().note(self.output_dir, path, facts, current().io_queue.files_in_hand())


class _Content:
    """The bytes of a record, made once, on the thread that writes them first."""

    def __init__(
        self,
        facts: Mapping[str, Any],
        frames: tuple[Frame, ...],
        amodal: Mapping[str, bool],
        moment: StageMoment | None,
    ) -> None:
        self._facts, self._amodal, self._moment = facts, amodal, moment
        self.frames = tuple(frame.hosted() for frame in frames)
        # Now, since other writers may read them while this waits for its thread.
        self._keypoints = [frame.memo.get(KEYPOINTS, ()) for frame in frames]

    @functools.cached_property
    def data(self) -> bytes:
        first = self.frames[0]
        numerator, denominator = first.reference_time
        filters = [
            tuple(dict.fromkeys(str(each["filter"] or "") for each in self._facts["annotators"].values())) or ("",)
        ] * len(self.frames)
        products = tuple(
            product_record(frame, chosen, amodal=self._amodal.get(frame.render_product, False), keypoints=keypoints)
            for frame, chosen, keypoints in zip(self.frames, filters, self._keypoints)
        )
        edits = self._moment.layer if self._moment is not None and self._moment.edits else b""
        moment = {"seconds": numerator / denominator, "capture": first.index, "edits": edits}
        return frame_record.encode(FrameRecord(**self._facts, **moment, products=products))


def note_keypoints(frame: Frame, annotators: Iterable[Annotator]) -> None:
    """Read the keypoints of a frame for its records, where annotators would have that are not computed."""
    if any(each.template_name == KEYPOINTS_ANNOTATOR for each in annotators):
        frame.derive(KEYPOINTS, frame.labeled_prims.read_keypoints)


def _put(path: str, content: _Content, arrays: Any, backend_instance: BaseBackend) -> None:
    backend_instance.write_blob(path, content.data)


def _put_bytes(path: str, data: bytes, backend_instance: BaseBackend) -> None:
    backend_instance.write_blob(path, data)


def product_record(
    frame: Frame, filters: tuple[str, ...], *, amodal: bool, keypoints: Iterable[Any] = ()
) -> ProductRecord:
    """Return the record of one product's frame, with the selections of these label filters ("": every label passes).

    keypoints: the prims that have any, as annotators have read them.
    """
    view, pictures = frame.view, pictures_of(frame)
    visible = pictures.visible
    selections = {key: frame.selection(key or None) for key in filters}
    rows = _rows_in_view(frame, selections, visible)
    place = np.full(len(frame.labeled_prims) + 1, -1, np.int64)
    place[rows] = np.arange(len(rows))
    recorded = {}
    for key, selection in selections.items():
        kept = np.flatnonzero(place[selection.rows] >= 0)
        member = np.full(len(selection) + 1, -1, np.int64)
        member[kept] = np.arange(len(kept))
        recorded[key] = SelectionRecord(
            place[selection.rows[kept]], selection.ids[kept], selection.class_ids[kept],
            tuple(selection.labels[index] for index in kept), member[selection.member_of_gprim[visible]],
        )  # fmt: skip
    labeled = frame.labeled_prims
    return ProductRecord(
        name=frame.render_product.rsplit("/", 1)[-1],
        path=frame.render_product,
        size=(view.width, view.height),
        cameras=views_of(view),
        columns=view.columns if isinstance(view, TiledView) else 1,
        gprims=tuple(frame.gprims[index] for index in visible),
        prims=tuple(labeled.prim_paths[row] for row in rows),
        labels=tuple({kind: list(own) for kind, own in labeled.labels[row].items()} for row in rows),
        bounds=labeled.bounds[rows],
        local_to_world=labeled.local_to_world[rows],
        amodal=frame.coverage[rows] if amodal else None,
        selections=recorded,
        runs=pictures.runs,
        depth=pictures.depth,
        normals=pictures.normals,
        keypoints=tuple(_keypoints(frame, selections, keypoints)),
        thumbnail=pictures.thumbnail,
        checksums=pictures.checksums,
    )


def _keypoints(frame: Frame, selections: Mapping[str, Selection], read: Iterable[Any]) -> Iterator[KeypointRecord]:
    """Yield the keypoints that annotators have read."""
    paths = frame.labeled_prims.prim_paths
    selected = {key: {paths[row] for row in each.rows.tolist()} for key, each in selections.items()}
    for prim in read:
        above = {key: next((name for name in prim.ancestors if name in own), None) for key, own in selected.items()}
        owners = {key: name for key, name in above.items() if name is not None}
        yield KeypointRecord(owners, prim.keypoints, prim.positions)


def _rows_in_view(frame: Frame, selections: Mapping[str, Any], visible: np.ndarray) -> np.ndarray:
    """Return the rows of labeled prims of which any pixel is visible, or would be if they were alone."""
    in_view = frame.coverage[:, PIXELS] > 0
    for selection in selections.values():
        members = selection.member_of_gprim[visible]
        in_view[selection.rows[members[members >= 0]]] = True
    return np.flatnonzero(in_view)


def _given_classes() -> dict[str, int]:
    """Return the ids of the classes that the user has fixed."""
    return {row["name"]: row["id"] for row in ClassTable(current().class_tables.given).listed()}


def _annotators(writer: Writer, frames: Mapping[str, Frame]) -> dict[str, dict[str, Any]]:
    """Return what a writer reads, by name."""
    found = {}
    for path in frames:
        for annotator in writer.annotators_of(path):
            found[annotator.get_name()] = {
                "template": annotator.template_name,
                "filter": annotator.label_filter,
                "params": annotator.parameters,
                "augmentations": annotator.augmentations,
            }
    return found


def _can_write(backend: BaseBackend) -> bool:
    if isinstance(backend, BackendGroup):
        return all(map(_can_write, backend.backends))
    return type(backend).write_blob is not BaseBackend.write_blob


def _place_of(backend: BaseBackend) -> str:
    return _folder_of(backend) or str(id(backend))


def _folder_of(backend: BaseBackend) -> str:
    try:
        return str(getattr(backend, "output_dir", ""))
    except Exception:  # noqa: BLE001 - a group without a folder says so with an error
        return ""


def _relative(files: Sequence[str], backend: BaseBackend) -> list[str]:
    """Return paths below the backend's folder, each once."""
    folder = _folder_of(backend)
    inside = [os.path.relpath(path, folder) if os.path.isabs(path) and folder else path for path in files]
    return list(dict.fromkeys(inside))

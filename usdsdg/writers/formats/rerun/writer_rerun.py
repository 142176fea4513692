"""RerunWriter: recordings for the Rerun viewer, a file for each frame."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from usdsdg.annotators import named_annotators
from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses.transforms import up_axis
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import BlobSink, checked_padding, write_bytes
from usdsdg.writers.formats.rerun.rerun_chunks import Moment, chunks, rrd_bytes
from usdsdg.writers.formats.rerun.rerun_entities import BOXES_2D, BOXES_3D, CAMERA, DEPTH, MASKS, RGB, entities
from usdsdg.writers.formats.rerun.rerun_extra import rerun
from usdsdg.writers.global_seed import global_seed
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.options import typed

_FORMATS = ("png", "jpeg")


@runtime_checkable  # options are checked
class ChunkSink(Protocol):
    """What takes the chunks of a frame in place of files."""

    def send(self, made: list[Any]) -> None: ...


class RerunWriter(Writer):
    """Writes `frame_NNNN.rrd` for each frame; `rerun DIR/*.rrd` shows them as one recording over the timelines `frame`
    and `time`.

    Of each render product: `/world/<name>` with the pose of the camera and its pinhole, and below it rgb,
    distance_to_image_plane [m], instance_segmentation, semantic_segmentation and bounding_box_2d_tight. Of the stage:
    `/world/objects/<prim path>` with the pose of each labeled prim and its box, in meters; `/draws/<name>` with the
    values of named distributions. What is logged, and its ids, repeat; the bytes of the files do not, since Rerun
    orders metadata at random. Needs `usdsdg[rerun]`.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        rgb: bool = True,
        distance_to_image_plane: bool = True,
        instance_segmentation: bool = True,
        semantic_segmentation: bool = False,
        bounding_box_2d_tight: bool = True,
        bounding_box_3d: bool = True,
        image_output_format: str = "png",
        frame_padding: int = 4,
        *,
        sink: ChunkSink | None = None,
        backend: BaseBackend | None = None,
    ) -> None:
        """
        rgb, distance_to_image_plane, instance_segmentation, semantic_segmentation, bounding_box_2d_tight,
        bounding_box_3d: whether it is logged.
        image_output_format: of pictures: "png", which has them exactly, or "jpeg".
        frame_padding: digits of the numbers in names of files.
        sink: takes the chunks (`rerun.chunk.Chunk`) of each frame by `send(chunks)`, in place of files.

        Raises:
            Unsupported: Rerun is not installed.
            WriterError: a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir cannot be written to.
        """
        rerun()
        if image_output_format not in _FORMATS:
            raise WriterError(f"RerunWriter: image_output_format is {image_output_format!r}; expected png or jpeg.")
        self._image_format, self._padding = image_output_format, checked_padding(frame_padding)
        self._sink = sink
        self.backend = make_backend("RerunWriter", output_dir, backend) if sink is None else None
        self._frame_id = 0
        wanted = {
            RGB: rgb, DEPTH: distance_to_image_plane, MASKS[0]: instance_segmentation, MASKS[1]: semantic_segmentation,
            BOXES_2D: bounding_box_2d_tight, BOXES_3D: bounding_box_3d,
        }  # fmt: skip
        self.annotators = [named_annotators.get(name) for name in (CAMERA, *(each for each in wanted if wanted[each]))]

    def write(self, data: dict[str, Any]) -> None:
        ticks, rate = data["reference_time"]
        frame = {
            "products": data["renderProducts"],
            "draws": data["distribution_outputs"],
            "moment": Moment(self._frame_id, ticks / rate),
            "up": up_axis(current_stage()),
            "image_format": self._image_format,
        }
        if self._sink is not None:
            current().wait_for_pictures()
            self._sink.send(chunks(list(entities(**frame))))
        else:
            assert self.backend is not None
            path = f"frame_{self._frame_id:0{self._padding}}.rrd"
            recording = recording_id(getattr(self.backend, "output_dir", ""))
            self.backend.schedule(_write_frame, path=path, data=frame, recording=recording)
        self._frame_id += 1


def recording_id(place: str) -> str:
    """Return an id that all processes that make frames of a run have: of its script, its arguments and its seed.

    place: the output folder, which does not count.
    """
    recipe = get_run().recipe
    facts = recipe.of(place) if recipe is not None else None
    known = [facts.source, facts.arguments, facts.options] if facts is not None else []
    text = json.dumps([*known, global_seed()], sort_keys=True, default=str)
    return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


def _write_frame(path: str, data: Mapping[str, Any], recording: str, backend_instance: BlobSink) -> None:
    write_bytes(path, rrd_bytes(chunks(list(entities(**data))), recording), backend_instance)

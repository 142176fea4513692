"""CosmosWriter: clips of colour, edges, depth and segmentation, as Cosmos Transfer takes them."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.errors import WriterError, warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.image_files.motion_jpeg import encode_frame, encode_video
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import BackendGroup, make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import write_image
from usdsdg.writers.options import typed

MODALITIES = ("rgb", "shaded_seg", "segmentation", "depth", "edges")


class CosmosWriter(Writer):
    """Writes `clip_NNNN/<modality>/<modality>_NNNN.png` and, when a clip ends, `clip_NNNN/<modality>.mp4`; below
    `<product>/` with several render products. The modalities are

    - rgb: the picture;
    - segmentation: things in different colours; shaded_seg: in pale ones and lit, so that their shape shows;
    - edges: Canny's edges of shaded_seg; depth: grey, from white at 0.1 m to black at 100 m, on a logarithmic scale.

    A clip ends with the run, with `next_clip()`, or when a `trigger.on_time` fires again. A video has the rate of the
    stage's time codes. It is Motion JPEG, which FFmpeg and what is built on it read; Replicator's is H.264. A backend
    that cannot read blobs gets no videos.
    """

    version = "0.0.2"
    data_structure = "renderProduct"
    shares_arrays = True

    @typed
    def __init__(
        self,
        backend: BaseBackend | None = None,
        output_dir: str | os.PathLike | None = None,
        segmentation_mapping: dict | None = None,
        use_instance_id: bool = True,
        canny_threshold_low: int = 10,
        canny_threshold_high: int = 100,
    ) -> None:
        """
        output_dir: a folder, where there is no backend.
        segmentation_mapping: colours (r, g, b, a), or ids, by label or "type:label"; then pixels of one label have one
            colour, and use_instance_id changes nothing.
        use_instance_id: tell gprims apart, labelled or not; False tells labelled things apart.
        canny_threshold_low, canny_threshold_high: gradients from which on a pixel may be an edge, and is one.

        Raises:
            WriterError: there is nowhere to write, or the mapping has another value.
            OutputNotWritable: output_dir cannot be written to.
        """
        self.backend = make_backend("CosmosWriter", None if backend else output_dir, backend)
        mapping = _by_semantics(segmentation_mapping) if segmentation_mapping else None
        if mapping:
            shaded, flat = "shaded_semantic_segmentation", "semantic_segmentation"
        elif use_instance_id:
            shaded, flat = "shaded_instance_id_segmentation", "instance_id_segmentation_fast"
        else:
            shaded, flat = "shaded_instance_segmentation", "instance_segmentation"
        colors = {"useCandyColours": False, "mapping": mapping} if mapping else {}
        thresholds = {"thresholdLow": canny_threshold_low, "thresholdHigh": canny_threshold_high}
        self.annotators = [
            named_annotators.get("rgb"),
            named_annotators.get(shaded, colors).copy("shaded_seg"),
            named_annotators.get(flat, {"colorize": True, "mapping": mapping}).copy("segmentation"),
            named_annotators.get("distance_to_camera").augment("ColorizeDepth", name="depth"),
            named_annotators.get(shaded).augment("Canny", name="edges", **thresholds),
        ]
        self._clip, self._frame_id = 0, 0
        self._in_videos = 0  # frames of the clip that its videos have
        # Of the clip in hand, by the folder of each video: size and number of its pictures.
        self._videos: dict[str, tuple[tuple[int, int], list[str]]] = {}

    def write(self, data: dict[str, Any]) -> None:
        fired = _times_fired(data.get("trigger_outputs") or {})
        if fired is not None and fired != self._clip:
            self.next_clip()
            self._clip = fired
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        for product, seen in data["renderProducts"].items():
            self._write_product(f"{product}/" if several else "", seen)
        self._frame_id += 1

    def on_final_frame(self) -> None:
        """Write the videos of the clip so far, unless they have been."""
        backend = self.backend
        assert backend is not None
        if self._frame_id == self._in_videos:
            return
        self._in_videos = self._frame_id
        if not _reads(backend):
            warn_once(f"CosmosWriter: {backend.get_name()} has no read_blob, so there are pictures and no videos.")
            return
        backend.wait_until_done()
        rate = float(current_stage().GetTimeCodesPerSecond())
        for path, (size, pictures) in self._videos.items():
            backend.schedule(_write_video, path=path, pictures=list(pictures), size=size, rate=rate)

    def detach(self) -> None:
        super().detach()
        if self.backend is not None:
            self.on_final_frame()

    def next_clip(self) -> None:
        """End the clip, with its videos; what is captured from now on is another one's, from frame 0 on."""
        self.on_final_frame()
        self._videos = {}
        self._clip, self._frame_id, self._in_videos = self._clip + 1, 0, 0

    def _write_product(self, root: str, seen: Mapping[str, Any]) -> None:
        clip = f"{root}clip_{self._clip:04d}"
        steps = []
        for modality in MODALITIES:
            picture = seen[modality]["data"]
            path = f"{clip}/{modality}/{modality}_{self._frame_id:04d}.png"
            steps.append(partial(write_image, path=path, data=picture))
            size = (picture.shape[1], picture.shape[0])
            self._videos.setdefault(f"{clip}/{modality}.mp4", (size, []))[1].append(path)
        assert self.backend is not None
        self.backend.schedule_together(steps)


def _by_semantics(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """The mapping with "type:label" keys; those without a type are classes."""
    for label, value in mapping.items():
        is_color = isinstance(value, (list, tuple)) and len(value) == 4 and all(isinstance(part, int) for part in value)
        if not is_color and not isinstance(value, int):
            raise WriterError(
                f"CosmosWriter: segmentation_mapping[{label!r}] is {value!r}; expected a colour (r, g, b, a) or an id."
            )
    return {label if ":" in label else f"class:{label}": value for label, value in mapping.items()}


def _times_fired(trigger_outputs: Mapping[str, Any]) -> int | None:
    """How often the first on_time trigger has fired; None without one."""
    return next((count for name, count in trigger_outputs.items() if "on_time" in name), None)


def _reads(backend: BaseBackend) -> bool:
    if isinstance(backend, BackendGroup):
        return all(map(_reads, backend.backends))
    return type(backend).read_blob is not BaseBackend.read_blob


def _write_video(
    path: str, pictures: Sequence[str], size: tuple[int, int], rate: float, backend_instance: BaseBackend
) -> None:
    """The video of pictures that the backend has."""
    from PIL import Image

    frames = (np.asarray(Image.open(io.BytesIO(backend_instance.read_blob(picture)))) for picture in pictures)
    backend_instance.write_blob(path, encode_video([encode_frame(frame) for frame in frames], size, rate))

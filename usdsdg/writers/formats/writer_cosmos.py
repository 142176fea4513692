"""CosmosWriter: clips of color, edges, depth and segmentation for Cosmos Transfer."""

import io
import os
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.packed_colors import unpacked
from usdsdg.errors import WriterError, warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.image_files.motion_jpeg import Video, encode_frame
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import BackendGroup, make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import write_image
from usdsdg.writers.options import typed
from usdsdg.writers.spool import Records, Spool

MODALITIES = ("rgb", "shaded_seg", "segmentation", "depth", "edges")


class CosmosWriter(Writer):
    """Writes `clip_NNNN/<modality>/<modality>_NNNN.png` and, when a clip ends, `clip_NNNN/<modality>.mp4`; below
    `<product>/` with several render products. The modalities are

    - rgb: color;
    - segmentation: ids in different colors; shaded_seg: in pastel colors, shaded;
    - edges: Canny edges of shaded_seg; depth: gray, from white at 0.1 m to black at 100 m, on a logarithmic scale.

    A clip ends with the run, with `next_clip()`, or when a `trigger.on_time` fires again. The frame rate of videos is
    the stage's time codes per second. They are Motion JPEG, which FFmpeg-based programs read; Replicator's are H.264.
    A backend that cannot read blobs gets no videos.
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
        output_dir: a folder, used without a backend.
        segmentation_mapping: colors (r, g, b, a), or ids, by label or "type:label"; then all pixels of a label have the
            same color, and use_instance_id is ignored.
        use_instance_id: segment gprims, labeled or not; False segments labeled prims.
        canny_threshold_low, canny_threshold_high: gradients of weak and strong edges.

        Raises:
            WriterError: there is nowhere to write, or the mapping has an invalid value.
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
        self._in_videos = 0  # number of frames in the written videos of the clip
        self._pictures = self._new_clip()
        self._sizes: dict[str, tuple[int, int]] = {}  # of the pictures of the clip, by folder of a render product

    def write(self, data: dict[str, Any]) -> None:
        fired = _times_fired(data.get("trigger_outputs") or {})
        if fired is not None and fired != self._clip:
            self.next_clip()
            self._clip = fired
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        roots = [f"{product}/" if several else "" for product in data["renderProducts"]]
        for root, seen in zip(roots, data["renderProducts"].values()):
            self._write_product(root, seen)
        rate = float(current_stage().GetTimeCodesPerSecond())
        self._pictures.note({"clip": self._clip, "rate": rate, "sizes": self._sizes})
        self._pictures.append(self.num_written, {"number": self._frame_id, "roots": roots})
        self._frame_id += 1

    def on_final_frame(self) -> None:
        """Write the videos of the clip so far, if there are new frames."""
        backend = self.backend
        assert backend is not None
        if self._frame_id == self._in_videos:
            return
        self._in_videos = self._frame_id
        if not _can_read(backend):
            warn_once(f"CosmosWriter: {backend.get_name()} has no read_blob, so only images are written, no videos.")
            return
        for root in self._sizes:
            for modality in MODALITIES:
                path = f"{root}clip_{self._clip:04d}/{modality}.mp4"
                records = self._pictures.so_far()
                backend.schedule_after_all(_write_video, path=path, records=records, root=root, modality=modality)

    def detach(self) -> None:
        super().detach()
        if self.backend is not None:
            self.on_final_frame()

    def next_clip(self) -> None:
        """End the clip and write its videos; later frames belong to a new clip, which starts at frame 0."""
        self.on_final_frame()
        self._clip, self._frame_id, self._in_videos = self._clip + 1, 0, 0
        self._pictures, self._sizes = self._new_clip(), {}

    def _new_clip(self) -> Spool:
        """Return the spool of the clip's pictures.

        A record has the "number" of a frame in the clip, and the folders of its render products in "roots"; "clip",
        "rate" and the "sizes" of pictures by folder are known of all frames.
        """
        assert self.backend is not None
        return Spool(self.backend, f"CosmosWriter/clip_{self._clip:04d}")

    def _write_product(self, root: str, seen: Mapping[str, Any]) -> None:
        steps = []
        for modality in MODALITIES:
            image = unpacked(seen[modality]) if modality == "segmentation" else seen[modality]["data"]
            path = _picture_path(root, self._clip, modality, self._frame_id)
            steps.append(partial(write_image, path=path, data=image))
            self._sizes.setdefault(root, (image.shape[1], image.shape[0]))
        assert self.backend is not None
        self.backend.schedule_together(steps)


def _by_semantics(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Return the mapping with "type:label" keys; labels without a type get the type "class"."""
    for label, value in mapping.items():
        is_color = isinstance(value, (list, tuple)) and len(value) == 4 and all(isinstance(part, int) for part in value)
        if not is_color and not isinstance(value, int):
            raise WriterError(
                f"CosmosWriter: segmentation_mapping[{label!r}] is {value!r}; expected a color (r, g, b, a) or an id."
            )
    return {label if ":" in label else f"class:{label}": value for label, value in mapping.items()}


def _times_fired(trigger_outputs: Mapping[str, Any]) -> int | None:
    """Return how often the first on_time trigger has fired; None without one."""
    return next((count for name, count in trigger_outputs.items() if "on_time" in name), None)


def _can_read(backend: BaseBackend) -> bool:
    if isinstance(backend, BackendGroup):
        return all(map(_can_read, backend.backends))
    return type(backend).read_blob is not BaseBackend.read_blob


def _picture_path(root: str, clip: int, modality: str, number: int) -> str:
    """Return the file of a picture. root: folder of the render product, with a slash, or ""."""
    return f"{root}clip_{clip:04d}/{modality}/{modality}_{number:04d}.png"


def _write_video(path: str, records: Records, root: str, modality: str, backend_instance: BaseBackend) -> None:
    """Write the video of a clip's pictures, which the backend has stored; one is in memory at a time."""
    width, height = records.about["sizes"][root]
    video = Video((width, height), records.about["rate"])
    for picture in _pictures(records, root, modality, backend_instance):
        video.append(encode_frame(picture))
    backend_instance.write_chunks(path, video)


def _pictures(records: Records, root: str, modality: str, backend: BaseBackend) -> Iterator[np.ndarray]:
    from PIL import Image

    for each in records:
        if root in each["roots"]:
            path = _picture_path(root, records.about["clip"], modality, each["number"])
            yield np.asarray(Image.open(io.BytesIO(backend.read_blob(path))))

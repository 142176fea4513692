"""CosmosWriter: clips of color, edges, depth and segmentation for Cosmos Transfer."""

import os
from collections.abc import Mapping
from functools import partial
from typing import Any

from usdsdg.annotators import named_annotators
from usdsdg.annotators.packed_colors import unpacked
from usdsdg.errors import WriterError
from usdsdg.session.stage_context import current_stage
from usdsdg.writers.aggregate_writer import AggregateWriter
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.files import write_image
from usdsdg.writers.formats.cosmos.clips import MODALITIES, Clip, picture_of
from usdsdg.writers.options import typed


class CosmosWriter(AggregateWriter):
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
        self.backend = make_backend("CosmosWriter", None if backend else output_dir, backend)
        self._clip = self._frame_id = 0
        self._pictures = Clip(self.backend, 0)

    def skip(self, data: dict[str, Any]) -> None:
        self._follow_trigger(data)
        self._frame_id += 1

    def write(self, data: dict[str, Any]) -> None:
        self._follow_trigger(data)
        several = max(len(self.render_products), len(data["renderProducts"])) > 1
        sizes = {}
        for product, seen in data["renderProducts"].items():
            root = f"{product}/" if several else ""
            self._write_product(root, seen)
            sizes[root] = [int(size) for size in seen["rgb"]["data"].shape[1::-1]]
        self._pictures.note(clip=self._clip, rate=float(current_stage().GetTimeCodesPerSecond()))
        self._pictures.add(self.num_written, number=self._frame_id, sizes=sizes)
        self._frame_id += 1

    def on_final_frame(self) -> None:
        """Write the videos of the clip so far, if there are new frames."""
        self._pictures.write()

    def next_clip(self) -> None:
        """End the clip and write its videos; later frames belong to a new clip, which starts at frame 0."""
        self._begin_clip(self._clip + 1)

    def _follow_trigger(self, data: Mapping[str, Any]) -> None:
        """Begin a clip where a `trigger.on_time` has fired again."""
        fired = _times_fired(data.get("trigger_outputs") or {})
        if fired is not None and fired != self._clip:
            self._begin_clip(fired)

    def _begin_clip(self, number: int) -> None:
        self.on_final_frame()
        assert self.backend is not None
        self._clip, self._frame_id = number, 0
        self._pictures = Clip(self.backend, number)

    def _write_product(self, root: str, seen: Mapping[str, Any]) -> None:
        steps = []
        for modality in MODALITIES:
            image = unpacked(seen[modality]) if modality == "segmentation" else seen[modality]["data"]
            path = picture_of(root, self._clip, modality, self._frame_id)
            steps.append(partial(write_image, path=path, data=image))
        assert self.backend is not None
        self.backend.schedule_together(steps)


def _by_semantics(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Return the mapping with "type:label" keys; labels without a type get the type "class"."""
    for label, value in mapping.items():
        is_color = isinstance(value, (list, tuple)) and len(value) == 4 and all(_is_in(part, 0xFF) for part in value)
        if not is_color and not _is_in(value, 0xFFFFFFFF):
            raise WriterError(
                f"CosmosWriter: segmentation_mapping[{label!r}] is {value!r}; expected a color (r, g, b, a), 0 to 255, "
                "or an id."
            )
    return {label if ":" in label else f"class:{label}": value for label, value in mapping.items()}


def _is_in(value: Any, last: int) -> bool:
    return isinstance(value, int) and 0 <= value <= last


def _times_fired(trigger_outputs: Mapping[str, Any]) -> int | None:
    """Return how often the first on_time trigger has fired; None without one."""
    return next((count for name, count in trigger_outputs.items() if "on_time" in name), None)

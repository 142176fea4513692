"""LabelBatch: the labels of many pictures, still where they were made."""

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdsdg_render.device.parallel import launch_rows
from usdsdg_render.kernels.labels.label_boxes import WORD, label_boxes, map_labels
from usdsdg_render.memory.readback import fetch

# A box that holds nothing, as it grows: pixels, x_min, y_min, x_max, y_max.
_EMPTY = np.array([0, 1 << 30, 1 << 30, -1, -1], np.int32)


@dataclass(frozen=True)
class LabelBatch:
    """AOVs of pictures of one size on the device that drew them, by name.

    Each is a Warp array of shape (pictures, height, width) of int32, float32, vec2 or vec3; names, units and values are
    those of `aov.AOVS`.
    """

    pictures: int
    arrays: dict[str, wp.array]
    threads: int | None = None

    def numpy(self) -> list[dict[str, np.ndarray]]:
        """The AOVs of each picture on the host, (H, W, *channels)."""
        fetched = fetch(self.arrays)
        return [{name: array[k] for name, array in fetched.items()} for k in range(self.pictures)]

    def boxes(self, gprims: int) -> np.ndarray:
        """What is seen of each of the first `gprims` gprims; wants the AOV `instance`.

        Returns:
            (pictures, gprims, 5) int32: pixels, x_min, y_min, x_max, y_max (inclusive); -1 bounds for no pixels.
        """
        shown = self.arrays["instance"]
        pictures, height, width = shown.shape
        boxes = wp.array(np.tile(_EMPTY, (pictures, gprims, 1)), dtype=wp.int32, device=shown.device)
        words = (pictures, height, -(-width // WORD))
        # On a CPU a thread takes whole pictures, so that no two of them add to one box.
        launch_rows(label_boxes, words, [shown], [boxes], device=str(shown.device), threads=self.threads, band_rows=1)
        result = boxes.numpy()
        result[result[..., 0] == 0, 1:] = -1
        return result

    def masks(self, values: np.ndarray, nothing: int = 0) -> wp.array:
        """(pictures, height, width) int32: for each pixel the value of the gprim that it shows.

        Args:
            values: (gprims,) int32, for example the number of the object or class of each.
            nothing: where no gprim is seen.
        """
        shown = self.arrays["instance"]
        device = str(shown.device)
        table = wp.array(np.append(np.asarray(values, np.int32), np.int32(nothing)), dtype=wp.int32, device=device)
        masks = wp.empty(shown.shape, dtype=wp.int32, device=device)
        launch_rows(map_labels, shown.shape, [shown, table], [masks], device=device, threads=self.threads, band_rows=1)
        return masks

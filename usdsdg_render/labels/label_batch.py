"""LabelBatch: the labels of many images, on the device that rendered them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from usdsdg.parallel import CUDA_BLOCK, launch_rows
from usdsdg.readback import read_back
from usdsdg_render.kernels.labels.label_boxes import WORD_PIXELS, clear_boxes, close_boxes, label_boxes, map_labels


@dataclass(frozen=True)
class LabelBatch:
    """AOVs of images of one size on the device that rendered them, by name.

    Each is a Warp array of shape (images, height, width) of int32, float32, vec2 or vec3; names, units and values are
    those of `aov.AOVS`.
    """

    images: int
    arrays: dict[str, wp.array]
    threads: int | None = None

    def numpy(self) -> list[dict[str, np.ndarray]]:
        """Return the AOVs of each image on the host, (H, W, *channels)."""
        copies = read_back(self.arrays)
        return [{name: array[k] for name, array in copies.items()} for k in range(self.images)]

    def in_place(self) -> list[dict[str, Any]]:
        """Return the AOVs of each image where they were rendered: on a CPU as `numpy`, else as Warp arrays."""
        if all(str(array.device) == "cpu" for array in self.arrays.values()):
            return self.numpy()
        return [{name: array[k] for name, array in self.arrays.items()} for k in range(self.images)]

    def boxes(self, gprims: int) -> np.ndarray:
        """Compute 2D bounding boxes of the visible pixels of the first `gprims` gprims, from the AOV `instance`.

        Returns:
            (images, gprims, 5) int32: pixels, x_min, y_min, x_max, y_max (inclusive); -1 bounds for no pixels.
        """
        return boxes_of(self.arrays["instance"], gprims, threads=self.threads).numpy()

    def masks(self, values: np.ndarray, nothing: int = 0) -> wp.array:
        """(images, height, width) int32: for each pixel the value of the gprim that it shows.

        Args:
            values: (gprims,) int32, for example the number of the object or class of each.
            nothing: value where no gprim is hit.
        """
        shown = self.arrays["instance"]
        device = str(shown.device)
        table = wp.array(np.append(np.asarray(values, np.int32), np.int32(nothing)), dtype=wp.int32, device=device)
        masks = wp.empty(shown.shape, dtype=wp.int32, device=device)
        launch_rows(map_labels, shown.shape, [shown, table], [masks], device=device, threads=self.threads, band_rows=1)
        return masks


def boxes_of(shown: wp.array, count: int, *, threads: int | None = None) -> wp.array:
    """Compute the boxes of `LabelBatch.boxes` of the numbers below `count` in (images, height, width) int32.

    Returns:
        (images, count, 5) int32 on the device of `shown`.
    """
    images, height, width = shown.shape
    device = str(shown.device)
    boxes = wp.empty((images, count, 5), dtype=wp.int32, device=device)
    if boxes.size == 0:
        return boxes
    wp.launch(clear_boxes, dim=(images, count), outputs=[boxes], device=device, block_dim=CUDA_BLOCK)
    words = (images, height, -(-width // WORD_PIXELS))
    # On a CPU each thread takes whole images, so that no two threads update one box.
    launch_rows(label_boxes, words, [shown], [boxes], device=device, threads=threads, band_rows=1)
    wp.launch(close_boxes, dim=(images, count), outputs=[boxes], device=device, block_dim=CUDA_BLOCK)
    return boxes

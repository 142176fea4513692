"""Bounding boxes and label masks from the instance AOV of many images."""

import warp as wp

from usdsdg_render.kernels.labels.coverage import WORD_PIXELS


@wp.func
def add_run(boxes: wp.array3d(dtype=wp.int32), image: int, gprim: int, y: int, first: int, last: int):
    """Extend the box of a gprim (-1 = none) by its pixels [first, last) of a row."""
    if gprim >= 0 and gprim < boxes.shape[1]:
        wp.atomic_add(boxes, image, gprim, 0, last - first)
        wp.atomic_min(boxes, image, gprim, 1, first)
        wp.atomic_min(boxes, image, gprim, 2, y)
        wp.atomic_max(boxes, image, gprim, 3, last - 1)
        wp.atomic_max(boxes, image, gprim, 4, y)


@wp.kernel(enable_backward=False)
def label_boxes(
    shown: wp.array3d(dtype=wp.int32),  # (images, height, width): the instance AOV
    first_image: int,
    # out, updated: (images, gprims, 5): pixels, x_min, y_min, x_max, y_max
    boxes: wp.array3d(dtype=wp.int32),
):
    image, y, word = wp.tid()
    image += first_image
    first = int(word * WORD_PIXELS)
    gprim = int(shown[image, y, first])
    for x in range(first + 1, wp.min(first + WORD_PIXELS, shown.shape[2])):
        other = shown[image, y, x]
        if other != gprim:
            add_run(boxes, image, gprim, y, first, x)
            first = x
            gprim = other
    add_run(boxes, image, gprim, y, first, wp.min((word + 1) * WORD_PIXELS, shown.shape[2]))


@wp.kernel(enable_backward=False)
def clear_boxes(boxes: wp.array3d(dtype=wp.int32)):
    """Fill in boxes of no pixels, for `label_boxes`."""
    image, gprim = wp.tid()
    boxes[image, gprim, 0] = 0
    boxes[image, gprim, 1] = 1 << 30
    boxes[image, gprim, 2] = 1 << 30
    boxes[image, gprim, 3] = -1
    boxes[image, gprim, 4] = -1


@wp.kernel(enable_backward=False)
def close_boxes(boxes: wp.array3d(dtype=wp.int32)):
    """Set the lower bounds of boxes of no pixels to -1 too."""
    image, gprim = wp.tid()
    if boxes[image, gprim, 0] == 0:
        boxes[image, gprim, 1] = -1
        boxes[image, gprim, 2] = -1


@wp.kernel(enable_backward=False)
def map_labels(
    shown: wp.array3d(dtype=wp.int32),
    values: wp.array(dtype=wp.int32),  # of each gprim; the last one where no gprim is hit
    first_image: int,
    # out
    masks: wp.array3d(dtype=wp.int32),
):
    image, y, x = wp.tid()
    image += first_image
    gprim = shown[image, y, x]
    if gprim < 0:
        gprim = values.shape[0] - 1
    masks[image, y, x] = values[gprim]

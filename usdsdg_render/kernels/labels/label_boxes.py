"""Boxes and masks from the instance AOV of many pictures."""

import warp as wp

WORD = wp.constant(64)  # pixels that a thread looks at


@wp.func
def add_run(boxes: wp.array3d(dtype=wp.int32), picture: int, gprim: int, y: int, first: int, last: int):
    """Count pixels [first, last) of a row, all of one gprim, if there is one."""
    if gprim >= 0 and gprim < boxes.shape[1]:
        wp.atomic_add(boxes, picture, gprim, 0, last - first)
        wp.atomic_min(boxes, picture, gprim, 1, first)
        wp.atomic_min(boxes, picture, gprim, 2, y)
        wp.atomic_max(boxes, picture, gprim, 3, last - 1)
        wp.atomic_max(boxes, picture, gprim, 4, y)


@wp.kernel(enable_backward=False)
def label_boxes(
    shown: wp.array3d(dtype=wp.int32),  # (pictures, height, width): the instance AOV
    first_picture: int,
    # out, grown: (pictures, gprims, 5): pixels, x_min, y_min, x_max, y_max
    boxes: wp.array3d(dtype=wp.int32),
):
    picture, y, word = wp.tid()
    picture += first_picture
    first = int(word * WORD)
    gprim = int(shown[picture, y, first])
    for x in range(first + 1, wp.min(first + WORD, shown.shape[2])):
        other = shown[picture, y, x]
        if other != gprim:
            add_run(boxes, picture, gprim, y, first, x)
            first = x
            gprim = other
    add_run(boxes, picture, gprim, y, first, wp.min((word + 1) * WORD, shown.shape[2]))


@wp.kernel(enable_backward=False)
def map_labels(
    shown: wp.array3d(dtype=wp.int32),
    values: wp.array(dtype=wp.int32),  # of each gprim, and of nothing
    first_picture: int,
    # out
    masks: wp.array3d(dtype=wp.int32),
):
    picture, y, x = wp.tid()
    picture += first_picture
    gprim = shown[picture, y, x]
    if gprim < 0:
        gprim = values.shape[0] - 1
    masks[picture, y, x] = values[gprim]

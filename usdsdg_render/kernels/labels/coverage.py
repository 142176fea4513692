"""Coverage pass: bit-packed masks of the pixels that instances would cover if each were alone.

Screen bounds of instances are split into words of up to 64 pixels of a row, each pixel of a word tests whether its ray
hits the instance, and words of instances are merged into words of the groups that they belong to.
"""

from typing import Any

import warp as wp

from usdsdg.stage.geometry import pixel_masks
from usdsdg_render.bvh.query import wide_any_hit_in_instance
from usdsdg_render.bvh.tile import TILE
from usdsdg_render.kernels.cameras.camera import PIXEL_CENTER, pixel_ray
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.scene.visibility import meets_cutout
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import Camera, SceneTables

WORD_PIXELS = wp.constant(pixel_masks.WORD_PIXELS)
BYTES = wp.constant(8)  # of a word
# Values of the instance AOV: the ray hits nothing, so that it hits no instance that is alone either; a pixel that no
# mask may have; what the ray hits is not known.
NOTHING, LEFT_OUT, UNKNOWN = (wp.constant(-k) for k in (1, 2, 3))


@wp.struct
class MaskWord:
    """Pixels [first, last) of one row of an image, all in the same word of a mask."""

    image: wp.int32
    owner: wp.int32  # index of a tested instance, or of a group
    row: wp.int32
    first: wp.int32
    last: wp.int32


@wp.struct
class Parts:
    """Gprims that are divided into parts: entries are all gprims, by their index, then all parts.

    In a divided gprim each triangle is of one entry; the gprim's own has what is left.
    """

    instance: wp.array(dtype=wp.int32)  # of each entry
    first: wp.array(dtype=wp.int32)  # of each gprim: where its triangles begin in `entry`; -1 for whole ones
    entry: wp.array(dtype=wp.int32)  # of each triangle of divided gprims


@wp.func
def first_center(edge: float, size: int):
    """Return the first of `size` pixels whose center is at or beyond an edge; `size` if there is none."""
    return int(wp.clamp(wp.ceil(edge - PIXEL_CENTER), 0.0, float(size)))


@wp.func
def columns_of(bounds: wp.array(dtype=wp.float32), row: int, width: int):
    """Return the pixels [first, last) of a row whose centers are within screen bounds (see screen_bounds.py)."""
    y = float(row) + PIXEL_CENTER
    left = wp.max(wp.max(-bounds[4], -bounds[6] - y), y - bounds[7])
    right = wp.min(wp.min(bounds[0], bounds[2] - y), bounds[3] + y)
    return first_center(left, width), first_center(right, width)


@wp.func
def rows_of_part(bounds: wp.array(dtype=wp.float32), height: int, part: int, parts: int):
    """Return the rows [begin, end) of a part of screen bounds; all but the last have whole tiles."""
    top = first_center(-bounds[5], height)
    rows = wp.max(first_center(bounds[1], height) - top, 0)
    tiles = (rows + TILE - 1) / TILE
    return top + TILE * (tiles * part / parts), top + wp.min(TILE * (tiles * (part + 1) / parts), rows)


@wp.kernel(enable_backward=False, module=LABELS)
def list_mask_words(
    width: int,
    height: int,
    all_bounds: wp.array3d(dtype=wp.float32),  # (views, tested, sides)
    after: wp.array3d(dtype=wp.int32),  # running sums of counts; empty while words are only counted
    first_view: int,
    # out
    counts: wp.array3d(dtype=wp.int32),  # (views, tested, parts): words in each part of the rows
    words: wp.array(dtype=MaskWord),
):
    v, k, part = wp.tid()
    v += first_view
    bounds = all_bounds[v, k]
    begin, end = rows_of_part(bounds, height, part, counts.shape[2])
    start = int(0)
    if after.shape[0] > 0:
        start = after[v, k, part] - counts[v, k, part]
    count = int(0)
    for row in range(begin, end):
        first, last = columns_of(bounds, row, width)
        if first < last:
            for column in range(first / WORD_PIXELS, (last - 1) / WORD_PIXELS + 1):
                if after.shape[0] > 0:
                    words[start + count] = MaskWord(
                        image=v,
                        owner=k,
                        row=row,
                        first=wp.max(first, column * WORD_PIXELS),
                        last=wp.min(last, (column + 1) * WORD_PIXELS),
                    )
                count += 1
    if after.shape[0] == 0:
        counts[v, k, part] = count


@wp.func
def hits_alone(tables: SceneTables, parts: Parts, camera: Camera, x: int, y: int, instance: int, mode: int):
    """Return whether the ray through the center of a pixel would hit an instance if it were alone in the scene."""
    ray = pixel_ray(camera, x, y)
    row = tables.first_instance + instance
    if tables.tlas.instances[row].cutout != 0:
        return meets_cutout(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, row, mode)
    return wide_any_hit_in_instance(tables.tlas, ray.origin, ray.direction, ray.tmin, ray.tmax, row)[3] >= 0


def fill_kernel(covers: wp.Function, module: Any) -> Any:
    """Make the kernel that fills mask words; `covers` has the arguments of `hits_alone`, with entries as instances."""

    @wp.kernel(enable_backward=False, module=module)
    def fill_mask_words(
        tables: SceneTables,
        cameras: wp.array(dtype=Camera),
        mode: int,
        shown: wp.array3d(dtype=wp.int32),  # entry of each pixel; the instance AOV where nothing is divided
        parts: Parts,
        tested: wp.array(dtype=wp.int32),  # entries
        words: wp.array(dtype=MaskWord),
        bytes_of_thread: int,
        first_word: int,
        # out: the bytes of each word, one bit per pixel
        covered: wp.array2d(dtype=wp.uint8),
        visible: wp.array2d(dtype=wp.uint8),
    ):
        s, part = wp.tid()
        s += first_word
        word = words[s]
        camera = cameras[word.image]
        tables = in_world(tables, camera.world)
        entry = tested[word.owner]
        word_start = word.first / WORD_PIXELS * WORD_PIXELS
        for b in range(part * bytes_of_thread, (part + 1) * bytes_of_thread):
            met = int(0)
            seen = int(0)
            begin = word_start + 8 * b
            for x in range(wp.max(word.first, begin), wp.min(word.last, begin + 8)):
                bit = 1 << (x - begin)
                here = shown[word.image, word.row, x]
                if here == entry:
                    seen = seen | bit
                elif here != NOTHING and here != LEFT_OUT and covers(tables, parts, camera, x, word.row, entry, mode):
                    met = met | bit
            covered[s, b] = wp.uint8(met | seen)
            visible[s, b] = wp.uint8(seen)

    return fill_mask_words


fill_mask_words = fill_kernel(hits_alone, LABELS)


@wp.kernel(enable_backward=False, module=LABELS)
def count_groups(
    words: wp.array(dtype=MaskWord),
    covered: wp.array(dtype=wp.uint64),
    first_group: wp.array(dtype=wp.int32),  # (tested + 1): offset of an instance's groups in `groups_of`
    # out
    counts: wp.array(dtype=wp.int32),
):
    s = wp.tid()
    owner = words[s].owner
    counts[s] = wp.where(covered[s] == wp.uint64(0), 0, first_group[owner + 1] - first_group[owner])


@wp.kernel(enable_backward=False, module=LABELS)
def copy_to_groups(
    words: wp.array(dtype=MaskWord),
    after: wp.array(dtype=wp.int32),  # running sums of counts
    counts: wp.array(dtype=wp.int32),
    first_group: wp.array(dtype=wp.int32),
    groups_of: wp.array(dtype=wp.int32),
    groups: int,
    width: int,
    height: int,
    # out
    keys: wp.array(dtype=wp.int64),  # in the order of images, groups, rows and words
    sources: wp.array(dtype=wp.int32),
):
    s = wp.tid()
    word = words[s]
    row_words = (width + WORD_PIXELS - 1) / WORD_PIXELS
    for k in range(counts[s]):
        group = word.image * groups + groups_of[first_group[word.owner] + k]
        slot = after[s] - counts[s] + k
        keys[slot] = (wp.int64(group) * wp.int64(height) + wp.int64(word.row)) * wp.int64(row_words) + wp.int64(
            word.first / WORD_PIXELS
        )
        sources[slot] = s


@wp.kernel(enable_backward=False, module=LABELS)
def mark_first_of_key(keys: wp.array(dtype=wp.int64), marks: wp.array(dtype=wp.int32)):
    i = wp.tid()
    marks[i] = 1
    if i > 0 and keys[i] == keys[i - 1]:
        marks[i] = 0


@wp.kernel(enable_backward=False, module=LABELS)
def merge_mask_words(
    count: int,
    keys: wp.array(dtype=wp.int64),  # sorted
    sources: wp.array(dtype=wp.int32),
    slots: wp.array(dtype=wp.int32),  # 1 + index of the merged word of a key
    marks: wp.array(dtype=wp.int32),
    words: wp.array(dtype=MaskWord),
    covered: wp.array(dtype=wp.uint64),
    visible: wp.array(dtype=wp.uint64),
    groups: int,
    width: int,
    height: int,
    # out
    merged: wp.array(dtype=MaskWord),
    merged_covered: wp.array(dtype=wp.uint64),
    merged_visible: wp.array(dtype=wp.uint64),
):
    i = wp.tid()
    if marks[i] == 0:
        return
    met = wp.uint64(0)
    seen = wp.uint64(0)
    key = keys[i]
    k = int(i)
    while k < count and keys[k] == key:
        met = met | covered[sources[k]]
        seen = seen | visible[sources[k]]
        k += 1
    row_words = wp.int64((width + WORD_PIXELS - 1) / WORD_PIXELS)
    word = words[sources[i]]
    word.owner = int(key / row_words / wp.int64(height)) - word.image * groups
    merged[slots[i] - 1] = word
    merged_covered[slots[i] - 1] = met
    merged_visible[slots[i] - 1] = seen


@wp.kernel(enable_backward=False, module=LABELS)
def sum_mask_words(
    words: wp.array(dtype=MaskWord),
    covered: wp.array(dtype=wp.uint64),
    visible: wp.array(dtype=wp.uint64),
    # out, (images, groups, 6): amodal pixels, x_min, y_min, x_max, y_max, modal pixels
    sums: wp.array3d(dtype=wp.int32),
):
    s = wp.tid()
    word = words[s]
    met = covered[s]
    if met == wp.uint64(0):
        return
    lowest = int(wp.bit_count((met & (~met + wp.uint64(1))) - wp.uint64(1)))
    upwards = met
    for k in range(6):
        upwards = upwards | (upwards >> wp.uint64(1 << k))
    highest = int(wp.bit_count(upwards)) - 1
    column = word.first / WORD_PIXELS * WORD_PIXELS
    wp.atomic_add(sums, word.image, word.owner, 0, int(wp.bit_count(met)))
    wp.atomic_min(sums, word.image, word.owner, 1, column + lowest)
    wp.atomic_min(sums, word.image, word.owner, 2, word.row)
    wp.atomic_max(sums, word.image, word.owner, 3, column + highest)
    wp.atomic_max(sums, word.image, word.owner, 4, word.row)
    wp.atomic_add(sums, word.image, word.owner, 5, int(wp.bit_count(visible[s])))

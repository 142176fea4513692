"""Coverage pass: which pixels instances would cover if each were alone, in strips of up to 64 pixels of a row.

Octagons around the instances are cut into strips, each pixel of a strip asks its instance whether it is met, and strips
of instances become those of the groups that they belong to.
"""

import warp as wp

from usdsdg_render.bvh.query import wide_any_hit_in_instance
from usdsdg_render.kernels.cameras.camera import PIXEL_CENTER, pixel_ray
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.scene.visibility import meets_cutout
from usdsdg_render.scene.structs import Camera, SceneTables

WORD = wp.constant(64)
BYTES = wp.constant(8)  # of a word


@wp.struct
class Strip:
    """A run of pixels of one row and one word, [first, last)."""

    picture: wp.int32
    owner: wp.int32  # row of what is tested, or a group
    row: wp.int32
    first: wp.int32
    last: wp.int32


@wp.func
def first_center(place: float, size: int):
    """The first pixel of a row of `size` whose center is not before a place; `size` if none is."""
    return int(wp.clamp(wp.ceil(place - PIXEL_CENTER), 0.0, float(size)))


@wp.func
def columns_of(ends: wp.array(dtype=wp.float32), row: int, width: int):
    """[first, last) of the pixels of a row whose centers are within an octagon; see tangents.py for its sides."""
    y = float(row) + PIXEL_CENTER
    left = wp.max(wp.max(-ends[4], -ends[6] - y), y - ends[7])
    right = wp.min(wp.min(ends[0], ends[2] - y), ends[3] + y)
    return first_center(left, width), first_center(right, width)


@wp.kernel(enable_backward=False, module=LABELS)
def cut_strips(
    width: int,
    height: int,
    octagons: wp.array3d(dtype=wp.float32),  # (views, tested, sides)
    after: wp.array3d(dtype=wp.int32),  # as counts: strips so far; empty where they are still to be counted
    first_view: int,
    # out
    counts: wp.array3d(dtype=wp.int32),  # (views, tested, parts): strips in each part of the rows
    strips: wp.array(dtype=Strip),
):
    v, k, part = wp.tid()
    v += first_view
    ends = octagons[v, k]
    top = first_center(-ends[5], height)
    rows = wp.max(first_center(ends[1], height) - top, 0)
    parts = counts.shape[2]
    place = int(0)
    if after.shape[0] > 0:
        place = after[v, k, part] - counts[v, k, part]
    count = int(0)
    for row in range(top + rows * part / parts, top + rows * (part + 1) / parts):
        first, last = columns_of(ends, row, width)
        if first < last:
            for word in range(first / WORD, (last - 1) / WORD + 1):
                if after.shape[0] > 0:
                    strips[place + count] = Strip(
                        picture=v,
                        owner=k,
                        row=row,
                        first=wp.max(first, word * WORD),
                        last=wp.min(last, (word + 1) * WORD),
                    )
                count += 1
    if after.shape[0] == 0:
        counts[v, k, part] = count


@wp.func
def meets(tables: SceneTables, camera: Camera, x: int, y: int, instance: int, mode: int):
    """Whether the ray through the center of a pixel would meet an instance that is alone."""
    ray = pixel_ray(camera, x, y)
    if tables.tlas.instances[instance].cutout != 0:
        return meets_cutout(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, instance, mode)
    return wide_any_hit_in_instance(tables.tlas, ray.origin, ray.direction, ray.tmin, ray.tmax, instance)[3] >= 0


@wp.kernel(enable_backward=False, module=LABELS)
def cover_strips(
    tables: SceneTables,
    cameras: wp.array(dtype=Camera),
    mode: int,
    shown: wp.array3d(dtype=wp.int32),  # the instance AOV
    tested: wp.array(dtype=wp.int32),  # instances
    strips: wp.array(dtype=Strip),
    bytes_of_thread: int,
    first_strip: int,
    # out, per strip the bytes of a word with a bit per pixel
    covered: wp.array2d(dtype=wp.uint8),
    visible: wp.array2d(dtype=wp.uint8),
):
    s, part = wp.tid()
    s += first_strip
    strip = strips[s]
    camera = cameras[strip.picture]
    instance = tested[strip.owner]
    word = strip.first / WORD * WORD
    for b in range(part * bytes_of_thread, (part + 1) * bytes_of_thread):
        met = int(0)
        seen = int(0)
        begin = word + 8 * b
        for x in range(wp.max(strip.first, begin), wp.min(strip.last, begin + 8)):
            bit = 1 << (x - begin)
            if shown[strip.picture, strip.row, x] == instance:
                seen = seen | bit
            elif meets(tables, camera, x, strip.row, instance, mode):
                met = met | bit
        covered[s, b] = wp.uint8(met | seen)
        visible[s, b] = wp.uint8(seen)


@wp.kernel(enable_backward=False, module=LABELS)
def count_groups(
    strips: wp.array(dtype=Strip),
    covered: wp.array(dtype=wp.uint64),
    first_group: wp.array(dtype=wp.int32),  # per tested instance, and one more: where its groups stand in a list
    # out
    counts: wp.array(dtype=wp.int32),
):
    s = wp.tid()
    owner = strips[s].owner
    counts[s] = wp.where(covered[s] == wp.uint64(0), 0, first_group[owner + 1] - first_group[owner])


@wp.kernel(enable_backward=False, module=LABELS)
def give_to_groups(
    strips: wp.array(dtype=Strip),
    after: wp.array(dtype=wp.int32),  # what is given so far
    counts: wp.array(dtype=wp.int32),
    first_group: wp.array(dtype=wp.int32),
    groups_of: wp.array(dtype=wp.int32),
    groups: int,
    width: int,
    height: int,
    # out
    keys: wp.array(dtype=wp.int64),  # in the order of pictures, groups, rows and words
    sources: wp.array(dtype=wp.int32),
):
    s = wp.tid()
    strip = strips[s]
    words = (width + WORD - 1) / WORD
    for k in range(counts[s]):
        group = strip.picture * groups + groups_of[first_group[strip.owner] + k]
        place = after[s] - counts[s] + k
        keys[place] = (wp.int64(group) * wp.int64(height) + wp.int64(strip.row)) * wp.int64(words) + wp.int64(
            strip.first / WORD
        )
        sources[place] = s


@wp.kernel(enable_backward=False, module=LABELS)
def mark_firsts(keys: wp.array(dtype=wp.int64), marks: wp.array(dtype=wp.int32)):
    i = wp.tid()
    marks[i] = 1
    if i > 0 and keys[i] == keys[i - 1]:
        marks[i] = 0


@wp.kernel(enable_backward=False, module=LABELS)
def merge_strips(
    count: int,
    keys: wp.array(dtype=wp.int64),  # sorted
    sources: wp.array(dtype=wp.int32),
    places: wp.array(dtype=wp.int32),  # 1 + where the words of a key go
    marks: wp.array(dtype=wp.int32),
    strips: wp.array(dtype=Strip),
    covered: wp.array(dtype=wp.uint64),
    visible: wp.array(dtype=wp.uint64),
    groups: int,
    width: int,
    height: int,
    # out
    merged: wp.array(dtype=Strip),
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
    words = wp.int64((width + WORD - 1) / WORD)
    strip = strips[sources[i]]
    strip.owner = int(key / words / wp.int64(height)) - strip.picture * groups
    merged[places[i] - 1] = strip
    merged_covered[places[i] - 1] = met
    merged_visible[places[i] - 1] = seen


@wp.kernel(enable_backward=False, module=LABELS)
def sum_strips(
    strips: wp.array(dtype=Strip),
    covered: wp.array(dtype=wp.uint64),
    visible: wp.array(dtype=wp.uint64),
    # out, (pictures, groups, 6): amodal pixels, x_min, y_min, x_max, y_max, modal pixels
    sums: wp.array3d(dtype=wp.int32),
):
    s = wp.tid()
    strip = strips[s]
    met = covered[s]
    if met == wp.uint64(0):
        return
    lowest = int(wp.bit_count((met & (~met + wp.uint64(1))) - wp.uint64(1)))
    upwards = met
    for k in range(6):
        upwards = upwards | (upwards >> wp.uint64(1 << k))
    highest = int(wp.bit_count(upwards)) - 1
    column = strip.first / WORD * WORD
    wp.atomic_add(sums, strip.picture, strip.owner, 0, int(wp.bit_count(met)))
    wp.atomic_min(sums, strip.picture, strip.owner, 1, column + lowest)
    wp.atomic_min(sums, strip.picture, strip.owner, 2, strip.row)
    wp.atomic_max(sums, strip.picture, strip.owner, 3, column + highest)
    wp.atomic_max(sums, strip.picture, strip.owner, 4, strip.row)
    wp.atomic_add(sums, strip.picture, strip.owner, 5, int(wp.bit_count(visible[s])))

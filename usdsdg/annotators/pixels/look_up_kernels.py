"""Kernels that look pixels up by the gprim that they show; entry -1, no hit, is the last of each table."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp


@wp.func
def entry_of(instance: int, entries: int):
    return wp.where(instance < 0, entries - 1, instance)


@wp.kernel(enable_backward=False, module="unique")
def look_up(
    instance: wp.array(dtype=wp.int32),
    table: wp.array(dtype=wp.uint32),
    words: int,  # of an entry
    first: int,
    # out
    values: wp.array(dtype=wp.uint32),
):
    i = wp.tid()
    i += first
    entry = entry_of(instance[i], table.shape[0] // words)
    for k in range(words):
        values[i * words + k] = table[entry * words + k]


@wp.kernel(enable_backward=False, module="unique")
def shade(
    instance: wp.array(dtype=wp.int32),
    normals: wp.array(dtype=wp.vec3),
    colors: wp.array(dtype=wp.vec3),  # table, 0 to 255
    light: wp.vec3,  # unit vector
    darkest: float,
    first: int,
    # out
    image: wp.array(dtype=wp.vec3ub),
):
    i = wp.tid()
    i += first
    n = normals[i]
    cosine = n[0] * light[0] + n[1] * light[1] + n[2] * light[2]
    brightness = wp.clamp(darkest + (1.0 - darkest) * (cosine + 1.0) / 2.0, 0.0, 1.0)
    color = colors[entry_of(instance[i], colors.shape[0])] * brightness
    image[i] = wp.vec3ub(wp.uint8(color[0]), wp.uint8(color[1]), wp.uint8(color[2]))


@wp.kernel(enable_backward=False, module="unique")
def sum_runs(
    instance: wp.array2d(dtype=wp.int32),
    part_pixels: int,  # of a row, which a thread of a GPU takes
    band_rows: int,
    first: int,
    # out, updated: of each gprim (bands, gprims, 5): pixels, x_min, y_min, x_max, y_max
    sums: wp.array3d(dtype=wp.int32),
):
    row, part = wp.tid()
    y = row + first
    band = y / band_rows  # threads of a CPU, and images, have sums of their own
    x = part * part_pixels
    end = wp.min(x + part_pixels, instance.shape[1])
    while x < end:
        gprim = instance[y, x]
        start = x
        x += 1
        while x < end and instance[y, x] == gprim:
            x += 1
        if gprim >= 0:
            wp.atomic_add(sums, band, gprim, 0, x - start)
            wp.atomic_min(sums, band, gprim, 1, start)
            wp.atomic_min(sums, band, gprim, 2, y)
            wp.atomic_max(sums, band, gprim, 3, x - 1)
            wp.atomic_max(sums, band, gprim, 4, y)


@wp.kernel(enable_backward=False, module="unique")
def count_kept(
    instance: wp.array2d(dtype=wp.int32),
    is_kept: wp.array(dtype=wp.int32),  # table
    part_pixels: int,
    first: int,
    # out
    counts: wp.array2d(dtype=wp.int32),  # of each part of a row
):
    y, part = wp.tid()
    y += first
    count = int(0)
    for x in range(part * part_pixels, wp.min((part + 1) * part_pixels, instance.shape[1])):
        count += is_kept[entry_of(instance[y, x], is_kept.shape[0])]
    counts[y, part] = count


@wp.kernel(enable_backward=False, module="unique")
def gather_points(
    instance: wp.array2d(dtype=wp.int32),
    is_kept: wp.array(dtype=wp.int32),  # table
    classes: wp.array(dtype=wp.uint32),  # table
    ids: wp.array(dtype=wp.uint32),  # table
    position: wp.array2d(dtype=wp.vec3),
    normals: wp.array2d(dtype=wp.vec3),
    color: wp.array2d(dtype=wp.vec4ub),
    starts: wp.array2d(dtype=wp.int32),  # of each part of a row
    part_pixels: int,
    first: int,
    # out, of each kept pixel
    points: wp.array(dtype=wp.vec3),
    point_normals: wp.array(dtype=wp.vec4),
    point_colors: wp.array(dtype=wp.vec4ub),
    point_classes: wp.array(dtype=wp.uint32),
    point_ids: wp.array(dtype=wp.uint32),
):
    y, part = wp.tid()
    y += first
    i = starts[y, part]
    for x in range(part * part_pixels, wp.min((part + 1) * part_pixels, instance.shape[1])):
        entry = entry_of(instance[y, x], is_kept.shape[0])
        if is_kept[entry] != 0:
            points[i] = position[y, x]
            n = normals[y, x]
            point_normals[i] = wp.vec4(n[0], n[1], n[2], 1.0)
            point_colors[i] = color[y, x]
            point_classes[i] = classes[entry]
            point_ids[i] = ids[entry]
            i += 1


@wp.kernel(enable_backward=False, module="unique")
def map_points(
    entries: wp.array(dtype=wp.int32),  # of each pixel
    points: wp.array(dtype=wp.vec3),
    matrices: wp.array(dtype=wp.mat33),  # of each entry; the last one is of entry -1
    offsets: wp.array(dtype=wp.vec3),
    is_mapped: wp.array(dtype=wp.int32),
    first: int,
    # out
    mapped: wp.array(dtype=wp.vec4),
):
    i = wp.tid()
    i += first
    entry = entries[i]
    if entry < 0 or is_mapped[entry] == 0:
        mapped[i] = wp.vec4(0.0)
        return
    p = matrices[entry] * points[i] + offsets[entry]
    mapped[i] = wp.vec4(wp.clamp(p[0], 0.0, 1.0), wp.clamp(p[1], 0.0, 1.0), wp.clamp(p[2], 0.0, 1.0), 1.0)

"""Kernels that gather the points of pixels that show some gprims, and map points by the gprim that they are on."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportReturnType=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import ENTRY, begin_of, end_of


@wp.func_native(f"""
    const int entries = is_kept.shape[0];
    {ENTRY}
    int count = 0;
    for (int i = begin; i < end; ++i) count += is_kept.data[entry_of(i)];
    return count;
""")
def number_kept(instance: wp.array2d(dtype=wp.int32), is_kept: wp.array(dtype=wp.int32), begin: int, end: int) -> int:
    """Return how many of the pixels are kept."""


@wp.func_native(f"""
    const int entries = is_kept.shape[0];
    {ENTRY}
    for (int i = begin, to = start; i < end; ++i) {{
        const int entry = entry_of(i);
        if (is_kept.data[entry] == 0) continue;
        const wp::vec_t<3, float>& n = normals.data[i];
        points.data[to] = position.data[i];
        point_normals.data[to] = wp::vec_t<4, float>(n[0], n[1], n[2], 1.0f);
        point_colors.data[to] = color.data[i];
        point_classes.data[to] = classes.data[entry];
        point_ids.data[to] = ids.data[entry];
        ++to;
    }}
""")
def write_kept(
    instance: wp.array2d(dtype=wp.int32),
    is_kept: wp.array(dtype=wp.int32),
    classes: wp.array(dtype=wp.uint32),
    ids: wp.array(dtype=wp.uint32),
    position: wp.array2d(dtype=wp.vec3),
    normals: wp.array2d(dtype=wp.vec3),
    color: wp.array2d(dtype=wp.vec4ub),
    start: int,
    begin: int,
    end: int,
    points: wp.array(dtype=wp.vec3),
    point_normals: wp.array(dtype=wp.vec4),
    point_colors: wp.array(dtype=wp.vec4ub),
    point_classes: wp.array(dtype=wp.uint32),
    point_ids: wp.array(dtype=wp.uint32),
):
    """Write the kept pixels from `start` on."""


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
    begin = y * instance.shape[1] + part * part_pixels
    end = wp.min(begin + part_pixels, (y + 1) * instance.shape[1])
    counts[y, part] = number_kept(instance, is_kept, begin, end)


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
    begin = y * instance.shape[1] + part * part_pixels
    end = wp.min(begin + part_pixels, (y + 1) * instance.shape[1])
    write_kept(
        instance, is_kept, classes, ids, position, normals, color, starts[y, part], begin, end,
        points, point_normals, point_colors, point_classes, point_ids,
    )  # fmt: skip


@wp.func_native("""
    const wp::vec_t<4, float> nothing(0.0f);
    for (int i = begin; i < end; ++i) {
        const int entry = entries.data[i];
        if (entry < 0 || is_mapped.data[entry] == 0) {
            mapped.data[i] = nothing;
            continue;
        }
        // The product of Warp, whose sums are in the same order everywhere.
        const wp::vec_t<3, float> turned = wp::mul(matrices.data[entry], points.data[i]);
        const wp::vec_t<3, float> p = wp::add(turned, offsets.data[entry]);
        mapped.data[i] = wp::vec_t<4, float>(
            wp::clamp(p[0], 0.0f, 1.0f), wp::clamp(p[1], 0.0f, 1.0f), wp::clamp(p[2], 0.0f, 1.0f), 1.0f);
    }
""")
def write_mapped(
    entries: wp.array(dtype=wp.int32),
    points: wp.array(dtype=wp.vec3),
    matrices: wp.array(dtype=wp.mat33),
    offsets: wp.array(dtype=wp.vec3),
    is_mapped: wp.array(dtype=wp.int32),
    begin: int,
    end: int,
    mapped: wp.array(dtype=wp.vec4),
):
    """Write each point under the matrix of its entry."""


@wp.kernel(enable_backward=False, module="unique")
def map_points(
    entries: wp.array(dtype=wp.int32),  # of each pixel
    points: wp.array(dtype=wp.vec3),
    matrices: wp.array(dtype=wp.mat33),  # of each entry; the last one is of entry -1
    offsets: wp.array(dtype=wp.vec3),
    is_mapped: wp.array(dtype=wp.int32),
    pixels: int,  # of a thread
    first: int,
    # out
    mapped: wp.array(dtype=wp.vec4),
):
    begin = begin_of(wp.tid() + first, pixels)
    end = end_of(begin, pixels, entries.shape[0])
    write_mapped(entries, points, matrices, offsets, is_mapped, begin, end, mapped)

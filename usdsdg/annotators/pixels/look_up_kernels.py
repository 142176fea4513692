"""Kernels that look pixels up by the gprim that they show; entry -1, no hit, is the last of each table."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import begin_of, end_of


@wp.func
def entry_of(instance: int, entries: int):
    return wp.where(instance < 0, entries - 1, instance)


# Loops in C++ over the pixels of a thread, as those of the encodings.
_ENTRY = "auto entry_of = [&](int i) { return instance.data[i] < 0 ? entries - 1 : instance.data[i]; };"


@wp.func_native(
    f"""
    const int entries = table.shape[0] / words;
    {_ENTRY}
    """
    + "".join(
        f"""
        if ({condition}) {{
            for (int i = begin; i < end; ++i) {{
                const unsigned int* entry = table.data + entry_of(i) * {count};
                for (int k = 0; k < {count}; ++k) values.data[i * {count} + k] = entry[k];
            }}
            return;
        }}
        """
        for condition, count in (*((f"words == {n}", n) for n in range(1, 5)), ("true", "words"))
    )
)
def write_entries(
    instance: wp.array(dtype=wp.int32),
    table: wp.array(dtype=wp.uint32),
    words: int,
    begin: int,
    end: int,
    values: wp.array(dtype=wp.uint32),
):
    """Write the entry of each pixel."""


@wp.func_native(f"""
    const int entries = colors.shape[0];
    {_ENTRY}
    const float lx = light[0], ly = light[1], lz = light[2];
    for (int i = begin; i < end; ++i) {{
        const wp::vec_t<3, float>& n = normals.data[i];
        const float x = n[0] * lx, y = n[1] * ly, z = n[2] * lz;
        const float xy = x + y;
        const float cosine = xy + z;
        const float lit = (1.0f - darkest) * (cosine + 1.0f);
        const float half_lit = lit / 2.0f;
        const float brightness = wp::clamp(darkest + half_lit, 0.0f, 1.0f);
        const wp::vec_t<3, float>& color = colors.data[entry_of(i)];
        const float r = color[0] * brightness, g = color[1] * brightness, b = color[2] * brightness;
        image.data[i] = wp::vec_t<3, wp::uint8>((unsigned char)r, (unsigned char)g, (unsigned char)b);
    }}
""")
def write_shaded(
    instance: wp.array(dtype=wp.int32),
    normals: wp.array(dtype=wp.vec3),
    colors: wp.array(dtype=wp.vec3),
    light: wp.vec3,
    darkest: float,
    begin: int,
    end: int,
    image: wp.array(dtype=wp.vec3ub),
):
    """Write the color of each pixel, times its brightness."""


@wp.kernel(enable_backward=False, module="unique")
def look_up(
    instance: wp.array(dtype=wp.int32),
    table: wp.array(dtype=wp.uint32),
    words: int,  # of an entry
    pixels: int,  # of a thread
    first: int,
    # out
    values: wp.array(dtype=wp.uint32),
):
    begin = begin_of(wp.tid() + first, pixels)
    write_entries(instance, table, words, begin, end_of(begin, pixels, instance.shape[0]), values)


@wp.kernel(enable_backward=False, module="unique")
def shade(
    instance: wp.array(dtype=wp.int32),
    normals: wp.array(dtype=wp.vec3),
    colors: wp.array(dtype=wp.vec3),  # table, 0 to 255
    light: wp.vec3,  # unit vector
    darkest: float,
    pixels: int,  # of a thread
    first: int,
    # out
    image: wp.array(dtype=wp.vec3ub),
):
    begin = begin_of(wp.tid() + first, pixels)
    write_shaded(instance, normals, colors, light, darkest, begin, end_of(begin, pixels, instance.shape[0]), image)


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

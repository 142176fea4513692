"""Kernels that look pixels up by the gprim that they show; entry -1, no hit, is the last of each table."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportGeneralTypeIssues=false, reportIndexIssue=false

import warp as wp

from usdsdg.annotators.pixels.pixel_runs import ENTRY, begin_of, end_of


# Loops in C++ over the pixels of a thread, as those of the encodings.
@wp.func_native(
    f"""
    const int entries = table.shape[0] / words;
    {ENTRY}
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
    {ENTRY}
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
    """Write the entry of a table for each pixel's instance; see `write_entries`."""
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
    """Write the color of each pixel, times its brightness."""
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
    """Count the pixels of each gprim and bound them, by runs of a row that belong to one."""
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

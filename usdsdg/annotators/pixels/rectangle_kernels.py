"""Rectangles of least area around masks."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false

import warp as wp


@wp.func
def turns_outwards(ax: wp.float64, ay: wp.float64, bx: wp.float64, by: wp.float64, x: wp.float64, y: wp.float64):
    """Return the cross product of the edges a to b and b to (x, y)."""
    return (bx - ax) * (y - by) - (by - ay) * (x - bx)


@wp.func
def add_to_chain(
    xs: wp.array(dtype=wp.float64),
    ys: wp.array(dtype=wp.float64),
    start: int,
    count: int,
    x: wp.float64,
    y: wp.float64,
    side: wp.float64,
):
    """Add a point below all others to a convex chain, the left (side -1) or right one (1); return its length."""
    last = start + count - 1
    while last > start:
        turn = turns_outwards(xs[last - 1], ys[last - 1], xs[last], ys[last], x, y)
        if side * turn > wp.float64(0.0):
            break
        last -= 1
    xs[last + 1] = x
    ys[last + 1] = y
    return last + 2 - start


@wp.kernel(enable_backward=False, module="unique")
def least_rectangles(
    first_run: wp.array(dtype=wp.int32),  # of each mask; the last entry is the number of runs
    rows: wp.array(dtype=wp.int32),  # of each run, ascending in a mask
    lefts: wp.array(dtype=wp.int32),  # first pixel of the row
    rights: wp.array(dtype=wp.int32),  # one after the last pixel of the row
    # scratch, twice as long as the runs
    left_x: wp.array(dtype=wp.float64),
    left_y: wp.array(dtype=wp.float64),
    right_x: wp.array(dtype=wp.float64),
    right_y: wp.array(dtype=wp.float64),
    first: int,
    # out: center, direction of the width (x, y), width and height of the rectangle of each mask
    rectangles: wp.array2d(dtype=wp.float64),
):
    m = wp.tid() + first
    begin = first_run[m]
    end = first_run[m + 1]
    if begin == end:
        return
    start = 2 * begin
    # The corners of the outermost pixels of each row, from the top down, are the corners of the mask's hull.
    n_left = int(0)
    n_right = int(0)
    for i in range(begin, end):
        y = wp.float64(rows[i])
        left = lefts[i]
        right = rights[i]
        if i > begin and rows[i - 1] == rows[i] - 1:
            left = wp.min(left, lefts[i - 1])
            right = wp.max(right, rights[i - 1])
        n_left = add_to_chain(left_x, left_y, start, n_left, wp.float64(left), y, wp.float64(-1.0))
        n_right = add_to_chain(right_x, right_y, start, n_right, wp.float64(right), y, wp.float64(1.0))
        if i + 1 == end or rows[i + 1] != rows[i] + 1:
            below = y + wp.float64(1.0)
            n_left = add_to_chain(left_x, left_y, start, n_left, wp.float64(lefts[i]), below, wp.float64(-1.0))
            n_right = add_to_chain(right_x, right_y, start, n_right, wp.float64(rights[i]), below, wp.float64(1.0))
    # A least rectangle has a side along an edge of the hull (Freeman and Shapira, 1975).
    best = wp.float64(1.0e300)
    for e in range(n_left + n_right - 1):
        dx = wp.float64(1.0)
        dy = wp.float64(0.0)
        if e >= 1 and e < n_left:
            dx = left_x[start + e] - left_x[start + e - 1]
            dy = left_y[start + e] - left_y[start + e - 1]
        elif e >= n_left:
            k = e - n_left
            dx = right_x[start + k + 1] - right_x[start + k]
            dy = right_y[start + k + 1] - right_y[start + k]
        length = wp.sqrt(dx * dx + dy * dy)
        dx /= length
        dy /= length
        low_u = wp.float64(1.0e300)
        high_u = wp.float64(-1.0e300)
        low_v = wp.float64(1.0e300)
        high_v = wp.float64(-1.0e300)
        for k in range(n_left + n_right):
            x = wp.float64(0.0)
            y = wp.float64(0.0)
            if k < n_left:
                x = left_x[start + k]
                y = left_y[start + k]
            else:
                x = right_x[start + k - n_left]
                y = right_y[start + k - n_left]
            u = x * dx + y * dy
            v = y * dx - x * dy
            low_u = wp.min(low_u, u)
            high_u = wp.max(high_u, u)
            low_v = wp.min(low_v, v)
            high_v = wp.max(high_v, v)
        area = (high_u - low_u) * (high_v - low_v)
        if area < best * (wp.float64(1.0) - wp.float64(1.0e-12)):
            best = area
            u = wp.float64(0.5) * (low_u + high_u)
            v = wp.float64(0.5) * (low_v + high_v)
            rectangles[m, 0] = u * dx - v * dy
            rectangles[m, 1] = u * dy + v * dx
            rectangles[m, 2] = dx
            rectangles[m, 3] = dy
            rectangles[m, 4] = high_u - low_u
            rectangles[m, 5] = high_v - low_v

// Return the place from `begin` to `end` of the first box that overlaps with the one at `place`, `end` where none does.
typedef float Eight __attribute__((vector_size(32), aligned(4), may_alias));
typedef int Eight_i __attribute__((vector_size(32)));
const int stride = boxes.shape[1];
const float *const lower_x = boxes.data + 2 * stride, *const lower_y = lower_x + stride,
            *const lower_z = lower_y + stride, *const upper_x = lower_z + stride, *const upper_y = upper_x + stride,
            *const upper_z = upper_y + stride;
const float left_x = lower_x[place], left_y = lower_y[place], left_z = lower_z[place];
const float right_x = upper_x[place], right_y = upper_y[place], right_z = upper_z[place];
int other = begin;
#define AT(bounds) (*(const Eight*)(bounds + other))
for (; other + 8 <= end; other += 8) {
    const Eight_i overlap = (AT(lower_x) <= right_x) & (AT(upper_x) >= left_x) & (AT(lower_y) <= right_y) &
                            (AT(upper_y) >= left_y) & (AT(lower_z) <= right_z) & (AT(upper_z) >= left_z);
    if (__builtin_reduce_or(overlap)) break;
}
#undef AT
for (; other < end; ++other) {
    // All six, since a processor cannot foresee which of them fails.
    const int overlaps = (lower_x[other] <= right_x) & (upper_x[other] >= left_x) & (lower_y[other] <= right_y) &
                         (upper_y[other] >= left_y) & (lower_z[other] <= right_z) & (upper_z[other] >= left_z);
    if (overlaps) break;
}
return other;

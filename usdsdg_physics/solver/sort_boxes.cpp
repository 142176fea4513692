// Sort boxes by where they begin along a direction, those that begin at the same place by their numbers in `shapes`.
//
// Products and sums are rounded one by one and in Newton's own order, so that the sweep meets shapes in the same one.
#pragma clang fp contract(off)
const int count = order.shape[0], stride = boxes.shape[1];
int* const numbers = order.data;
float *const key = boxes.data, *const last = key + stride, *const bounds = last + stride;
const float dx = direction[0], dy = direction[1], dz = direction[2];
const float size_x = __builtin_fabsf(dx), size_y = __builtin_fabsf(dy), size_z = __builtin_fabsf(dz);
for (int i = 0; i < count; ++i) {
    const int shape = shapes.data[numbers[i]];
    const float* const low = (const float*)(lower.data + shape);
    const float* const high = (const float*)(upper.data + shape);
    const float middle = (dx * (0.5f * (low[0] + high[0])) + dy * (0.5f * (low[1] + high[1]))) +
                         dz * (0.5f * (low[2] + high[2]));
    const float half = (size_x * (0.5f * (high[0] - low[0])) + size_y * (0.5f * (high[1] - low[1]))) +
                       size_z * (0.5f * (high[2] - low[2]));
    // What is not a number overlaps with nothing.
    key[i] = middle - half < 1.0e30f ? middle - half : 1.0e30f;
    last[i] = middle + half;
}
// Shell's sort: shapes are nearly in the order of the substep before, but for the first and where many are moved.
int gap = 1;
while (gap < count / 9) gap = 3 * gap + 1;
for (; gap > 0; gap /= 3) {
    for (int i = gap; i < count; ++i) {
        const float begin = key[i], end = last[i];
        const int number = numbers[i];
        int at = i;
        for (; at >= gap; at -= gap) {
            const int before = at - gap;
            if (key[before] < begin || (key[before] == begin && numbers[before] < number)) break;
            key[at] = key[before];
            last[at] = last[before];
            numbers[at] = numbers[before];
        }
        key[at] = begin;
        last[at] = end;
        numbers[at] = number;
    }
}
for (int i = 0; i < count; ++i) {
    const int shape = shapes.data[numbers[i]];
    const float* const low = (const float*)(lower.data + shape);
    const float* const high = (const float*)(upper.data + shape);
    for (int axis = 0; axis < 3; ++axis) {
        bounds[axis * stride + i] = low[axis];
        bounds[(3 + axis) * stride + i] = high[axis];
    }
}

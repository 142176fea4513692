// Sort boxes by where they begin along a direction, those that begin at the same place by their numbers in `shapes`.
//
// Products and sums are rounded one by one and in Newton's own order, so that the sweep meets shapes in the same one.
#pragma clang fp contract(off)
const int count = order.shape[0], stride = boxes.shape[1];
int* const numbers = order.data;
float *const key = boxes.data, *const last = key + stride, *const bounds = last + stride;
const float dx = direction[0], dy = direction[1], dz = direction[2];
const float size_x = __builtin_fabsf(dx), size_y = __builtin_fabsf(dy), size_z = __builtin_fabsf(dz);
// By insertion: shapes are nearly in the order of the substep before.
for (int i = 0; i < count; ++i) {
    const int number = numbers[i], shape = shapes.data[number];
    const float* const low = (const float*)(lower.data + shape);
    const float* const high = (const float*)(upper.data + shape);
    const float middle = (dx * (0.5f * (low[0] + high[0])) + dy * (0.5f * (low[1] + high[1]))) +
                         dz * (0.5f * (low[2] + high[2]));
    const float half = (size_x * (0.5f * (high[0] - low[0])) + size_y * (0.5f * (high[1] - low[1]))) +
                       size_z * (0.5f * (high[2] - low[2]));
    // What is not a number overlaps with nothing.
    const float begin = middle - half < 1.0e30f ? middle - half : 1.0e30f, end = middle + half;
    int at = i;
    for (; at > 0 && (key[at - 1] > begin || (key[at - 1] == begin && numbers[at - 1] > number)); --at) {
        key[at] = key[at - 1];
        last[at] = last[at - 1];
        numbers[at] = numbers[at - 1];
    }
    key[at] = begin;
    last[at] = end;
    numbers[at] = number;
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

// Return the number of the corner of mesh `id` that is farthest along a direction, the first of several.
//
// Eight corners at a time, with products and sums rounded one by one in Newton's own order, so that it is the same one.
#pragma clang fp contract(off)
typedef float Eight __attribute__((vector_size(32), aligned(4), may_alias));
typedef int Eight_i __attribute__((vector_size(32)));
const wp::Mesh* const mesh = (const wp::Mesh*)id;
const float* const corners = (const float*)mesh->points.data;
const int count = mesh->points.shape[0];
const float dx = direction[0], dy = direction[1], dz = direction[2];
int best = 0, at = 0;
float farthest = -1.0e10f;
if (count >= 8) {
    Eight_i places = {0, 1, 2, 3, 4, 5, 6, 7}, best_of_each = {0, 0, 0, 0, 0, 0, 0, 0};
    Eight farthest_of_each = {farthest, farthest, farthest, farthest, farthest, farthest, farthest, farthest};
    for (; at + 8 <= count; at += 8) {
        // x y z of eight corners in a row, to eight of each.
        const Eight a = *(const Eight*)(corners + 3 * at), b = *(const Eight*)(corners + 3 * at + 8),
                    c = *(const Eight*)(corners + 3 * at + 16);
        const Eight x = __builtin_shufflevector(
            __builtin_shufflevector(a, b, 0, 3, 6, 9, 12, 15, -1, -1), c, 0, 1, 2, 3, 4, 5, 10, 13
        );
        const Eight y = __builtin_shufflevector(
            __builtin_shufflevector(a, b, 1, 4, 7, 10, 13, -1, -1, -1), c, 0, 1, 2, 3, 4, 8, 11, 14
        );
        const Eight z = __builtin_shufflevector(
            __builtin_shufflevector(a, b, 2, 5, 8, 11, 14, -1, -1, -1), c, 0, 1, 2, 3, 4, 9, 12, 15
        );
        const Eight along = (x * dx + y * dy) + z * dz;
        const Eight_i farther = along > farthest_of_each;
        farthest_of_each = (Eight)((farther & (Eight_i)along) | (~farther & (Eight_i)farthest_of_each));
        best_of_each = (farther & places) | (~farther & best_of_each);
        places += 8;
    }
    for (int lane = 0; lane < 8; ++lane) {
        const float along = farthest_of_each[lane];
        if (along > farthest || (along == farthest && best_of_each[lane] < best)) {
            farthest = along;
            best = best_of_each[lane];
        }
    }
}
for (; at < count; ++at) {
    const float along = (corners[3 * at] * dx + corners[3 * at + 1] * dy) + corners[3 * at + 2] * dz;
    if (along > farthest) {
        farthest = along;
        best = at;
    }
}
return best;

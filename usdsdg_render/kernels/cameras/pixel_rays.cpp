// Body of put_pixel_rays on a CPU: what `center_ray` of camera.py computes, operation by operation, for eight pixels at
// once. Rays of pixels that are not needed get no range, and hit nothing.
{
#pragma clang fp contract(off)
typedef float float8 __attribute__((ext_vector_type(8)));
typedef int int8 __attribute__((ext_vector_type(8)));
float8* const x = (float8*)((char*)memory.data + (size_t)tile * memory.strides[0]);
const auto& m = camera.rotation.data;
const int8 lane_bits = {1, 2, 4, 8, 16, 32, 64, 128};
const float8 lanes = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
for (int g = 0; g < 8; ++g) {
    const float8 column = lanes + ((float)left + PIXEL_CENTER);
    const float8 row = (float)(top + g) + PIXEL_CENTER;
    const float8 px = (column - camera.cx) / camera.fx, py = (camera.cy - row) / camera.fy;
    const float8 depth = -1.0f, length = __builtin_elementwise_sqrt(px * px + py * py + 1.0f);
    const float8 dx = px / length, dy = py / length, dz = depth / length;
    x[g] = m[0][0] * dx + m[0][1] * dy + m[0][2] * dz;
    x[8 + g] = m[1][0] * dx + m[1][1] * dy + m[1][2] * dz;
    x[16 + g] = m[2][0] * dx + m[2][1] * dy + m[2][2] * dz;
    x[24 + g] = camera.near * length;
    const float8 nowhere = -1.0f, far = camera.far * length;
    x[32 + g] = (lane_bits & (int)(needed >> (8 * g))) != 0 ? far : nowhere;
}
}

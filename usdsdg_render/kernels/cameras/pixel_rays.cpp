// Body of put_pixel_rays on a CPU: what `center_ray` of camera.py computes, operation by operation, for eight pixels at
// once. With `by_columns` the rows of the tile are eights of columns of one row of the image.
{
#pragma clang fp contract(off)
typedef float float8 __attribute__((ext_vector_type(8)));
float8* const x = (float8*)((char*)memory.data + (size_t)tile * memory.strides[0]);
const auto& m = camera.rotation.data;
const float8 lanes = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
for (int g = 0; g < rows; ++g) {
    const float8 column = lanes + ((float)(left + (by_columns ? 8 * g : 0)) + PIXEL_CENTER);
    const float8 row = (float)(top + (by_columns ? 0 : g)) + PIXEL_CENTER;
    const float8 px = (column - camera.cx) / camera.fx, py = (camera.cy - row) / camera.fy;
    const float8 depth = -1.0f, length = __builtin_elementwise_sqrt(px * px + py * py + 1.0f);
    const float8 dx = px / length, dy = py / length, dz = depth / length;
    x[g] = m[0][0] * dx + m[0][1] * dy + m[0][2] * dz;
    x[8 + g] = m[1][0] * dx + m[1][1] * dy + m[1][2] * dz;
    x[16 + g] = m[2][0] * dx + m[2][1] * dy + m[2][2] * dz;
    x[24 + g] = camera.near * length;
    x[32 + g] = camera.far * length;
}
}

// Body of closest, occluded, closest_in_instance and closest_in_part on a CPU; query.py sets ANY_HIT and
// ONE_INSTANCE, and defines is_in_part.
//
// TLAS and BLAS have one format: a node tests eight boxes at once, a leaf tests triangles in blocks of eight. The
// triangle test is that of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013): vertices are
// sheared into a frame where the ray runs along z, and the signs of three edge functions decide. Products in an edge
// function are rounded one by one (no fused multiply-add), so exchanging the ends of an edge exactly changes its sign:
// two triangles that share an edge can both miss a ray only if it passes outside both. A sign may round to zero but
// never flips, and zero counts as inside.
{
#pragma clang fp contract(off)
typedef float float8 __attribute__((ext_vector_type(8)));
typedef int int8 __attribute__((ext_vector_type(8)));
typedef bool bool8 __attribute__((ext_vector_type(8)));

struct Entry {
    float t;
    int node;
};
constexpr int FINISHED = -2147483647 - 1;
// The far side of a slab is moved out by three roundings, so that a box never hides what it contains (Ize, JCGT 2013).
constexpr float WIDEN = 1.0000004f;

// A zero direction component is replaced by a tiny one. It must be so tiny that a ray cannot leave a flat box, even one
// that a corner like (cos(pi / 2), 0, 1) made 6e-17 wider than its neighbor.
auto reciprocal = [](float x) { return 1.0f / (x > 1e-37f || x < -1e-37f ? x : (x < 0 ? -1e-37f : 1e-37f)); };
// One instruction each; the elementwise builtins would handle NaN, which does not occur.
auto larger = [](float8 a, float8 b) -> float8 { return a > b ? a : b; };
auto smaller = [](float8 a, float8 b) -> float8 { return a < b ? a : b; };
auto mask_of = [](int8 lanes) -> unsigned {
    return (unsigned)__builtin_bit_cast(unsigned char, __builtin_convertvector(lanes, bool8));
};

float best_t = tmax, best_u = 0.0f, best_v = 0.0f;
int best_instance = -1, best_triangle = -1;
Entry stack[STACK_SIZE];
int top = 0;

// The ray in the frame of the current tree: the world, or the instance that was entered.
float ox = origin[0], oy = origin[1], oz = origin[2];
float dx = direction[0], dy = direction[1], dz = direction[2];
float rx = reciprocal(dx), ry = reciprocal(dy), rz = reciprocal(dz);
const float world_rx = rx, world_ry = ry, world_rz = rz;
const float* nodes = (const float*)tlas.nodes;
const float* blocks = nullptr;
int entered = -1, floor_of_instance = 0;
int node = 0;

// Shear of the watertight test: rows of a block are offset by the permuted axes, so permuting costs nothing.
int kx = 0, ky = 8, kz = 16;
float sx = 0.0f, sy = 0.0f, sz = 0.0f, okx = 0.0f, oky = 0.0f, okz = 0.0f;

auto enter = [&](int index) {
    const auto& in = tlas.instances.data[index];
    const auto& m = in.world_to_local.data;
    entered = index;
    floor_of_instance = top;
    // The difference first: it is exact near the instance, however far that is from the world origin.
    const auto& start = in.world_origin;
    const float wx = origin[0] - start[0], wy = origin[1] - start[1], wz = origin[2] - start[2];
    const float ex = direction[0], ey = direction[1], ez = direction[2];
    ox = m[0][0] * wx + m[0][1] * wy + m[0][2] * wz;
    oy = m[1][0] * wx + m[1][1] * wy + m[1][2] * wz;
    oz = m[2][0] * wx + m[2][1] * wy + m[2][2] * wz;
    dx = m[0][0] * ex + m[0][1] * ey + m[0][2] * ez;
    dy = m[1][0] * ex + m[1][1] * ey + m[1][2] * ez;
    dz = m[2][0] * ex + m[2][1] * ey + m[2][2] * ez;
    rx = reciprocal(dx);
    ry = reciprocal(dy);
    rz = reciprocal(dz);
    const float ax = __builtin_fabsf(dx), ay = __builtin_fabsf(dy), az = __builtin_fabsf(dz);
    if (ax > ay && ax > az) {
        kx = 8, ky = 16, kz = 0;
        sz = 1.0f / dx, sx = dy * sz, sy = dz * sz;
        okx = oy, oky = oz, okz = ox;
    } else if (ay > az) {
        kx = 16, ky = 0, kz = 8;
        sz = 1.0f / dy, sx = dz * sz, sy = dx * sz;
        okx = oz, oky = ox, okz = oy;
    } else {
        kx = 0, ky = 8, kz = 16;
        sz = 1.0f / dz, sx = dx * sz, sy = dy * sz;
        okx = ox, oky = oy, okz = oz;
    }
    nodes = (const float*)in.nodes;
    blocks = (const float*)in.blocks;
    node = 0;
};

wp::vec_t<5, int> found;
found[3] = -1;
if (ONE_INSTANCE)
    enter(only_instance);
else if (tlas.instance_count == 0)
    return found;

for (;;) {
    while (node >= 0) {
        const float* box = nodes + (size_t)node * 64;
        const int nx = rx < 0 ? 24 : 0, ny = ry < 0 ? 32 : 8, nz = rz < 0 ? 40 : 16;
        const float wide_rx = rx * WIDEN, wide_ry = ry * WIDEN, wide_rz = rz * WIDEN;
        const float8 near_x = (*(const float8*)(box + nx) - ox) * rx, far_x = (*(const float8*)(box + 24 - nx) - ox) * wide_rx;
        const float8 near_y = (*(const float8*)(box + ny) - oy) * ry, far_y = (*(const float8*)(box + 40 - ny) - oy) * wide_ry;
        const float8 near_z = (*(const float8*)(box + nz) - oz) * rz, far_z = (*(const float8*)(box + 56 - nz) - oz) * wide_rz;
        const float8 first = tmin, last = best_t;
        const float8 t_near = larger(larger(near_x, near_y), larger(near_z, first));
        const float8 t_far = smaller(smaller(far_x, far_y), smaller(far_z, last));
        unsigned hits = mask_of(t_near <= t_far);
        if (!hits) {
            node = FINISHED;
            break;
        }
        const int* child = (const int*)(box + 48);
        int k = __builtin_ctz(hits);
        hits &= hits - 1;
        if (!hits) {
            node = child[k];
            continue;
        }
        // Push all hits, nearest on top.
        const int bottom = top;
        float entry_t[8];
        __builtin_memcpy(entry_t, &t_near, 32);
        stack[top++] = {entry_t[k], child[k]};
        while (hits) {
            k = __builtin_ctz(hits);
            hits &= hits - 1;
            const float tk = entry_t[k];
            int j = top++;
            while (j > bottom && stack[j - 1].t < tk) {
                stack[j] = stack[j - 1];
                --j;
            }
            stack[j] = {tk, child[k]};
        }
        node = stack[--top].node;
    }
    if (node != FINISHED) {
        const int leaf = ~node;
        if (entered < 0) {
            if (!(ANY_HIT && !tlas.instances.data[leaf].casts_shadow)) {
                enter(leaf);
                continue;
            }
        } else {
            const float* block = blocks + (size_t)(leaf >> 2) * 80;
            for (int left = leaf & 3; left > 0; --left, block += 80) {
                const float8 az = *(const float8*)(block + kz) - okz;
                const float8 bz = *(const float8*)(block + 24 + kz) - okz;
                const float8 cz = *(const float8*)(block + 48 + kz) - okz;
                const float8 shear_x = -sx, shear_y = -sy;
                const float8 ax = __builtin_elementwise_fma(shear_x, az, *(const float8*)(block + kx) - okx);
                const float8 ay = __builtin_elementwise_fma(shear_y, az, *(const float8*)(block + ky) - oky);
                const float8 bx = __builtin_elementwise_fma(shear_x, bz, *(const float8*)(block + 24 + kx) - okx);
                const float8 by = __builtin_elementwise_fma(shear_y, bz, *(const float8*)(block + 24 + ky) - oky);
                const float8 cx = __builtin_elementwise_fma(shear_x, cz, *(const float8*)(block + 48 + kx) - okx);
                const float8 cy = __builtin_elementwise_fma(shear_y, cz, *(const float8*)(block + 48 + ky) - oky);
                const float8 a = cx * by - cy * bx, b = ax * cy - ay * cx, c = bx * ay - by * ax;
                const float8 zero = 0.0f;
                const float8 least = smaller(smaller(a, b), c);
                const float8 most = larger(larger(a, b), c);
                const float8 det = a + b + c;
                const int8 inside = ((least >= zero) | (most <= zero)) & (det != zero);
                if (!mask_of(inside))
                    continue;
                const float8 scale = 1.0f / det;
                const float8 t = (a * az + b * bz + c * cz) * (scale * sz);
                unsigned hits = mask_of(inside & (t > tmin) & (t < best_t));
                if (!hits)
                    continue;
                if (ANY_HIT) {
                    found[3] = entered;
                    return found;
                }
                do {
                    const int k = __builtin_ctz(hits);
                    hits &= hits - 1;
                    const int triangle = ((const int*)(block + 72))[k];
                    if (t[k] < best_t && is_in_part(triangle)) {
                        best_t = t[k];
                        best_u = b[k] * scale[k];
                        best_v = c[k] * scale[k];
                        best_instance = entered;
                        best_triangle = triangle;
                    }
                } while (hits);
            }
        }
    }
    // Pop the next node, first of the instance, then of the world.
    do {
        if (entered >= 0 && top == floor_of_instance) {
            if (ONE_INSTANCE)
                goto done;
            entered = -1;
            nodes = (const float*)tlas.nodes;
            ox = origin[0], oy = origin[1], oz = origin[2];
            rx = world_rx, ry = world_ry, rz = world_rz;
        }
        if (top == 0)
            goto done;
        --top;
    } while (stack[top].t >= best_t);
    node = stack[top].node;
}
done:
found[0] = __builtin_bit_cast(int, best_t);
found[1] = __builtin_bit_cast(int, best_u);
found[2] = __builtin_bit_cast(int, best_v);
found[3] = best_instance;
found[4] = best_triangle;
return found;
}

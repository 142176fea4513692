// Body of closest, occluded, closest_in_instance and closest_in_part on CUDA; query.py sets ANY_HIT and
// ONE_INSTANCE, and defines is_in_part.
//
// The two levels of traverse.cpp with nodes of 80 bytes (see compress.py), after Ylitie, Karras and Laine, "Efficient
// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs" (HPG 2017): a group is a base index and a word whose
// high byte marks nodes still to visit, nearest first, and whose low 24 bits mark triangles or instances. Rays and
// triangles are rounded as in traverse.cpp, so both devices find the same hits; in modules with fast math, those of the
// path tracer, reciprocals are approximate.
constexpr float WIDEN = 1.0000005f;
constexpr unsigned LEAVES = 0x00ffffffu, ROOT = 0x80000000u;
using wp::uint32;

struct Group {
    uint32 base, bits;
};
auto reciprocal = [](float x) { return 1.0f / (x * x > 1e-36f ? x : (x < 0 ? -1e-18f : 1e-18f)); };
auto dot3 = [](float a, float b, float c, float x, float y, float z) {
    return __fadd_rn(__fadd_rn(__fmul_rn(a, x), __fmul_rn(b, y)), __fmul_rn(c, z));
};
auto cross2 = [](float ax, float ay, float bx, float by) { return __fsub_rn(__fmul_rn(ax, by), __fmul_rn(ay, bx)); };
// Byte k of a word as 1 + byte / FINE: one permute, where an integer conversion takes the time of four.
constexpr float FINE = 32768.0f;
auto one_and_byte = [](uint32 word, int k) {
    return __uint_as_float(__byte_perm(word, 0x3f800000u, 0x7604u + (k << 4)));
};
// Largest and smallest of three floats by their bit patterns: exact if positive, else still negative.
auto largest = [](float a, float b, float c) {
    return __int_as_float(__vimax3_s32(__float_as_int(a), __float_as_int(b), __float_as_int(c)));
};
auto smallest = [](float a, float b, float c) {
    return __int_as_float(__vimin3_s32(__float_as_int(a), __float_as_int(b), __float_as_int(c)));
};

float best_t = tmax, best_u = 0.0f, best_v = 0.0f;
int best_instance = -1, best_triangle = -1;
Group stack[STACK_SIZE];
int top = 0, entered = -1, floor_of_instance = 0;

// The ray in the frame of the current tree: the world, or the instance that was entered.
float ox, oy, oz, rx, ry, rz;
uint32 octant;
const uint4* nodes;
const float4* triangles = nullptr;
int axis = 2;  // the ray's longest, z of the sheared frame
float sx = 0.0f, sy = 0.0f, sz = 0.0f, okx = 0.0f, oky = 0.0f, okz = 0.0f;

auto look_along = [&](float px, float py, float pz, float dx, float dy, float dz) {
    ox = px, oy = py, oz = pz;
    rx = reciprocal(dx), ry = reciprocal(dy), rz = reciprocal(dz);
    octant = 7u - ((rx < 0 ? 4u : 0u) | (ry < 0 ? 2u : 0u) | (rz < 0 ? 1u : 0u));
};
auto into_world = [&]() {
    entered = -1;
    nodes = (const uint4*)tlas.nodes;
    look_along(origin[0], origin[1], origin[2], direction[0], direction[1], direction[2]);
};
auto enter = [&](int index) {
    const auto& in = tlas.instances.data[index];
    const auto& m = in.world_to_local.data;
    entered = index;
    floor_of_instance = top;
    const auto& start = in.world_origin;
    const float wx = __fsub_rn(origin[0], start[0]), wy = __fsub_rn(origin[1], start[1]);
    const float wz = __fsub_rn(origin[2], start[2]);
    const float ex = direction[0], ey = direction[1], ez = direction[2];
    const float dx = dot3(m[0][0], m[0][1], m[0][2], ex, ey, ez);
    const float dy = dot3(m[1][0], m[1][1], m[1][2], ex, ey, ez);
    const float dz = dot3(m[2][0], m[2][1], m[2][2], ex, ey, ez);
    look_along(
        dot3(m[0][0], m[0][1], m[0][2], wx, wy, wz), dot3(m[1][0], m[1][1], m[1][2], wx, wy, wz),
        dot3(m[2][0], m[2][1], m[2][2], wx, wy, wz), dx, dy, dz);
    const float ax = fabsf(dx), ay = fabsf(dy), az = fabsf(dz);
    if (ax > ay && ax > az) {
        axis = 0;
        sz = 1.0f / dx, sx = __fmul_rn(dy, sz), sy = __fmul_rn(dz, sz);
        okx = oy, oky = oz, okz = ox;
    } else if (ay > az) {
        axis = 1;
        sz = 1.0f / dy, sx = __fmul_rn(dz, sz), sy = __fmul_rn(dx, sz);
        okx = oz, oky = ox, okz = oy;
    } else {
        axis = 2;
        sz = 1.0f / dz, sx = __fmul_rn(dx, sz), sy = __fmul_rn(dy, sz);
        okx = ox, oky = oy, okz = oz;
    }
    nodes = (const uint4*)in.nodes;
    triangles = (const float4*)in.blocks;
};
// Transform a corner into the sheared frame.
auto shear = [&](const float4& p, float& x, float& y, float& z) {
    const float px = axis == 0 ? p.y : (axis == 1 ? p.z : p.x);
    const float py = axis == 0 ? p.z : (axis == 1 ? p.x : p.y);
    z = __fsub_rn(axis == 0 ? p.x : (axis == 1 ? p.y : p.z), okz);
    x = __fmaf_rn(-sx, z, __fsub_rn(px, okx));
    y = __fmaf_rn(-sy, z, __fsub_rn(py, oky));
};
// Whether the triangle is hit closer than the best hit so far.
auto intersects = [&](int item) {
    const float4* corner = triangles + 3 * (size_t)item;
    const float4 p0 = __ldg(corner), p1 = __ldg(corner + 1), p2 = __ldg(corner + 2);
    float ax, ay, az, bx, by, bz, cx, cy, cz;
    shear(p0, ax, ay, az);
    shear(p1, bx, by, bz);
    shear(p2, cx, cy, cz);
    const float a = cross2(cx, cy, bx, by), b = cross2(ax, ay, cx, cy), c = cross2(bx, by, ax, ay);
    const bool inside = fminf(fminf(a, b), c) >= 0.0f || fmaxf(fmaxf(a, b), c) <= 0.0f;
    const float det = __fadd_rn(__fadd_rn(a, b), c);
    if (!inside || det == 0.0f)
        return false;
    const float scale = 1.0f / det;
    const float t = __fmul_rn(dot3(a, b, c, az, bz, cz), __fmul_rn(scale, sz));
    if (!(t > tmin && t < best_t && is_in_part(__float_as_int(p0.w))))
        return false;
    best_t = t;
    best_u = __fmul_rn(b, scale);
    best_v = __fmul_rn(c, scale);
    best_instance = entered;
    best_triangle = __float_as_int(p0.w);
    return true;
};

wp::vec_t<5, int> found;
found[3] = -1;
if (ONE_INSTANCE)
    enter(only_instance);
else if (tlas.instance_count == 0)
    return found;
else
    into_world();

Group inner = {0u, ROOT}, leaves = {0u, 0u};
for (;;) {
    if (inner.bits > LEAVES) {
        const int bit = 31 - __clz(inner.bits);
        const uint32 slot = (uint32)(bit - 24) ^ octant;
        const uint32 child = inner.base + __popc(inner.bits & 0xffu & ~(0xffffffffu << slot));
        inner.bits &= ~(1u << bit);
        if (inner.bits > LEAVES)
            stack[top++] = inner;
        const uint4* node = nodes + 5 * (size_t)child;
        const uint4 head = __ldg(node), links = __ldg(node + 1);
        const uint4 low_xy = __ldg(node + 2), mixed = __ldg(node + 3), high_yz = __ldg(node + 4);
        // Boxes are quantized in steps of a power of two from the node's corner.
        const float adx = __uint_as_float((head.w & 255u) << 23) * (rx * FINE);
        const float ady = __uint_as_float((head.w >> 8 & 255u) << 23) * (ry * FINE);
        const float adz = __uint_as_float((head.w >> 16 & 255u) << 23) * (rz * FINE);
        const float cx = (__uint_as_float(head.x) - ox) * rx - adx;
        const float cy = (__uint_as_float(head.y) - oy) * ry - ady;
        const float cz = (__uint_as_float(head.z) - oz) * rz - adz;
        uint32 hits = 0u;
#pragma unroll
        for (int half = 0; half < 2; ++half) {
            const uint32 meta = half ? links.w : links.z;
            const uint32 is_inner = (meta & (meta << 1)) & 0x10101010u;
            const uint32 inner_mask = (is_inner >> 4) * 0xffu;
            const uint32 bit_index = (meta ^ (octant * 0x01010101u & inner_mask)) & 0x1f1f1f1fu;
            const uint32 child_bits = meta >> 5 & 0x07070707u;
            const uint32 lx = half ? low_xy.y : low_xy.x, ly = half ? low_xy.w : low_xy.z;
            const uint32 lz = half ? mixed.y : mixed.x, hx = half ? mixed.w : mixed.z;
            const uint32 hy = half ? high_yz.y : high_yz.x, hz = half ? high_yz.w : high_yz.z;
            const uint32 near_x = rx < 0 ? hx : lx, far_x = rx < 0 ? lx : hx;
            const uint32 near_y = ry < 0 ? hy : ly, far_y = ry < 0 ? ly : hy;
            const uint32 near_z = rz < 0 ? hz : lz, far_z = rz < 0 ? lz : hz;
#pragma unroll
            for (int k = 0; k < 4; ++k) {
                const float t_near = fmaxf(tmin, largest(
                    fmaf(one_and_byte(near_x, k), adx, cx), fmaf(one_and_byte(near_y, k), ady, cy),
                    fmaf(one_and_byte(near_z, k), adz, cz)));
                const float t_far = smallest(
                    fmaf(one_and_byte(far_x, k), adx, cx), fmaf(one_and_byte(far_y, k), ady, cy),
                    fmaf(one_and_byte(far_z, k), adz, cz));
                if (t_near <= fminf(t_far * WIDEN, best_t))
                    hits |= (child_bits >> (8 * k) & 255u) << (bit_index >> (8 * k) & 255u);
            }
        }
        inner = {links.x, (hits & ~LEAVES) | head.w >> 24};
        leaves = {links.y, hits & LEAVES};
    } else {
        leaves = inner;
        inner.bits = 0u;
    }
    while (leaves.bits) {
        const int k = 31 - __clz(leaves.bits);
        leaves.bits &= ~(1u << k);
        const int item = (int)leaves.base + k;
        if (entered >= 0) {
            if (intersects(item) && ANY_HIT) {
                found[3] = entered;
                return found;
            }
            continue;
        }
        const int instance = tlas.order.data[item];
        if (ANY_HIT && !tlas.instances.data[instance].casts_shadow)
            continue;
        if (leaves.bits)
            stack[top++] = leaves;
        if (inner.bits > LEAVES)
            stack[top++] = inner;
        enter(instance);
        inner = {0u, ROOT};
        break;
    }
    if (inner.bits > LEAVES)
        continue;
    if (entered >= 0 && top == floor_of_instance) {
        if (ONE_INSTANCE)
            break;
        into_world();
    }
    if (top == 0)
        break;
    inner = stack[--top];
}
found[0] = __float_as_int(best_t);
found[1] = __float_as_int(best_u);
found[2] = __float_as_int(best_v);
found[3] = best_instance;
found[4] = best_triangle;
return found;

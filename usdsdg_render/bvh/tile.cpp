// Body of trace_tile and trace_tile_in_instance on a CPU: hits of the rays of 8 x 8 pixels, which start at one point.
// tile.py sets ONE_INSTANCE: whether a ray hits one of its triangles counts then, and not which is the closest.
//
// One instruction does the work of the eight rays of a row. The tree is traversed once for the tile: a node is entered
// where its box meets the pyramid of the tile, and a triangle is tested with those rows that it may reach. The test is
// that of traverse.cpp, operation by operation, so hits have the same bits. What differs is the order in which triangles
// are met, and which boxes: a ray to which two hits are equally near, or that passes along an edge, up to rounding, is
// marked as undecided, and the caller traces it by itself. So are all rays of a tile whose pyramid rounding leaves without
// a volume.
{
#pragma clang fp contract(off)
typedef float float8 __attribute__((ext_vector_type(8)));
typedef int int8 __attribute__((ext_vector_type(8)));
typedef bool bool8 __attribute__((ext_vector_type(8)));
typedef unsigned char byte;

constexpr int ROWS = 8;
constexpr int FINISHED = -2147483647 - 1;
// Rounding of a sum of three products, relative to their magnitudes, with a margin.
constexpr float ROUNDING = 1e-6f;
// By how many rows the extent of a triangle is widened.
constexpr float ROW_MARGIN = 0.1f;

struct Entry {
    float t;
    int node;
};

auto larger = [](float8 a, float8 b) -> float8 { return a > b ? a : b; };
auto smaller = [](float8 a, float8 b) -> float8 { return a < b ? a : b; };
auto absolute = [](float8 a) -> float8 { return __builtin_elementwise_abs(a); };
auto mask_of = [](int8 lanes) -> unsigned {
    return (unsigned)__builtin_bit_cast(byte, __builtin_convertvector(lanes, bool8));
};
auto largest = [](float8 a) -> float { return __builtin_reduce_max(a); };
auto smallest = [](float8 a) -> float { return __builtin_reduce_min(a); };

// Rows of the tile in memory: inputs are directions and ranges, outputs are packed hits.
const char* const start_of_tile = (const char*)memory.data + (size_t)tile * memory.strides[0];
const float8 *const world_x = (const float8*)start_of_tile, *const world_y = world_x + ROWS, *const world_z = world_y + ROWS;
const float8 *const tmin = world_z + ROWS, *const tmax = tmin + ROWS;
float8 *const best_t = (float8*)(tmax + ROWS), *const best_u = best_t + ROWS, *const best_v = best_u + ROWS;
int8 *const best_instance = (int8*)(best_v + ROWS), *const best_triangle = best_instance + ROWS;
int8* const undecided = best_triangle + ROWS;
// Directions through the corners of the tile, in cyclic order, beginning with both ends of the first row's outer side.
const float* const corners = (const float*)(undecided + ROWS);
float8 best_error[ROWS];  // by which the distance of the hit may be rounded
float row_far[ROWS], tile_far = 0.0f;  // up to where hits count
for (int g = 0; g < ROWS; ++g) {
    best_t[g] = tmax[g];
    best_u[g] = best_v[g] = best_error[g] = 0.0f;
    best_instance[g] = best_triangle[g] = -1;
    undecided[g] = 0;
    row_far[g] = largest(tmax[g]);
    tile_far = tile_far > row_far[g] ? tile_far : row_far[g];
}
auto leave_undecided = [&]() {
    for (int g = 0; g < ROWS; ++g) undecided[g] = -1;
};
if (!ONE_INSTANCE && tlas.instance_count == 0)
    return;

// The rays in the frame of a tree, and planes that bound them: inside, the products with the normals are positive.
struct Frame {
    float origin[3], depth[3];  // depth: products with it are depths
    float normals[4][3];
    float per_depth;  // t of the ray that goes deepest
    float first_row, rows_of_side;  // row = (product with the first normal / depth - first_row) * rows_of_side
};
float8 local_x[ROWS], local_y[ROWS], local_z[ROWS];

// Set the planes of a frame; q: the corners of the tile there. False: rounding leaves the pyramid without a volume.
auto set_planes = [&](Frame& f, const float8* x, const float8* y, const float8* z, float q[4][3]) -> bool {
    // Depths and products are linear in the place in the image, so that their least values are those of the corners.
    const int outer[2] = {0, ROWS - 1};
    float8 inverse[2], low_depth = 3e38f, high_depth = 0.0f;
    float8 spread_x = 0.0f, spread_y = 0.0f, spread_z = 0.0f;
    for (int g = 0; g < ROWS; ++g)
        high_depth = larger(high_depth, x[g] * f.depth[0] + y[g] * f.depth[1] + z[g] * f.depth[2]);
    for (int k = 0; k < 2; ++k) {
        const float8 dx = x[outer[k]], dy = y[outer[k]], dz = z[outer[k]];
        const float8 in_x = dx * f.depth[0], in_y = dy * f.depth[1], in_z = dz * f.depth[2];
        const float8 depth = in_x + in_y + in_z, error = ROUNDING * (absolute(in_x) + absolute(in_y) + absolute(in_z));
        low_depth = smaller(low_depth, depth - 2.0f * error);
        high_depth = larger(high_depth, depth + 2.0f * error);
        inverse[k] = 1.0f / depth;
        spread_x = larger(spread_x, absolute(dx * inverse[k]));
        spread_y = larger(spread_y, absolute(dy * inverse[k]));
        spread_z = larger(spread_z, absolute(dz * inverse[k]));
    }
    const float reach = largest(high_depth) * (1.0f + 4.0f * ROUNDING);
    if (!(smallest(low_depth) > 0.0f) || !(reach < 3e38f))
        return false;
    f.per_depth = 1.0f / reach;
    const float spread[3] = {largest(spread_x), largest(spread_y), largest(spread_z)};
    for (int k = 0; k < 4; ++k) {
        const float depth = q[k][0] * f.depth[0] + q[k][1] * f.depth[1] + q[k][2] * f.depth[2];
        for (int i = 0; i < 3; ++i) q[k][i] *= 1.0f / depth;
    }
    for (int k = 0; k < 4; ++k) {
        const float *a = q[k], *b = q[(k + 1) & 3], *c = q[(k + 2) & 3];
        float n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
        float width = n[0] * c[0] + n[1] * c[1] + n[2] * c[2];
        if (width < 0)
            n[0] = -n[0], n[1] = -n[1], n[2] = -n[2], width = -width;
        float8 least = 3e38f;
        for (int j = 0; j < 2; ++j) {
            const float8 product = x[outer[j]] * n[0] + y[outer[j]] * n[1] + z[outer[j]] * n[2];
            least = smaller(least, product * inverse[j]);
        }
        // All rays are inside by more than rounding: where they are not, the plane is moved out.
        float terms = 0.0f;
        for (int i = 0; i < 3; ++i) terms += __builtin_fabsf(n[i]) * spread[i];
        float shift = 6.0f * ROUNDING * terms - smallest(least);
        if (!(width > 0.0f) || !(shift < 3e38f))
            return false;
        shift = shift > 0.0f ? shift : 0.0f;
        for (int i = 0; i < 3; ++i) f.normals[k][i] = n[i] + shift * f.depth[i];
        if (k == 0)
            f.first_row = shift, f.rows_of_side = (float)ROWS / width;
    }
    return true;
};

Frame world_frame, local_frame;
float8 finite = 0.0f;
for (int g = 0; g < ROWS; ++g) finite += 0.0f * (world_x[g] + world_y[g] + world_z[g]);
for (int i = 0; i < 3; ++i) {
    world_frame.origin[i] = origin[i], world_frame.depth[i] = forward[i];
    finite += 0.0f * origin[i];
}
if (mask_of(finite != 0.0f)) {
    leave_undecided();
    return;
}

// Shear of the watertight test. Rays whose largest components are along different axes make different classes.
float8 shear_x[ROWS], shear_y[ROWS], shear_z[ROWS];
byte rows_of_class[3][ROWS];
bool has_class[3];
const int axes[3][3] = {{8, 16, 0}, {16, 0, 8}, {0, 8, 16}};  // offsets of the permuted axes in a block: x, y, z

auto enter = [&](int index) -> bool {
    const auto& in = tlas.instances.data[index];
    const auto& m = in.world_to_local.data;
    const auto& to_world = in.local_to_world.data;
    const auto& start = in.world_origin;
    const float wx = origin[0] - start[0], wy = origin[1] - start[1], wz = origin[2] - start[2];
    for (int i = 0; i < 3; ++i) {
        local_frame.origin[i] = m[i][0] * wx + m[i][1] * wy + m[i][2] * wz;
        local_frame.depth[i] = to_world[0][i] * forward[0] + to_world[1][i] * forward[1] + to_world[2][i] * forward[2];
    }
    has_class[0] = has_class[1] = has_class[2] = false;
    for (int g = 0; g < ROWS; ++g) {
        const float8 ex = world_x[g], ey = world_y[g], ez = world_z[g];
        const float8 dx = m[0][0] * ex + m[0][1] * ey + m[0][2] * ez;
        const float8 dy = m[1][0] * ex + m[1][1] * ey + m[1][2] * ez;
        const float8 dz = m[2][0] * ex + m[2][1] * ey + m[2][2] * ez;
        local_x[g] = dx, local_y[g] = dy, local_z[g] = dz;
        const float8 ax = absolute(dx), ay = absolute(dy), az = absolute(dz);
        const int8 is_x = (ax > ay) & (ax > az), is_y = ~is_x & (ay > az);
        const float8 one = 1.0f;
        const float8 sz = one / (is_x ? dx : (is_y ? dy : dz));
        shear_z[g] = sz;
        shear_x[g] = -((is_x ? dy : (is_y ? dz : dx)) * sz);
        shear_y[g] = -((is_x ? dz : (is_y ? dx : dy)) * sz);
        rows_of_class[0][g] = (byte)mask_of(is_x);
        rows_of_class[1][g] = (byte)mask_of(is_y);
        rows_of_class[2][g] = (byte)~(rows_of_class[0][g] | rows_of_class[1][g]);
        for (int c = 0; c < 3; ++c) has_class[c] |= rows_of_class[c][g] != 0;
    }
    float q[4][3];
    for (int k = 0; k < 4; ++k) {
        const float* c = corners + 3 * k;
        for (int i = 0; i < 3; ++i) q[k][i] = m[i][0] * c[0] + m[i][1] * c[1] + m[i][2] * c[2];
    }
    return set_planes(local_frame, local_x, local_y, local_z, q);
};

const int8 lane_bits = {1, 2, 4, 8, 16, 32, 64, 128};
// Test the triangle in a lane of a block with rows of the tile; return whether it was hit.
auto test_triangle = [&](const float* block, int lane, int first_row, int last_row, float nearest, int instance) -> bool {
    const int triangle = ((const int*)(block + 72))[lane];
    bool was_hit = false;
    for (int c = 0; c < 3; ++c) {
        if (!has_class[c])
            continue;
        const int kx = axes[c][0], ky = axes[c][1], kz = axes[c][2];
        const float okx = local_frame.origin[kx >> 3], oky = local_frame.origin[ky >> 3], okz = local_frame.origin[kz >> 3];
        const float* v = block + lane;
        const float az = v[kz] - okz, bz = v[24 + kz] - okz, cz = v[48 + kz] - okz;
        const float px = v[kx] - okx, py = v[ky] - oky;
        const float qx = v[24 + kx] - okx, qy = v[24 + ky] - oky;
        const float rx = v[48 + kx] - okx, ry = v[48 + ky] - oky;
        const float depth_error = ROUNDING * (__builtin_fabsf(az) + __builtin_fabsf(bz) + __builtin_fabsf(cz));
        for (int g = first_row; g <= last_row; ++g) {
            const unsigned lanes = rows_of_class[c][g];
            if (!lanes || nearest > row_far[g])
                continue;
            const float8 sx = shear_x[g], sy = shear_y[g];
            const float8 az8 = az, bz8 = bz, cz8 = cz;
            const float8 px8 = px, py8 = py, qx8 = qx, qy8 = qy, rx8 = rx, ry8 = ry;
            const float8 ax = __builtin_elementwise_fma(sx, az8, px8), ay = __builtin_elementwise_fma(sy, az8, py8);
            const float8 bx = __builtin_elementwise_fma(sx, bz8, qx8), by = __builtin_elementwise_fma(sy, bz8, qy8);
            const float8 cx = __builtin_elementwise_fma(sx, cz8, rx8), cy = __builtin_elementwise_fma(sy, cz8, ry8);
            const float8 a1 = cx * by, a2 = cy * bx, b1 = ax * cy, b2 = ay * cx, c1 = bx * ay, c2 = by * ax;
            const float8 a = a1 - a2, b = b1 - b2, c8 = c1 - c2;
            const float8 zero = 0.0f;
            const float8 least = smaller(smaller(a, b), c8);
            const float8 most = larger(larger(a, b), c8);
            const float8 det = a + b + c8;
            int8 inside = ((least >= zero) | (most <= zero)) & (det != zero);
            if (lanes != 255)
                inside &= (lane_bits & (int)lanes) != 0;
            if (!mask_of(inside))
                continue;
            const float8 one = 1.0f;
            const float8 scale = one / det;
            const float8 t = (a * az8 + b * bz8 + c8 * cz8) * (scale * shear_z[g]);
            const float8 error = depth_error * absolute(shear_z[g]) + ROUNDING * absolute(t);
            undecided[g] |= inside & (absolute(t - tmin[g]) <= error);
            inside &= t > tmin[g];
            if (ONE_INSTANCE) {
                // Any hit will do: a ray that has one needs no other.
                const int8 hits = inside & (t < best_t[g]);
                undecided[g] |= inside & (absolute(t - tmax[g]) <= error);
                if (!mask_of(hits))
                    continue;
                const int8 instance8 = instance;
                const float8 nowhere = -3e38f;
                best_instance[g] = hits ? instance8 : best_instance[g];
                best_t[g] = hits ? nowhere : best_t[g];
                row_far[g] = largest(best_t[g]);
                was_hit = true;
                continue;
            }
            const float8 difference = t - best_t[g], margin = error + best_error[g];
            const int8 closer = inside & (difference < zero);
            // A ray along an edge may pass beside the boxes of the triangle, which a tile enters and a ray does not.
            const int8 on_edge = (absolute(a) <= ROUNDING * (absolute(a1) + absolute(a2)))
                | (absolute(b) <= ROUNDING * (absolute(b1) + absolute(b2)))
                | (absolute(c8) <= ROUNDING * (absolute(c1) + absolute(c2)));
            const int8 tied = inside & ((absolute(difference) <= margin) | (closer & on_edge));
            undecided[g] = (undecided[g] & ~(closer & ~tied)) | tied;
            if (!mask_of(closer))
                continue;
            best_t[g] = closer ? t : best_t[g];
            best_u[g] = closer ? b * scale : best_u[g];
            best_v[g] = closer ? c8 * scale : best_v[g];
            best_error[g] = closer ? error : best_error[g];
            const int8 instance8 = instance, triangle8 = triangle;
            best_instance[g] = closer ? instance8 : best_instance[g];
            best_triangle[g] = closer ? triangle8 : best_triangle[g];
            row_far[g] = largest(best_t[g]) * (1.0f + 4.0f * ROUNDING);
            was_hit = true;
        }
    }
    return was_hit;
};

auto test_block = [&](const float* block, int instance) -> bool {
    const Frame& f = local_frame;
    float8 x[3], y[3], z[3], depth[3];
    for (int k = 0; k < 3; ++k) {
        x[k] = *(const float8*)(block + 24 * k) - f.origin[0];
        y[k] = *(const float8*)(block + 24 * k + 8) - f.origin[1];
        z[k] = *(const float8*)(block + 24 * k + 16) - f.origin[2];
        depth[k] = x[k] * f.depth[0] + y[k] * f.depth[1] + z[k] * f.depth[2];
    }
    const float8 size_x = larger(larger(absolute(x[0]), absolute(x[1])), absolute(x[2]));
    const float8 size_y = larger(larger(absolute(y[0]), absolute(y[1])), absolute(y[2]));
    const float8 size_z = larger(larger(absolute(z[0]), absolute(z[1])), absolute(z[2]));
    auto error_of = [&](const float* n) -> float8 {
        return ROUNDING * (size_x * __builtin_fabsf(n[0]) + size_y * __builtin_fabsf(n[1]) + size_z * __builtin_fabsf(n[2]));
    };
    int8 kept = *(const int8*)(block + 72) >= 0;
    float8 top[3], top_error;
    for (int k = 0; k < 4; ++k) {
        const float* n = f.normals[k];
        float8 side[3];
        for (int i = 0; i < 3; ++i) side[i] = x[i] * n[0] + y[i] * n[1] + z[i] * n[2];
        const float8 error = error_of(n);
        kept &= larger(larger(side[0], side[1]), side[2]) >= -error;
        if (k == 0)
            top[0] = side[0], top[1] = side[1], top[2] = side[2], top_error = error;
    }
    const float8 depth_error = error_of(f.depth);
    const float8 low = smaller(smaller(depth[0], depth[1]), depth[2]) - depth_error;
    const float8 high = larger(larger(depth[0], depth[1]), depth[2]) + depth_error;
    const float8 zero = 0.0f, nearest = low * f.per_depth;
    kept &= (high >= zero) & (nearest <= tile_far);
    unsigned left = mask_of(kept);
    if (!left)
        return false;
    // Rows that a triangle in front of the camera reaches.
    float8 first = 3e38f, last = -3e38f;
    for (int i = 0; i < 3; ++i) {
        const float8 row = (top[i] / depth[i] - f.first_row) * f.rows_of_side;
        first = smaller(first, row), last = larger(last, row);
    }
    const float8 margin = ROW_MARGIN + top_error / low * f.rows_of_side;
    const float8 everywhere = 16.0f, last_row = (float)(ROWS - 1);
    const int8 in_front = low > zero;
    first = in_front ? first - PIXEL_CENTER - margin : -everywhere;
    last = in_front ? last - PIXEL_CENTER + margin : everywhere;
    first = __builtin_elementwise_ceil(larger(first, zero));
    last = __builtin_elementwise_floor(smaller(last, last_row));
    bool was_hit = false;
    do {
        const int lane = __builtin_ctz(left);
        left &= left - 1;
        was_hit |= test_triangle(block, lane, (int)first[lane], (int)last[lane], nearest[lane], instance);
    } while (left);
    return was_hit;
};

Entry stack[STACK_SIZE];
int top = 0, entered = -1, floor_of_instance = 0, node = 0;
const float* nodes = (const float*)tlas.nodes;
const float* blocks = nullptr;
const Frame* f = &world_frame;
auto descend = [&](int instance) -> bool {
    const auto& in = tlas.instances.data[instance];
    entered = instance, floor_of_instance = top, f = &local_frame;
    nodes = (const float*)in.nodes, blocks = (const float*)in.blocks;
    node = 0;
    return enter(instance);
};
bool is_volume;
if (ONE_INSTANCE)
    is_volume = descend(only_instance);
else {
    float q[4][3];
    __builtin_memcpy(q, corners, sizeof(q));
    is_volume = set_planes(world_frame, world_x, world_y, world_z, q);
}
if (!is_volume) {
    leave_undecided();
    return;
}
for (;;) {
    while (node >= 0) {
        const float* box = nodes + (size_t)node * 64;
        const float8 zero = 0.0f;
        int8 met = -1;
        for (int k = 0; k < 4; ++k) {
            // The corner of each box that is farthest inside.
            const float* n = f->normals[k];
            const int x = n[0] < 0 ? 0 : 24, y = n[1] < 0 ? 8 : 32, z = n[2] < 0 ? 16 : 40;
            const float8 side = (*(const float8*)(box + x) - f->origin[0]) * n[0]
                + (*(const float8*)(box + y) - f->origin[1]) * n[1] + (*(const float8*)(box + z) - f->origin[2]) * n[2];
            met &= side >= zero;
        }
        const float* n = f->depth;
        const int x = n[0] < 0 ? 24 : 0, y = n[1] < 0 ? 32 : 8, z = n[2] < 0 ? 40 : 16;
        const float8 low = (*(const float8*)(box + x) - f->origin[0]) * n[0]
            + (*(const float8*)(box + y) - f->origin[1]) * n[1] + (*(const float8*)(box + z) - f->origin[2]) * n[2];
        const float8 t_near = low * f->per_depth;
        unsigned hits = mask_of(met & (t_near <= tile_far));
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
            if (descend(leaf))
                continue;
            leave_undecided();
            return;
        }
        const float* block = blocks + (size_t)(leaf >> 2) * 80;
        bool was_hit = false;
        for (int left = leaf & 3; left > 0; --left, block += 80) was_hit |= test_block(block, entered);
        if (was_hit) {
            tile_far = row_far[0];
            for (int g = 1; g < ROWS; ++g) tile_far = tile_far > row_far[g] ? tile_far : row_far[g];
        }
    }
    do {
        if (entered >= 0 && top == floor_of_instance) {
            if (ONE_INSTANCE)
                return;
            entered = -1, f = &world_frame, nodes = (const float*)tlas.nodes;
        }
        if (top == 0)
            return;
        --top;
    } while (stack[top].t > tile_far);
    node = stack[top].node;
}
}

// Body of lookup_texture: bilinear, with USD's wrap modes (the numbers of scene.WRAP_* and scene.TEXELS_*).
using wp::float32;
using wp::uint32;
using wp::uint64;
constexpr int REPEAT = 0, MIRROR = 2, BLACK = 3;
constexpr int SRGB = 0, RAW = 1, SHORTS = 2;
constexpr int TILES_IN_A_ROW = 10, ADJUSTED = 1, TILED = 2;
using Records = decltype(textures.data);

struct Sampler {
    // Brings a coordinate into [0, 1]; black keeps a margin of one image that reads as black.
    static CUDA_CALLABLE float fold(float u, int mode) {
        if (mode == REPEAT) return u - ::floorf(u);
        if (mode == MIRROR) return 1.0f - ::fabsf(1.0f - (u - 2.0f * ::floorf(0.5f * u)));
        const float low = mode == BLACK ? -1.0f : 0.0f, high = mode == BLACK ? 2.0f : 1.0f;
        return u > low ? (u < high ? u : high) : low;
    }
    // Index inside the image; -1 reads as black.
    static CUDA_CALLABLE int wrap(int i, int n, int mode) {
        if (i >= 0 && i < n) return i;
        if (mode == BLACK) return -1;
        if (mode == REPEAT) return i < 0 ? n - 1 : 0;
        return i < 0 ? 0 : n - 1;
    }
    // Finite half floats: exponents are moved by a product, which keeps the small ones.
    static CUDA_CALLABLE float from_half(uint32 half) {
        const uint32 bits = (half & 0x7fffu) << 13 | (half & 0x8000u) << 16;
        float value;
        memcpy(&value, &bits, 4);
        return value * 5.192296858534828e33f;
    }
#if !defined(__CUDA_ARCH__)
    __attribute__((noinline))
#endif
    static CUDA_CALLABLE wp::vec_t<4, float32> at(Records textures, const float32* decode, int index, float s, float t) {
        auto* texture = textures + index;
        float u = texture->u_row[0] * s + texture->u_row[1] * t + texture->u_row[2];
        float v = texture->v_row[0] * s + texture->v_row[1] * t + texture->v_row[2];
        if (texture->special & TILED) {
            const float column = ::floorf(u), row = ::floorf(v);
            const bool inside = column >= 0.0f && column < TILES_IN_A_ROW && row >= 0.0f && row < texture->tile_rows;
            const int tile = TILES_IN_A_ROW * (inside ? (int)row : texture->tile_rows) + (inside ? (int)column : 0);
            texture = textures + ((const int*)texture->tiles)[tile];
            u -= column;
            v -= row;
        }
        const int wrap_s = texture->wrap_s, wrap_t = texture->wrap_t, width = texture->width, height = texture->height;
        const float x = fold(u, wrap_s) * width - 0.5f, y = (1.0f - fold(v, wrap_t)) * height - 0.5f;
        const float x_floor = ::floorf(x), y_floor = ::floorf(y), fx = x - x_floor, fy = y - y_floor;
        const int x0 = wrap((int)x_floor, width, wrap_s), x1 = wrap((int)x_floor + 1, width, wrap_s);
        const int y0 = wrap((int)y_floor, height, wrap_t), y1 = wrap((int)y_floor + 1, height, wrap_t);
        const bool there[4] = {(x0 | y0) >= 0, (x1 | y0) >= 0, (x0 | y1) >= 0, (x1 | y1) >= 0};
        const int texel[4] = {y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1};
        const float weight[4] = {(1.0f - fx) * (1.0f - fy), fx * (1.0f - fy), (1.0f - fx) * fy, fx * fy};
        const int format = texture->format;
        wp::vec_t<4, float32> sum;
        if (format <= RAW) {
            const uint32* texels = (const uint32*)texture->texels;
            if (format != SRGB) decode += 256;
            for (int k = 0; k < 4; ++k) {
                const uint32 word = there[k] ? texels[texel[k]] : 0u;
                const float w = weight[k];
                for (int c = 0; c < 3; ++c) sum[c] += w * decode[word >> (8 * c) & 255u];
                sum[3] += w * ((word >> 24) * (1.0f / 255.0f));
            }
        } else {
            const uint64* texels = (const uint64*)texture->texels;
            for (int k = 0; k < 4; ++k) {
                const uint64 word = there[k] ? texels[texel[k]] : 0u;
                for (int c = 0; c < 4; ++c) {
                    const uint32 bits = (uint32)(word >> (16 * c)) & 0xffffu;
                    sum[c] += weight[k] * (format == SHORTS ? bits * (1.0f / 65535.0f) : from_half(bits));
                }
            }
        }
        if (texture->special & ADJUSTED)
            for (int c = 0; c < 4; ++c) sum[c] = wp::max(sum[c] * texture->scale[c] + texture->bias[c], 0.0f);
        return sum;
    }
};

return Sampler::at(textures.data, texel_values.data, index, u, v);

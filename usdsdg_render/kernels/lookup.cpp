// Body of lookup_texture: bilinear, with USD's wrap modes (the numbers of scene.WRAP_*).
using wp::float32;
using wp::uint32;
constexpr int REPEAT = 0, MIRROR = 2, BLACK = 3;
const auto& texture = textures.data[index];

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
#if !defined(__CUDA_ARCH__)
    __attribute__((noinline))
#endif
    static CUDA_CALLABLE wp::vec_t<4, float32> at(
        const uint32* texels, const float32* decode, int width, int height, int modes, float u, float v)
    {
        const int wrap_s = modes & 3, wrap_t = modes >> 2 & 3;
        const float x = fold(u, wrap_s) * width - 0.5f, y = (1.0f - fold(v, wrap_t)) * height - 0.5f;
        const float x_floor = ::floorf(x), y_floor = ::floorf(y), fx = x - x_floor, fy = y - y_floor;
        const int x0 = wrap((int)x_floor, width, wrap_s), x1 = wrap((int)x_floor + 1, width, wrap_s);
        const int y0 = wrap((int)y_floor, height, wrap_t), y1 = wrap((int)y_floor + 1, height, wrap_t);
        const uint32 word[4] = {
            (x0 | y0) < 0 ? 0u : texels[y0 * width + x0], (x1 | y0) < 0 ? 0u : texels[y0 * width + x1],
            (x0 | y1) < 0 ? 0u : texels[y1 * width + x0], (x1 | y1) < 0 ? 0u : texels[y1 * width + x1]};
        const float weight[4] = {(1.0f - fx) * (1.0f - fy), fx * (1.0f - fy), (1.0f - fx) * fy, fx * fy};
        wp::vec_t<4, float32> sum;
        for (int k = 0; k < 4; ++k) {
            const float w = weight[k];
            for (int c = 0; c < 3; ++c) sum[c] += w * decode[word[k] >> (8 * c) & 255u];
            sum[3] += w * ((word[k] >> 24) * (1.0f / 255.0f));
        }
        return sum;
    }
};

return Sampler::at(
    (const uint32*)texture.texels,
    texel_values.data + (texture.srgb ? 0 : 256),
    texture.width,
    texture.height,
    texture.wrap_s | texture.wrap_t << 2,
    u,
    v);

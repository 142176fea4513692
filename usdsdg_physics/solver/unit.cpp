// What `sweep_free` does to single units.
//
// Products and sums are rounded one by one and in the solver's own order, so that the bits are those of its own sweep.
#pragma clang fp contract(off)
struct Unit {
    typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));
    typedef float Two __attribute__((vector_size(8), aligned(4), may_alias));
    // Of one body or two: the product of a row and velocities, and an impulse's change of these.
    static inline float of_one(float total, const float* row, const float* a) {
        for (int k = 0; k < 6; ++k) {
            const float product = row[k] * a[k];
            total = total + product;
        }
        return total;
    }
    static inline float of_two(float total, const float* row, const float* a, const float* b) {
        for (int k = 0; k < 6; ++k) {
            const float product_a = row[k] * a[k], product_b = row[6 + k] * b[k];
            total = total + product_a;
            total = total + product_b;
        }
        return total;
    }
    static inline void add(const float* row, float impulse, float* a) {
        // Read before it is written, so that the compiler may take several numbers at once.
        const Four first = *(const Four*)row * impulse + *(const Four*)a;
        const Two second = *(const Two*)(row + 4) * impulse + *(const Two*)(a + 4);
        *(Four*)a = first;
        *(Two*)(a + 4) = second;
    }
    // Set both impulses of friction, scaled to what the normal impulses allow; return whether they change.
    static inline bool set_friction(const float* unit, float next0, float next1, float radius, float* impulses, float* v) {
        const int* header = (const int*)unit;
        const int kind = header[0], row = header[1];
        const float square0 = next0 * next0, square1 = next1 * next1;
        const float length = __builtin_sqrtf(square0 + square1);
        const float scale = length > radius ? radius / length : 1.0f;
        next0 = next0 * scale;
        next1 = next1 * scale;
        const float change0 = next0 - impulses[row], change1 = next1 - impulses[row + 1];
        impulses[row] = next0;
        impulses[row + 1] = next1;
        float* const a = v + header[2];
        if (kind == 2) {
            if (change1 != 0.0f) add(unit + 38, change1, a);
            if (change0 != 0.0f) add(unit + 26, change0, a);
        } else {
            float* const b = v + header[3];
            if (change1 != 0.0f) {
                add(unit + 56, change1, a);
                add(unit + 62, change1, b);
            }
            if (change0 != 0.0f) {
                add(unit + 32, change0, a);
                add(unit + 38, change0, b);
            }
        }
        return change0 != 0.0f || change1 != 0.0f;
    }
    // Find the impulses of friction: those that stop the surfaces where the radius of the disk allows that, otherwise
    // those on the disk with the least energy. Newton's method finds how much stiffer both axes have to be for them.
    static inline void rub(
        const float* unit, float residual0, float residual1, float old0, float old1, float radius, float omega,
        float& next0, float& next1
    ) {
        next0 = next1 = 0.0f;
        if (!(radius > 0.0f)) return;
        // Along the two axes that do not influence each other.
        const float scale = unit[6], large = unit[7], small = unit[8], x = unit[9], y = unit[10];
        const float along = dot(x, y, residual0, residual1) / scale, across = dot(-y, x, residual0, residual1) / scale;
        float stop0 = old0, stop1 = old1;
        bool sticks = false;
        if (large > 0.0f && (small > 0.0f || across == 0.0f)) {
            float step0 = along / large * x, step1 = along / large * y;
            if (small > 0.0f) {
                const float other0 = across / small * -y, other1 = across / small * x;
                step0 = step0 + other0;
                step1 = step1 + other1;
            }
            stop0 = old0 - step0;
            stop1 = old1 - step1;
            sticks = length(stop0, stop1) <= radius;
        }
        if (!sticks) {
            const float before = length(old0, old1);
            const float left = residual0 * old1, right = residual1 * old0;
            next0 = old0;
            next1 = old1;
            // What solves it already to seven digits stays, so that rounding keeps no sweep going.
            if (before > 0.0f && before <= radius && radius - before <= 2.0e-7f * radius &&
                dot(residual0, residual1, old0, old1) <= 0.0f &&
                __builtin_fabsf(left - right) <= 2.0e-7f * before * length(residual0, residual1))
                return;
            const float from0 = dot(x, y, old0, old1), from1 = dot(-y, x, old0, old1);
            const float large_from = large * from0, small_from = small * from1;
            const float b0 = large_from - along, b1 = small_from - across;
            float found0 = 0.0f, found1 = 0.0f;
            float high = length(b0, b1) / radius;
            if (high > 0.0f) {
                const float other = __builtin_fabsf(b1) / radius - small;
                float low = larger(larger(high - large, other), 0.0f);
                float stiffer = low;
                bool converged = false;
                for (int i = 0; i < 8; ++i) {
                    const float inverse0 = 1.0f / (large + stiffer);
                    const float inverse1 = small + stiffer > 0.0f ? 1.0f / (small + stiffer) : 0.0f;
                    const float more0 = stiffer * from0, more1 = stiffer * from1;
                    const float change0 = (along + more0) * inverse0, change1 = (across + more1) * inverse1;
                    const float trial0 = from0 - change0, trial1 = from1 - change1;
                    const float size = length(trial0, trial1);
                    if (__builtin_fabsf(size - radius) <= 2.0e-7f * radius || (stiffer == 0.0f && size <= radius)) {
                        found0 = trial0;
                        found1 = trial1;
                        converged = true;
                        break;
                    }
                    if (size > radius) low = stiffer;
                    else high = stiffer;
                    const float slope0 = trial0 * trial0 * inverse0, slope1 = trial1 * trial1 * inverse1;
                    const float slope = slope0 + slope1;
                    float candidate = stiffer;
                    if (slope > 0.0f) {
                        const float step = (size / radius - 1.0f) * size * size / slope;
                        candidate = stiffer + step;
                    }
                    stiffer = candidate > low && candidate < high ? candidate : 0.5f * (low + high);
                }
                if (!converged) {
                    for (int i = 0; i < 24; ++i) {
                        stiffer = 0.5f * (low + high);
                        if (length(b0 / (large + stiffer), b1 / (small + stiffer)) > radius) low = stiffer;
                        else high = stiffer;
                    }
                    found0 = b0 / (large + high);
                    found1 = b1 / (small + high);
                }
            }
            const float turn0 = found0 - from0, turn1 = found1 - from1;
            const float first0 = turn0 * x, first1 = turn0 * y, second0 = turn1 * -y, second1 = turn1 * x;
            stop0 = old0 + first0;
            stop1 = old1 + first1;
            stop0 = stop0 + second0;
            stop1 = stop1 + second1;
        }
        const float step0 = omega * (stop0 - old0), step1 = omega * (stop1 - old1);
        next0 = old0 + step0;
        next1 = old1 + step1;
    }
    static inline float dot(float a0, float a1, float b0, float b1) {
        const float product0 = a0 * b0, product1 = a1 * b1;
        return product0 + product1;
    }
    static inline float length(float a0, float a1) { return __builtin_sqrtf(dot(a0, a1, a0, a1)); }
    static inline float larger(float a, float b) { return a < b ? b : a; }
};

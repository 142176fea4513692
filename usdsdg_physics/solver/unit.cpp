// What the bodies of `sweep_free` and `finish_friction` share.
//
// Products and sums are rounded one by one and in the solver's own order, so that the bits are those of its own sweep.
#pragma clang fp contract(off)
struct Unit {
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
        for (int k = 0; k < 6; ++k) {
            const float product = row[k] * impulse;
            a[k] = a[k] + product;
        }
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
            if (change1 != 0.0f) add(unit + 41, change1, a);
            if (change0 != 0.0f) add(unit + 29, change0, a);
        } else {
            float* const b = v + header[3];
            if (change1 != 0.0f) {
                add(unit + 59, change1, a);
                add(unit + 65, change1, b);
            }
            if (change0 != 0.0f) {
                add(unit + 35, change0, a);
                add(unit + 41, change0, b);
            }
        }
        return change0 != 0.0f || change1 != 0.0f;
    }
};

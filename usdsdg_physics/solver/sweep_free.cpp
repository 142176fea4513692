// Solve the units of free bodies from place `begin` of `active` on, up to the first that needs more than that: a row of a
// joint, or friction that slides. Return its place, `count` where there is none.
const float* const bias = free_bias.data;
float* const impulses = free_impulses.data;
for (int place = begin; place < count; ++place) {
    const float* const unit = islands.numbers.data + islands.active.data[place];
    const int* const header = (const int*)unit;
    const int kind = header[0], row = header[1];
    if (kind > 3) return place;
    int& changed = islands.changed.data[header[4]];
    float* const a = v.data + header[2];
    float* const b = v.data + header[3];  // not used where one body moves
    if (kind <= 1) {
        const float speed = kind == 0 ? Unit::of_one(0.0f, unit + 6, a) : Unit::of_two(0.0f, unit + 6, a, b);
        const float residual = speed + bias[row];
        const float old = impulses[row];
        const float step = omega * (-residual * unit[5]);
        const float next = old + step;
        const float impulse = next >= 0.0f ? next : 0.0f;
        const float change = impulse - old;
        impulses[row] = impulse;
        if (change != 0.0f) {
            changed = 1;
            if (kind == 0) {
                Unit::add(unit + 12, change, a);
            } else {
                Unit::add(unit + 18, change, a);
                Unit::add(unit + 24, change, b);
            }
        }
        continue;
    }

    // Friction is bounded by the normal impulses of the patch that it belongs to.
    const int* const patch = header + 14;
    float load = impulses[patch[0]];
    int next = 1;
    for (; next < 8 && patch[next] >= 0; ++next) load = load + impulses[patch[next]];
    if (next == 8)
        for (int more = patch[8]; more >= 0 && more != patch[0]; more = rows.free_parent.data[more])
            load = load + impulses[more];
    const float bound = unit[5] * load;
    const float radius = bound >= 0.0f ? bound : 0.0f;
    const float old0 = impulses[row], old1 = impulses[row + 1];
    if (radius == 0.0f && old0 == 0.0f && old1 == 0.0f) continue;

    // The impulses that would stop the surfaces, along the two axes that do not influence each other.
    float residual0, residual1;
    if (kind == 2) {
        residual0 = Unit::of_one(0.0f, unit + 23, a) + bias[row];
        residual1 = Unit::of_one(bias[row + 1], unit + 35, a);
    } else {
        residual0 = Unit::of_two(0.0f, unit + 23, a, b) + bias[row];
        residual1 = Unit::of_two(bias[row + 1], unit + 47, a, b);
    }
    const float scale = unit[6], large = unit[7], small = unit[8], x = unit[9], y = unit[10];
    const float x0 = x * residual0, y1 = y * residual1, y0 = -y * residual0, x1 = x * residual1;
    const float along = (x0 + y1) / scale / large, across = (y0 + x1) / scale / small;
    const float along0 = along * x, along1 = along * y, across0 = across * -y, across1 = across * x;
    const float stop0 = old0 - (along0 + across0), stop1 = old1 - (along1 + across1);
    const float square0 = stop0 * stop0, square1 = stop1 * stop1;
    if (!(radius > 0.0f && small > 0.0f && __builtin_sqrtf(square0 + square1) <= radius)) {
        islands.slide.data[0] = residual0;
        islands.slide.data[1] = residual1;
        islands.slide.data[2] = radius;
        return place;
    }
    const float step0 = omega * (stop0 - old0), step1 = omega * (stop1 - old1);
    if (Unit::set_friction(unit, old0 + step0, old1 + step1, radius, impulses, v.data)) changed = 1;
}
return count;

// Solve the units of free bodies from place `begin` of `active` on, up to the first that is a row of a joint or a limit.
// Return its place, `count` where there is none.
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
    const int* const patch = header + 11;
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

    float residual0, residual1;
    if (kind == 2) {
        residual0 = Unit::of_one(0.0f, unit + 20, a) + bias[row];
        residual1 = Unit::of_one(bias[row + 1], unit + 32, a);
    } else {
        residual0 = Unit::of_two(0.0f, unit + 20, a, b) + bias[row];
        residual1 = Unit::of_two(bias[row + 1], unit + 44, a, b);
    }
    float next0, next1;
    Unit::rub(unit, residual0, residual1, old0, old1, radius, omega, next0, next1);
    if (Unit::set_friction(unit, next0, next1, radius, impulses, v.data)) changed = 1;
}
return count;

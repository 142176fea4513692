// Set the impulses of the unit of friction at place `place` of `active`.
const float* const unit = islands.numbers.data + islands.active.data[place];
if (Unit::set_friction(unit, impulse0, impulse1, islands.slide.data[2], free_impulses.data, v.data))
    islands.changed.data[((const int*)unit)[4]] = 1;

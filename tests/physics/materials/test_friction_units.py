"""Friction of two rows has the bits of Newton's own function, where it slides and where rows are degenerate too."""

import numpy as np
import warp as wp
from newton._src.solvers.steel.friction import friction_pair_candidate

from usdsdg_physics.solver.free_rows import UNIT
from usdsdg_physics.solver.gather_units import store_axes
from usdsdg_physics.solver.sweep_arrays import FRICTION_AXES

NUMBERS = wp.constant(16)


@wp.func_native(f"""{{
{UNIT}
const float* const unit = numbers.data + at;
wp::vec2 next;
Unit::rub(unit, residual[0], residual[1], old[0], old[1], radius, omega, next[0], next[1]);
return next;
}}""")
def rub(numbers: wp.array[float], at: int, residual: wp.vec2, old: wp.vec2, radius: float, omega: float) -> wp.vec2: ...


@wp.kernel(enable_backward=False)
def both(
    block: wp.array[wp.vec3],
    residual: wp.array[wp.vec2],
    old: wp.array[wp.vec2],
    radius: wp.array[float],
    numbers: wp.array[float],
    ours: wp.array[wp.vec2],
    newtons: wp.array[wp.vec2],
):
    i = wp.tid()
    store_axes(numbers, NUMBERS * i + FRICTION_AXES, block[i][0], block[i][1], block[i][2])
    ours[i] = rub(numbers, NUMBERS * i, residual[i], old[i], radius[i], 1.0)
    newtons[i] = friction_pair_candidate(block[i][0], block[i][1], block[i][2], residual[i], old[i], radius[i], 1.0)


def test_friction_has_the_bits_of_newtons_function():
    rng = np.random.default_rng(5)
    count = 200_000
    # J M⁻¹ Jᵀ of two rows: a positive matrix, of rank one in a part of them and zero in others, of all sizes.
    rows = rng.normal(size=(count, 2, 2)) * 10.0 ** rng.uniform(-3, 3, (count, 1, 1))
    rows[: count // 4, 1] = rows[: count // 4, 0] * rng.choice([0.0, 1.0, -0.5], (count // 4, 1))
    rows[count // 4 : count // 3] = 0.0
    block = np.stack([(rows[:, 0] ** 2).sum(1), (rows[:, 0] * rows[:, 1]).sum(1), (rows[:, 1] ** 2).sum(1)], axis=1)
    residual = rng.normal(size=(count, 2)) * 10.0 ** rng.uniform(-4, 2, (count, 1))
    residual[rng.random(count) < 0.05] = 0.0
    radius = 10.0 ** rng.uniform(-5, 1, count)
    radius[rng.random(count) < 0.05] = 0.0
    angle = rng.uniform(0, 2 * np.pi, count)
    old = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (radius * rng.choice([0.0, 0.5, 1.0], count))[:, None]
    # Some slide already as they should: their residuals oppose them.
    slides = rng.random(count) < 0.2
    residual[slides] = -old[slides] * rng.uniform(0, 5, (slides.sum(), 1))

    arrays = [wp.array(block.astype(np.float32), dtype=wp.vec3, device="cpu")]
    arrays += [wp.array(values.astype(np.float32), dtype=wp.vec2, device="cpu") for values in (residual, old)]
    arrays += [wp.array(radius.astype(np.float32), device="cpu"), wp.zeros(NUMBERS * count, dtype=float, device="cpu")]
    found = [wp.zeros(count, dtype=wp.vec2, device="cpu") for _ in range(2)]
    wp.launch(both, dim=count, inputs=arrays, outputs=found, device="cpu")
    ours, newtons = (array.numpy() for array in found)
    assert ours.tobytes() == newtons.tobytes()
    length = np.hypot(*newtons.T.astype(float))
    assert 0.2 < np.mean(length > 0.99 * radius) < 0.9  # slides

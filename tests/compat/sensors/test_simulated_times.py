"""The simulated time of an image follows from its reference time."""

import pytest

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core.simulation_manager.simulation_manager import SimulationManager
from usdsdg.compat.isaacsim.core.simulation_manager.time_samples import TimeSamples
from usdsdg.session.timeline import get_timeline


def test_an_image_has_the_time_of_the_physics_that_it_shows(stage):
    product = rep.create.render_product(rep.create.camera(), (4, 4))
    reference = rep.annotators.get("ReferenceTime")
    reference.attach(product)
    interface = SimulationManager._simulation_manager_interface
    get_timeline().play()
    for _ in range(7):
        get_app().update()
    time = reference.get_data()
    given = time["referenceTimeNumerator"], time["referenceTimeDenominator"]
    assert interface.get_simulation_time_at_time(given) == pytest.approx(7 / 60, abs=1e-6)
    assert SimulationManager.get_simulation_time() == pytest.approx(7 / 60, abs=1e-9)
    first, last = interface.get_sample_range()
    assert interface.get_sample_count() == 7
    assert first.numerator / first.denominator == pytest.approx(1 / 60, abs=1e-6)
    assert last.numerator / last.denominator == pytest.approx(7 / 60, abs=1e-6)


def test_times_between_steps_are_interpolated():
    samples = TimeSamples()
    for step in range(1, 4):
        samples.note(step * 0.1, 5 + step * 0.1)
    assert samples.simulated_at(0.25, tolerance=0) == pytest.approx(5.25)
    assert samples.simulated_at(0.05, tolerance=0) is None
    samples.note(0.1, 6.0)  # the timeline began anew
    assert list(samples.times) == [(0.1, 6.0)]

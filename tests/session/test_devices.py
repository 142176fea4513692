"""Where pictures are made and where bodies are simulated."""

import pytest

from usdsdg.cli.options.dataset_options import device_facts
from usdsdg.errors import PhysicsError
from usdsdg.session import engines, session
from usdsdg.session.session import current


@pytest.fixture
def devices(stage):
    """The engines, which are of the CPU again afterwards."""
    yield current().engines
    current().engines.physics_device = "cpu"


def test_bodies_stay_on_the_cpu_wherever_pictures_are_made(devices):
    devices.device = "cuda:0"  # as `use_device` where there is one
    assert engines.physics_device() == "cpu"
    engines.use_device("cpu", physics="cpu")
    assert (engines.renderer_device(), engines.physics_device()) == ("cpu", "cpu")


def test_a_device_that_is_not_there_changes_nothing(devices):
    with pytest.raises(PhysicsError, match=r"cannot simulate on 'cuda:77': .* Devices here: cpu"):
        engines.use_device("cpu", physics="cuda:77")
    assert engines.physics_device() == "cpu"


def test_a_new_session_keeps_both_devices(devices):
    engines.use_device("cpu")
    current().engines.physics_device = "cuda:1"
    session.restart()
    assert (current().engines.device, current().engines.physics_device) == ("cpu", "cuda:1")
    current().engines.physics_device = "cpu"


def test_a_recipe_has_the_kind_of_another_device_than_the_cpu(devices):
    assert device_facts() == {}
    devices.physics_device = "cuda:1"
    assert device_facts() == {"physics_device": "cuda"}

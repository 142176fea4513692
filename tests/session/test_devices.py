"""Where pictures are made and where bodies are simulated."""

import pytest

from usdsdg.cli.options.dataset_options import device_facts
from usdsdg.errors import PhysicsError
from usdsdg.session import devices, session
from usdsdg.session.session import current


@pytest.fixture
def restored(stage):
    """The engines, which are of the CPU again afterward."""
    yield current().engines
    current().engines.physics_device = "cpu"


def test_bodies_stay_on_the_cpu_wherever_pictures_are_made(restored):
    restored.device = "cuda:0"  # as `use_device` where there is one
    assert devices.physics_device() == "cpu"
    devices.use_device("cpu", physics="cpu")
    assert (devices.renderer_device(), devices.physics_device()) == ("cpu", "cpu")


def test_a_device_that_is_not_there_changes_nothing(restored):
    with pytest.raises(PhysicsError, match=r"cannot simulate on 'cuda:77': .* Devices here: cpu"):
        devices.use_device("cpu", physics="cuda:77")
    assert devices.physics_device() == "cpu"


def test_a_new_session_keeps_both_devices(restored):
    devices.use_device("cpu")
    current().engines.physics_device = "cuda:1"
    session.restart()
    assert (current().engines.device, current().engines.physics_device) == ("cpu", "cuda:1")
    current().engines.physics_device = "cpu"


def test_a_recipe_has_the_kind_of_another_device_than_the_cpu(restored):
    assert device_facts() == {}
    restored.physics_device = "cuda:1"
    assert device_facts() == {"physics_device": "cuda"}

"""Names that a family of the API does not have: the error says where they are, or what does that work."""

import pytest

import usdsdg
from tests.arguments.plain_names import plain_names


@pytest.fixture(autouse=True)
def _plain_names():
    with plain_names():
        yield


@pytest.mark.parametrize(
    ("family", "name", "told"),
    [
        (None, "render_product", "it is rep.create.render_product"),
        (None, "create_camera", "it is rep.create.camera"),
        (None, "Wrter", "did you mean 'Writer'"),
        ("settings", "set_global_seed", "it is rep.set_global_seed"),
        ("create", "scatter_2d", "it is rep.randomizer.scatter_2d"),
        ("modify", "scale", "rep.modify.pose(scale=...) does that"),
        ("modify", "color", "it is rep.randomizer.color"),
        ("distribution", "gaussian", "rep.distribution.normal does that"),
        ("distribution", "constant", "the value itself does that"),
        ("trigger", "on_frames", "did you mean 'on_frame'"),
        ("randomizer", "my_lights", "once it is registered: rep.randomizer.register(my_lights)"),
        ("randomizer", "scater_2d", "did you mean 'scatter_2d'"),
        ("orchestrator", "register", "has no attribute 'register'"),
    ],
)
def test_a_missing_name_is_told_where_it_is(family, name, told):
    owner = usdsdg if family is None else getattr(usdsdg, family)
    with pytest.raises(AttributeError) as caught:
        getattr(owner, name)
    assert told in str(caught.value)
    assert caught.value.name == name


def test_a_function_that_a_script_registered_is_found_in_the_root():
    usdsdg.randomizer.register(lambda: None, fn_name="of_this_test")
    try:
        with pytest.raises(AttributeError, match=r"it is rep\.randomizer\.of_this_test"):
            usdsdg.of_this_test  # noqa: B018
    finally:
        del usdsdg.randomizer.of_this_test


def test_names_that_python_asks_for_are_told_nothing():
    with pytest.raises(AttributeError, match=r"'_nothing'$"):
        usdsdg.randomizer._nothing  # noqa: B018

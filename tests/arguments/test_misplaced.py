"""Names that a family of the API does not have: the error says where they are, or what does that work."""

import importlib
import pickle

import pytest

import usdsdg
from usdsdg.arguments import misplaced
from usdsdg.compat import finder
from usdsdg.compat.coverage.verdicts import verdict


@pytest.mark.parametrize(
    ("family", "name", "told"),
    [
        (None, "render_product", "it is rep.create.render_product"),
        (None, "create_camera", "it is rep.create.camera"),
        (None, "Wrter", "did you mean Writer"),
        ("settings", "set_global_seed", "it is rep.set_global_seed"),
        ("create", "scatter_2d", "it is rep.randomizer.scatter_2d"),
        ("modify", "scale", "rep.modify.pose(scale=...) does that"),
        ("modify", "color", "it is rep.randomizer.color"),
        ("distribution", "gaussian", "rep.distribution.normal does that"),
        ("distribution", "constant", "the value itself does that"),
        ("trigger", "on_frames", "did you mean on_frame"),
        ("randomizer", "my_lights", "once it is registered: rep.randomizer.register(my_lights)"),
        ("randomizer", "scater_2d", "did you mean scatter_2d"),
        ("randomizer", "objects", "rep.randomizer.instantiate, which returns a population of assets, does that"),
        ("utils", "AttrMap", "rep.modify.attribute does that"),
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


NAMES = [("create", "cub"), ("modify", "scale"), ("randomizer", "my_lights"), ("randomizer", "scater_2d"),
         ("trigger", "on_frames"), (None, "Wrter"), (None, "render_product"), (None, "creat")]  # fmt: skip


@pytest.mark.parametrize(("family", "name"), NAMES)
def test_what_is_told_does_not_depend_on_how_the_module_was_imported(family, name, monkeypatch):
    finder.install()
    foreign = "omni.replicator.core" if family is None else f"omni.replicator.core.{family}"
    module = importlib.import_module(foreign)
    with pytest.raises(AttributeError) as caught:
        getattr(module, name)
    told = str(caught.value)
    if family is not None:
        monkeypatch.setattr(module, "__getattr__", misplaced.explaining(vars(module)))
        with pytest.raises(AttributeError) as caught:
            getattr(module, name)
    assert str(caught.value) == told
    hint = told.partition("; ")[2]
    assert hint
    assert verdict(f"{foreign}.{name}").why == hint
    with pytest.raises(ModuleNotFoundError) as imported:
        importlib.import_module(f"{module.__name__}.{name}")
    assert str(imported.value) == f"{foreign} of usdsdg has no {name!r}; {hint}"


def test_the_error_of_a_missing_name_can_be_sent_to_another_process():
    with pytest.raises(AttributeError) as caught:
        usdsdg.create.cub  # noqa: B018
    assert str(pickle.loads(pickle.dumps(caught.value.args[0]))) == str(caught.value)

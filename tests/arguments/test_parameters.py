"""Keyword arguments that a public function does not have: Python's TypeError, with the one that was meant."""

import asyncio
import importlib
import inspect
import pickle
from types import FunctionType

import pytest

import usdsdg as rep
from usdsdg.arguments.near_arguments import near_arguments

FAMILIES = [
    "annotators", "backends", "create", "distribution", "functional.create", "functional.create_batch",
    "functional.get", "functional.modify", "functional.physics", "functional.randomizer", "functional.utils", "get",
    "modify", "orchestrator", "physics", "randomizer", "rng", "settings", "tools", "trigger", "utils", "writers",
]  # fmt: skip


def functions(family: str) -> dict[str, FunctionType]:
    """Return the public functions of a family's module that are its own, by name."""
    module = importlib.import_module(f"usdsdg.{family}")
    listed = getattr(module, "__all__", [name for name in vars(module) if not name.startswith("_")])
    found = {name: getattr(module, name) for name in listed}
    own = {name: each for name, each in found.items() if isinstance(each, FunctionType)}
    return {
        name: each for name, each in own.items() if hasattr(module, "__all__") or each.__module__ == module.__name__
    }


def call(function, **arguments):
    done = function(**arguments)
    if inspect.iscoroutine(done):
        asyncio.run(done)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_public_function_names_the_parameter_that_was_meant(family):
    found = functions(family)
    assert found
    for name, function in found.items():
        assert hasattr(function, "_names_parameters"), name
        parameters = inspect.signature(function).parameters.values()
        known = [each.name for each in parameters if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
        if not known or any(each.kind is each.VAR_KEYWORD for each in parameters):
            continue
        for parameter in known:
            wrong = f"{parameter[0]}{parameter}"
            with pytest.raises(TypeError, match=rf"\(\) got an .*'{wrong}'; did you mean .*'{parameter}'"):
                call(function, **{wrong: None})


def test_all_families_are_in_the_list():
    modules = {name for name in rep.__all__ if inspect.ismodule(getattr(rep, name))}
    without_functions = {
        "annotators_default",
        "augmentations_default",
        "errors",
        "example",
        "functional",
        "vp_manager",  # of whose missing names the modules of omni say where they are
        "writers_default",
    }
    assert modules - without_functions == {name.partition(".")[0] for name in FAMILIES} - {"functional"}


def test_where_nothing_is_near_the_parameters_are_listed():
    with pytest.raises(TypeError, match=r"group\(\) got an unexpected .* 'zzz'; it takes items, semantics, name"):
        rep.create.group([], zzz=1)


def test_a_type_error_of_the_body_is_left_alone():
    with pytest.raises(TypeError, match=r"^no$"):
        rep.backends.unregister(name=Odd("odd"))


class Odd(str):
    """A name that cannot be used as one."""

    def __hash__(self):
        raise TypeError("no")


def test_names_signatures_and_pickles_are_those_of_the_function():
    assert list(inspect.signature(rep.create.group).parameters) == ["items", "semantics", "name"]
    assert (rep.create.cube.__name__, rep.create.cube.__module__) == ("cube", "usdsdg.create.shapes")
    assert pickle.loads(pickle.dumps(rep.create.cube)) is rep.create.cube
    assert inspect.iscoroutinefunction(rep.orchestrator.step_async)


@pytest.mark.parametrize(
    ("given", "known", "meant"),
    [
        ("translation", ["rotation", "position"], ["position"]),
        ("type", ["light_type", "texture"], ["light_type"]),
        ("samples", ["samples_per_pixel"], ["samples_per_pixel"]),
        ("depth", ["rgb", "distance_to_image_plane"], ["distance_to_image_plane"]),
        ("positon", ["rotation", "position"], ["position"]),
        ("nothing", ["rgb"], []),
    ],
)
def test_arguments_that_are_meant_by_other_words(given, known, meant):
    assert near_arguments(given, known)[: len(meant) or None] == meant

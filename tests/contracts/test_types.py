"""What a type checker knows of the functions that scripts call."""

import inspect

import pytest

import usdsdg as rep

FAMILIES = (
    "annotators", "backends", "create", "distribution", "functional", "get", "modify", "orchestrator", "physics",
    "randomizer", "rng", "settings", "tools", "trigger", "utils", "writers",
)  # fmt: skip


def functions(family):
    module = getattr(rep, family)
    public = getattr(module, "__all__", None) or [name for name in vars(module) if not name.startswith("_")]
    found = {name: inspect.unwrap(getattr(module, name)) for name in public if callable(getattr(module, name))}
    return {name: each for name, each in found.items() if inspect.isfunction(each) and "usdsdg" in each.__module__}


@pytest.mark.parametrize("family", FAMILIES)
def test_every_parameter_and_result_has_a_type(family):
    lacking = {}
    for name, function in functions(family).items():
        signature = inspect.signature(function)
        missing = [each.name for each in signature.parameters.values() if each.annotation is each.empty]
        missing += ["return"] * (signature.return_annotation is signature.empty)
        if missing:
            lacking[name] = missing
    assert not lacking

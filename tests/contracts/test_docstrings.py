"""Every name of Replicator's that is here says what it does, and every function which errors it raises itself."""

import inspect
import re

import pytest

import usdsdg as rep
from tests.contracts import mirror
from usdsdg.stage.cameras.render_products import HydraTexture

# Modules, imports and registries' members have pages of their own.
FUNCTIONS = [
    path for path, name in mirror.names().items() if name.kind not in ("module", "import", "annotator", "augmentation")
]


def found(path):
    """What a name stands for, as written: functions of classes and properties without their wrappers."""
    value, parts = rep, path.split(".")
    if parts[0] == "HydraTexture":
        value, parts = HydraTexture, parts[1:]
    for part in parts:
        value = inspect.getattr_static(value, part, None) if isinstance(value, type) else getattr(value, part, None)
    value = getattr(value, "__func__", value)
    return value.fget if isinstance(value, property) else value


def described(path):
    value = found(path)
    return value, inspect.getdoc(value) or "" if callable(value) else None


@pytest.mark.parametrize("path", FUNCTIONS)
def test_it_says_what_it_does(path):
    _, text = described(path)
    assert text is None or len(text) >= 12


@pytest.mark.parametrize("path", FUNCTIONS)
def test_it_names_the_errors_that_it_raises(path):
    value, text = described(path)
    if not inspect.isfunction(value) or not value.__module__.startswith("usdsdg"):
        return
    raised = set(re.findall(r"^\s+raise (\w+)\(", inspect.getsource(value), re.MULTILINE))
    module = inspect.getdoc(inspect.getmodule(value)) or ""
    # What only refuses says so in its first words.
    untold = {error for error in raised if error not in text and error not in module}
    assert untold <= ({"Unsupported"} if text.startswith("Not available") else set())

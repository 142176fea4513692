"""Every name of Replicator has a docstring, and docstrings of functions name the errors that they raise."""

import inspect
import re

import pytest

import usdsdg as rep
from tests.contracts import mirror
from usdsdg.session.render_products import HydraTexture

# Modules, imports and members of registries are documented elsewhere.
FUNCTIONS = [
    path for path, name in mirror.names().items() if name.kind not in ("module", "import", "annotator", "augmentation")
]


def found(path):
    """Return the object of a name; methods and properties without their wrappers."""
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
def test_every_name_has_a_docstring(path):
    _, text = described(path)
    assert text is None or len(text) >= 12


@pytest.mark.parametrize("path", FUNCTIONS)
def test_docstrings_name_the_errors_that_are_raised(path):
    value, text = described(path)
    if not inspect.isfunction(value) or not value.__module__.startswith("usdsdg"):
        return
    raised = set(re.findall(r"^\s+raise (\w+)\(", inspect.getsource(value), re.MULTILINE))
    module = inspect.getdoc(inspect.getmodule(value)) or ""
    # Functions that only raise Unsupported say so in their first words.
    undocumented = {error for error in raised if error not in text and error not in module}
    assert undocumented <= ({"Unsupported"} if text.startswith("Not available") else set())

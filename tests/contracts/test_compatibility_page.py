"""The tables of docs/compatibility.md agree with the registries and modules."""

import re
from pathlib import Path

import pytest

import usdsdg as rep
from tests.contracts import mirror
from usdsdg.annotators.augmentations.defaults import DEFAULT_AUGMENTATIONS
from usdsdg.annotators.base import annotator_specs
from usdsdg.annotators.named_annotators import UNSUPPORTED
from usdsdg.session.settings import store as settings
from usdsdg.writers.backends import registry as backends

PAGE = (Path(__file__).parents[2] / "docs" / "compatibility.md").read_text(encoding="utf-8")

FAMILIES = ["create", "modify", "get", "randomizer", "distribution", "trigger", "physics", "settings", "utils"]


def words(text: str) -> set[str]:
    """Return all words in backticks, split at spaces."""
    return {word for part in re.findall(r"`([^`]*)`", text) for word in part.split()}


def section(title: str) -> str:
    return re.split(r"\n#+ ", PAGE.split(f"# {title}\n", 1)[1], maxsplit=1)[0]


def row(name: str) -> set[str]:
    (line,) = re.findall(rf"^\| `?{name}`? \|(.*)\|$", section("Replicator"), re.MULTILINE)
    return words(line)


def built(family: str) -> set[str]:
    """Return the members of a family that Replicator has and that are implemented here."""
    names = [name for path, name in mirror.names().items() if re.fullmatch(rf"{family}\.\w+", path)]
    absent = (mirror.MISSING, mirror.REFUSES)
    return {name.path.split(".")[1] for name in names if mirror.difference(name) not in absent}


@pytest.mark.parametrize("family", [name for name in FAMILIES if hasattr(rep, name)])
def test_the_page_lists_the_members_of_each_family(family):
    assert row(family) == built(family)


def test_the_page_lists_writers_and_backends():
    assert {"BasicWriter", "PoseWriter"} <= row("writers")
    assert row("writers") >= set(rep.writers.get_writers())
    assert row("backends") >= set(backends.registered.names())
    assert all(hasattr(rep, name) for name in row("top level"))


def test_the_page_lists_annotators():
    """Annotators that tests may have registered do not count."""
    there, missing = section("Annotators").split("These are known and raise", 1)
    specs = {name: annotator_specs.get(name) for name in annotator_specs}
    own = {name for name, spec in specs.items() if spec.compute.__module__.startswith("usdsdg.")}
    assert words(there) - {"annotators.get(name)", "AnnotatorRegistry.get_annotator(name)"} == own
    assert set(UNSUPPORTED) <= words(missing)
    assert not words(missing) & own


def test_the_page_lists_augmentations():
    assert words(section("Augmentations")) >= set(DEFAULT_AUGMENTATIONS)


def test_the_page_lists_settings_that_have_an_effect():
    listed = {word.rstrip(",") for word in words(section("Settings with an effect")) if word.startswith("/")}
    assert listed == set(settings.DEFAULTS)

import pytest

from usdsdg.arguments.registry import Registry, near_misses
from usdsdg.errors import WriterRegistryError


@pytest.fixture
def registry():
    fruits = Registry("fruit", WriterRegistryError)
    fruits.add("Apple", 1)
    fruits.add("Banana", 2)
    return fruits


def test_members_are_listed_in_order(registry):
    assert registry.names() == list(registry) == ["Apple", "Banana"]
    assert len(registry) == 2
    assert "Apple" in registry
    assert registry.get("Banana") == 2


@pytest.mark.parametrize("name", ["apple", "Aple", "APPLES"])
def test_similar_names_are_suggested_regardless_of_case(registry, name):
    with pytest.raises(WriterRegistryError, match=rf"No fruit is named '{name}'. Did you mean 'Apple'"):
        registry.get(name)


def test_without_a_similar_name_all_names_are_listed(registry):
    with pytest.raises(WriterRegistryError, match="Known: Apple, Banana"):
        registry.get("xyz")


def test_a_name_can_be_replaced_only_with_override(registry):
    registry.add("Apple", 3)
    assert registry.get("Apple") == 3
    with pytest.raises(WriterRegistryError, match="exists already"):
        registry.add("Apple", 4, override=False)


def test_a_removed_member_is_gone(registry):
    assert registry.remove("Apple") == 1
    assert registry.names() == ["Banana"]
    with pytest.raises(WriterRegistryError):
        registry.remove("Apple")


def test_similar_names_are_listed_best_first():
    assert near_misses("rgbb", ["depth", "rgb", "rgba"])[0] in ("rgb", "rgba")
    assert near_misses("zzz", ["depth"]) == []

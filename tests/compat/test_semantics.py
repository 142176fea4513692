"""Labels through the functions of Isaac Sim 4."""

import pytest

from usdsdg.compat.isaacsim.core.experimental.utils import semantics
from usdsdg.compat.isaacsim.core.utils.semantics import add_update_semantics, remove_all_semantics
from usdsdg.errors import UsdsdgWarning
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.schemas.semantics_schema import SemanticsAPI
from usdsdg.stage.semantics import labels


def test_each_suffix_has_its_own_label():
    prim = new_stage().DefinePrim("/World/mug", "Cube")
    add_update_semantics(prim, semantic_label="mug", type_label="class")
    add_update_semantics(prim, "vessel", suffix="_2")
    assert labels.get_labels(prim) == {"class": ["mug", "vessel"]}
    assert prim.GetAttribute("semantic:Semantics_2:params:semanticData").Get() == "vessel"
    add_update_semantics(prim, "bowl", suffix="_2")
    assert labels.get_labels(prim) == {"class": ["mug", "bowl"]}
    remove_all_semantics(prim)
    assert labels.get_labels(prim) == {}


def test_labels_of_the_old_schema_show_once_they_are_upgraded():
    prim = new_stage().DefinePrim("/World/mug", "Cube")
    for name, label in (("a", "mug"), ("b", "")):
        api = SemanticsAPI.Apply(prim, name)
        api.CreateSemanticTypeAttr().Set("class")
        api.CreateSemanticDataAttr().Set(label)
    assert semantics.get_labels(prim) == {}
    with pytest.warns(UsdsdgWarning, match="'b' in the old schema has no type or no text"):
        assert semantics.upgrade_prim_semantics_to_labels(prim) == ["/World/mug"]
    assert semantics.get_labels(prim) == {"class": ["mug"]}
    assert semantics.upgrade_prim_semantics_to_labels(prim) == []

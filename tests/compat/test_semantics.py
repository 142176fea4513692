"""Labels through the functions of Isaac Sim 4."""

from usdsdg.compat.isaacsim.core.utils.semantics import add_update_semantics, remove_all_semantics
from usdsdg.session.stage_context import new_stage
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

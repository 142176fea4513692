"""`isaacsim.core.utils.stage`."""

from __future__ import annotations

import pytest
from pxr import Usd, UsdGeom

from usdsdg.compat.isaacsim.core.utils import stage as stage_utils
from usdsdg.errors import AssetNotFound
from usdsdg.session import stage_context


def test_stages_are_made_opened_referenced_and_saved(tmp_path):
    assert stage_utils.create_new_stage()
    stage_utils.set_stage_units(0.01)
    stage_utils.set_stage_up_axis("y")
    assert (stage_utils.get_stage_units(), stage_utils.get_stage_up_axis()) == (0.01, "Y")
    made = Usd.Stage.CreateNew(str(tmp_path / "part.usda"))
    made.SetDefaultPrim(UsdGeom.Cube.Define(made, "/part").GetPrim())
    made.Save()
    prim = stage_utils.add_reference_to_stage(str(tmp_path / "part.usda"), "/World/part", prim_type="Cube")
    assert prim.IsA(UsdGeom.Cube)
    stage_utils.save_stage(str(tmp_path / "all.usda"))
    assert stage_utils.open_stage(str(tmp_path / "all.usda"))
    assert stage_utils.get_current_stage() == stage_context.current_stage()
    assert stage_utils.get_current_stage().GetPrimAtPath("/World/part").IsA(UsdGeom.Cube)
    assert not stage_utils.is_stage_loading()
    with pytest.raises(AssetNotFound):
        stage_utils.open_stage(str(tmp_path / "missing.usd"))

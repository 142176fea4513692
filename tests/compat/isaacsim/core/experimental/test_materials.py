"""`isaacsim.core.experimental.materials.NonVisualMaterial`."""

import numpy as np
import pytest
from pxr import UsdShade

from usdsdg.compat.isaacsim.core.experimental.materials import NonVisualMaterial, PreviewSurfaceMaterial


def test_materials_for_other_sensors_are_authored_encoded_and_decoded(stage):
    materials = NonVisualMaterial(["/World/a", "/World/b"], bases="aluminum", coatings=["paint", "none"])
    materials.set_attributes("emissive", indices=[0])
    assert materials.get_bases() == ["aluminum", "aluminum"]
    assert (materials.get_coatings(indices=[1]), materials.get_attributes()) == (["none"], ["emissive", "none"])
    assert stage.GetPrimAtPath("/World/a").GetAttribute("omni:simready:nonvisual:coating").Get() == "paint"
    # base + coating * 2^8 + attribute * 2^11
    assert NonVisualMaterial.encode_material_ids(materials).numpy().tolist() == [[1 + 256 + 2048], [1]]
    assert NonVisualMaterial.encode_material_ids("/World").numpy().tolist() == [[0]]
    expected = [("aluminum", "paint", "emissive"), ("aluminum", "none", "none")]
    assert NonVisualMaterial.decode_material_ids(np.array([[2305], [1]], np.uint16)) == expected
    assert NonVisualMaterial.decode_material_ids(2305) == expected[:1]


def test_a_visual_material_gets_what_other_sensors_see_of_it_as_well(stage):
    PreviewSurfaceMaterial("/World/paint")
    NonVisualMaterial("/World/paint", bases="plastic")
    assert NonVisualMaterial("/World/paint").get_bases() == ["plastic"]
    assert UsdShade.Material.Get(stage, "/World/paint").ComputeSurfaceSource()[0]


def test_unknown_words_and_numbers_are_named(stage):
    with pytest.raises(ValueError, match="no base 'aluminium'; did you mean 'aluminum'"):
        NonVisualMaterial("/World/a", bases="aluminium")
    with pytest.raises(ValueError, match="no coating 'gold'; known: none, paint"):
        NonVisualMaterial("/World/a", coatings="gold")
    with pytest.raises(ValueError, match="65536 is no number of a material"):
        NonVisualMaterial.decode_material_ids([65536])
    with pytest.raises(AssertionError, match="/World is no material"):
        NonVisualMaterial("/World")

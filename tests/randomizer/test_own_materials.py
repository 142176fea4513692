"""`randomizer.color` gives every prim a material of its own, whatever it had before."""

from pxr import UsdShade

import usdsdg as rep
from usdsdg.randomizer.appearance import MATERIALS_SCOPE


def drawn(stage, paths):
    with rep.trigger.on_frame(), rep.get.prim_at_path(paths):
        rep.randomizer.color(rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    for _ in range(2):
        rep.orchestrator.step()
    found = {}
    for path in paths:
        bound, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial()
        assert str(bound.GetPath()).startswith(f"{MATERIALS_SCOPE}/")
        found[str(bound.GetPath())] = tuple(
            bound.GetPrim().GetChild("Shader").GetAttribute("inputs:diffuse_color_constant").Get()
        )
    return found


def test_clones_that_inherit_from_the_first_do_not_have_its_color(stage):
    stage.DefinePrim("/World/env_0/cube", "Cube")
    for index in (1, 2):
        stage.DefinePrim(f"/World/env_{index}", "Xform").GetInherits().AddInherit("/World/env_0")
    found = drawn(stage, [f"/World/env_{index}/cube" for index in range(3)])
    assert len(set(found.values())) == len(found) == 3


def test_prims_that_shared_a_material_have_colors_of_their_own(stage):
    cubes = rep.create.cube(count=3, material=rep.create.material_omnipbr(diffuse=(1, 0, 0)))
    found = drawn(stage, list(cubes.prims))
    assert len(set(found.values())) == len(found) == 3


def test_two_randomizers_of_one_prim_share_its_material(stage):
    cube = rep.create.cube()
    first, second = drawn(stage, list(cube.prims)), drawn(stage, list(cube.prims))
    assert first.keys() == second.keys()

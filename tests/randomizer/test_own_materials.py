"""`randomizer.color` gives every prim a material of its own, whatever it had before."""

from pxr import Tf, Usd, UsdShade

import usdsdg as rep
from usdsdg.stage.scopes import LOOKS


def drawn(stage, paths):
    with rep.trigger.on_frame(), rep.get.prim_at_path(paths):
        rep.randomizer.color(rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    for _ in range(2):
        rep.orchestrator.step()
    found = {}
    for path in paths:
        bound, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial()
        assert str(bound.GetPath()).startswith(f"{LOOKS}/")
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


def test_the_material_is_the_one_that_create_makes(stage):
    """Also where nothing of Replicator is on the stage: opened scenes are colored as they are."""
    stage.DefinePrim("/World/cube", "Cube")
    drawn(stage, ["/World/cube"])
    made, created = (stage.GetPrimAtPath(path) for path in (f"{LOOKS}/OmniPBR", *rep.create.material_omnipbr().prims))
    assert [stage.GetPrimAtPath(path).GetTypeName() for path in ("/Replicator", LOOKS)] == ["Scope", "Scope"]
    outputs = [
        {each.GetBaseName(): each.GetAttr().GetTypeName() for each in UsdShade.Material(prim).GetOutputs()}
        for prim in (made, created)
    ]
    assert outputs[0] == outputs[1] != {}
    for kind in ("surface", "volume", "displacement"):
        source, name, _ = UsdShade.Material(made).GetOutput(f"mdl:{kind}").GetConnectedSource()
        assert (source.GetPath(), name) == (made.GetPath().AppendChild("Shader"), "out")


def test_many_materials_are_made_in_one_change(stage):
    """One by one, each of them took as long as there were materials."""
    changes = []
    listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, lambda notice, _: changes.append(
        [path for path in notice.GetResyncedPaths() if str(path).startswith(f"{LOOKS}/")]), stage)  # fmt: skip
    cubes = rep.create.cube(count=20)
    with rep.trigger.on_frame(), cubes:
        rep.randomizer.color(rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    rep.orchestrator.step()
    listener.Revoke()
    assert max(len(each) for each in changes) == 19  # all but the first, which is copied

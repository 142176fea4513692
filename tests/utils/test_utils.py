"""`rep.utils`: bounding boxes, search, files and nodes."""

import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.errors import AssetNotFound, BadPrim, GraphError, Unsupported, UsdsdgWarning
from usdsdg.graph import evaluate


def test_boxes_and_transforms_of_prims(stage):
    cube = rep.create.cube(position=(1, 2, 3), scale=2, rotation=(0, 0, 45))
    cache = UsdGeom.BBoxCache(0, [UsdGeom.Tokens.default_])
    half = np.sqrt(2)
    expected = (1 - half, 2 - half, 2, 1 + half, 2 + half, 4)
    np.testing.assert_allclose(rep.utils.compute_aabb(cache, cube.prims[0]), expected, atol=1e-6)
    child = stage.GetPrimAtPath(f"{cube.prims[0]}/Cube")
    np.testing.assert_allclose(rep.utils.compute_aabb(cache, child, include_children=False), expected, atol=1e-6)
    np.testing.assert_allclose(rep.utils.compute_aabb(cache, cube.prims[0], False), expected, atol=1e-6)
    nothing = rep.utils.compute_aabb(cache, stage.DefinePrim("/World/empty", "Xform"))
    assert nothing.tolist() == [np.inf] * 3 + [-np.inf] * 3
    assert rep.utils.read_prim_transform(child).ExtractTranslation() == Gf.Vec3d(1, 2, 3)


def test_prims_prototypes_meshes_and_materials_of_paths(stage):
    made = rep.create.material_omnipbr()
    cube = rep.create.cube(material=made)
    xform, mesh = (stage.GetPrimAtPath(path) for path in (cube.prims[0], f"{cube.prims[0]}/Cube"))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/rocks")
    kinds = [stage.DefinePrim(f"/World/{name}", "Mesh") for name in ("round", "flat")]
    instancer.CreatePrototypesRel().SetTargets([kind.GetPath() for kind in kinds])
    paths = [str(instancer.GetPath()), cube.prims[0]]
    assert rep.utils.find_prims(paths) == rep.utils.find_prims(paths, mode="instances") == [*kinds, xform]
    assert rep.utils.find_prims(paths, mode="prims") == [instancer.GetPrim(), xform]
    assert rep.utils.find_prims(paths, mode="meshes") == [*kinds, mesh]
    materials = rep.utils.find_prims(paths, mode="materials")
    assert {type(material) for material in materials} == {UsdShade.Material}
    assert {str(material.GetPath()) for material in materials} == set(made.prims)
    for mode in ("prototypes", "shapes"):
        with pytest.raises(ValueError, match=f"mode='{mode}'; known: instances, prims, meshes, materials"):
            rep.utils.find_prims(paths, mode)
    with pytest.raises(BadPrim, match="/World/none"):
        rep.utils.find_prims(["/World/none"], "prims")


def test_paths_without_a_prim_are_left_out_with_a_warning(stage):
    cube = rep.create.cube()
    assert rep.utils.get_prims_from_paths(["/World"]) == [stage.GetPrimAtPath("/World")]
    with pytest.warns(UsdsdgWarning) as warned:
        assert rep.utils.get_prims_from_paths(["/World", "/nowhere", "no path!"]) == [stage.GetPrimAtPath("/World")]
    assert ["/nowhere" in str(warned[0].message), "no path!" in str(warned[1].message)] == [True, True]
    with pytest.warns(UsdsdgWarning, match="/elsewhere is not a prim on the stage"):
        assert rep.utils.get_non_xform_prims([*cube.prims, "/elsewhere"]) == [f"{cube.prims[0]}/Cube"]


def test_variants_of_a_set(stage):
    copy = stage.DefinePrim("/World/copy")
    copy.GetVariantSets().AddVariantSet("color").AddVariant("red")
    assert rep.utils.get_prim_variant_values("/World/copy", "color") == ["red"]
    with pytest.warns(UsdsdgWarning, match="no variant set 'size'; it has: color"):
        assert rep.utils.get_prim_variant_values("/World/copy", "size") == []


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "deep").mkdir()
    for name in ("b_crate.usd", "a_crate.usda", "deep/c_crate.usdc", "notes.txt"):
        file = tmp_path / name
        if file.suffix == ".txt":
            file.write_text("")
        else:
            layer = Usd.Stage.CreateNew(str(file))
            layer.SetDefaultPrim(layer.DefinePrim("/Crate", "Cube"))
            layer.Save()
    for name in ("rust_Diffuse.PNG", "rust_normal.png", "moss_diffuse.png", "rust_diffuse.jpg"):
        (tmp_path / name).write_text("")
    return tmp_path


def test_usd_files_of_a_folder(folder):
    def names(**options):
        return [path.rsplit("/", 1)[-1] for path in rep.utils.get_usd_files(str(folder), **options)]

    assert names() == ["a_crate.usda", "b_crate.usd"]
    assert names(recursive=True) == ["a_crate.usda", "b_crate.usd", "c_crate.usdc"]
    assert names(path_filter="b_") == ["b_crate.usd"]
    assert rep.utils.get_usd_files(str(folder / "b_crate.usd")) == [str(folder / "b_crate.usd")]
    with pytest.raises(AssetNotFound, match="is a file, not a folder"):
        rep.utils.get_usd_files(str(folder / "rust_normal.png"))
    with pytest.raises(GraphError, match="not a regular expression"):
        names(path_filter="(")
    with pytest.raises(AssetNotFound):
        rep.utils.get_usd_files(str(folder / "nowhere"))


def test_textures_are_grouped_by_stem(folder):
    groups = rep.utils.get_files_group(str(folder), ["_diffuse", "_normal"])
    moss, rust = str(folder / "moss_diffuse.png"), str(folder / "rust_normal.png")
    assert groups == [json.dumps({"moss": {"_diffuse": moss}}), json.dumps({"rust": {"_normal": rust}})]
    both = rep.utils.get_files_group(str(folder), ["_diffuse", "_normal"], file_type="png|PNG")
    assert list(json.loads(both[1])["rust"]) == ["_diffuse", "_normal"]
    assert len(rep.utils.get_files_group(str(folder), ["_DIFFUSE"])) == 1
    assert rep.utils.get_files_group(str(folder), ["_DIFFUSE"], ignore_case=False) == []
    (jpeg,) = rep.utils.get_files_group(str(folder), ["_diffuse"], file_type="jpg")
    assert json.loads(jpeg) == {"rust": {"_diffuse": str(folder / "rust_diffuse.jpg")}}
    for path, suffixes, message in (
        (str(folder), None, "file_suffixes is empty"),
        (str(folder / "notes.txt"), ["_diffuse"], "is not a folder"),
        (str(folder / "nowhere"), ["_diffuse"], "is not a folder"),
        ("ftp://server/textures", ["_diffuse"], "is not a folder"),
    ):
        with pytest.warns(UsdsdgWarning, match=message):
            assert rep.utils.get_files_group(path, suffixes) is None
    with pytest.raises(GraphError, match="not a regular expression"):
        rep.utils.get_files_group(str(folder), ["("])


def test_references_of_a_folder(stage, folder):
    item = rep.create.from_dir(str(folder), recursive=True, semantics=[("class", "crate")])
    assert len(item.prims) == 3
    assert all(stage.GetPrimAtPath(f"{path}/Ref").GetTypeName() == "Cube" for path in item.prims)
    with pytest.raises(AssetNotFound, match="no USD or mesh file that matches 'barrel'"):
        rep.create.from_dir(str(folder), path_filter="barrel")


def test_nodes_created_by_type_run_and_can_be_retargeted(stage):
    cubes = rep.create.cube(count=2)
    assert not rep.utils.get_replicator_graph_exists()
    first, second = cubes.prims
    node = rep.utils.create_node(
        "omni.replicator.core.OgnWritePose", input_prims=first, **{"inputs:position": (1.0, 0.0, 0.0)}
    )
    assert rep.utils.get_replicator_graph_exists()
    assert rep.utils.get_graph().get_path_to_graph() == "/Replicator/SDGPipeline"
    assert rep.utils.get_node_targets(node, "inputs:prims") == [first]
    rep.utils.set_target_prims(node, "inputs:prims", [second])
    evaluate.graph().evaluate()
    assert [
        stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Get() == (1, 0, 0) for path in (first, second)
    ] == [False, True]
    authored = stage.GetPrimAtPath(node.path).GetRelationship("inputs:prims").GetTargets()
    assert [str(path) for path in authored] == [second]
    with pytest.raises(Unsupported, match=r"no node type 'my\.OgnNode'"):
        rep.utils.create_node("my.OgnNode")
    with pytest.raises(Unsupported, match="one graph per stage"):
        rep.utils.get_graph("/World/graph")


def test_a_node_that_has_run_can_be_retargeted(stage):
    first, second = (str(stage.DefinePrim(f"/World/{name}", "Cube").GetPath()) for name in "ab")
    with rep.trigger.on_custom_event("go"):
        nodes = [
            rep.modify.pose(position=rep.distribution.sequence([(1, 0, 0), (2, 0, 0)]), input_prims=first),
            rep.modify.attribute("size", rep.distribution.sequence([5, 6]), input_prims=first),
            rep.physics.rigid_body(rep.distribution.sequence([(3, 0, 0), (4, 0, 0)]), input_prims=first),
        ]
    rep.physics.rigid_body(input_prims=second)
    for targets in (first, second):
        for node in nodes:
            rep.utils.set_target_prims(node, "inputs:prims", [targets])
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()

    def written(path):
        names = ("xformOp:translate", "size", "physics:velocity")
        return [stage.GetPrimAtPath(path).GetAttribute(name).Get() for name in names]

    assert written(first) == [(1, 0, 0), 5, (3, 0, 0)]
    assert written(second) == [(2, 0, 0), 6, (4, 0, 0)]
    with pytest.raises(BadPrim, match="/World/c"):
        rep.utils.set_target_prims(nodes[0], "inputs:prims", ["/World/c"])


def test_inputs_of_nodes_are_set_with_or_without_their_prefix(stage):
    cube = rep.create.cube()
    item = rep.modify.pose(position=(1, 1, 1), input_prims=cube)
    item.set_input("inputs:position", (5, 5, 5))
    item.set_input("scale", 2)
    evaluate.graph().evaluate()
    prim = stage.GetPrimAtPath(cube.prims[0])
    assert prim.GetAttribute("xformOp:translate").Get() == (5, 5, 5)
    assert prim.GetAttribute("xformOp:scale").Get() == (2, 2, 2)
    assert item.get_input("inputs:position") == (5, 5, 5)


def test_items_list_their_prims(stage):
    cubes = rep.create.cube(count=2)
    item = rep.modify.pose(position=1, input_prims=cubes)
    assert item.get_output_prims() == item.get_input_prims() == {"prims": [stage.GetPrimAtPath(p) for p in cubes.prims]}
    assert [str(each.GetChildren()[0].GetName()) for each in cubes.get_output_prims()["prims"]] == ["Cube", "Cube"]
    assert item.outputs == ["prims", "execCount"]
    assert item.get_output("prims") == item.get_outputs()["prims"] == list(cubes.prims)
    given = item.get_inputs()
    given["position"] = 2
    assert item.get_input("position") == 1
    assert item.inputs == ["attribute", "position", "prims"]


def test_inputs_and_outputs_that_a_node_does_not_have_are_errors_of_both_kinds(stage):
    cubes = rep.create.cube(count=2)
    item = rep.modify.pose(position=1, input_prims=cubes)
    drawn = rep.distribution.uniform(0, 1)
    for read, message in (
        (lambda: item.get_output("samples"), "no outputs:samples; it has prims, execCount"),
        (lambda: item.get_input("color"), "no inputs:color; it has attribute, position, prims"),
        (lambda: item.set_input("color", 1), "no inputs:color; it has attribute, position, prims, position_x"),
        (lambda: cubes.set_input("position", 1), "no inputs:position; it has primsIn"),
        (lambda: drawn.set_input("color", 1), "no input 'color'"),
        (lambda: drawn.get_input("color"), "no inputs:color"),
    ):
        for kind in (ValueError, KeyError, GraphError):
            with pytest.raises(kind, match=message):
                read()
    assert item.get_input("scale") is None
    assert item.get_inputs() == {"attribute": "position", "position": 1, "prims": list(cubes.prims)}


def test_the_prims_of_an_item_can_be_replaced(stage):
    """As scripts do after they have moved them."""
    cubes, other = rep.create.cube(count=2), stage.DefinePrim("/World/other", "Cube")
    found = rep.get.prims(path_match="other")
    for item in (cubes, found, rep.create.group(list(cubes.prims))):
        item.set_input("primsIn", [other])
        assert item.get_output_prims()["prims"] == [other]
        assert item.get_input("primsIn") == ["/World/other"]
    with cubes:
        rep.modify.pose(position=(1, 2, 3))
    evaluate.graph().evaluate()
    assert other.GetAttribute("xformOp:translate").Get() == (1, 2, 3)
    trigger, drawn = rep.trigger.on_frame(), rep.distribution.uniform(0, 1)
    for item in (trigger, drawn):
        with pytest.raises(GraphError, match="primsIn"):
            item.set_input("primsIn", [other])


def test_inputs_may_be_distributions_and_prims(stage):
    first, second = rep.create.cube(count=2).prims
    item = rep.modify.pose(position=1, input_prims=first)
    item.set_input("position", rep.distribution.choice([(4, 4, 4)]))
    item.set_input("prims", [second])
    evaluate.graph().evaluate()
    moved = [stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Get() for path in (first, second)]
    assert moved == [(0, 0, 0), (4, 4, 4)]


def test_items_are_shown_by_the_function_that_made_them(stage):
    cube = rep.create.cube()
    with cube:
        posed = rep.modify.pose(position=1)
    rep.randomizer.register(lambda: rep.modify.visibility(True, input_prims=cube), fn_name="shown")
    made = {
        "create.cube": cube,
        "create.group": rep.create.group([cube]),
        "create.camera": rep.create.camera(),
        "create.light": rep.create.light(),
        "create.material_omnipbr": rep.create.material_omnipbr(),
        "modify.pose": posed,
        "modify.visibility": rep.randomizer.shown(),
        "randomizer.rotation": rep.randomizer.rotation(input_prims=cube),
        "distribution.uniform": rep.distribution.uniform(0, 1),
        "trigger.on_frame": rep.trigger.on_frame(),
        "get.prims": rep.get.prims(),
        "physics.rigid_body": rep.physics.rigid_body(input_prims=cube),
    }
    assert {name: str(item) for name, item in made.items()} == {name: f"omni.replicator.core.{name}" for name in made}


def test_nodes_cannot_be_disconnected():
    from usdsdg.utils.utils import _disconnect

    with pytest.raises(Unsupported, match="run in the order of the script"):
        _disconnect("/a.outputs:execOut", "/b.inputs:execIn")


@pytest.mark.parametrize("family", ["create", "get", "modify", "randomizer", "distribution", "trigger"])
def test_functions_of_scripts_can_be_registered_in_every_family(family):
    module = getattr(rep, family)

    def lucky(number):
        return number + 1

    module.register(lucky)
    module.register(lucky, fn_name="other")
    assert (module.lucky(6), module.other(7)) == (7, 8)
    with pytest.raises(ValueError, match=f"{family}.register: 'lucky' exists"):
        module.register(lucky, override=False)
    module.register(abs, fn_name="lucky")
    assert module.lucky(-6) == 6
    del module.lucky, module.other
    with pytest.raises(ValueError, match="5 is not a function"):
        module.register(5)


def test_paths_in_outputs_are_texts_and_usd_paths(stage):
    cube = rep.create.cube()
    (path,) = cube.get_outputs()["prims"]
    expected = Sdf.Path("/Replicator/Cube_Xform")
    assert (path, path.GetString(), path.pathString, path.GetText()) == ("/Replicator/Cube_Xform",) * 4
    assert type(path.pathString) is str
    assert (path.name, path.GetName()) == (expected.name,) * 2
    assert path.GetParentPath() == str(expected.GetParentPath())
    assert path.AppendChild("Cube") == str(expected.AppendChild("Cube"))
    assert path.GetParentPath().GetParentPath().AppendChild("World") == "/World"
    assert stage.GetPrimAtPath(path.AppendChild("Cube")).IsA(UsdGeom.Mesh)
    assert rep.modify.pose(position=1, input_prims=cube).get_input("prims")[0].GetString() == path


def test_attributes_of_nodes_are_read_and_set_as_those_of_omnigraph(stage):
    cubes, drawn = rep.create.cube(count=2), rep.distribution.uniform((0, 0, 0), (1, 1, 1))
    with rep.trigger.on_custom_event("go"), cubes:
        posed = rep.modify.pose(position=drawn, name="drop")
    assert cubes.node.get_attribute("outputs:prims").get() == list(cubes.prims)
    assert posed.node.get_attribute("inputs:prims").get() == list(cubes.prims)
    lower = drawn.node.get_attribute("inputs:lower")
    assert (lower.get_name(), lower.get(), lower.get_node()) == ("inputs:lower", (0, 0, 0), drawn.node)
    lower.set((0.5, 0.5, 1))
    rep.utils.send_og_event("go")
    evaluate.graph().evaluate()
    samples = drawn.node.get_attribute("outputs:samples").get()
    assert [tuple(each) for each in samples] == [
        tuple(stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Get()) for path in cubes.prims
    ]
    assert all(each[0] >= 0.5 and each[2] == 1 for each in samples)

    assert stage.GetPrimAtPath(posed.node.get_prim_path()).GetRelationship("inputs:prims").GetTargets() == [
        *cubes.prims
    ]
    with pytest.raises(Unsupported, match=r"has no prim of its own.*get_output_prims"):
        cubes.node.get_prim_path()
    assert not cubes.node.get_attribute_exists("outputs:samples")
    assert drawn.node.get_attribute_exists("outputs:samples")
    with pytest.raises(ValueError, match="has no inputs:lover"):
        drawn.node.get_attribute("inputs:lover").get()


def test_nodes_run_in_the_order_of_the_script(stage):
    cube = rep.create.cube()
    with rep.utils.sequential():
        first = rep.modify.pose(position=1, input_prims=cube)
        second = rep.modify.pose(position=2, input_prims=cube)
    rep.utils.auto_connect(first, second)
    with pytest.raises(Unsupported, match="made before"):
        rep.utils.auto_connect(second, first)
    rep.utils.auto_connect(upstream_node=None, downstream_node=first, mapping=[], no_exec=True)
    with pytest.raises(Unsupported, match="mapping is not available"):
        rep.utils.auto_connect(first, second, mapping=[("outputs:samples", "inputs:values")])

    @rep.utils.ReplicatorWrapper
    def lifted(height):
        return rep.modify.pose(position_z=height, input_prims=cube).node

    assert lifted(3).prims == cube.prims


def test_cameras_are_told_from_other_objects(stage):
    camera, cube = rep.create.camera(), rep.create.cube()
    inner = stage.GetPrimAtPath(camera.prims[0]).GetChildren()[0]
    assert rep.utils.is_camera_prim(stage.GetPrimAtPath(camera.prims[0]))
    assert rep.utils.is_camera_prim(inner.GetPath())
    assert not rep.utils.is_camera_prim(stage.GetPrimAtPath(cube.prims[0]))
    assert not rep.utils.is_camera_prim("/World")


def test_an_mdl_material_is_made_at_the_next_free_path(stage):
    for _ in range(2):
        rep.utils.create_material("OmniGlass.mdl", "OmniGlass", "/World/Looks/Glass")
    assert stage.GetPrimAtPath("/World/Looks").GetTypeName() == "Scope"
    for path in ("/World/Looks/Glass", "/World/Looks/Glass_01"):
        shader = UsdShade.Material(stage.GetPrimAtPath(path)).ComputeSurfaceSource("mdl")[0]
        assert shader.GetSourceAsset("mdl").path == "OmniGlass.mdl"
        assert shader.GetSourceAssetSubIdentifier("mdl") == "OmniGlass"


def test_times_are_reduced_to_lowest_terms():
    assert rep.utils.get_reduced_ref_time(120, 90) == (4, 3)
    assert rep.utils.get_reduced_ref_time(0, 90) == (0, 90)
    assert (rep.utils.REPLICATOR_SCOPE, rep.utils.GRAPH_PATH) == ("/Replicator", "/Replicator/SDGPipeline")


def test_modules_below_utils_have_what_scripts_import_from_them():
    from usdsdg.utils import utils

    assert utils.find_prims is rep.utils.find_prims
    assert {name for name in rep.utils.__all__ if not hasattr(utils, name)} == set()
    rep.rng.set_global_seed(7)
    assert rep.rng.get_global_seed() == rep.get_global_seed() == 7

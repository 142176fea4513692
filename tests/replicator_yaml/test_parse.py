"""Replicator YAML files: what they build on the stage, and how mistakes are reported."""

import re
import textwrap
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import usdsdg as rep
from usdsdg.errors import GraphError
from usdsdg.graph import evaluate
from usdsdg.graph.node import ReplicatorItem
from usdsdg.replicator_yaml import ParserError, parse
from usdsdg.session.stage_context import current_stage, new_stage, save_stage

pytestmark = pytest.mark.usefixtures("stage")


@pytest.fixture
def parsed(tmp_path):
    """A function that writes text to `scene.yaml` and parses it."""

    def parse_text(text, **options):
        path = tmp_path / "scene.yaml"
        path.write_text(textwrap.dedent(text))
        return parse(path, **options)

    return parse_text


def position_of(path):
    matrix = UsdGeom.XformCache().GetLocalToWorldTransform(current_stage().GetPrimAtPath(path))
    return np.array(matrix.ExtractTranslation())


def labels(path):
    return list(current_stage().GetPrimAtPath(path).GetAttribute("semantics:labels:class").Get())


SCENE = """
    up:
      settings.set_stage_up_axis:
        up_axis: "Z"
    unit:
      settings.set_stage_meters_per_unit:
        meters_per_unit: 0.01

    cube:
      create.cube:
        position: [1, 2, 3]
        semantics: [["class", "cube"]]
    sphere:
      create.sphere:
        count: 3
    both:
      create.group:
        items: [cube, sphere]

    trigger:
      trigger.on_frame:
        max_execs: 4
    with_trigger:
      with.trigger:
        with.both:
          modify.pose:
            position:
              distribution.uniform:
                lower: [-1, -1, 5]
                upper: [1, 1, 5]
            scale: 1e-1
          modify.semantics:
            semantics: [["class", "cube"]]
    """


def test_groups_are_calls_and_names_of_their_results(stage, parsed):
    made = parsed(SCENE)
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert tuple(position_of("/Replicator/Cube_Xform")) == (1, 2, 3)
    assert isinstance(made["both"], ReplicatorItem)
    assert made["both"].prims == (*made["cube"].prims, *made["sphere"].prims)
    assert made["trigger"]._trigger.max_execs == 4
    assert made["with_trigger"] is None


def test_with_blocks_nest_and_run_their_calls_in_order(parsed):
    made = parsed(SCENE)
    (trigger,) = evaluate.graph().triggers
    assert [node.kind for node in trigger.nodes] == ["OgnWritePose", "OgnWriteSemantics"]
    assert trigger.nodes[0].prims == made["both"].prims
    evaluate.graph().evaluate(preview=True)
    heights = [position_of(path)[2] for path in made["both"].prims]
    assert heights == [5] * 4
    prim = current_stage().GetPrimAtPath("/Replicator/Sphere_Xform_02")
    assert UsdGeom.Xformable(prim).GetLocalTransformation().GetRow3(0)[0] == pytest.approx(0.1)


def test_a_file_draws_what_the_same_script_draws(parsed):
    parsed(SCENE)
    evaluate.graph().evaluate(preview=True)
    paths = ["/Replicator/Cube_Xform", "/Replicator/Sphere_Xform_01"]
    by_file = [position_of(path) for path in paths]
    new_stage()
    rep.settings.set_stage_up_axis("Z")
    both = rep.create.group([rep.create.cube(position=(1, 2, 3)), rep.create.sphere(count=3)])
    with rep.trigger.on_frame(max_execs=4), both:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, 5), (1, 1, 5)), scale=0.1)
    evaluate.graph().evaluate(preview=True)
    assert np.array_equal(by_file, [position_of(path) for path in paths])


def test_labels_are_not_names_of_groups(parsed):
    made = parsed(
        """
        cube:
          create.cube:
            semantics: [["class", "cube"]]
        again:
          create.cone:
            semantics: [["class", "cube"]]
        found:
          get.prims:
            semantics: [["class", "cube"]]
        """
    )
    assert labels("/Replicator/Cone_Xform") == ["cube"]
    assert set(made["found"].prims) == {"/Replicator/Cube_Xform", "/Replicator/Cone_Xform"}


def test_plain_groups_are_values_for_later_ones(parsed):
    parsed(
        """
        heights: [[0, 0, 1], [0, 0, 2]]
        about: &about {visible: false, count: 2}
        cubes:
          create.cube:
            <<: *about
            position:
              distribution.sequence:
                items: heights
                stride: 2
        """
    )
    evaluate.graph().evaluate()
    assert [position_of(f"/Replicator/Cube_Xform{end}")[2] for end in ("", "_01")] == [1, 2]


def test_registered_functions_have_inputs_and_local_names(stage, parsed):
    parsed(
        """
        shape:
          create.cube: null
        register_tower:
          randomizer.register:
            yaml_tower:
              inputs:
                height: 2
                base: null
              shape:
                create.cylinder:
                  count: height
              with.shape:
                modify.pose:
                  scale: 3
              lid:
                create.cone:
                  parent: base
        low:
          randomizer.yaml_tower: {base: shape}
        high:
          randomizer.yaml_tower:
            height: 5
            base: shape
        """
    )
    try:
        cylinders = [prim for prim in stage.Traverse() if prim.GetName().startswith("Cylinder_Xform")]
        assert len(cylinders) == 7
        assert stage.GetPrimAtPath("/Replicator/Cube_Xform/Cone_Xform_01")
        # The name inside the function is not the one outside.
        assert len(rep.randomizer.yaml_tower(base="/Replicator/Cube_Xform").prims) == 1
    finally:
        del rep.randomizer.yaml_tower


def test_methods_of_the_result_of_a_group_can_be_called(parsed, tmp_path):
    made = parsed(
        f"""
        camera:
          create.camera:
            position: [5, 0, 0]
            look_at: [0, 0, 0]
        render_product:
          create.render_product:
            camera: camera
            resolution: [16, 12]
        writer:
          writers.get:
            name: "BasicWriter"
            init_params:
              output_dir: "{tmp_path / "out"}"
              rgb: True
        attach:
          writer.attach:
            render_products: [render_product]
        """
    )
    assert made["writer"].render_products == (made["render_product"].path,)
    made["writer"].detach()


def test_a_group_inherits_the_entries_that_it_does_not_have(parsed, tmp_path):
    (tmp_path / "base.yaml").write_text(
        textwrap.dedent(
            """
            flying:
              create.sphere:
                count: 2
                position: [0, 0, 7]
            places: [[1, 0, 0]]
            unused:
              create.torus: null
            """
        )
    )
    made = parsed(
        """
        profiles:
          - base.yaml
        objects:
          inherit: flying
          create.sphere:
            count: 4
        cubes:
          create.cube:
            position:
              distribution.choice:
                choices: places
        moved:
          with.objects:
            inherit: move
        move:
          modify.pose:
            scale: 2
        """
    )
    evaluate.graph().evaluate()
    assert len(made["objects"].prims) == 4
    assert position_of(made["objects"].prims[3])[2] == 7
    assert tuple(position_of("/Replicator/Cube_Xform")) == (1, 0, 0)
    assert not current_stage().GetPrimAtPath("/Replicator/Torus_Xform")
    assert "move" not in made


def test_file_paths_are_relative_to_a_root(parsed, tmp_path):
    (tmp_path / "assets").mkdir()
    thing = Usd.Stage.CreateNew(str(tmp_path / "assets" / "thing.usda"))
    thing.SetDefaultPrim(UsdGeom.Cube.Define(thing, "/Thing").GetPrim())
    thing.Save()
    text = """
        {root}thing:
          create.from_usd:
            usd: {{value: "thing.usda", property: "file_path"}}
        """
    for root, options in (
        ("file_root_dir: assets\n        ", {}),
        (f"file_root_dir: {tmp_path / 'assets'}\n        ", {}),
        ("", {"root_dir": tmp_path / "assets"}),
    ):
        new_stage()
        parsed(text.format(root=root), **options)
        assert current_stage().GetPrimAtPath("/Replicator/Ref_Xform/Ref").GetTypeName() == "Cube"


def test_nucleus_paths_are_prefixed_with_their_server(parsed):
    text = """
        nucleus_server: "omniverse://there/"
        path: {value: "NVIDIA/a.usd", property: "nucleus_path"}
        """
    assert parsed(text)["path"] == "omniverse://there/NVIDIA/a.usd"
    assert parsed(text, nucleus_server="here")["path"] == "omniverse://here/NVIDIA/a.usd"


def test_nodes_keep_their_line_also_in_a_saved_stage(parsed, tmp_path):
    parsed(
        """
        cube:
          create.cube: null
        trigger:
          trigger.on_frame: null
        moves:
          with.trigger:
            with.cube:
              modify.attribute:
                name: nothing
                value: 3
        """
    )
    save_stage(tmp_path / "saved.usda")
    assert 'usdsdg:line = "scene.yaml:9"' in (tmp_path / "saved.usda").read_text()
    with pytest.raises(GraphError, match=r"scene\.yaml:9"):
        evaluate.graph().evaluate(preview=True)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("a:\n  create.cub: null\n", 2, "no function create.cub .*; did you mean 'cube'"),
        ("a:\n  creat.cube: null\n", 2, "no module or group 'creat'; did you mean 'create'"),
        ("a:\n  create.cube:\n    positon: 1\n", 3, "unexpected keyword argument 'positon'; did you mean 'position'"),
        ("a:\n  create.from_usd:\n    count: 2\n", 2, "create.from_usd needs a value for usd"),
        ("a:\n  create.cube: 3\n", 2, "as a mapping of names to values, not 3"),
        ("cube:\n  create.cube: null\nb:\n  with.cub:\n    modify.pose: {scale: 2}\n", 4, "no group 'cub'.*'cube'"),
        ("n: 3\nb:\n  with.n:\n    modify.pose: {scale: 2}\n", 3, "'n' is the int 3"),
        ("a:\n  create.cube: null\n\na:\n  create.cone: null\n", 4, "'a' is given twice in the file"),
        ("a:\n  inherit: b\n  create.cube: null\nbb: 3\n", 2, "no group 'b' to inherit from"),
        ("a: {create.cube: {position: {distribution.uniform: {}}}}\n", 1, "uniform needs a value for lower, upper"),
        ("a:\n  inherit: b\nb:\n  inherit: c\nc:\n  inherit: b\n", 6, "inherits from itself"),
        ("a: [1, 2\nb: 3\n", 2, "expected"),
        ("a:\n  randomizer.register:\n    two words:\n      create.cube: null\n", 3, "'two words' cannot be the name"),
        ("a:\n  randomizer.register:\n    f:\n      inputs:\n        b.c: 3\n", 5, "'b.c' cannot be the name"),
        ("- 1\n", 1, "the file must be a mapping"),
        ('a:\n  create.cube:\n    count: !!int ""\n', 3, "'' is no int"),
        ("a:\n  create.cube:\n    count: !!python/name:os.system\n", 3, "could not determine a constructor"),
        ("profiles: [nowhere.yaml]\n", 1, "no profile .*nowhere.yaml"),
        ("a: {value: x, property: file}\n", 1, "expected file_path or nucleus_path"),
        ("a:\n  create.cube:\n    count: -1\n", 2, "create.cube: count is -1"),
        (
            "a:\n  create.render_product: {camera: camera, resolution: [8, 8]}\ncamera:\n  create.camera: null\n",
            2, "camera is 'camera', a group that is defined later, in line 3",
        ),
        (
            "camera:\n  create.camera: null\na:\n  create.render_product:\n    camera: camra\n    resolution: [8, 8]\n",
            4, "camera is 'camra'; did you mean 'camera'",
        ),
    ],
)  # fmt: skip
def test_mistakes_are_reported_with_their_line(parsed, tmp_path, text, line, words):
    with pytest.raises(ParserError, match=f"Error parsing {tmp_path / 'scene.yaml'}, line {line}: .*{words}"):
        parsed(text)


def test_a_missing_file_is_an_error_that_names_it(tmp_path):
    with pytest.raises(ParserError, match=r"nothing\.yaml: it cannot be read"):
        parse(tmp_path / "nothing.yaml")


def test_an_alias_inside_itself_is_an_error(parsed):
    with pytest.raises(ParserError, match="alias"):
        parsed("a: &a\n  b: *a\n")


def test_the_example_of_the_documentation_works(parsed, tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "yaml.md").read_text(encoding="utf-8")
    example = re.search(r"```yaml\n(.*?)```", page, re.DOTALL)[1]
    made = parsed(example.replace("output_dir: cubes", f"output_dir: {tmp_path}/out"))
    made["writer"].detach()
    assert [trigger.max_execs for trigger in evaluate.graph().triggers] == [10]
    line = re.search(r"line (\d+): create.cube", page)[1]
    with pytest.raises(ParserError, match=f"line {line}: create.cube .*'positon'; did you mean 'position'"):
        parsed(example.replace("semantics:", "positon:"))

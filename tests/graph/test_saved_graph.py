"""The graph as prims on a saved stage, which runs again without its script."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd

import usdsdg as rep
from tests import forked
from tests.dataset_files import data_names
from tests.sampled_cases import in_soak
from usdsdg.app import saved_graph
from usdsdg.app.status import OrchestratorError
from usdsdg.errors import ConfigError, GraphError, UsdsdgWarning
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node_prims import Link, NodeRecord, define_graph, define_node, read_node
from usdsdg.scenarios import saved_pipeline
from usdsdg.session import stage_context

pytestmark = pytest.mark.usefixtures("stage")

PIPELINE = Path(__file__).with_name("twenty_nodes.py")


@pytest.mark.parametrize(
    "value",
    [
        True,
        3,
        0.25,
        "text",
        (1, 2),
        (1, 2, 3),
        (0.5, 1.5, 2.5),
        (0.0, 1.0, 0.5, 1.0),
        ["/World/a", "/World/b"],
        [0.5, 1.5],
        [(0.0, 1.0, 0.5), (1.0, 0.0, 0.5)],
        [1, 2, 3],
        [True, False],
        [["class", "cube"], ["class", "ball"]],
        {"class": "cube"},
        [1, "two", None],
    ],
)
def test_an_input_reads_back_as_it_was_written(value):
    stage = stage_context.current_stage()
    define_graph(stage)
    prim = define_node(stage, "/Replicator/SDGPipeline/Node", NodeRecord("OgnNode", {"value": value}))
    found = read_node(prim).inputs["value"]
    assert found == value
    assert type(found) is type(value)


def test_arrays_and_links_read_back():
    stage = stage_context.current_stage()
    define_graph(stage)
    inputs = {"rows": np.arange(6.0).reshape(2, 3), "drawn": Link("/A"), "mixed": [Link("/A"), 2.0, Link("/B")]}
    found = read_node(define_node(stage, "/Replicator/SDGPipeline/Node", NodeRecord("OgnNode", inputs))).inputs
    assert found["rows"] == [(0.0, 1.0, 2.0), (3.0, 4.0, 5.0)]
    assert found["drawn"] == Link("/A")
    assert found["mixed"] == [Link("/A"), 2.0, Link("/B")]


def test_a_saved_stage_cannot_have_scripts_of_its_own_run():
    stage = stage_context.current_stage()
    define_graph(stage)
    keys = {"app:scripting:ignoreWarningDialog": True, "rtx:pathtracing:totalSpp": 3}
    stage.GetRootLayer().customLayerData = {"renderSettings": keys}
    assert saved_graph.load(stage).settings == {"/rtx/pathtracing/totalSpp": 3}


def test_nodes_are_prims_with_their_targets_order_and_script_line():
    cubes = rep.create.cube(count=2)
    with rep.trigger.on_frame(interval=2, name="often"), cubes:
        rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 2, 3)))
        rep.randomizer.color(rep.distribution.choice([(1, 0, 0), (0, 1, 0)]))
    prims = {
        p.GetName(): p for p in stage_context.current_stage().GetPrimAtPath("/Replicator/SDGPipeline").GetChildren()
    }
    assert list(prims) == ["OgnOnFrame", "OgnSampleUniform", "OgnWritePose", "OgnSampleChoice", "OgnColor"]
    assert {prim.GetTypeName() for prim in prims.values()} == {"OmniGraphNode"}
    assert prims["OgnWritePose"].GetAttribute("node:type").Get() == "omni.replicator.core.OgnWritePose"
    assert prims["OgnOnFrame"].GetAttribute("inputs:interval").Get() == 2
    assert prims["OgnSampleUniform"].GetAttribute("inputs:upper").Get() == Gf.Vec3i(1, 2, 3)
    pose = read_node(prims["OgnWritePose"])
    assert pose.prims == cubes.prims
    assert pose.inputs["position"] == Link("/Replicator/SDGPipeline/OgnSampleUniform")
    assert pose.after == "/Replicator/SDGPipeline/OgnOnFrame"
    assert read_node(prims["OgnColor"]).after == "/Replicator/SDGPipeline/OgnWritePose"
    assert pose.metadata["line"].startswith("test_saved_graph.py:")


def test_setting_an_input_changes_draws_and_prim():
    cube = rep.create.cube()
    drawn = rep.distribution.uniform((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with rep.trigger.on_frame(), cube:
        rep.modify.pose(position=drawn)
    drawn.set_input("upper", (6.0, 6.0, 6.0))
    drawn.set_input("lower", (5.0, 5.0, 5.0))
    graph().evaluate(preview=True)
    prim = stage_context.current_stage().GetPrimAtPath(cube.prims[0])
    assert min(prim.GetAttribute("xformOp:translate").Get()) >= 5.0
    node = stage_context.current_stage().GetPrimAtPath("/Replicator/SDGPipeline/OgnSampleUniform")
    assert node.GetAttribute("inputs:upper").Get() == Gf.Vec3d(6, 6, 6)


@pytest.mark.parametrize("changed", [(0.25, 0.5, 1), 0.5, rep.distribution.uniform])
def test_an_input_may_be_set_to_a_value_of_another_type(changed):
    value = changed(0, 1) if callable(changed) else changed
    first = (1, 1, 1) if isinstance(changed, tuple) else 1
    for before, after in ((first, value), (value, first)):
        with rep.trigger.on_custom_event("go"), rep.create.cube():
            item = rep.modify.pose(scale=before)
        item.set_input("scale", after)
        saved = read_node(stage_context.current_stage().GetPrimAtPath(item.node.get_prim_path())).inputs["scale"]
        assert isinstance(saved, Link) if after is value and callable(changed) else saved == after


def test_a_loaded_graph_repeats_the_draws_of_the_script():
    rep.set_global_seed(11)
    cubes = rep.create.cube(count=3)
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(
            position=rep.distribution.normal((0, 0, 0), (1, 2, 3)), rotation=rep.distribution.uniform(0, 90)
        )
        rep.randomizer.rotation(min_angle=(0, 0, 0), max_angle=(0, 0, 90))
        rep.physics.rigid_body(velocity=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
    stage = stage_context.current_stage()
    graph().evaluate(preview=True)
    graph().evaluate(capture=1)
    expected = stage.GetRootLayer().ExportToString()
    saved_graph.load(stage)
    graph().evaluate(preview=True)
    graph().evaluate(capture=1)
    assert stage.GetRootLayer().ExportToString() == expected


def test_a_loaded_graph_draws_by_the_seeds_of_the_script_and_of_its_randomizers():
    rep.set_global_seed(11)
    boxes, balls = rep.create.cube(count=2), rep.create.sphere(count=2)
    for group in (boxes, balls):
        with rep.trigger.on_frame(), group:
            rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1), seed=4))
            rep.randomizer.color(rep.distribution.uniform((0, 0, 0), (1, 1, 1)), seed=4)
    stage = stage_context.current_stage()
    made = [stage.GetPrimAtPath(path) for path in (*boxes.prims, *balls.prims)]

    def drawn():
        graph().evaluate(preview=True)
        graph().evaluate(capture=1)
        places = [tuple(prim.GetAttribute("xformOp:translate").Get()) for prim in made]
        colors = (prim.GetAttribute("inputs:diffuse_color_constant").Get() for prim in stage.Traverse())
        return places, [tuple(color) for color in colors if color is not None]

    places, colors = drawn()
    assert places[:2] == places[2:]
    assert places[0] != places[1]
    assert len(set(colors)) == len(colors) == 4
    saved_graph.load(stage)
    assert drawn() == (places, colors)


def test_a_bound_edited_on_the_prim_is_read_when_the_stage_is_loaded():
    cube = rep.create.cube()
    with rep.trigger.on_frame(), cube:
        rep.modify.pose(position=rep.distribution.uniform((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    stage = stage_context.current_stage()
    drawn = stage.GetPrimAtPath("/Replicator/SDGPipeline/OgnSampleUniform")
    drawn.GetAttribute("inputs:upper").Set(Gf.Vec3d(30, 30, 30))
    drawn.GetAttribute("inputs:lower").Set(Gf.Vec3d(20, 20, 20))
    saved_graph.load(stage)
    graph().evaluate(preview=True)
    assert min(stage.GetPrimAtPath(cube.prims[0]).GetAttribute("xformOp:translate").Get()) >= 20.0


def test_nodes_added_to_a_loaded_graph_get_new_keys():
    cube = rep.create.cube()
    with rep.trigger.on_frame(), cube:
        rep.modify.attribute("size", rep.distribution.uniform(1, 2), attribute_type="double")
    saved_graph.load(stage_context.current_stage())
    with rep.trigger.on_frame(), cube:
        rep.modify.attribute("size", rep.distribution.uniform(1, 2), attribute_type="double")
    first, second = (trigger.nodes[0].key for trigger in graph().triggers)
    assert first != second


@pytest.mark.parametrize(
    ("break_it", "words"),
    [
        (lambda s: s.RemovePrim("/Replicator/SDGPipeline"), "no /Replicator/SDGPipeline"),
        (lambda s: s.RemovePrim("/Replicator/SDGPipeline/OgnSampleUniform"), "OgnSampleUniform.*not on the stage"),
        (lambda s: s.RemovePrim("/Replicator/SDGPipeline/OgnOnFrame"), "started by .*OgnOnFrame"),
        (
            lambda s: s.GetPrimAtPath("/Replicator/SDGPipeline/OgnWritePose").GetAttribute("node:type").Set("x.Fold"),
            "of type Fold",
        ),
        (
            lambda s: s.GetPrimAtPath("/Replicator/SDGPipeline/OgnSampleUniform").RemoveProperty("node:type"),
            "/Replicator/SDGPipeline/OgnSampleUniform: .* is not a distribution",
        ),
    ],
)
def test_loading_a_damaged_graph_names_what_is_missing(break_it, words):
    with rep.trigger.on_frame(), rep.create.cube():
        rep.modify.pose(position=rep.distribution.uniform(0, 1))
    break_it(stage_context.current_stage())
    with pytest.raises(GraphError, match=words):
        saved_graph.load(stage_context.current_stage())


def test_loading_a_python_condition_raises_and_names_it():
    def rarely():
        return False

    with rep.trigger.on_condition(rarely), rep.create.cube():
        rep.modify.pose(position=(0, 0, 1))
    with pytest.raises(GraphError, match=r"rarely.*test_saved_graph\.py:.*run the script"):
        saved_graph.load(stage_context.current_stage())


def test_overrides_name_all_mistakes_at_once():
    assert saved_pipeline.Overrides.parse(["num_frames=3", "seed=0"]) == saved_pipeline.Overrides(3, None, 0)
    with pytest.raises(ConfigError, match=r"num_frame: .*num_frames.*seed: 'x'"):
        saved_pipeline.Overrides.parse(["num_frame=3", "seed=x"])


@in_soak
def test_a_saved_pipeline_of_twenty_nodes_makes_the_same_files_in_a_fresh_process(tmp_path):
    command = [sys.executable, "-m", "usdsdg"]
    script, again, stage = tmp_path / "script", tmp_path / "again", tmp_path / "scene.usdc"
    run = [*command, "run", "-q", "--device", "cpu", "--save-stage", str(stage), str(PIPELINE), str(script)]
    generate = [*command, "generate", "-q", "--device", "cpu", str(stage), "--set", f"output_dir={again}"]
    for each in (run, generate):
        subprocess.run(each, check=True, capture_output=True, timeout=300, cwd=tmp_path)
    saved = Usd.Stage.Open(str(stage))
    nodes = [prim for prim in saved.Traverse() if prim.GetTypeName() == "OmniGraphNode"]
    assert len(nodes) >= 20
    files = data_names(script)
    assert files == data_names(again)
    assert [name for name in files if (script / name).read_bytes() != (again / name).read_bytes()] == []
    assert saved.GetRootLayer().customLayerData["renderSettings"]["omni:replicator:RTSubframes"] == 2


def test_items_return_their_inputs_and_outputs():
    cube = rep.create.cube()
    with rep.trigger.on_frame(interval=3) as trigger, cube:
        item = rep.modify.pose(position=(1, 2, 3))
    assert trigger.get_input("inputs:interval") == 3
    assert item.get_input("position") == (1, 2, 3)
    assert item.get_output("prims") == list(cube.prims)
    assert item.get_outputs()["execCount"] == 0
    graph().evaluate(preview=True)
    assert (item.get_output("execCount"), trigger.get_output("outputs:execCount")) == (1, 1)
    with pytest.raises(KeyError, match="no inputs:color; it has attribute, position"):
        item.get_input("color")


def test_nodes_tell_their_types():
    made = [rep.distribution.normal(0, 1), rep.trigger.on_frame(), rep.trigger.on_custom_event("go")]
    assert [item.node.get_type_name() for item in made] == [
        "omni.replicator.core.OgnSampleNormal",
        "omni.replicator.core.OgnOnFrame",
        "omni.graph.action.OnCustomEvent",
    ]


@pytest.mark.parametrize("family", ["distribution", "trigger"])
def test_functions_can_be_registered_in_a_family(family):
    module = getattr(rep, family)
    module.register(lambda: 7, fn_name="lucky")
    assert module.lucky() == 7
    with pytest.raises(ValueError, match="lucky"):
        module.register(lambda: 8, override=False, fn_name="lucky")
    del module.lucky


def test_a_writer_or_number_that_was_changed_is_an_error_that_names_the_prim():
    stage = stage_context.current_stage()
    define_graph(stage)
    define_node(stage, f"{saved_graph.WRITERS}/Writer", NodeRecord("Writer", {"writerName": "BasicWriter"}))
    with pytest.raises(GraphError, match=rf"^{saved_graph.WRITERS}/Writer is no writer.*renderProducts"):
        saved_graph.load(stage)
    stage.RemovePrim(f"{saved_graph.WRITERS}/Writer")
    root = stage.GetPrimAtPath("/Replicator/SDGPipeline")
    root.CreateAttribute("usdsdg:frames", Sdf.ValueTypeNames.String).Set("many")
    with pytest.raises(GraphError, match="frames is no number"):
        saved_graph.load(stage)


WRITERS = """
import omni.replicator.core as rep
cube = rep.create.cube(semantics=[("class", "cube")])
rep.create.light(light_type="dome")
views = [rep.create.render_product(rep.create.camera(position=(8, y, 3), look_at=cube), (32, 24)) for y in (0, 2)]
with rep.trigger.on_frame(), cube:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
for name, options in {"all": {}, "some": {"trigger": rep.trigger.on_frame(interval=2)}}.items():
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=name, bounding_box_2d_tight=True)
    writer.attach(views, **options)
rep.orchestrator.run(num_frames=3)
"""


def test_saved_writers_keep_their_triggers_and_share_their_render_products(tmp_path, monkeypatch):
    """They wrote every frame, below folders with other names where two had one render product."""
    # Kernels are not compiled anew for this home.
    monkeypatch.setenv("XDG_CACHE_HOME", os.environ.get("XDG_CACHE_HOME", os.path.expanduser("~/.cache")))
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "script.py").write_text(WRITERS)
    found = []
    for command in (["run", "--save-stage", "saved.usda", "script.py"], ["generate", "saved.usda"]):
        done = forked.run(["-m", "usdsdg", command[0], "-q", "--device", "cpu", *command[1:]], cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        output = tmp_path / "omni.replicator_out"
        found.append({name: (output / name).read_bytes() for name in sorted(map(str, data_names(output)))})
        shutil.rmtree(output)
    assert found[0] == found[1]
    assert sum("some" in name and name.endswith(".npy") for name in found[0]) == 4
    assert sum("all" in name and name.endswith(".npy") for name in found[0]) == 6


def test_a_writer_with_a_function_as_its_trigger_is_told(tmp_path):
    product = rep.create.render_product(rep.create.camera(position=(8, 0, 3)), (32, 24))
    with rep.trigger.on_frame():
        rep.create.cube(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), bounding_box_2d_tight=True)
    writer.attach(product, trigger=lambda: True)
    with pytest.warns(match="when its BasicWriter is due, which a Python function decides"):
        rep.save_stage(tmp_path / "saved.usda")


@pytest.mark.parametrize("capture", ["step", "run"])
def test_a_script_is_told_of_triggers_that_its_stage_was_saved_with(stage, tmp_path, capture):
    cube = rep.create.cube()
    with rep.trigger.on_frame(max_execs=2), cube:
        rep.modify.pose(position=rep.distribution.uniform((1, 1, 1), (2, 2, 2)))
    stage.GetRootLayer().Export(str(tmp_path / "scene.usda"))
    assert stage_context.open_stage(str(tmp_path / "scene.usda"))
    message = r"/Replicator/SDGPipeline/OgnOnFrame is a trigger of the graph .* `usdsdg generate FILE` runs"
    if capture == "step":
        with pytest.warns(UsdsdgWarning, match=message):
            rep.orchestrator.step()
    else:
        with pytest.warns(UsdsdgWarning, match=message), pytest.raises(OrchestratorError, match="nothing ends the run"):
            rep.orchestrator.run()


def test_triggers_that_run_are_not_warned_of(stage, recwarn):
    with rep.trigger.on_frame(), rep.create.cube():
        rep.modify.pose(position=rep.distribution.uniform((1, 1, 1), (2, 2, 2)))
    rep.modify.visibility(rep.distribution.choice([True]), input_prims=rep.create.cone())
    rep.orchestrator.step()
    assert not [each for each in recwarn if "saved with" in str(each.message)]


def test_an_edited_trigger_is_checked(stage, tmp_path):
    rep.trigger.on_frame(interval=2)
    stage.GetPrimAtPath("/Replicator/SDGPipeline/OgnOnFrame").GetAttribute("inputs:interval").Set(0)
    with pytest.raises(GraphError, match="interval is 0"):
        saved_graph.load(stage)

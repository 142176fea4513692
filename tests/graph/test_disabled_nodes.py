"""Nodes that a script disables do not run until it enables them again."""

import pytest

import usdsdg as rep
from tests.capture.part_runs import differences, run, run_parts
from usdsdg.orchestrator import OrchestratorError


def moved(kind="position", **trigger):
    """A cube that goes on by one at each firing; return its item, the trigger, the node, and what reads it."""
    cube = rep.create.cube(position=(0, 0, 0), scale=1)
    with rep.trigger.on_frame(**trigger) as fired, cube:
        node = rep.modify.pose(**{kind: rep.distribution.sequence([(i, i, i) for i in range(1, 9)])}).node
    prim = cube.get_output_prims()["prims"][0]
    op = {"position": "xformOp:translate", "scale": "xformOp:scale"}[kind]
    return fired.node, node, lambda: prim.GetAttribute(op).Get()[0]


def stepped(read):
    rep.orchestrator.step()
    return read()


@pytest.mark.parametrize("which", [0, 1])
def test_a_disabled_node_does_not_run(stage, which):
    *nodes, read = moved()
    other = moved("scale")[2]
    assert [stepped(read), stepped(read)] == [1, 2]
    nodes[which].set_disabled(True)
    assert nodes[which].is_disabled()
    assert not nodes[1 - which].is_disabled()
    assert [stepped(read), stepped(read)] == [2, 2]
    assert other() == 4
    nodes[which].set_disabled(False)
    assert stepped(read) == 3


def test_events_and_what_runs_once_do_not_run_disabled_nodes(stage):
    cube = rep.create.cube()
    with rep.trigger.on_custom_event("go") as trigger, cube:
        rep.modify.pose(position=(5, 0, 0))
    with cube:
        once = rep.modify.pose(position=rep.distribution.uniform((7, 7, 7), (8, 8, 8)))
    trigger.node.set_disabled(True)
    once.node.set_disabled(True)
    rep.utils.send_og_event("go")
    rep.orchestrator.step()
    assert not (cube.get_output_prims()["prims"][0].GetAttribute("xformOp:translate").Get() or (0,))[0]


def test_a_run_that_waits_for_a_disabled_trigger_is_an_error(stage):
    trigger, *_ = moved(max_execs=3)
    trigger.set_disabled(True)
    with pytest.raises(OrchestratorError, match=r"OgnOnFrame .* is disabled"):
        rep.orchestrator.run()


@pytest.mark.parametrize("which", [0, 1])
def test_frames_made_in_parts_leave_out_disabled_nodes(which, tmp_path):
    def write(folder):
        moved("scale")
        moved()[which].set_disabled(True)
        writer = rep.writers.get("BasicWriter")
        writer.initialize(output_dir=str(folder / "out"), bounding_box_3d=True)
        rep.modify.semantics([("class", "cube")], input_prims=rep.get.mesh())
        camera = rep.create.camera(position=(40, 0, 0), look_at=(0, 0, 0))
        writer.attach(rep.create.render_product(camera, (16, 12)))
        rep.orchestrator.run_until_complete(num_frames=6)

    run(write, tmp_path / "whole")
    run_parts(write, tmp_path / "parts", "0:2", "2:5", "5:")
    assert differences(tmp_path / "parts", tmp_path / "whole") == []

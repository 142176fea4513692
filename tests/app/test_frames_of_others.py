"""Frames of other processes are passed over where nothing depends on them, and evaluated where something does."""

from pathlib import Path

import pytest

import usdsdg as rep
from tests.capture.part_runs import differences, run, run_again, run_parts
from usdsdg.app import frames_of_others
from usdsdg.capture.tap import Tap
from usdsdg.graph import evaluate
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.writers.journal.portion import Portion

FRAMES = 12
uniform, choice = rep.distribution.uniform, rep.distribution.choice


def shapes():
    return rep.create.cube(count=3, semantics=[("class", "cube")])


def moved():
    """Poses, colors, visibility that is rarely drawn, and a camera that looks at a prim which moves."""
    cubes, ball = shapes(), rep.create.sphere(semantics=[("class", "ball")])
    camera = rep.create.camera(position=(8, 0, 3))
    with rep.trigger.on_frame():
        with cubes:
            rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 1)), rotation=uniform((0, 0, 0), (360, 360, 360)))
            rep.randomizer.color(colors=uniform((0, 0, 0), (1, 1, 1)))
            rep.modify.visibility(choice([True, False], weights=[0.8, 0.2]))
        with ball:
            rep.modify.pose(position=choice([(0, 0, 0), (0, 1, 0), (0, 0, 1)]), scale=uniform(0.5, 1.0))
        with camera:
            rep.modify.pose(position=uniform((7, -1, 2), (9, 1, 4)), look_at=ball)
    return camera


def at_intervals():
    """Two triggers with intervals, of prims of their own, and one that fires only for a while."""
    cubes, ball, cone = shapes(), rep.create.sphere(semantics=[("class", "ball")]), rep.create.cone()
    for interval, limit, group in ((1, 0, cubes), (5, 0, ball), (2, 3, cone)):
        with rep.trigger.on_frame(interval=interval, max_execs=limit), group:
            rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 1)))
    return rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))


def one_axis():
    """A height alone: the rest of the position is read."""
    camera = rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))
    with rep.trigger.on_frame(), shapes():
        rep.modify.pose(position_z=uniform(-1, 1))
    return camera


def scattered():
    """Positions on a floor, at random alone."""
    floor, cubes = rep.create.plane(scale=4), shapes()
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(rotation=uniform((0, 0, 0), (360, 360, 360)))
        rep.randomizer.scatter_2d(floor)
    with rep.trigger.on_frame(), rep.create.cone():
        rep.randomizer.scatter_3d(min_samp=(-1, -1, 0), max_samp=(1, 1, 2))
    return rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))


def scattered_apart():
    """A randomizer that looks at what is on the stage."""
    floor = rep.create.plane(scale=4)
    with rep.trigger.on_frame(), shapes():
        rep.randomizer.scatter_2d(floor, check_for_collisions=True)
    return rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))


def two_triggers_of_one_prim():
    """The last one of two triggers decides."""
    cubes = shapes()
    for interval in (2, 3):
        with rep.trigger.on_frame(interval=interval), cubes:
            rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 1)))
    return rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))


def falling():
    """A body, which the timeline moves."""
    rep.create.plane(scale=10)
    cubes = shapes()
    with cubes:
        rep.physics.rigid_body()
    with rep.trigger.on_frame(), rep.create.sphere():
        rep.modify.pose(position=uniform((-2, -2, 1), (2, 2, 3)))
    return rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0))


def script(scene, **run_options):
    def write(folder: Path) -> None:
        writer = rep.writers.get("BasicWriter")
        writer.initialize(output_dir=str(folder / "out"), bounding_box_3d=True, semantic_segmentation=True)
        writer.attach(rep.create.render_product(scene(), (32, 24)))
        rep.orchestrator.run_until_complete(**{"num_frames": FRAMES, **run_options})

    return write


@pytest.fixture
def executed(monkeypatch):
    """Executions of nodes."""
    found = []

    def noted(node):
        found.append(node)
        run_node(node)

    run_node = evaluate.run
    monkeypatch.setattr(evaluate, "run", noted)
    monkeypatch.setattr(frames_of_others, "run", noted)
    return found


@pytest.mark.parametrize("scene", [moved, at_intervals, scattered])
@pytest.mark.parametrize("portions", [("0:1", "1:5", "5:6", "6:"), ("2/3", "0/3", "1/3")])
def test_frames_of_others_are_passed_over(scene, portions, tmp_path, executed):
    run(script(scene), tmp_path / "whole")
    evaluated = len(executed)
    executed.clear()
    run_parts(script(scene), tmp_path / "parts", *portions)
    assert differences(tmp_path / "parts", tmp_path / "whole") == []
    # Each process evaluates its own frames, the first one, and the last one, which the stage shows afterward.
    assert len(executed) < 0.9 * evaluated * len(portions)


@pytest.mark.parametrize("scene", [one_axis, scattered_apart, two_triggers_of_one_prim, falling])
def test_frames_on_which_others_depend_are_evaluated(scene, tmp_path, executed):
    run(script(scene), tmp_path / "whole")
    evaluated = len(executed)
    executed.clear()
    run_parts(script(scene), tmp_path / "parts", "0:2", "2:9", "9:")
    assert differences(tmp_path / "parts", tmp_path / "whole") == []
    assert len(executed) == 3 * evaluated


def test_a_run_that_goes_on_passes_over_what_is_there(tmp_path, executed):
    run(script(moved), tmp_path / "whole")
    executed.clear()
    run_again(script(moved), tmp_path / "again", tmp_path / "whole", FRAMES - 2)
    assert differences(tmp_path / "again", tmp_path / "whole") == []
    nodes = len(set(executed))
    assert len(executed) <= nodes * 5


def test_a_run_that_triggers_end_passes_over_its_frames(tmp_path, executed):
    def scene():
        camera, cubes = rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0)), shapes()
        with rep.trigger.on_frame(max_execs=FRAMES), cubes:
            rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 1)))
        return camera

    run(script(scene, num_frames=None), tmp_path / "whole")
    executed.clear()
    run_parts(script(scene, num_frames=None), tmp_path / "parts", "0:4", "4:")
    assert differences(tmp_path / "parts", tmp_path / "whole") == []
    assert len(executed) < 2 * FRAMES


@pytest.mark.parametrize("between", [lambda: None, rep.orchestrator.stop, rep.orchestrator.step])
def test_a_second_run_is_counted_and_made_in_parts_as_it_is_made_whole(between, tmp_path):
    """The first frame of a run starts it, whoever makes it: until then, all counts are those of the one before."""

    def scene():
        camera, cubes = rep.create.camera(position=(8, 0, 3), look_at=(0, 0, 0)), shapes()
        with rep.trigger.on_frame(max_execs=4), cubes:
            rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 1)))
        return camera

    counts = []

    def write(folder):
        current().run.counts_only = folder.name == "counted"
        script(scene, num_frames=None)(folder)
        between()
        rep.orchestrator.run_until_complete()
        counts.append(current().run.captures)

    run(write, tmp_path / "whole")
    run(write, tmp_path / "counted")
    assert counts[0] == counts[1]
    run_parts(write, tmp_path / "parts", "0:5", "5:")
    assert differences(tmp_path / "parts", tmp_path / "whole") == []


def test_the_stage_shows_the_last_frame_after_a_run(tmp_path):
    shown = []

    def write(folder):
        script(moved)(folder)
        cube = current_stage().GetPrimAtPath("/Replicator/Cube_Xform")
        shown.append(str(cube.GetAttribute("xformOp:translate").Get()))

    run(write, tmp_path / "whole")
    run(write, tmp_path / "part", Portion.of_frames("0:2"))
    assert shown[0] == shown[1]


def test_a_listener_of_frames_sees_all_of_them(tmp_path):
    seen = []

    def write(folder):
        rep.orchestrator.get_orchestrator().on_captured(lambda: seen.append(1))
        script(moved)(folder)

    run(write, tmp_path / "part", Portion.of_frames("8:9"))
    assert len(seen) == FRAMES


def test_a_stream_passes_over_frames_that_are_not_wanted(stage, executed):
    received = []
    product = rep.create.render_product(moved(), (32, 24))
    assert product
    current().tap = Tap(["distance_to_camera"], lambda frame: frame == 9, received.append)
    rep.orchestrator.run_until_complete(num_frames=FRAMES)
    nodes = len(set(executed))
    assert [view.frame for view in received] == [9]
    assert len(executed) <= 4 * nodes

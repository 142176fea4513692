"""Models of BopWriter have the same numbers whichever process makes which frames."""

import json

import numpy as np
import pytest
import trimesh
from pxr import Gf, UsdGeom

import usdsdg as rep
from tests.capture.part_runs import differences, run, run_parts
from usdsdg.app import frames_of_others
from usdsdg.graph import evaluate
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.semantics.labels import add_labels

FRAMES = 6
uniform = rep.distribution.uniform


def box(path: str) -> UsdGeom.Cube:
    shape = UsdGeom.Cube.Define(current_stage(), path)
    shape.CreateSizeAttr(1.0)
    add_labels(shape.GetPrim(), {"class": ["box"]})
    return shape


def scaled():
    cubes = rep.create.cube(count=2, semantics=[("class", "box")])
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 1)), scale=uniform((0.2, 0.2, 0.2), (1, 1, 1)))


def turned_below_a_stretch():
    above = UsdGeom.Xform.Define(current_stage(), "/World/Above")
    above.AddScaleOp().Set((1.0, 0.5, 0.5))
    box("/World/Above/Box")
    prims = rep.get.prims(path_pattern="/World/Above/Box$")
    with rep.trigger.on_frame(), prims:
        rep.modify.pose(rotation=uniform((0, 0, 0), (360, 360, 360)))


def with_a_part_that_moves():
    add_labels(UsdGeom.Xform.Define(current_stage(), "/World/Car").GetPrim(), {"class": ["car"]})
    for name in ("Body", "Door"):
        UsdGeom.Cube.Define(current_stage(), f"/World/Car/{name}").CreateSizeAttr(0.5)
    prims = rep.get.prims(path_pattern="/World/Car/Door$")
    with rep.trigger.on_frame(), prims:
        rep.modify.pose(position=uniform((-1, -1, -1), (1, 1, 1)))


def shown_now_and_then():
    for number in range(6):
        box(f"/World/Box_{number}").AddScaleOp().Set((1.0, 0.2 * (number + 1), 1.0))
    for number in range(6):
        prims = rep.get.prims(path_pattern=f"/World/Box_{number}$")
        with rep.trigger.on_frame(), prims:
            rep.modify.visibility(rep.distribution.choice([True, False], weights=[0.2, 0.8]))


def scaled_by_samples():
    for name, speed in (("A", 1), ("B", 2)):
        scale = box(f"/World/{name}").AddScaleOp()
        for code in range(2 * FRAMES):
            scale.Set(Gf.Vec3f(1.0 + 0.1 * (code // (2 * speed)), 1.0, 0.5 if name == "A" else 1.0), float(code))
    get_timeline().play()


def drawn_by_samples():
    """Points of a PointInstancer that come up and shrink, and a prim that samples show late."""
    stage = current_stage()
    box("/World/Bush/Box")
    points = UsdGeom.PointInstancer.Define(stage, "/World/Bush")
    points.CreatePrototypesRel().SetTargets(["/World/Bush/Box"])
    for code in range(2 * FRAMES):
        count = 1 + code // 4
        points.CreateProtoIndicesAttr().Set([0] * count, float(code))
        points.CreatePositionsAttr().Set([(number - 1.0, 0, 0) for number in range(count)], float(code))
        heights = [0.9 - 0.05 * code - 0.2 * number for number in range(count)]
        points.CreateScalesAttr().Set([(0.9, 0.9, each) for each in heights], float(code))
    late = box("/World/Late")
    late.AddScaleOp().Set((0.3, 0.4, 0.5))
    late.CreateVisibilityAttr("invisible")
    for code, shown in ((0, "invisible"), (7, "inherited")):
        late.GetVisibilityAttr().Set(shown, float(code))
    get_timeline().play()


def writes(scene):
    def script(folder):
        current_stage().SetTimeCodesPerSecond(24)
        scene()
        camera = rep.create.camera(position=(9, 0, 3), look_at=(0, 0, 0))
        writer = rep.writers.get("BopWriter")
        writer.initialize(output_dir=str(folder / "out"))
        writer.attach(rep.create.render_product(camera, (48, 32)))
        if get_timeline().is_playing():
            for _ in range(FRAMES):
                rep.orchestrator.step(delta_time=2 / 24)
        else:
            rep.orchestrator.run_until_complete(num_frames=FRAMES)

    return script


def sizes_of_models(folder):
    """The sizes of the models of all objects, frame by frame, as the files tell."""
    poses = json.loads((folder / "out/train_pbr/000000/scene_gt.json").read_text())
    known = {path.stem: trimesh.load(path).extents for path in (folder / "out/models").glob("*.ply")}
    return [[np.round(known[f"obj_{each['obj_id']:06d}"], 1).tolist() for each in frame] for frame in poses.values()]


@pytest.mark.parametrize(
    "scene",
    [scaled, turned_below_a_stretch, with_a_part_that_moves, shown_now_and_then, scaled_by_samples, drawn_by_samples],
)
def test_parts_have_the_models_of_the_whole(scene, tmp_path):
    run(writes(scene), tmp_path / "whole")
    assert len(list((tmp_path / "whole/out/models").glob("*.ply"))) > 2
    run_parts(writes(scene), tmp_path / "shards", "1/2", "0/2")
    assert sizes_of_models(tmp_path / "shards") == sizes_of_models(tmp_path / "whole")
    assert differences(tmp_path / "shards", tmp_path / "whole") == []


def test_models_have_the_scale_of_their_frame(tmp_path):
    run_parts(writes(scaled_by_samples), tmp_path, "3:", "0:3")
    scales = [[1.0 + 0.1 * frame, 1.0 + 0.1 * (frame // 2)] for frame in range(FRAMES)]
    expected = [[[1000 * a, 1000, 500], [1000 * b, 1000, 1000]] for a, b in scales]
    assert sizes_of_models(tmp_path) == [[pytest.approx(size) for size in frame] for frame in expected]


def moved():
    cubes = rep.create.cube(count=2, semantics=[("class", "box")], scale=(1, 0.5, 1))
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 1)), rotation=uniform((0, 0, 0), (360, 360, 360)))


def test_frames_of_others_are_passed_over_where_shapes_stay(tmp_path, monkeypatch):
    executed, run_node = [], evaluate.run
    for module in (evaluate, frames_of_others):
        monkeypatch.setattr(module, "run", lambda node: (executed.append(node), run_node(node)))
    run(writes(moved), tmp_path / "whole")
    evaluated = len(executed)
    executed.clear()
    run_parts(writes(moved), tmp_path / "parts", "0:2", "2:4", "4:")
    assert differences(tmp_path / "parts", tmp_path / "whole") == []
    assert len(executed) < 3 * evaluated

"""Projections follow what moves their projector or targets between two firings, as physics and scripts do."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import usdsdg as rep
from usdsdg.app import saved_graph
from usdsdg.session.stage_context import current_stage, open_stage

PANEL, PROXY = "/Replicator/panel_Xform", "/Replicator/proxy_Xform"


@pytest.fixture
def defect(stage):
    panel = rep.create.cube(scale=2, name="panel", semantics=[("class", "panel")])
    proxy = rep.create.cube(position=(1, 0, 0), scale=0.5, visible=False, name="proxy")
    rep.create.projection_material(proxy, semantics=[("class", "defect")], name="defect", input_prims=panel)
    rep.annotators.get("distance_to_camera").attach(rep.create.render_product(rep.create.camera(), (8, 8)))


def place(path, position):
    current_stage().GetPrimAtPath(path).GetAttribute("xformOp:translate").Set(position)


def center():
    (prim,) = current_stage().GetPrimAtPath("/Replicator/defect_Xform").GetChildren()[:1]
    points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get() or np.zeros((0, 3)))
    matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    return ((points.min(0) + points.max(0)) / 2 @ matrix[:3, :3] + matrix[3, :3]).tolist()


@pytest.mark.usefixtures("defect")
def test_what_a_script_moves_between_frames_is_followed():
    rep.orchestrator.step()
    assert center() == pytest.approx([1, 0, 0], abs=0.02)
    place(PROXY, (1, 0.4, -0.3))
    rep.orchestrator.step()
    assert center() == pytest.approx([1, 0.4, -0.3], abs=0.02)
    place(PANEL, (-0.2, 0, 0))
    rep.orchestrator.step()
    assert center() == pytest.approx([0.8, 0.4, -0.3], abs=0.02)


@pytest.mark.usefixtures("defect")
def test_projections_of_which_nothing_moved_are_not_computed_again():
    rep.orchestrator.step()
    (prim,) = current_stage().GetPrimAtPath("/Replicator/defect_Xform").GetChildren()[:1]
    UsdGeom.Mesh(prim).GetPointsAttr().Set([(7, 7, 7)] * 3)
    rep.orchestrator.step()
    assert center() == pytest.approx([7, 7, 7])


@pytest.mark.usefixtures("defect")
def test_projections_without_their_projector_stay(stage):
    rep.orchestrator.step()
    stage.RemovePrim(PROXY)
    rep.orchestrator.step()
    assert center() == pytest.approx([1, 0, 0], abs=0.02)


@pytest.mark.usefixtures("defect")
def test_those_of_a_stage_that_was_saved_are_followed_too(stage, tmp_path):
    rep.trigger.on_frame()
    stage.Export(str(tmp_path / "saved.usda"))
    open_stage(str(tmp_path / "saved.usda"))
    saved_graph.load(current_stage())
    rep.annotators.get("distance_to_camera").attach(
        rep.create.render_product("/Replicator/Camera_Xform/Camera", (8, 8))
    )
    place(PROXY, (1, 0.4, 0))
    rep.orchestrator.step()
    assert center() == pytest.approx([1, 0.4, 0], abs=0.02)

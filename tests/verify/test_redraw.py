"""`usdsdg verify --render`: faults above the record, which files and record agree about, are found."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
from click.testing import CliRunner
from pxr import Sdf, UsdGeom, UsdShade

import usdsdg as rep
from tests.sampled_cases import sampled
from tests.verify import datasets, faults_above
from usdsdg.annotators.ownership import LabeledStage
from usdsdg.capture import subsets
from usdsdg.cli.app import app
from usdsdg.datasets.folder import Folder
from usdsdg.session import session
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry.face_parts import read_face_parts
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.verify import redraw, verify
from usdsdg.verify.recorded_assets import RecordedAssets


@pytest.fixture(autouse=True)
def restarted():
    yield
    session.restart()


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    return datasets.make(tmp_path_factory.mktemp("rendered"), ("basic_ids", "pose"), frames=3)


@pytest.mark.parametrize("name", ["basic_ids", "pose"])
def test_frames_render_again_as_they_were(clean, name):
    report = verify(clean / name, render=3)
    assert report.faults == []
    assert report.notes == []
    assert report.rendered == 3


@pytest.mark.parametrize("kind", sampled(faults_above.KINDS, 4), ids=lambda kind: kind.name)
def test_a_fault_above_the_record_is_found(tmp_path, kind):
    with faults_above.patched(kind):
        folder = datasets.make(tmp_path, ("basic",), frames=4, edit=kind.edit) / "basic"
    assert any(fault.file.startswith(".usdsdg/frames") for fault in verify(folder, render=4).faults)


def divide(frame: int) -> None:
    """Put a board before the things, of which each face is a subset: one labeled, one not, one of no subset."""
    if frame > 0:
        return
    get_settings().set("/syntheticdata/sensors/perSubsetSegmentation", True)
    mesh = UsdGeom.Mesh.Define(current_stage(), "/World/Board")
    mesh.CreatePointsAttr([(x, -2, z) for z in (0, 1) for x in (-1.5, -0.5, 0.5, 1.5)])
    mesh.CreateFaceVertexCountsAttr([4, 4, 4])
    mesh.CreateFaceVertexIndicesAttr([k + d for k in range(3) for d in (0, 1, 5, 4)])
    mesh.CreateSubdivisionSchemeAttr("none")
    add_labels(mesh.GetPrim(), {"class": ["box"]})
    for name, face in (("Door", 0), ("Window", 2)):
        subset = UsdGeom.Subset.Define(current_stage(), f"/World/Board/{name}")
        subset.CreateElementTypeAttr("face")
        subset.CreateIndicesAttr([face])
    add_labels(current_stage().GetPrimAtPath("/World/Board/Door"), {"class": ["lid"]})


def test_frames_with_labels_of_subsets_render_again_as_they_were(tmp_path):
    folder = datasets.make(tmp_path, ("basic_ids",), frames=2, edit=divide) / "basic_ids"
    report = verify(folder, render=2)
    assert report.faults == []
    assert report.rendered == 2


def test_faces_that_showed_another_subset_are_found(tmp_path, monkeypatch):
    def swapped(mesh, time):
        parts, of_face = read_face_parts(mesh, time)
        return parts, np.array([1, -1, 0], np.int32) if len(parts) == 2 else of_face

    with monkeypatch.context() as patch:
        patch.setattr(subsets, "read_face_parts", swapped)
        folder = datasets.make(tmp_path, ("basic_ids",), frames=2, edit=divide) / "basic_ids"
    found = [fault.what for fault in verify(folder, render=2).faults]
    assert any("show another gprim" in what for what in found)


def test_labels_of_subsets_that_are_others_on_the_stage_are_found(tmp_path, monkeypatch):
    original = LabeledStage._own_labels

    def own(self, owner):
        return {} if owner.path.name == "Door" else original(self, owner)

    with monkeypatch.context() as patch:
        patch.setattr(LabeledStage, "_own_labels", own)
        folder = datasets.make(tmp_path, ("basic_ids",), frames=2, edit=divide) / "basic_ids"
    found = [fault.what for fault in verify(folder, render=2).faults]
    assert "/World/Board/Door belongs to" in found


def repaint(frame: int) -> None:
    """Give one thing a labeled paint, then a labeled glaze, which at last is invisible."""
    stage, paths = current_stage(), ("/World/Looks/Paint", "/World/Looks/Glaze")
    if frame == 0:
        for path in paths:
            material = UsdShade.Material.Define(stage, path)
            shader = UsdShade.Shader.Define(stage, f"{path}/Shader")
            shader.CreateIdAttr("UsdPreviewSurface")
            shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(1.0)
            shader.CreateInput("opacityThreshold", Sdf.ValueTypeNames.Float).Set(0.5)
            material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
            add_labels(material.GetPrim(), {"finish": [material.GetPrim().GetName()]})
    if frame < 2:
        body = stage.GetPrimAtPath("/World/Thing_0/Body")
        UsdShade.MaterialBindingAPI.Apply(body).Bind(UsdShade.Material.Get(stage, paths[frame]))
    else:
        stage.GetAttributeAtPath(f"{paths[1]}/Shader.inputs:opacity").Set(0.0)


def test_frames_whose_materials_change_render_again_as_they_were(tmp_path):
    folder = datasets.make(tmp_path, ("basic_ids",), frames=3, edit=repaint) / "basic_ids"
    report = verify(folder, render=3)
    assert report.faults == []
    assert report.rendered == 3
    finishes = [
        labels.get("finish")
        for record in Folder(folder).records
        for selection in record.products[0].selections.values()
        for labels in map(dict, selection.labels)
    ]
    assert {"paint", "glaze"} <= set(finishes)


def test_labels_of_materials_that_are_others_on_the_stage_are_found(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(LabeledStage, "_materials", lambda self, gprims: {})
        folder = datasets.make(tmp_path, ("basic_ids",), frames=1, edit=repaint) / "basic_ids"
    found = [(fault.what, fault.expected) for fault in verify(folder, render=1).faults]
    assert any("paint" in str(expected) or "Body" in str(expected) for _, expected in found)


def test_frames_are_chosen_by_number(clean):
    done = CliRunner().invoke(app, ["verify", str(clean / "pose"), "--frames", "0,2"])
    assert done.exit_code == 0
    assert "2 rendered again" in done.output
    assert "expected" not in done.output
    wrong = CliRunner().invoke(app, ["verify", str(clean / "pose"), "--frames", "first"])
    assert wrong.exit_code == 1


def test_a_dataset_without_its_stage_says_so(clean, tmp_path):
    folder = shutil.copytree(clean / "pose", tmp_path / "pose")
    shutil.rmtree(folder / ".usdsdg" / "stages")
    report = verify(folder, render=3)
    assert report.rendered == 0
    assert any("is missing" in fault.what and "stages" in fault.file for fault in report.faults)


def test_frames_that_are_not_recorded_are_an_error(clean):
    done = CliRunner().invoke(app, ["verify", str(clean / "pose"), "--render", "--frames", "1,99"])
    assert done.exit_code == 1
    assert f"error: --frames: {clean / 'pose'} does not have frame 99; it has 3 frames, from 0 to 2" in done.output


@pytest.mark.parametrize("writer_name", ["BopWriter", "VocWriter", "YoloWriter"])
def test_labels_of_a_type_in_upper_case_are_those_of_the_stage(stage, tmp_path, writer_name):
    add_labels(UsdGeom.Cube.Define(stage, "/World/Cup").GetPrim(), {"class": ["cup"], "Material": ["Steel"]})
    camera = rep.create.camera(position=(0, -8, 3), look_at=(0, 0, 0))
    writer = rep.writers.get(writer_name)
    writer.initialize(output_dir=str(tmp_path), semantic_filter_predicate="Material: Steel")
    writer.attach(rep.create.render_product(camera, (64, 48)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    (table,) = json.loads((tmp_path / ".usdsdg/classes.json").read_text())["tables"]
    assert [each["labels"] for each in table["classes"]] == [{"Material": "steel"}]
    assert [str(each) for each in verify(tmp_path, render=1).faults] == []


def share(frame: int) -> None:
    """Put an instance before the things, and edit what instances share in later frames."""
    stage = current_stage()
    if frame == 0:
        cup = UsdGeom.Cube.Define(stage, "/Asset/Cup")
        cup.CreateSizeAttr(0.4)
        add_labels(cup.GetPrim(), {"class": ["cup"]})
        copy = stage.DefinePrim("/World/Copy", "Xform")
        copy.GetReferences().AddInternalReference("/Asset")
        copy.SetInstanceable(True)
        UsdGeom.Xformable(copy).AddTranslateOp().Set((0, -1, 1))
        return
    stage.GetPrimAtPath("/Asset/Cup").GetAttribute("size").Set(0.4 + 0.1 * frame)


def test_what_instances_share_is_recorded_where_it_stands(tmp_path):
    """Records had overs of the instances' prototype too, with which USD crashed when it opened the stage."""
    folder = datasets.make(tmp_path, ("basic_ids",), frames=3, edit=share) / "basic_ids"
    edits = [record.edits.decode() for record in Folder(folder).records]
    assert "Cup" in edits[1]
    assert not any("__Prototype" in each for each in edits)
    report = verify(folder, render=3)
    assert (report.faults, report.notes, report.rendered) == ([], [], 3)


def test_records_with_edits_of_prototypes_are_rendered_again_without_these(clean, tmp_path):
    data = Folder(clean / "basic_ids")
    edits = b'#usda 1.0\nover "__Prototype_1"\n{\n    over "Cup"\n    {\n        double size = 3\n    }\n}\n'
    record = dataclasses.replace(data.records[0], edits=edits)
    stage = redraw._stage(data, record, tmp_path, RecordedAssets(data.path))
    names = [prim.name for layer in stage.GetLayerStack() for prim in layer.rootPrims]
    assert "World" in names
    assert not any(name.startswith("__Prototype") for name in names)

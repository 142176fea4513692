"""Amodal annotators and the setting for glass, through real captures."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.errors import UsdsdgWarning
from usdsdg.session.settings.store import get_settings
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.semantics.labels import add_labels


def cube(stage, path, label, position, scale):
    prim = UsdGeom.Cube.Define(stage, path)
    prim.CreateSizeAttr(1.0)
    prim.AddTranslateOp().Set(Gf.Vec3d(*position))
    prim.AddScaleOp().Set(Gf.Vec3f(*scale))
    if label:
        add_labels(prim.GetPrim(), {"class": [label]})
    return prim.GetPrim()


@pytest.fixture
def annotators(stage):
    """A labeled box behind a labeled pane of glass, half hidden by an unlabeled wall in front of both."""
    UsdGeom.SetStageUpAxis(stage, "Z")
    cube(stage, "/World/Box", "box", (0, 0, 0), (1, 1, 1))
    pane = cube(stage, "/World/Pane", "pane", (0, -2, 0), (3, 0.05, 3))
    cube(stage, "/World/Wall", None, (-2.0, -3, 0), (4, 0.1, 4))
    glass = UsdShade.Material.Define(stage, "/World/Glass")
    shader = UsdShade.Shader.Define(stage, "/World/Glass/Shader")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.2)
    glass.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(pane).Bind(glass)
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTransformOp().Set(look_at_matrix((0, -12, 0), (0, 0, 0), up=(0, 0, 1)))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, 100.0))
    product = rep.create.render_product("/World/Camera", (100, 70))
    names = ["visibility", "occlusion", "instance_segmentation", "amodal_instance_segmentation"]
    yield {name: rep.annotators.get(name).attach(product) for name in names}
    get_settings().set("/usdsdg/labels/glass", "surface")


def visibility(annotators) -> dict:
    """Prim → (visible pixels, amodal pixels, {prim: pixels that it occludes})."""
    data = annotators["visibility"].get_data()
    names = data["info"]["idToLabels"]
    return {
        path: (row["visiblePixels"], row["amodalPixels"], {names[other]: n for other, n in hidden_by.items()})
        for path, row, hidden_by in zip(data["info"]["primPaths"], data["data"], data["info"]["hiddenBy"])
    }


def test_a_pane_hides_what_is_behind_it_unless_labels_look_through_glass(annotators):
    rep.orchestrator.step()
    seen, alone, hidden_by = visibility(annotators)["/World/Box"]
    assert seen == 0
    assert alone > 50
    assert set(hidden_by) == {"/World/Pane", "UNLABELLED"}
    assert sum(hidden_by.values()) == alone
    get_settings().set("/usdsdg/labels/glass", "behind")
    rep.orchestrator.step()
    through = visibility(annotators)
    # With glass_labels "behind", labels ignore the glass.
    assert set(through) == {"/World/Box"}
    assert through["/World/Box"][1:] == (alone, {"UNLABELLED": hidden_by["UNLABELLED"]})
    assert through["/World/Box"][0] == alone - hidden_by["UNLABELLED"]
    assert set(annotators["instance_segmentation"].get_data()["info"]["idToLabels"].values()) == {
        "BACKGROUND", "UNLABELLED", "/World/Box"
    }  # fmt: skip
    (row,) = [row for row in annotators["occlusion"].get_data() if row["occlusionRatio"] >= 0]  # nan out of view
    assert row["occlusionRatio"] == pytest.approx(hidden_by["UNLABELLED"] / alone)
    masks = annotators["amodal_instance_segmentation"].get_data()["data"]
    assert masks.shape == (1, 70, 100)
    assert masks.sum() == alone


def test_an_unknown_glass_setting_warns(annotators):
    get_settings().set("/usdsdg/labels/glass", "through")
    with pytest.warns(UsdsdgWarning, match="/usdsdg/labels/glass 'through' is not known"):
        rep.orchestrator.step()
    assert "/World/Pane" in visibility(annotators)


def test_aovs_of_the_renderer_become_annotators(annotators):
    registry = rep.AnnotatorRegistry
    registry.register_annotator_from_aov("prim", name="face")
    try:
        face = registry.get_annotator("face").attach(annotators["visibility"].render_product)
        rep.orchestrator.step()
        data = face.get_data()
        # Of the cube drawn for the gprim, one of six faces; nothing is -1.
        assert data.dtype == np.int32
        assert set(np.unique(data)) <= set(range(-1, 6))
        assert (data == -1).any()
        assert (data >= 0).any()
    finally:
        registry.unregister_annotator("face")

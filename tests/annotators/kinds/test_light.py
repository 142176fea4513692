"""Annotators of the light by where it came from, in types and shapes of Replicator, and the openness of surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.session.settings import store as settings
from usdsdg.session.stage_context import current_stage, new_stage

SIZE = (40, 30)


@pytest.fixture
def lit_ball(monkeypatch):
    """Data of annotators of a ball on a floor under a sky: (names) → {name: array}."""
    monkeypatch.setattr(settings.get_settings(), "_values", dict(settings.DEFAULTS))
    new_stage()
    rep.create.light(light_type="dome", intensity=800)
    rep.create.plane(scale=20)
    rep.create.sphere(position=(0, 0, 0.5))
    camera = rep.create.camera(position=(0, -4, 3), look_at=(0, 0, 0.4))
    product = rep.create.render_product(camera, SIZE)
    rep.settings.set_render_pathtraced(16)
    rep.settings.carb_settings("/rtx/pathtracing/optixDenoiser/enabled", False)

    def data(*names: str) -> dict[str, np.ndarray]:
        found = {name: rep.annotators.get(name) for name in names}
        for annotator in found.values():
            annotator.attach(product)
        rep.orchestrator.step()
        return {name: annotator.get_data() for name, annotator in found.items()}

    return data


def test_parts_of_the_light_make_up_the_picture(lit_ball):
    halves = ["PtDirectIllumation", "PtGlobalIllumination", "PtReflections", "PtRefractions", "PtVolumes"]
    others = ["DirectDiffuse", "DirectSpecular", "IndirectDiffuse", "Reflections", "HdrColor"]
    data = lit_ball(*halves, *others)
    for name in halves:
        assert (data[name].shape, data[name].dtype) == ((30, 40, 4), np.float16)
        assert (data[name][..., 3] == 1).all()
    assert data["Reflections"].dtype == np.float32
    total = sum(data[name].astype(np.float32) for name in halves)
    np.testing.assert_allclose(total[..., :3], data["HdrColor"][..., :3], rtol=0.01, atol=0.5)
    direct = data["DirectDiffuse"].astype(np.float32) + data["DirectSpecular"]
    np.testing.assert_allclose(data["PtDirectIllumation"][..., :3], direct[..., :3], rtol=2e-3)
    np.testing.assert_array_equal(data["IndirectDiffuse"], data["PtGlobalIllumination"])
    assert data["DirectDiffuse"][..., :3].min() > 0
    assert not data["PtRefractions"][..., :3].any()
    assert not data["PtVolumes"][..., :3].any()


def test_ambient_occlusion_darkens_where_things_meet(lit_ball):
    openness = lit_ball("AmbientOcclusion")["AmbientOcclusion"]
    assert (openness.shape, openness.dtype) == ((30, 40, 4), np.float16)
    assert (openness[..., 0] == openness[..., 2]).all()
    assert openness[0, 0, 0] == 1  # the open floor, far from the ball
    assert openness.min() < 0.6


def test_half_of_the_hemisphere_is_left_at_the_foot_of_a_wall(lit_ball):
    rep.create.cube(position=(0, 0, 5), scale=(10, 1, 10))
    camera = rep.create.camera(position=(0, -3, 1.0), look_at=(0, -0.5005, 0.0))
    product = rep.create.render_product(camera, (1, 1))
    openness = rep.annotators.get("AmbientOcclusion")
    openness.attach(product)
    rep.orchestrator.step()
    np.testing.assert_allclose(openness.get_data()[0, 0, 0], 0.5, atol=0.05)


def test_the_refraction_filter_is_the_color_of_glass(lit_ball):
    stage = current_stage()
    glass = UsdShade.Material.Define(stage, "/World/Glass")
    shader = UsdShade.Shader.Define(stage, "/World/Glass/Shader")
    shader.SetSourceAsset("OmniGlass.mdl", "mdl")
    shader.SetSourceAssetSubIdentifier("OmniGlass", "mdl")
    shader.CreateInput("glass_color", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.25, 0.5, 1))
    glass.CreateSurfaceOutput("mdl").ConnectToSource(shader.ConnectableAPI(), "out")
    (ball,) = (prim for prim in stage.Traverse() if prim.GetName().startswith("Sphere") and prim.IsA(UsdGeom.Gprim))
    UsdShade.MaterialBindingAPI.Apply(ball).Bind(glass)
    data = lit_ball("PtRefractionFilter", "PtRefractions")
    ball = data["PtRefractionFilter"][..., 2] > 0
    assert 20 < ball.sum() < 400
    np.testing.assert_array_equal(data["PtRefractionFilter"][ball][:, :3], np.float16([[0.25, 0.5, 1]] * ball.sum()))
    color = data["PtRefractions"][..., :3].astype(np.float32)
    assert color[ball].mean() > 10 * color[~ball].mean()

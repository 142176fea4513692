"""Every material model of a stage in a white world of one nit: what absorbs nothing is as bright as the world."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade

from tests.render import scenes
from tests.render.images import EXACT
from tests.render.materials.test_materials import Looks, Mdl, material_x
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings

WHITE = Gf.Vec3f(1.0)
GRAY = Gf.Vec3f(0.5)
KINDS = {
    bool: Sdf.ValueTypeNames.Bool,
    int: Sdf.ValueTypeNames.Int,
    float: Sdf.ValueTypeNames.Float,
    str: Sdf.ValueTypeNames.Token,
}


def authored(model: str, inputs: dict) -> Looks:
    if model == "UsdPreviewSurface":
        looks = Looks()
    elif model in ("standard_surface", "open_pbr_surface"):
        looks = material_x(model)
    else:
        looks = Mdl(model)
    for name, value in inputs.items():
        looks.set(name, KINDS.get(type(value), Sdf.ValueTypeNames.Color3f), value)
    return looks


def furnace(model: str, inputs: dict, *, samples=256) -> np.ndarray:
    """(12, 12, 3) radiance of a ball of the material that fills the image."""
    looks = authored(model, inputs)
    ball = UsdGeom.Sphere.Define(looks.stage, "/Ball")
    UsdShade.MaterialBindingAPI.Apply(ball.GetPrim()).Bind(looks.material)
    UsdLux.DomeLight.Define(looks.stage, "/Sky").CreateIntensityAttr(1.0)
    renderer = WarpRenderer(looks.stage, device="cpu")
    renderer.sync()
    film = renderer.new_film(12, 12)
    view = scenes.view_from((0, -6, 0), size=(12, 12), focal_length=110.0)
    settings = PathSettings(bounces=12, glass_bounces=24, denoise=False, **EXACT)
    renderer.accumulate(film, view, samples=samples, settings=settings)
    assert film.dropped == 0
    return film.radiance()


PREVIEW, PBR, SURFACE, GLTF = "UsdPreviewSurface", "OmniPBR", "OmniSurface", "gltf_material"
WHITE_METAL = dict(useSpecularWorkflow=1, diffuseColor=Gf.Vec3f(0.0), specularColor=WHITE)
LOSSLESS = {
    "preview": (PREVIEW, dict(diffuseColor=WHITE)),
    "preview, no index": (PREVIEW, dict(diffuseColor=WHITE, ior=1.0)),
    "preview, metal": (PREVIEW, dict(diffuseColor=WHITE, metallic=1.0, roughness=0.3)),
    "preview, half metal": (PREVIEW, dict(diffuseColor=WHITE, metallic=0.5, roughness=0.7)),
    "preview, specular workflow": (
        PREVIEW,
        dict(useSpecularWorkflow=1, diffuseColor=WHITE, specularColor=Gf.Vec3f(0.3), roughness=0.4),
    ),
    "preview, specular workflow alone": (PREVIEW, {**WHITE_METAL, "roughness": 0.6}),
    "preview, coat": (PREVIEW, dict(diffuseColor=WHITE, clearcoat=1.0, clearcoatRoughness=0.3)),
    "preview, coat on metal": (PREVIEW, dict(diffuseColor=WHITE, metallic=1.0, clearcoat=0.5)),
    "preview, pane": (PREVIEW, dict(diffuseColor=WHITE, opacity=0.3)),
    "preview, presence": (PREVIEW, dict(diffuseColor=WHITE, opacity=0.3, opacityMode="presence")),
    "preview, cut out": (PREVIEW, dict(diffuseColor=WHITE, opacity=0.3, opacityThreshold=0.5)),
    "OmniPBR": (PBR, dict(diffuse_color_constant=WHITE)),
    "OmniPBR, metal": (PBR, dict(diffuse_color_constant=WHITE, metallic_constant=1.0)),
    "OmniPBR, opacity": (PBR, dict(diffuse_color_constant=WHITE, enable_opacity=True, opacity_constant=0.4)),
    "OmniPBR_ClearCoat": ("OmniPBR_ClearCoat", dict(diffuse_color_constant=WHITE, enable_clearcoat=True)),
    "OmniPBR_Opacity": ("OmniPBR_Opacity", dict(diffuse_color_constant=WHITE, opacity_constant=0.4)),
    "OmniGlass": ("OmniGlass", {}),
    "OmniGlass, thin": ("OmniGlass", dict(thin_walled=True, glass_ior=1.8)),
    "OmniGlass, frosted": ("OmniGlass", dict(frosting_roughness=0.2)),
    "OmniSurface": (SURFACE, dict(diffuse_reflection_weight=1.0)),
    "OmniSurface, metal": (SURFACE, dict(diffuse_reflection_weight=1.0, metalness=1.0)),
    "OmniSurface, coat": (SURFACE, dict(diffuse_reflection_weight=1.0, coat_weight=1.0, coat_roughness=0.2)),
    "OmniSurface, skin": (
        SURFACE,
        dict(enable_diffuse_transmission=True, subsurface_weight=1.0, diffuse_reflection_weight=1.0),
    ),
    "OmniSurface, glass": (SURFACE, dict(enable_specular_transmission=True, specular_transmission_weight=1.0)),
    "gltf": (GLTF, dict(metallic_factor=0.0, roughness_factor=0.5)),
    "gltf, metal": (GLTF, {}),
    "gltf, glass": (GLTF, dict(metallic_factor=0.0, roughness_factor=0.0, transmission_factor=1.0)),
    "gltf, coat": (GLTF, dict(metallic_factor=0.0, clearcoat_factor=1.0, clearcoat_roughness_factor=0.3)),
    "standard surface": ("standard_surface", dict(base_color=WHITE)),
    "standard surface, coat": ("standard_surface", dict(base_color=WHITE, coat=1.0)),
    "standard surface, skin": ("standard_surface", dict(base_color=WHITE, subsurface=0.5)),
    "OpenPBR": ("open_pbr_surface", dict(base_color=WHITE)),
    "OpenPBR, metal": ("open_pbr_surface", dict(base_color=WHITE, base_metalness=1.0)),
    "OpenPBR, glass": ("open_pbr_surface", dict(transmission_weight=1.0, specular_roughness=0.0)),
}


@pytest.mark.parametrize("case", LOSSLESS)
def test_what_absorbs_nothing_vanishes(case):
    image = furnace(*LOSSLESS[case])
    # The balance of energy comes from a table; of a rough pane, facets hide some of the light that they mirror.
    least = 0.96 if case == "preview, pane" else 0.99
    assert least < image.mean() < 1.005
    assert image.max() < 1.05


# Lambert's surface alone: no other layer is there, so that its color is all there is.
DIFFUSE = {
    "preview": (PREVIEW, dict(diffuseColor=GRAY, ior=1.0)),
    "preview, specular workflow": (PREVIEW, dict(useSpecularWorkflow=1, diffuseColor=GRAY)),
    "OmniPBR": (PBR, dict(diffuse_color_constant=GRAY, specular_level=0.0)),
    "OmniSurface": (SURFACE, dict(diffuse_reflection_weight=0.5, specular_reflection_weight=0.0)),
    "gltf": (GLTF, dict(base_color_factor=GRAY, metallic_factor=0.0, specular_factor=0.0)),
    "standard surface": ("standard_surface", dict(base_color=GRAY, specular=0.0)),
    "OpenPBR": ("open_pbr_surface", dict(base_color=GRAY, specular_weight=0.0)),
}


@pytest.mark.parametrize("case", DIFFUSE)
def test_a_diffuse_gray_ball_is_as_bright_as_its_color(case):
    image = furnace(*DIFFUSE[case], samples=64)
    np.testing.assert_allclose(image.mean((0, 1)), 0.5, rtol=0.005)

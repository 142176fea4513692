"""Metals and coats against what their models say, and rough metals against light that walks from facet to facet."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Sdf

from tests.render import scenes
from tests.render.materials.test_materials import Looks, Mdl, material_x
from tests.render.materials.test_scattering import hemisphere, scattered
from tests.sampled_cases import crossed

COPPER = (0.9, 0.6, 0.3)


def albedo(material: np.ndarray, cosine: float) -> np.ndarray:
    """(3,) share of a white world that a surface seen at an angle sends back."""
    directions, solid_angle = hemisphere(700)
    found = scattered(material, np.array([np.sqrt(1 - cosine**2), 0.0, cosine]), directions)
    return (found.diffuse + found.specular).sum(0) * solid_angle


class Facets:
    """A surface of GGX facets with Smith's shadowing, as a medium that light walks through until it leaves.

    Source: Heitz et al., "Multiple-Scattering Microfacet BSDFs with the Smith Model" (SIGGRAPH 2016).
    """

    def __init__(self, roughness: float) -> None:
        self.alpha = roughness**2
        self.rng = np.random.default_rng(7)

    def bounces(self, cosine: float, walks: int = 100_000) -> np.ndarray:
        """Share of walks that leave after 0, 1, 2, … facets."""
        toward = np.tile([-np.sqrt(1 - cosine**2), 0.0, -cosine], (walks, 1))
        below = np.ones(walks)  # share of the facets that lie lower than the light is
        met = np.zeros(walks, int)
        inside = np.arange(walks)
        while len(inside):
            way, up = toward[inside], toward[inside, 2] > 0
            slope = self._slope(way)
            number = self.rng.random(len(inside))
            with np.errstate(over="ignore", divide="ignore"):
                height = below[inside] * (1 - number) ** (-1 / slope)
            stays = ~up | (height < 1)
            inside, way = inside[stays], way[stays]
            below[inside] = np.clip(height[stays], 1e-12, 1)
            facet = self._visible(-way)
            toward[inside] = way - 2 * (way * facet).sum(1, keepdims=True) * facet
            met[inside] += 1
            inside = inside[met[inside] < 60]
        return np.bincount(met) / walks

    def _slope(self, way: np.ndarray) -> np.ndarray:
        """Smith's lambda, negative downward."""
        squared = (1 - way[:, 2] ** 2) / np.maximum(way[:, 2] ** 2, 1e-12)
        root = np.sqrt(1 + self.alpha**2 * squared)
        return np.where(way[:, 2] > 0, root - 1, -root - 1) / 2

    def _visible(self, seen_from: np.ndarray) -> np.ndarray:
        """Facets as they are seen, drawn by spherical caps."""
        stretched = seen_from * [self.alpha, self.alpha, 1]
        stretched /= np.linalg.norm(stretched, axis=1, keepdims=True)
        turn, share = self.rng.random((2, len(seen_from)))
        z = (1 - share) * (1 + stretched[:, 2]) - stretched[:, 2]
        s = np.sqrt(np.clip(1 - z * z, 0, 1))
        h = np.stack([s * np.cos(2 * np.pi * turn), s * np.sin(2 * np.pi * turn), z], -1) + stretched
        h = np.stack([self.alpha * h[:, 0], self.alpha * h[:, 1], np.maximum(h[:, 2], 0)], -1)
        return h / np.linalg.norm(h, axis=1, keepdims=True)


@pytest.mark.parametrize(("cosine", "roughness"), crossed([0.2, 0.5, 0.95], [0.4, 0.7, 1.0]))
def test_rough_metals_send_back_what_walks_from_facet_to_facet_bring(roughness, cosine):
    shares = Facets(roughness).bounces(cosine)
    walked = [(shares * color ** np.arange(len(shares))).sum() for color in COPPER]
    found = albedo(scenes.material(base_color=COPPER, metallic=1.0, roughness=roughness), cosine)
    # 1 % of the formula, 1 % of the table, and the walks' noise.
    np.testing.assert_allclose(found, walked, rtol=0.025)


@pytest.mark.parametrize("cosine", [0.2, 0.5, 1.0])
def test_a_smooth_metal_has_its_color_at_every_angle(cosine):
    """UsdPreviewSurface: reflectance at normal and at grazing incidence is the albedo."""
    found = albedo(scenes.material(base_color=COPPER, metallic=1.0, roughness=0.2), cosine)
    np.testing.assert_allclose(found, COPPER, rtol=0.02)


def test_a_metal_may_be_white_at_grazing_angles():
    """By Schlick's formula, as in glTF: F0 + (1 - F0) (1 - cos)^5, at a roughness that blurs it little."""
    cosine = 0.2
    material = scenes.material(base_color=COPPER, metallic=1.0, roughness=0.15, metal_f90=1.0)
    expected = np.array(COPPER) + (1 - np.array(COPPER)) * (1 - cosine) ** 5
    np.testing.assert_allclose(albedo(material, cosine), expected, rtol=0.03)


@pytest.mark.parametrize("f0", [0.0, 0.005, 0.04])
def test_dark_specular_colors_reflect_little_at_grazing_angles(f0):
    """Schlick's formula with the F90 that docs/materials.md states: 50 times F0, at most 1."""
    cosine = 0.2
    material = scenes.material(base_color=0.0, specular=f0, roughness=0.15)
    expected = f0 + (min(1.0, 50 * f0) - f0) * (1 - cosine) ** 5
    np.testing.assert_allclose(albedo(material, cosine), expected, rtol=0.05, atol=1e-6)  # the lobe blurs it


@pytest.mark.parametrize("ior", [1.3, 1.5, 2.0])
def test_a_coat_reflects_by_its_index(ior):
    f0 = ((ior - 1) / (ior + 1)) ** 2
    material = scenes.material(
        base_color=0.0, specular=0.0, coat_f0=f0, clearcoat=1.0, clearcoat_roughness=0.3, roughness=1.0
    )
    np.testing.assert_allclose(albedo(material, 1.0), f0, rtol=0.02)


def test_models_say_what_metals_reflect_at_grazing_angles():
    """UsdPreviewSurface and OmniPBR: their color; glTF, MaterialX and OmniSurface: everything."""
    models_of = {
        0.0: (Looks(), Mdl("OmniPBR"), Mdl("OmniPBR_ClearCoat")),
        1.0: (Mdl("OmniSurface"), Mdl("gltf_material"), material_x("standard_surface"), material_x("open_pbr_surface")),
    }
    for metal_f90, models in models_of.items():
        assert [model.row()[0]["metal_f90"] for model in models] == [metal_f90] * len(models)


@pytest.mark.parametrize(
    ("model", "name", "default"),
    [
        (Looks, "ior", 1.5),
        (lambda: Mdl("OmniPBR_ClearCoat"), "clearcoat_ior", 1.56),
        (lambda: Mdl("OmniSurface"), "coat_ior", 1.5),
        (lambda: material_x("standard_surface"), "coat_IOR", 1.5),
        (lambda: material_x("open_pbr_surface"), "coat_ior", 1.6),
    ],
)
def test_coats_have_the_index_of_their_model(model, name, default):
    looks = model()
    assert looks.row()[0]["coat_f0"] == pytest.approx(((default - 1) / (default + 1)) ** 2)
    looks.set(name, Sdf.ValueTypeNames.Float, 2.0)
    assert looks.row()[0]["coat_f0"] == pytest.approx(1 / 9)

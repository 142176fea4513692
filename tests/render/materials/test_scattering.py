"""The scattering function itself, asked direction by direction: reciprocity, energy, and the density of its samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
import warp as wp

from tests.render import scenes
from tests.sampled_cases import crossed
from usdsdg_render.device.albedo_table import albedo_table
from usdsdg_render.kernels.bsdf.bsdf import evaluate_bsdf, make_bsdf, sample_bsdf
from usdsdg_render.kernels.scene.surface import Surface
from usdsdg_render.scene import structs


@wp.func
def flat(material: structs.Material, up: wp.vec3):
    surface = Surface()
    surface.normal = up
    surface.horizon_normal = up
    surface.base = material.base_color
    surface.metallic = material.metallic
    surface.roughness = material.roughness
    surface.specular = material.specular
    surface.clearcoat = material.clearcoat
    surface.clearcoat_roughness = material.clearcoat_roughness
    return surface


@wp.kernel(enable_backward=False)
def scatter_between(
    table: wp.array(dtype=wp.vec2),
    materials: wp.array(dtype=structs.Material),
    seen_from: wp.array(dtype=wp.vec3),
    lit_from: wp.array(dtype=wp.vec3),
    # out
    diffuse: wp.array(dtype=wp.vec3),
    specular: wp.array(dtype=wp.vec3),
    scale: wp.array(dtype=wp.vec3),
    density: wp.array(dtype=wp.float32),
):
    k = wp.tid()
    material = materials[0]
    up = wp.vec3(0.0, 0.0, 1.0)
    b = make_bsdf(table, flat(material, up), material, 1.0, up, seen_from[k], 0.0)
    out = evaluate_bsdf(b, lit_from[k])
    diffuse[k] = out.diffuse
    specular[k] = out.specular
    scale[k] = b.specular_scale
    density[k] = out.pdf


@wp.kernel(enable_backward=False)
def draw_directions(
    table: wp.array(dtype=wp.vec2),
    materials: wp.array(dtype=structs.Material),
    seen_from: wp.vec3,
    numbers: wp.array(dtype=wp.vec2),
    # out
    directions: wp.array(dtype=wp.vec3),
):
    k = wp.tid()
    material = materials[0]
    up = wp.vec3(0.0, 0.0, 1.0)
    directions[k] = sample_bsdf(make_bsdf(table, flat(material, up), material, 1.0, up, seen_from, 0.0), numbers[k])


class BsdfValue(NamedTuple):
    """f * cosine of each pair of directions, by lobe; the scale of the glossy one; the density [1/sr]."""

    diffuse: np.ndarray
    specular: np.ndarray
    scale: np.ndarray
    density: np.ndarray


def on_device(material: np.ndarray) -> list[wp.array]:
    row = np.zeros(1, structs.Material.numpy_dtype())
    for name in row.dtype.names or ():
        row[name] = material[name]
    table = wp.array(albedo_table().reshape(-1, 2), dtype=wp.vec2, device="cpu")
    return [table, wp.array(row, dtype=structs.Material, device="cpu")]


def vectors(values) -> wp.array:
    return wp.array(np.ascontiguousarray(values, np.float32), dtype=wp.vec3, device="cpu")


def scattered(material: np.ndarray, seen_from, lit_from) -> BsdfValue:
    seen_from, lit_from = np.broadcast_arrays(seen_from, lit_from)
    out = [wp.zeros(len(lit_from), dtype=kind, device="cpu") for kind in (wp.vec3, wp.vec3, wp.vec3, wp.float32)]
    inputs = [*on_device(material), vectors(seen_from), vectors(lit_from)]
    wp.launch(scatter_between, dim=len(lit_from), inputs=inputs, outputs=out, device="cpu")
    return BsdfValue(*(each.numpy().astype(np.float64) for each in out))


def hemisphere(count: int) -> tuple[np.ndarray, float]:
    """(N, 3) directions of cells of equal solid angle, and that."""
    up, turn = np.meshgrid((np.arange(count) + 0.5) / count, (np.arange(2 * count) + 0.5) * np.pi / count)
    out = np.sqrt(1 - up**2)
    directions = np.stack([out * np.cos(turn), out * np.sin(turn), up], -1).reshape(-1, 3)
    return directions, 2 * np.pi / len(directions)


MATERIALS = {
    "diffuse": dict(base_color=(0.2, 0.5, 0.9), specular=0.0),
    "plastic": dict(base_color=(0.2, 0.5, 0.9), specular=0.04, roughness=0.4),
    "shiny plastic": dict(base_color=0.9, specular=0.1, roughness=0.25),
    "rough metal": dict(base_color=(1.0, 0.7, 0.3), metallic=1.0, roughness=1.0),
    "metal": dict(base_color=(1.0, 0.7, 0.3), metallic=1.0, roughness=0.4),
    "half metal": dict(base_color=0.8, metallic=0.5, roughness=0.6),
    "coated": dict(base_color=0.7, roughness=0.8, clearcoat=1.0, clearcoat_roughness=0.3),
    "coated metal": dict(base_color=0.9, metallic=1.0, roughness=0.7, clearcoat=0.6, clearcoat_roughness=0.5),
}


def pairs(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, 4000, 3))
    for each in (a, b):
        each[:, 2] = np.abs(each[:, 2]) + 0.05
        each /= np.linalg.norm(each, axis=1, keepdims=True)
    return a, b


@pytest.mark.parametrize("name", MATERIALS)
def test_facets_scatter_as_much_there_as_back(name):
    """Helmholtz reciprocity of the glossy lobe; what balances its energy depends on the viewer alone: taken out."""
    material = scenes.material(**{**MATERIALS[name], "clearcoat": 0.0})
    a, b = pairs(1)
    there, back = scattered(material, a, b), scattered(material, b, a)
    lobe_there = there.specular / there.scale / b[:, 2:]
    lobe_back = back.specular / back.scale / a[:, 2:]
    np.testing.assert_allclose(lobe_there, lobe_back, rtol=2e-3, atol=1e-6)


def test_diffuse_surfaces_are_reciprocal_as_they_are():
    a, b = pairs(2)
    material = scenes.material(**MATERIALS["diffuse"])
    there, back = scattered(material, a, b), scattered(material, b, a)
    np.testing.assert_allclose(there.diffuse / b[:, 2:], back.diffuse / a[:, 2:], rtol=1e-5)


@pytest.mark.parametrize(
    ("name", "typical", "worst"),
    [("plastic", 0.03, 0.15), ("metal", 0.02, 0.12), ("coated", 0.05, 0.25), ("rough metal", 0.2, 0.7)],
)
def test_the_whole_is_reciprocal_to_a_known_bound(name, typical, worst):
    """The balance of energy costs reciprocity: |there - back| over their mean, away from grazing angles."""
    a, b = pairs(3)
    steep = (a[:, 2] > 0.3) & (b[:, 2] > 0.3)
    material = scenes.material(**MATERIALS[name])
    there, back = scattered(material, a[steep], b[steep]), scattered(material, b[steep], a[steep])
    f_there = (there.diffuse + there.specular) / b[steep, 2:]
    f_back = (back.diffuse + back.specular) / a[steep, 2:]
    off = np.abs(f_there - f_back) / (0.5 * (f_there + f_back))
    assert np.median(off) < typical
    assert off.max() < worst


@pytest.mark.parametrize(("cosine", "name"), crossed([0.1, 0.3, 0.7, 1.0], MATERIALS))
def test_no_surface_gives_more_than_it_gets(name, cosine):
    """All directions together: the energy that leaves is at most what came, and directions are drawn by the density."""
    material = scenes.material(**MATERIALS[name])
    seen_from = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    directions, solid_angle = hemisphere(700)
    found = scattered(material, seen_from, directions)
    total = (found.diffuse + found.specular).sum(0) * solid_angle
    assert (found.diffuse >= 0).all()
    assert (found.specular >= 0).all()
    # The balance comes from a table that is right to 3 % at its worst.
    assert total.max() < 1.03
    # Facets may mirror below the horizon; nothing else is missing.
    drawn = found.density.sum() * solid_angle
    assert drawn < 1.005
    numbers = np.random.default_rng(4).random((200000, 2)).astype(np.float32)
    out = wp.zeros(len(numbers), dtype=wp.vec3, device="cpu")
    inputs = [*on_device(material), wp.vec3(*seen_from), wp.array(numbers, dtype=wp.vec2, device="cpu")]
    wp.launch(draw_directions, dim=len(numbers), inputs=inputs, outputs=[out], device="cpu")
    up = out.numpy()[:, 2]
    assert (up > 0).mean() == pytest.approx(drawn, abs=0.01)
    # In rings of equal solid angle as many as the density says.
    rings = np.histogram(up, 20, (0, 1))[0] / len(up)
    by_density = np.histogram(directions[:, 2], 20, (0, 1), weights=found.density)[0] * solid_angle
    np.testing.assert_allclose(rings, by_density, atol=0.006)

"""Lenses of direction textures against the formula of the textures, and textures that are invalid."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom

import usdsdg.session.stage_context  # noqa: F401  registers the schemas
from tests.stage.cameras.lens_cases import CASES, mei_directions, write_directions
from usdsdg.errors import AssetError, AssetNotFound, AssetUnreadable, Unsupported, UsdsdgWarning
from usdsdg.image_files import exr
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.cameras.lens_attributes import LensParameters
from usdsdg.stage.cameras.lens_tables import LensTable, from_octahedral, to_octahedral

SIZE = (960, 600)


def view(**lens) -> CameraView:
    values = {"nominal_size": (960.0, 600.0), "center": (480.0, 300.0), **lens}
    return CameraView("/cam", *SIZE, np.eye(4), projection_type="generalizedProjection",
                      lens_parameters=LensParameters(**values))  # fmt: skip


def mei_fractions(points: np.ndarray) -> np.ndarray:
    """Project points by Mei's unified model to fractions of the image: the unit sphere, seen from 1.3 behind it."""
    x, y, z = (points / np.linalg.norm(points, axis=1, keepdims=True) * (1.0, -1.0, -1.0)).T
    return np.stack([0.42 * x / (z + 1.3) + 0.47, 0.68 * y / (z + 1.3) + 0.52], axis=1)


def points_before(count: int = 3000) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(count, 3)) * 2.0 - (0.0, 0.0, 2.0)


@pytest.mark.parametrize(("texels", "tolerance"), [((480, 300), 0.05), ((960, 600), 0.02), ((171, 1200), 0.3)])
def test_points_are_projected_as_by_the_formula_for_any_size_of_texture(tmp_path, texels, tolerance):
    camera = view(direction_texture=write_directions(tmp_path / "d.exr", texels))
    pixels, _ = camera.project(points_before())
    seen = np.isfinite(pixels).all(axis=1)
    assert 0.3 < seen.mean() < 0.95
    error = np.linalg.norm(pixels[seen] - mei_fractions(points_before()[seen]) * SIZE, axis=1)
    # Directions are interpolated linearly between texels.
    assert np.quantile(error, 0.99) < tolerance


def test_the_middle_of_the_texture_is_at_the_optical_center(tmp_path):
    file = write_directions(tmp_path / "d.exr", (480, 300))
    shifted = view(direction_texture=file, nominal_size=(1920.0, 1200.0), center=(980.0, 570.0))
    points = points_before()
    a, b = view(direction_texture=file).project(points)[0], shifted.project(points)[0]
    seen = np.isfinite(a).all(axis=1)
    np.testing.assert_allclose(b[seen], a[seen] + (10.0, -15.0), atol=1e-9)
    # The part of the image outside of the texture is dark.
    _, directions = shifted.rays(np.array([(9.0, 300.0), (480.0, 590.0), (480.0, 300.0)]))
    assert np.isfinite(directions).all(axis=1).tolist() == [False, False, True]


def test_dark_texels_transmit_no_light(tmp_path):
    image = mei_directions(np.stack(np.meshgrid(*((np.arange(n) + 0.5) / n for n in (60, 40))), -1).reshape(-1, 2))
    image = image.reshape(40, 60, 3).astype(np.float32)
    image[20, 30], image[20, 35], image[25, 30] = (0, 0, 1), np.nan, 0.0
    (tmp_path / "d.exr").write_bytes(exr.encode(image))
    with pytest.warns(UsdsdgWarning, match=r"d\.exr: 1 texel is NaN.*column 35 of row 20"):
        lens = view(direction_texture=str(tmp_path / "d.exr")).lens
    assert lens is not None
    texels = np.array([(30, 20), (35, 20), (30, 25), (32, 20), (30.5, 20), (29, 19)])
    directions = lens.to_directions((texels + 0.5) * (16, 15))
    lit = np.isfinite(directions).all(axis=1)
    assert lit.tolist() == [False, False, False, True, False, True]
    np.testing.assert_allclose(directions[3], image[20, 32], atol=1e-6)


@pytest.mark.parametrize("pole", [1.0, -1.0])
def test_positions_that_contradict_the_directions_are_named_in_a_warning(tmp_path, pole):
    directions = write_directions(tmp_path / "d.exr", (480, 300))
    centers = (np.arange(512) + 0.5) / 256 - 1
    rays = from_octahedral(np.stack(np.meshgrid(centers, centers), -1).reshape(-1, 2)) * (1.0, 1.0, pole)
    positions = mei_fractions(rays).reshape(512, 512, 2).astype(np.float32)
    (tmp_path / "p.exr").write_bytes(exr.encode(positions))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert view(direction_texture=directions, position_texture=str(tmp_path / "p.exr")).lens is not None
    (tmp_path / "q.exr").write_bytes(exr.encode(positions[:, ::-1]))
    with pytest.warns(UsdsdgWarning, match=r"q\.exr is not the inverse of .*d\.exr"):
        _ = view(direction_texture=directions, position_texture=str(tmp_path / "q.exr")).lens


def test_octahedral_coordinates_are_undone():
    directions = np.random.default_rng(1).normal(size=(1000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    np.testing.assert_allclose(from_octahedral(to_octahedral(directions)), directions, atol=1e-12)
    assert to_octahedral(np.array([(0.0, 0.0, -1.0)])).tolist() == [[0.0, 0.0]]


def image_file(folder: Path, image: np.ndarray, *, half: bool = False) -> str:
    (folder / "t.exr").write_bytes(exr.encode(image.astype(np.float32), half=half))
    return str(folder / "t.exr")


def test_invalid_textures_are_refused(tmp_path):
    ahead = np.tile((0.0, 0.0, -1.0), (4, 4, 1))
    Image.new("RGB", (4, 4)).save(tmp_path / "t.png")
    (tmp_path / "broken.exr").write_bytes(exr.encode(ahead.astype(np.float32))[:200])
    cases: list[tuple[str, type[Exception], str]] = [
        ("", AssetNotFound, "/cam: a generalized projection needs the texture.*generalizedProjectionDirectionTexture"),
        (str(tmp_path / "t.ex"), AssetNotFound, r"/cam: no file for .*t\.ex"),
        (str(tmp_path / "t.png"), Unsupported, r"/cam: .*t\.png is not an OpenEXR file"),
        (str(tmp_path / "broken.exr"), AssetUnreadable, r"/cam: .*broken\.exr is not an EXR file, or it is damaged"),
    ]
    for file, kind, message in cases:
        with pytest.raises(kind, match=message):
            _ = view(direction_texture=file).lens
    for image, message in (
        (ahead[:1], "4 x 1 texels of 3 numbers; a lens needs 3 numbers and 2 x 2 texels"),
        (ahead[..., :1], "4 x 4 texels of 1 numbers"),
        (ahead * 0, r"holds no directions: its texels are all zero, NaN or \(0, 0, 1\)"),
        (ahead * 0.5 + 0.5, "holds no directions: its texels are of length 0.707"),
    ):
        with pytest.raises((AssetError, Unsupported), match=message):
            _ = view(direction_texture=image_file(tmp_path, image)).lens
    with pytest.warns(UsdsdgWarning, match="16-bit floats"):
        _ = view(direction_texture=image_file(tmp_path, ahead, half=True)).lens


def test_a_changed_texture_is_read_again(tmp_path):
    file = write_directions(tmp_path / "d.exr", (48, 30))
    before = view(direction_texture=file).lens
    assert before is not None
    assert view(direction_texture=file).lens == before
    write_directions(tmp_path / "d.exr", (64, 40))
    after = view(direction_texture=file).lens
    assert after is not None
    assert after.table is not None
    assert after.table.size == (64, 40)


def test_attributes_of_both_generations_name_the_textures_beside_the_stage(tmp_path):
    (tmp_path / "lut").mkdir()
    write_directions(tmp_path / "lut" / "d.exr", (480, 300))
    stage = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    older, newer = (UsdGeom.Camera.Define(stage, f"/{name}").GetPrim() for name in ("older", "newer"))
    for name, kind, value in (
        ("cameraProjectionType", "Token", "generalizedProjection"),
        ("fthetaWidth", "Float", 480.0),
        ("fthetaHeight", "Float", 300.0),
        ("fthetaCx", "Float", 243.0),
        ("fthetaCy", "Float", 149.0),
        ("generalizedProjectionDirectionTexturePath", "Asset", "./lut/d.exr"),
    ):
        older.CreateAttribute(name, getattr(Sdf.ValueTypeNames, kind)).Set(value)
    assert newer.ApplyAPI("OmniLensDistortionLutAPI")
    for name, value in (
        ("nominalWidth", 480.0),
        ("nominalHeight", 300.0),
        ("opticalCenter", Gf.Vec2f(243, 149)),
        ("rayEnterDirectionTexture", "./lut/d.exr"),
    ):
        assert newer.GetAttribute(f"omni:lensdistortion:lut:{name}").Set(value), name
    stage.Save()
    reference = CameraView("/cam", *SIZE, np.eye(4), **CASES["generalizedProjection"]).project(points_before())[0]
    for path in ("/older", "/newer"):
        found = read_camera(stage, path, SIZE)
        assert found.projection_type == "generalizedProjection"
        np.testing.assert_array_equal(found.project(points_before())[0], reference)


def test_few_lit_texels_are_found():
    directions, lit = np.zeros((400, 400, 3)), np.zeros((400, 400), bool)
    lit[200:203, 301:304] = True
    directions[200:203, 301:304] = (0.0, 0.0, -1.0)
    directions[200:203, 301:304, 0] += 0.01 * np.arange(3)
    directions[200:203, 301:304, 1] += 0.01 * np.arange(3)[:, None]
    directions[lit] /= np.linalg.norm(directions[lit], axis=1, keepdims=True)
    table = LensTable.of(directions, lit)
    positions = np.array([(301.0, 200.0), (302.5, 201.3), (303.0, 202.0)])
    np.testing.assert_allclose(table.to_texels(table.to_directions(positions)), positions, atol=1e-6)
    assert np.isnan(table.to_texels(np.array([(0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (np.nan, 0, 0)]))).all()


def test_equal_parameters_give_equal_lenses(tmp_path):
    camera = view(direction_texture=write_directions(tmp_path / "d.exr", (48, 30)))
    assert replace(camera).lens == camera.lens
    assert hash(replace(camera).lens) == hash(camera.lens)

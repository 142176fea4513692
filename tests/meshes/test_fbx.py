"""Looks of FBX files: pictures inside of them and beside them, what their materials connect, colors of points."""

import io

import numpy as np
import pytest
from PIL import Image
from pxr import UsdGeom

from tests.meshes.fbx_files import as_binary, as_text, square
from tests.meshes.test_conversion import meshes, opened, source_of, surface
from usdsdg.meshes.readers.fbx_media import media

pytest.importorskip("assimp_py")

FORMS = {"text": as_text, "7400": lambda nodes: as_binary(nodes, 7400), "7500": lambda nodes: as_binary(nodes, 7500)}
PAINT = {"DiffuseColor": [0.5, 0.25, 0.125], "EmissiveColor": [0.0, 0.0, 0.0]}
COLORS = [1.0, 0.0, 0.0, 1.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.25, 1.0, 1.0, 1.0, 1.0, 1.0]


def png(color, mode="RGB"):
    content = io.BytesIO()
    Image.new(mode, (8, 8), color).save(content, "PNG")
    return content.getvalue()


def picture(stage, name):
    """The first texel of what feeds an input, and the output that does."""
    shader, output = source_of(surface(stage), name)
    with Image.open(shader.GetInput("file").Get().resolvedPath) as image:
        return np.array(image)[0, 0].tolist(), output


def written(form, tmp_path, pictures, **options):
    (tmp_path / "square.fbx").write_bytes(FORMS[form](square(pictures, **options)))
    stage, report, _ = opened(tmp_path / "square.fbx", tmp_path, up_axis="Y")
    return stage, report.notes


@pytest.mark.parametrize("form", FORMS)
def test_pictures_inside_are_read(form, tmp_path):
    pictures = {
        "DiffuseColor": ("wood.png", png((10, 20, 30))),
        "EmissiveColor": ("glow.png", png((40, 50, 60))),
        "NormalMap": ("bumps.png", png((128, 128, 255))),
        "ReflectionFactor": ("metal.png", png(70, "L")),
    }
    stage, notes = written(form, tmp_path, pictures, material=PAINT)
    assert notes == []
    assert picture(stage, "diffuseColor") == ([10, 20, 30], "rgb")
    assert picture(stage, "emissiveColor") == ([40, 50, 60], "rgb")
    assert picture(stage, "normal") == ([128, 128, 255], "rgb")
    color, output = picture(stage, "metallic")
    assert (color[2], output) == (70, "b")
    shader, _ = source_of(surface(stage), "emissiveColor")
    assert not shader.GetInput("scale"), "a picture takes the place of the color that it is connected to"


@pytest.mark.parametrize("form", FORMS)
def test_pictures_beside_are_read_and_one_that_is_missing_is_named(form, tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "wood.png").write_bytes(png((10, 20, 30)))
    pictures = {"DiffuseColor": ("wood.png", None), "EmissiveColor": ("gone.png", None)}
    stage, [note] = written(form, tmp_path, pictures, material=PAINT)
    assert picture(stage, "diffuseColor") == ([10, 20, 30], "rgb")
    assert "gone.png beside square.fbx" in note


@pytest.mark.parametrize("form", FORMS)
def test_a_damaged_picture_inside_is_named(form, tmp_path):
    stage, [note] = written(form, tmp_path, {"DiffuseColor": ("wood.png", png((1, 2, 3))[:40])}, material=PAINT)
    assert "wood.png cannot be read" in note
    np.testing.assert_allclose(surface(stage).GetInput("diffuseColor").Get(), PAINT["DiffuseColor"])


@pytest.mark.parametrize("cut", range(30, 2000, 37))
@pytest.mark.parametrize("form", FORMS)
def test_files_that_are_cut_off_have_no_pictures_but_whole_ones(form, cut):
    content = FORMS[form](square({"DiffuseColor": ("wood.png", png((1, 2, 3)))}, material=PAINT))
    whole = media(content)
    assert set(whole) == {"wood.png"}
    assert all(each == whole["wood.png"] for each in media(content[:-cut]).values())


def test_the_alpha_of_a_picture_is_the_opacity_where_one_is_connected(tmp_path):
    leaf = png((10, 20, 30, 40), "RGBA")
    stage, notes = written("text", tmp_path, {"DiffuseColor": ("leaf.png", leaf)}, material=PAINT)
    assert not surface(stage).GetInput("opacity").HasConnectedSource()
    both = {"DiffuseColor": ("leaf.png", leaf), "TransparentColor": ("leaf.png", leaf)}
    stage, notes = written("text", tmp_path, both, material=PAINT)
    assert notes == []
    assert picture(stage, "opacity") == ([10, 20, 30, 40], "a")
    mask = {"DiffuseColor": ("wood.png", png((1, 2, 3))), "TransparentColor": ("mask.png", png((0, 0, 0, 9), "RGBA"))}
    stage, notes = written("text", tmp_path, mask, material=PAINT)
    assert picture(stage, "opacity") == ([1, 2, 3, 9], "a")


def test_what_is_not_read_is_named(tmp_path):
    gray = png(99, "L")
    pictures = {name: (f"{name}.png", gray) for name in ("TransparentColor", "SpecularColor", "Bump")}
    _, notes = written("text", tmp_path, pictures, material=PAINT)
    assert len(notes) == 2
    assert any("specular and bump of the material Paint" in note for note in notes)
    assert any("opacity of the material Paint has no alpha" in note for note in notes)


@pytest.mark.parametrize("has_material", [False, True])
def test_colors_of_points_show_where_there_is_no_material(has_material, tmp_path):
    stage, notes = written("text", tmp_path, {}, colors=COLORS, material=PAINT if has_material else None)
    [mesh] = meshes(stage)
    colors = UsdGeom.Gprim(mesh).GetDisplayColorAttr().Get()
    if has_material:
        assert not colors
        [note] = notes
        assert "the colors of the points" in note
        np.testing.assert_allclose(surface(stage).GetInput("diffuseColor").Get(), PAINT["DiffuseColor"])
    else:
        assert notes == []
        assert {tuple(color) for color in colors} == {tuple(COLORS[k : k + 3]) for k in range(0, 16, 4)}
        assert not mesh.GetRelationship("material:binding").GetTargets()


@pytest.mark.parametrize("count", [1, 2])
def test_the_tiles_of_a_picture(count, tmp_path):
    """Those of several are not told apart by assimp, so they are named."""
    pictures = {"DiffuseColor": ("wood.png", png((1, 2, 3))), "EmissiveColor": ("glow.png", png((1, 2, 3)))}
    stage, notes = written("text", tmp_path, dict(list(pictures.items())[:count]), material=PAINT, scaling=3.0)
    [mesh] = meshes(stage)
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    assert st.max() == (3.0 if count == 1 else 1.0)
    assert len(notes) == count - 1

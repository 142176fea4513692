"""Looks of OBJ, glTF and PLY files: what the formats' specifications say, on the converted materials."""

import base64
import json
import struct

import numpy as np
import pytest
from PIL import Image
from pxr import Usd, UsdGeom, UsdShade

from tests.meshes.test_conversion import gltf_with, meshes, opened, source_of, surface
from usdsdg.meshes.conversion import Options, convert

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"


def obj_with(library, tmp_path, *, head="mtllib look.mtl\n", face="usemtl a\n" + FACE):
    """Convert a square with a material library; return the stage and the notes."""
    Image.new("RGB", (4, 4), (10, 20, 30)).save(tmp_path / "Wood 1.png")
    Image.new("L", (8, 8), 51).save(tmp_path / "mask.png")
    (tmp_path / "look.mtl").write_text(library)
    (tmp_path / "thing.obj").write_text(head + SQUARE + face)
    stage, report, _ = opened(tmp_path / "thing.obj", tmp_path)
    return stage, report.notes


def value(stage, name):
    return surface(stage).GetInput(name).Get()


def picture(stage, name):
    """The texels of what feeds an input."""
    file = source_of(surface(stage), name)[0].GetInput("file").Get().resolvedPath
    with Image.open(file) as image:
        return np.array(image)


@pytest.mark.parametrize(
    ("lines", "opacity", "told"),
    [("d 0.25", 0.25, 0), ("Tr 0.25", 0.75, 0), ("d 0.5\nTr 0.9", 0.5, 0), ("d -halo 0.5", 0.5, 0), ("Tr 1.0", 1, 1)],
)
def test_opacity_of_mtl(lines, opacity, told, tmp_path):
    stage, notes = obj_with(f"newmtl a\nKd 0.3 0.4 0.5\n{lines}\n", tmp_path)
    assert value(stage, "opacity") == opacity
    np.testing.assert_allclose(value(stage, "diffuseColor"), (0.3, 0.4, 0.5), rtol=1e-6)
    assert len(notes) == told


def test_a_mask_of_mtl_is_the_alpha_of_the_color(tmp_path):
    stage, notes = obj_with("newmtl a\nmap_Kd Wood 1.png\nmap_d mask.png\n", tmp_path)
    assert source_of(surface(stage), "opacity")[1] == "a"
    assert picture(stage, "diffuseColor")[0, 0].tolist() == [10, 20, 30, 51]
    assert notes == []


def see_through(kind, file):
    """Save a red picture whose first texels are transparent: a palette with transparent entries, or one such color."""
    image = Image.new("RGBA", (4, 4), (255, 0, 0, 255))
    image.paste((0, 0, 255, 0), (0, 0, 4, 2))
    if kind == "palette":
        image.quantize(4).save(file)
    else:
        image.convert("RGB").save(file, transparency=(0, 0, 255))


@pytest.mark.parametrize("kind", ["palette", "color"])
def test_transparency_of_pictures_without_a_channel_of_alpha_counts(kind, tmp_path, recwarn):
    """As optimizers of PNG files leave them."""
    look = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": "MASK"}
    file = gltf_with(look, ["leaf.png"], tmp_path)
    see_through(kind, tmp_path / "leaf.png")
    stage, _, _ = opened(file, tmp_path)
    shader, output = source_of(surface(stage), "opacity")
    assert output == "a"
    with Image.open(shader.GetInput("file").Get().resolvedPath) as image:
        assert np.array(image.convert("RGBA"))[[0, 3], 0, 3].tolist() == [0, 255]
    (tmp_path / "obj").mkdir()
    see_through(kind, tmp_path / "obj" / "leaf.png")
    for library in ("map_Kd leaf.png", "map_Kd leaf.png\nmap_d leaf.png"):
        stage, _ = obj_with(f"newmtl a\n{library}\n", tmp_path / "obj")
        assert source_of(surface(stage), "opacity")[1] == "a"
        with Image.open(source_of(surface(stage), "diffuseColor")[0].GetInput("file").Get().resolvedPath) as image:
            assert np.array(image.convert("RGBA"))[[0, 3], 0, 3].tolist() == [0, 255]
    assert not recwarn.list


def test_specular_color_and_glossiness_of_gltf(tmp_path):
    """KHR_materials_pbrSpecularGlossiness: roughness is one minus glossiness, and the metallic look a stand-in."""
    look = {
        "pbrMetallicRoughness": {"metallicFactor": 1.0, "baseColorFactor": [0, 0, 0, 1]},
        "extensions": {
            "KHR_materials_pbrSpecularGlossiness": {
                "diffuseFactor": [0.2, 0.4, 0.6, 1.0], "diffuseTexture": {"index": 0},
                "specularFactor": [0.5, 0.25, 0.125], "glossinessFactor": 0.75,
                "specularGlossinessTexture": {"index": 1},
            }
        },
    }  # fmt: skip
    file = gltf_with(look, ["color.png", "gloss.png"], tmp_path, alpha=102)
    stage, report, _ = opened(file, tmp_path)
    assert value(stage, "useSpecularWorkflow") == 1
    color, specular, rough = (
        source_of(surface(stage), name) for name in ("diffuseColor", "specularColor", "roughness")
    )
    assert [output for _, output in (color, specular, rough)] == ["rgb", "rgb", "a"]
    np.testing.assert_allclose(color[0].GetInput("scale").Get(), (0.2, 0.4, 0.6, 1.0), rtol=1e-6)
    np.testing.assert_allclose(specular[0].GetInput("scale").Get(), (0.5, 0.25, 0.125, 1.0))
    assert specular[0].GetInput("sourceColorSpace").Get() == "sRGB"
    alpha = picture(stage, "roughness")[0, 0, 3] / 255
    scale, bias = (rough[0].GetInput(name).Get()[3] for name in ("scale", "bias"))
    assert scale * alpha + bias == pytest.approx(1.0 - 0.75 * 102 / 255)
    assert report.notes == []
    del look["extensions"]["KHR_materials_pbrSpecularGlossiness"]["specularGlossinessTexture"]
    stage, _, _ = opened(gltf_with(look, ["color.png"], tmp_path), tmp_path)
    np.testing.assert_allclose(value(stage, "specularColor"), (0.5, 0.25, 0.125))
    assert value(stage, "roughness") == 0.25


def test_extensions_of_materials_that_are_not_read_are_named(tmp_path):
    look = {"name": "toon", "extensions": {"VENDOR_toon": {}, "KHR_materials_sheen": {}}}
    _, report, _ = opened(gltf_with(look, [], tmp_path), tmp_path)
    assert report.notes == ["VENDOR_toon, KHR_materials_sheen of the material toon are left out"]


def test_coats_and_indices_of_refraction_of_gltf_are_kept(tmp_path):
    coat = {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25, "clearcoatNormalTexture": {"index": 0}}
    extensions = {"KHR_materials_clearcoat": coat, "KHR_materials_ior": {"ior": 1.33}}
    stage, report, _ = opened(gltf_with({"name": "car", "extensions": extensions}, ["a.png"], tmp_path), tmp_path)
    names = ("clearcoat", "clearcoatRoughness", "ior")
    np.testing.assert_allclose([value(stage, name) for name in names], (0.75, 0.25, 1.33), rtol=1e-6)
    assert report.notes == ["clearcoatNormalTexture of the material car is left out"]


@pytest.mark.parametrize(("alpha_mode", "expected"), [("OPAQUE", 0.25), ("BLEND", 0.125)])
def test_what_shines_through_gltf_is_seen_through_a_clear_pane(alpha_mode, expected, tmp_path):
    look = {
        "name": "glass",
        "alphaMode": alpha_mode,
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.75}},
    }
    stage, report, _ = opened(gltf_with(look, [], tmp_path), tmp_path)
    assert value(stage, "opacity") == expected
    assert report.notes == [
        "what shines through the material glass is drawn as through a clear pane, neither refracted nor tinted"
    ]
    look["extensions"]["KHR_materials_transmission"]["transmissionTexture"] = {"index": 0}
    stage, report, _ = opened(gltf_with(look, ["a.png"], tmp_path), tmp_path)
    assert value(stage, "opacity") == expected * 4
    assert report.notes == ["KHR_materials_transmission of the material glass is left out"]


def test_files_in_one_folder_keep_their_pictures(tmp_path):
    """Their materials, and so the pictures, have the same name."""
    look = {"name": "Material", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    for name, color in (("red", (255, 0, 0)), ("blue", (0, 0, 255))):
        file = gltf_with(look, ["color.png"], tmp_path)
        Image.new("RGB", (4, 4), color).save(tmp_path / "color.png")
        convert(file, tmp_path / f"{name}.usd", Options())
    for name, color in (("red", (255, 0, 0)), ("blue", (0, 0, 255))):
        stage = Usd.Stage.Open(str(tmp_path / f"{name}.usd"))
        assert tuple(picture(stage, "diffuseColor")[0, 0]) == color


def test_glow_metal_and_normals_of_mtl(tmp_path):
    stage, notes = obj_with("newmtl a\nKe 1 2 3\nPm 0.75\nPr 0.25\nnorm Wood 1.png\nmap_Ke mask.png\n", tmp_path)
    assert [value(stage, name) for name in ("metallic", "roughness")] == [0.75, 0.25]
    glow, output = source_of(surface(stage), "emissiveColor")
    assert (glow.GetInput("scale").Get(), output) == ((1, 2, 3, 1), "rgb")
    assert picture(stage, "normal")[0, 0].tolist() == [10, 20, 30]
    assert notes == []


def test_options_of_pictures_are_no_part_of_their_name(tmp_path):
    library = "newmtl a\nmap_Kd -blendu on -s 1 1 1 -o 0 0 Wood 1.png\n"
    stage, notes = obj_with(library, tmp_path)
    assert picture(stage, "diffuseColor")[0, 0].tolist() == [10, 20, 30]
    assert notes == []
    stage, notes = obj_with(library.replace("1 1 1", "2 2"), tmp_path)
    assert picture(stage, "diffuseColor")[0, 0].tolist() == [10, 20, 30]
    assert notes == ["the options -s 2 2 of the picture Wood 1.png are left out"]


def test_names_of_files_in_another_case_are_found(tmp_path):
    stage, notes = obj_with("newmtl a\nmap_Kd textures\\wood 1.PNG\n", tmp_path, head="mtllib LOOK.mtl\n")
    assert picture(stage, "diffuseColor")[0, 0].tolist() == [10, 20, 30]
    assert notes == []


def test_several_libraries_are_read_and_unknown_materials_named(tmp_path):
    (tmp_path / "more.mtl").write_text("newmtl b\nKd 0 1 0\n")
    head = "mtllib look.mtl more.mtl\nmtllib gone.mtl\n"
    face = "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl c\nf 2 3 4\n"
    stage, notes = obj_with("newmtl a\nKd 1 0 0\n", tmp_path, head=head, face=face)
    looks = {prim.GetName() for prim in stage.Traverse() if prim.IsA(UsdShade.Material)}
    assert looks == {"a", "b"}
    assert sorted(notes) == [
        "c is in none of its material files, so it has no look",
        "gone.mtl is missing beside thing.obj, so its part of the look is left out",
    ]


def test_what_is_left_out_of_mtl_is_named(tmp_path):
    _, notes = obj_with("newmtl a\nbump -bm 2 mask.png\nmap_Pr mask.png\n", tmp_path)
    assert notes == ["bump, map_pr of the material a are left out"]


def edited(file, edit):
    model = json.loads(file.read_text())
    edit(model)
    file.write_text(json.dumps(model))
    return file


def with_colors(model, rows, kind):
    """Add COLOR_0 to the square of `gltf_with`."""
    content = np.ascontiguousarray(rows).tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    model["buffers"].append({"byteLength": len(content), "uri": uri})
    model["bufferViews"].append({"buffer": 1, "byteLength": len(content)})
    entry = {
        "bufferView": 3,
        "componentType": kind,
        "count": 4,
        "type": f"VEC{rows.shape[1]}",
        "normalized": kind != 5126,
    }
    model["accessors"].append(entry)
    model["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 3


COLORS = np.array([(1, 0, 0.2, 1), (0, 1, 0.4, 1), (0, 0, 1, 1), (0.6, 0.6, 0.6, 1)])


@pytest.mark.parametrize(
    ("kind", "rows"),
    [
        (5126, COLORS.astype("<f4")),
        (5126, COLORS[:, :3].astype("<f4")),
        (5121, (COLORS * 255).round().astype("u1")),
        (5123, (COLORS * 65535).round().astype("<u2")),
    ],
)
def test_colors_of_points_multiply_the_factor_of_their_material(kind, rows, tmp_path):
    file = gltf_with({"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.0625, 1]}}, [], tmp_path)
    stage, report, _ = opened(edited(file, lambda model: with_colors(model, rows, kind)), tmp_path)
    reader, _ = source_of(surface(stage), "diffuseColor")
    assert reader.GetInput("varname").Get() == "displayColor"
    [mesh] = meshes(stage)
    found = np.array(UsdGeom.Gprim(mesh).GetDisplayColorAttr().Get())
    np.testing.assert_allclose(found, COLORS[:, :3] * (0.5, 0.25, 0.0625), atol=1e-5)
    assert report.notes == []


def srgb(linear):
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("scale", [1.0, 255.0])
@pytest.mark.parametrize("has_uvs", [False, True])
@pytest.mark.parametrize("has_material", [False, True])
def test_colors_of_the_points_of_obj(scale, has_uvs, has_material, tmp_path):
    """Kept beside UVs and materials without a picture, from 0 to 1 or to 255; a point without one is white."""
    linear = np.array([(1, 0, 0.2), (0, 1, 0.4), (0.1, 0.05, 1)])
    places = [line for line in SQUARE.splitlines() if line.startswith("v ")]
    given = [" ".join(map(str, color)) for color in (srgb(linear) * scale).round(8).tolist()]
    points = "".join(f"{place} {color}\n" for place, color in zip(places, [*given, ""]))
    points += "".join(line + "\n" for line in SQUARE.splitlines() if line.startswith("vt") and has_uvs)
    head = "mtllib look.mtl\nusemtl a\n" if has_material else ""
    (tmp_path / "look.mtl").write_text("newmtl a\nKd 0.5 0.25 0.125\n")
    (tmp_path / "thing.obj").write_text(head + points + (FACE if has_uvs else "f 1 2 3 4\n"))
    stage, report, _ = opened(tmp_path / "thing.obj", tmp_path, up_axis="Y")
    [mesh] = meshes(stage)
    found = np.array(UsdGeom.Gprim(mesh).GetDisplayColorAttr().Get())
    places = np.array(UsdGeom.Mesh(mesh).GetPointsAttr().Get())
    order = [[0, 1, 3, 2][int(x + 2 * y)] for x, y, _ in places]
    factor = (0.5, 0.25, 0.125) if has_material else (1, 1, 1)
    np.testing.assert_allclose(found, np.vstack([linear, np.ones(3)])[order] * factor, atol=0.005)
    assert report.notes == []
    if has_material:
        reader, _ = source_of(surface(stage), "diffuseColor")
        assert reader.GetInput("varname").Get() == "displayColor"


def test_colors_of_points_beside_a_picture_are_named(tmp_path):
    file = gltf_with({"name": "wood", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, ["a.png"], tmp_path)
    stage, report, _ = opened(edited(file, lambda model: with_colors(model, COLORS.astype("<f4"), 5126)), tmp_path)
    assert source_of(surface(stage), "diffuseColor")[1] == "rgb"
    [note] = report.notes
    assert "the colors of the points" in note
    assert "wood has a picture" in note


@pytest.mark.parametrize(
    ("sampler", "expected"),
    [
        ({}, ("repeat", "repeat")),
        ({"wrapS": 33071, "wrapT": 33648}, ("clamp", "mirror")),
        ({"wrapT": 33071}, ("repeat", "clamp")),
    ],
)
def test_wrap_modes_of_gltf(sampler, expected, tmp_path):
    file = gltf_with({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, ["a.png"], tmp_path)

    def edit(model):
        model["samplers"] = [sampler]
        model["textures"][0]["sampler"] = 0

    stage, _, _ = opened(edited(file, edit), tmp_path)
    color, _ = source_of(surface(stage), "diffuseColor")
    assert (color.GetInput("wrapS").Get(), color.GetInput("wrapT").Get()) == expected


def test_factors_of_gltf_are_not_rounded_and_strengths_count(tmp_path):
    material = {
        "pbrMetallicRoughness": {"baseColorFactor": [0.001, 0.0123, 0.5, 1]},
        "normalTexture": {"index": 0, "scale": 0.5},
        "emissiveFactor": [1, 0.5, 0.25],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 40}},
    }
    stage, report, _ = opened(gltf_with(material, ["a.png"], tmp_path), tmp_path)
    np.testing.assert_allclose(value(stage, "diffuseColor"), (0.001, 0.0123, 0.5), rtol=1e-6)
    np.testing.assert_allclose(value(stage, "emissiveColor"), (40, 20, 10), rtol=1e-6)
    normal, _ = source_of(surface(stage), "normal")
    # (texel * 2 - 1) * (scale, scale, 1)
    assert (normal.GetInput("scale").Get(), normal.GetInput("bias").Get()) == ((1, 1, 2, 1), (-0.5, -0.5, -1, 0))
    assert report.notes == []


def test_what_is_left_out_of_gltf_is_named(tmp_path):
    extensions = {"KHR_materials_unlit": {}, "KHR_materials_iridescence": {"iridescenceFactor": 1}}
    file = gltf_with({"name": "paint", "extensions": extensions}, ["a.png"], tmp_path)

    def edit(model):
        model["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
        model["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
        model["nodes"][0]["camera"] = 0

    stage, report, points = opened(edited(file, edit), tmp_path)
    assert report.notes == [
        "lights are left out",
        "cameras are left out",
        "the material paint is unlit; it is drawn as a lit one, without metal or highlights",
        "KHR_materials_iridescence of the material paint is left out",
    ]
    assert [value(stage, name) for name in ("metallic", "roughness")] == [0, 1]
    assert len(points) == 4


@pytest.mark.parametrize("uri", ["data:image/png;base64,AAAA", "broken.png"])
def test_pictures_that_are_none_are_named(uri, tmp_path):
    file = gltf_with({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, ["a.png"], tmp_path)
    (tmp_path / "broken.png").write_bytes(b"no picture")
    _, report, _ = opened(edited(file, lambda model: model["images"][0].update(uri=uri)), tmp_path)
    [note] = report.notes
    assert "cannot be read, so its part of the look is left out" in note


def test_a_gltf_without_scenes_has_all_its_nodes(tmp_path):
    def edit(model):
        del model["scenes"], model["scene"]
        model["nodes"] = [{"children": [1]}, {"mesh": 0, "translation": [0, 0, 3]}, {"mesh": 0}]

    _, _, points = opened(edited(gltf_with({}, [], tmp_path), edit), tmp_path, up_axis="Y")
    assert sorted(points[:, 2].tolist()) == [0] * 4 + [3] * 4


def test_names_of_parts_are_the_same_in_every_conversion(tmp_path):
    def edit(model):
        model["meshes"][0]["primitives"] *= 3
        model["nodes"][0]["name"] = "body"

    file = edited(gltf_with({}, [], tmp_path), edit)
    for _ in range(2):
        stage, _, _ = opened(file, tmp_path)
        assert {prim.GetName() for prim in meshes(stage)} == {"body_0", "body_1", "body_2"}


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_colors_of_the_faces_of_ply_do_not_run(order, tmp_path):
    faces = [(0, 1, 2), (0, 2, 3), (0, 2, 1), (0, 3, 2)]
    colors = [(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)]
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 4\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nend_header\n"
    )
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], "<f4")
    rows = b"".join(struct.pack("<B3i3B", 3, *(face[k] for k in order), *color) for face, color in zip(faces, colors))
    (tmp_path / "a.ply").write_bytes(head.encode() + points.tobytes() + rows)
    stage, _, _ = opened(tmp_path / "a.ply", tmp_path)
    [mesh] = meshes(stage)
    shown = UsdGeom.Gprim(mesh).GetDisplayColorPrimvar()
    assert shown.GetInterpolation() == "faceVarying"
    found = np.array(shown.Get()).reshape(-1, 3, 3)
    assert sorted(map(tuple, found[:, 0].tolist())) == sorted(tuple(c / 255 for c in color) for color in colors)
    assert (found == found[:, :1]).all()


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_faces_of_ply_show_the_picture_of_their_number(form, tmp_path):
    """A square in three triangles and one quad with a picture each, as photogrammetry writes them."""
    colors = [(200, 0, 0), (0, 200, 0), (0, 0, 200)]
    for number, color in enumerate(colors):
        Image.new("RGB", (4, 4), color).save(tmp_path / f"p{number}.png")
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)]
    faces = [((0, 1, 2), 2), ((0, 2, 3), 0), ((1, 4, 5, 2), 1)]
    names = "".join(f"comment TextureFile p{number}.png\n" for number in range(3))
    head = (
        f"ply\nformat {form} 1.0\n{names}element vertex {len(points)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\n"
        "property list uchar float texcoord\nproperty int texnumber\nelement edge 1\nproperty int vertex1\n"
        "property int vertex2\nend_header\n"
    )
    uvs = [[coordinate / 2 for corner in face for coordinate in points[corner][:2]] for face, _ in faces]
    if form == "ascii":
        lines = [" ".join(map(str, point)) for point in points]
        for (face, number), uv in zip(faces, uvs):
            lines.append(" ".join(map(str, (len(face), *face, len(uv), *uv, number))))
        body = "\n".join([*lines, "0 1", ""]).encode()
    else:
        order = "<" if "little" in form else ">"
        body = b"".join(struct.pack(order + "3f", *point) for point in points)
        for (face, number), uv in zip(faces, uvs):
            body += struct.pack(f"{order}B{len(face)}iB{len(uv)}fi", len(face), *face, len(uv), *uv, number)
        body += struct.pack(order + "2i", 0, 1)
    (tmp_path / "a.ply").write_bytes(head.encode() + body)
    stage, report, _ = opened(tmp_path / "a.ply", tmp_path, up_axis="Z")
    assert report.notes == []
    assert report.repairs == []
    found = {}
    for prim in meshes(stage):
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        shader = UsdShade.Shader(stage.GetPrimAtPath(f"{material.GetPath()}/color"))
        with Image.open(shader.GetInput("file").Get().resolvedPath) as image:
            color = np.array(image)[0, 0].tolist()
        mesh = UsdGeom.Mesh(prim)
        places = np.array(mesh.GetPointsAttr().Get())
        st = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
        at_points = np.array(st.Get())
        np.testing.assert_allclose(at_points, places[:, :2] / 2, atol=1e-6)
        found[tuple(color)] = (len(mesh.GetFaceVertexCountsAttr().Get()), places.mean(axis=0).round(3).tolist())
    assert {color: count for color, (count, _) in found.items()} == {colors[2]: 1, colors[0]: 1, colors[1]: 2}
    assert found[colors[1]][1] == [1.5, 0.5, 0.0]


def test_older_names_of_colors_in_ply(tmp_path):
    colors = "".join(f"property uchar diffuse_{name}\n" for name in ("red", "green", "blue"))
    (tmp_path / "a.ply").write_text(
        f"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{colors}"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\n3 0 1 2\n"
    )
    stage, _, _ = opened(tmp_path / "a.ply", tmp_path)
    [mesh] = meshes(stage)
    np.testing.assert_allclose(UsdGeom.Gprim(mesh).GetDisplayColorAttr().Get(), [(1, 0, 0)] * 3)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("names", ["red green blue", "r g b", "diffuse_red diffuse_green diffuse_blue"])
@pytest.mark.parametrize(
    ("kind", "packed", "top"),
    [("uchar", "B", 255), ("ushort", "H", 65535), ("int", "i", 255), ("uint", "I", 2**32 - 1)],
)
@pytest.mark.parametrize("element", ["vertex", "face"])
def test_colors_of_ply_of_any_size_and_name(element, kind, packed, top, names, form, tmp_path):
    """As scanners write them with 16 bits; of a face, among its other numbers."""
    shares = [(1, 0.5, 0), (0.2, 0.4, 1), (0, 0, 0.7)] if element == "vertex" else [(1, 0.5, 0)]
    colors = [[round(share * top) for share in each] for each in shares]
    points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    listed = "".join(f"property {kind} {name}\n" for name in names.split())
    own = {"vertex": "", "face": "", element: listed}
    head = (
        f"ply\nformat {form} 1.0\nelement vertex 3\nproperty float x\nproperty float y\n{own['vertex']}"
        f"property float z\nelement face 1\n{own['face']}property list uchar int vertex_indices\n"
        "property uchar flags\nend_header\n"
    )
    rows = [(x, y, *(colors[k] if element == "vertex" else ()), z) for k, (x, y, z) in enumerate(points)]
    face = (*(colors[0] if element == "face" else ()), 3, 0, 1, 2, 7)
    if form == "ascii":
        body = "".join(" ".join(map(str, row)) + "\n" for row in [*rows, face]).encode()
    else:
        order = "<" if "little" in form else ">"
        of_vertex, of_face = (packed * 3 if element == each else "" for each in ("vertex", "face"))
        body = b"".join(struct.pack(f"{order}2f{of_vertex}f", *row) for row in rows)
        body += struct.pack(f"{order}{of_face}B3iB", *face)
    (tmp_path / "a.ply").write_bytes(head.encode() + body)
    stage, _, _ = opened(tmp_path / "a.ply", tmp_path)
    [mesh] = meshes(stage)
    shown = np.array(UsdGeom.Gprim(mesh).GetDisplayColorPrimvar().ComputeFlattened())
    srgb = np.array(shares * (3 if element == "face" else 1))
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(np.sort(shown, axis=0), np.sort(linear, axis=0), atol=8e-3)

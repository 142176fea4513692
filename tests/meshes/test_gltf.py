"""What the glTF specification says of skins, instances, packed numbers and UVs, against converted points."""

import importlib.machinery
import sys
import tracemalloc
import types

import numpy as np
import pytest
from pxr import UsdGeom

from tests.meshes.test_conversion import meshes, opened, same_places
from tests.soak.meshes.made_gltf import Model, encoded
from tests.soak.meshes.shapes import floats, textured_box, uvs_of
from usdsdg.errors import AssetUnreadable, Unsupported
from usdsdg.meshes.readers.gltf_document import Document

Y_TO_Z = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def points_of(model, tmp_path):
    """The points of a model, in glTF's axes, and the report."""
    (tmp_path / "model.glb").write_bytes(model.glb())
    _, report, points = opened(tmp_path / "model.glb", tmp_path)
    return points @ Y_TO_Z.T, report


def test_skins_have_the_pose_of_their_joints(tmp_path):
    model, points = Model().with_box(), np.asarray(textured_box().vertices)
    upper = points[:, 1] > 0
    weights = np.zeros((len(points), 4))
    weights[:, 0], weights[:, 1] = ~upper, upper
    model.primitive["attributes"] |= {
        "JOINTS_0": model.add(np.tile(np.array((0, 1, 0, 0), np.uint8), (len(points), 1))),
        "WEIGHTS_0": model.add(floats(weights)),
    }
    # The second joint was bound at 0.1 above the origin, and is now a meter beside, turned by 90 degrees about z.
    inverse = np.stack([np.eye(4), np.eye(4)])
    inverse[1, 1, 3] = -0.1
    matrices = model.add(floats(inverse.transpose(0, 2, 1)))
    turn = np.sqrt(0.5)
    model.json["nodes"] = [
        {"mesh": 0, "skin": 0, "translation": [7, 7, 7]},
        {"name": "root", "children": [2]},
        {"translation": [1, 0, 0], "rotation": [0, 0, turn, turn]},
    ]
    model.json["scenes"] = [{"nodes": [0, 1]}]
    model.json["skins"] = [{"joints": [1, 2], "inverseBindMatrices": matrices}]
    found, report = points_of(model, tmp_path)
    moved = points - (0, 0.1, 0)
    turned = np.stack([1 - moved[:, 1], moved[:, 0], moved[:, 2]], axis=1)
    expected = np.where(upper[:, None], turned, points)
    assert same_places(found, expected)
    assert any("skeleton" in note for note in report.notes)


def test_instances_are_nodes_of_their_own(tmp_path):
    model, points = Model().with_box(), np.asarray(textured_box().vertices)
    rows = {
        "TRANSLATION": model.add(floats([(0, 0, 0), (1, 0, 0)])),
        "ROTATION": model.add(floats([(0, 0, 0, 1), (0, 0, np.sqrt(0.5), np.sqrt(0.5))])),
        "SCALE": model.add(floats([(1, 1, 1), (1, 3, 1)])),
    }
    extensions = {"EXT_mesh_gpu_instancing": {"attributes": rows}}
    model.json["nodes"][0] |= {"translation": [0, 5, 0], "extensions": extensions}
    stretched = points * (1, 3, 1)
    turned = np.stack([1 - stretched[:, 1], stretched[:, 0], stretched[:, 2]], axis=1)
    found, _ = points_of(model, tmp_path)
    assert same_places(found, np.concatenate([points, turned]) + np.array((0, 5, 0)))


def test_packed_and_sparse_numbers(tmp_path):
    model, points = Model().with_box(), np.asarray(textured_box().vertices)
    packed = np.round(points / 0.1 * 32767).astype(np.int16)
    padded = np.c_[packed, np.zeros(len(packed), np.int16)].astype(np.int16)  # rows of eight bytes
    view = model.view(padded.tobytes())
    model.json["bufferViews"][view]["byteStride"] = 8
    sparse = {
        "count": 1,
        "indices": {"bufferView": model.view(np.array([0], np.uint16).tobytes()), "componentType": 5123},
        "values": {"bufferView": model.view(np.array([32767, 0, 0], np.int16).tobytes())},
    }
    model.json["accessors"].append(
        {
            "bufferView": view, "componentType": 5122, "normalized": True, "count": len(points), "type": "VEC3",
            "sparse": sparse,
        }
    )  # fmt: skip
    model.primitive["attributes"]["POSITION"] = len(model.json["accessors"]) - 1
    model.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    expected = points / 0.1
    expected[0] = (1, 0, 0)
    found, _ = points_of(model, tmp_path)
    assert same_places(found, expected, 1e-4)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, lambda u, v: (u, v)),
        ({"texCoord": 1}, lambda u, v: (2 * u, 3 * v)),
        (
            {"extensions": {"KHR_texture_transform": {"offset": [0.5, 0.25], "scale": [2, 4]}}},
            lambda u, v: (2 * u + 0.5, 4 * v + 0.25),
        ),
        (
            # Counterclockwise, with v down: the specification's matrix.
            {"extensions": {"KHR_texture_transform": {"rotation": np.pi / 2, "texCoord": 1}}},
            lambda u, v: (3 * v, -2 * u),
        ),
    ],
)
def test_the_uvs_are_those_of_the_picture(tmp_path, given, expected):
    model, uvs = Model().with_box(), uvs_of(textured_box())
    u, v = uvs[:, 0], 1 - uvs[:, 1]
    model.primitive["attributes"]["TEXCOORD_1"] = model.add(floats(np.stack([2 * u, 3 * v], axis=1)))
    model.with_look({"index": model.image(encoded("PNG"), "image/png"), **given})
    (tmp_path / "model.glb").write_bytes(model.glb())
    stage, _, _ = opened(tmp_path / "model.glb", tmp_path)
    [mesh] = meshes(stage)
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    wanted_u, wanted_v = expected(u, v)
    assert same_places(np.c_[st, 0 * st[:, :1]], np.stack([wanted_u, 1 - wanted_v, 0 * u], axis=1), 1e-4)


def test_all_joints_of_a_point_count(tmp_path):
    """A second set of joints and weights: half of each point goes with a joint that is two meters to the right."""
    model, points = Model().with_box(), np.asarray(textured_box().vertices)
    for k, joint in ((0, 0), (1, 1)):
        rows = np.tile(np.array((joint, 0, 0, 0), np.uint8), (len(points), 1))
        weights = np.tile((0.5, 0.0, 0.0, 0.0), (len(points), 1))
        model.primitive["attributes"] |= {f"JOINTS_{k}": model.add(rows), f"WEIGHTS_{k}": model.add(floats(weights))}
    model.json["nodes"] = [{"mesh": 0, "skin": 0}, {}, {"translation": [2, 0, 0]}]
    model.json["scenes"] = [{"nodes": [0, 1, 2]}]
    model.json["skins"] = [{"joints": [1, 2]}]
    found, _ = points_of(model, tmp_path)
    assert same_places(found, points + np.array((1, 0, 0)))


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("has_material", [False, True])
def test_colors_of_points_in_every_kind_of_number(kind, has_material, tmp_path):
    model = Model().with_box()
    most = 1.0 if kind is np.float32 else np.iinfo(kind).max
    color = np.array((0.25, 0.5, 0.75))
    colors = np.tile(np.round(color * most) if most > 1.0 else color, (len(textured_box().vertices), 1)).astype(kind)
    model.primitive["attributes"]["COLOR_0"] = model.add(colors, normalized=most > 1.0)
    if has_material:
        model.json["materials"], model.primitive["material"] = [{}], 0
    (tmp_path / "model.glb").write_bytes(model.glb())
    stage, _, _ = opened(tmp_path / "model.glb", tmp_path)
    [mesh] = meshes(stage)
    found = np.array(UsdGeom.Gprim(mesh).GetDisplayColorAttr().Get())
    np.testing.assert_allclose(found, np.broadcast_to(color, found.shape), atol=1.0 / 255)


def test_the_opacity_of_the_colors_of_points_is_named(tmp_path):
    model = Model().with_box()
    count = len(textured_box().vertices)
    model.with_look({"index": model.image(encoded("PNG"), "image/png")})
    colors = np.tile(np.array((255, 255, 255, 100), np.uint8), (count, 1))
    model.primitive["attributes"]["COLOR_0"] = model.add(colors, normalized=True)
    for mode, is_named in (("OPAQUE", False), ("BLEND", True)):
        model.json["materials"][0] |= {"alphaMode": mode, "name": "hair"}
        _, report = points_of(model, tmp_path)
        note = "the opacity of the colors of points is left out for the material hair"
        assert (note in report.notes) is is_named


@pytest.fixture
def draco(monkeypatch):
    """A stand-in for DracoPy, whose packed meshes are the keys of a dictionary."""
    module = types.ModuleType("DracoPy")
    module.__spec__ = importlib.machinery.ModuleSpec("DracoPy", None)
    meshes = {}
    module.decode = meshes.__getitem__  # pyright: ignore[reportAttributeAccessIssue]
    monkeypatch.setitem(sys.modules, "DracoPy", module)
    return meshes


def test_packed_numbers_in_compressed_meshes(tmp_path, draco):
    """Draco holds integers, which the accessors say stand for floats; its UVs have the transform of their picture."""
    model, box = Model().with_box(), textured_box()
    points, uvs = np.asarray(box.vertices), uvs_of(box) * (1, -1) + (0, 1)
    model.with_look(
        {
            "index": model.image(encoded("PNG"), "image/png"),
            "extensions": {"KHR_texture_transform": {"scale": [2, 3]}},
        }
    )
    packed = np.round(points / 0.1 * 32767).astype(np.int16)
    for name, kind, code in (("POSITION", "VEC3", 5122), ("TEXCOORD_0", "VEC2", 5126)):
        accessor = {"componentType": code, "count": len(points), "type": kind, "normalized": code == 5122}
        model.json["accessors"].append(accessor)
        model.primitive["attributes"][name] = len(model.json["accessors"]) - 1
    model.primitive["attributes"] = {k: v for k, v in model.primitive["attributes"].items() if k != "NORMAL"}
    extension = {"bufferView": model.view(b"a mesh__"), "attributes": {"POSITION": 7, "TEXCOORD_0": 3}}
    model.primitive["extensions"] = {"KHR_draco_mesh_compression": extension}
    draco[b"a mesh__"] = types.SimpleNamespace(
        faces=np.asarray(box.faces),
        attributes=[{"unique_id": 7, "data": packed}, {"unique_id": 3, "data": uvs.astype(np.float32)}],
    )
    found, report = points_of(model, tmp_path)
    assert same_places(found, points / 0.1, 1e-4)
    assert report.triangles == len(box.faces)
    stage, _, _ = opened(tmp_path / "model.glb", tmp_path)
    [mesh] = meshes(stage)
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    wanted = np.stack([2 * uvs[:, 0], 1 - 3 * uvs[:, 1], 0 * uvs[:, 0]], axis=1)
    assert same_places(np.c_[st, 0 * st[:, :1]], wanted, 1e-4)


def test_an_accessor_takes_the_memory_of_its_own_values(tmp_path):
    model = Model().with_box()
    model.buffer += bytes(20 << 20)  # as of many other meshes
    (tmp_path / "model.glb").write_bytes(model.glb())
    document = Document(tmp_path / "model.glb", lambda name: b"")
    tracemalloc.start()
    try:
        document.array(model.primitive["attributes"]["POSITION"])
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most < 1 << 20


def test_fans_are_triangles(tmp_path):
    model = Model()
    ring = [(np.cos(angle), np.sin(angle), 0) for angle in np.linspace(0, 5, 9)]
    model.primitive.update(attributes={"POSITION": model.add(floats([(0, 0, 0), *ring]))}, mode=6)
    found, report = points_of(model, tmp_path)
    assert report.triangles == 8
    assert same_places(found, np.array([(0, 0, 0), *ring]))


def test_files_that_are_refused_say_why(tmp_path):
    draco = Model().with_box()
    draco.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}}
    meshopt = Model().with_box()
    meshopt.json["extensionsRequired"] = ["EXT_meshopt_compression"]
    for model, why in ((draco, "DracoPy"), (meshopt, "glTF extension EXT_meshopt_compression")):
        with pytest.raises(Unsupported, match=why):
            points_of(model, tmp_path)
    (tmp_path / "cut.glb").write_bytes(Model().with_box().glb()[:-100])
    with pytest.raises(AssetUnreadable, match=r"cut off after \d+ of \d+ bytes"):
        opened(tmp_path / "cut.glb", tmp_path)


def test_broken_pictures_are_left_out_and_named(tmp_path):
    model = Model().with_box()
    model.with_look({"index": model.image(encoded("PNG")[:100], "image/png")})
    _, report = points_of(model, tmp_path)
    assert any("cannot be read" in note for note in report.notes)

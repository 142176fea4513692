"""Mesh files as USD: geometry, looks and axes against what trimesh and the files themselves say."""

import base64
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from PIL import Image
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.cli.app import app
from usdsdg.errors import AssetError, AssetUnreadable, ConfigError, OutputNotWritable, Unsupported, UsdsdgWarning
from usdsdg.meshes import repairs
from usdsdg.meshes.cache import converted
from usdsdg.meshes.conversion import Options, convert
from usdsdg.meshes.placement import UNITS, Origin
from usdsdg.scenarios.shared import mesh_folder
from usdsdg.stage.semantics.labels import get_labels

FORMS = ("obj", "glb", "gltf", "ply", "stl", "dae", "off")
Y_UP = ("obj", "glb", "gltf", "dae")


@pytest.fixture
def wedge():
    """A box of 0.2 x 0.1 x 0.3 with one corner pulled out, so that no two axes look alike."""
    mesh = trimesh.creation.box((0.2, 0.1, 0.3))
    vertices = np.array(mesh.vertices)
    vertices[vertices.sum(axis=1).argmax()] += (0.05, 0.02, 0.1)
    return trimesh.Trimesh(vertices, mesh.faces, process=False)


def saved(mesh, folder, form):
    """Write a mesh in a form, glTF with a separate buffer; return the file."""
    if form != "gltf":
        file = folder / f"thing.{form}"
        mesh.export(file)
        return file
    for name, content in trimesh.exchange.gltf.export_gltf(trimesh.Scene(mesh)).items():
        (folder / name).write_bytes(content)
    return (folder / "model.gltf").rename(folder / "thing.gltf")


def opened(source, tmp_path, **options):
    """Convert a file; return the stage, the report and the points of all meshes in the world."""
    target = tmp_path / "out" / "thing.usda"
    report, _ = convert(source, target, Options(**options))
    stage = Usd.Stage.Open(str(target))
    points = []
    for prim in meshes(stage):
        to_world = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
        local = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get())
        points.append(np.c_[local, np.ones(len(local))] @ to_world)
    return stage, report, np.concatenate(points)[:, :3]


def meshes(stage):
    return [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]


def same_places(a, b, tolerance=1e-5):
    """Whether two sets of points are at the same places."""
    return set(map(tuple, np.round(a / tolerance / 10).astype(int).tolist())) == set(
        map(tuple, np.round(b / tolerance / 10).astype(int).tolist())
    )


@pytest.mark.parametrize("form", FORMS)
def test_every_form_keeps_size_and_place(wedge, tmp_path, form):
    stage, report, points = opened(saved(wedge, tmp_path, form), tmp_path)
    vertices = np.asarray(wedge.vertices)
    # From Y up to Z up: x, -z, y.
    expected = vertices[:, [0, 2, 1]] * (1, -1, 1) if form in Y_UP else vertices
    assert same_places(points, expected)
    assert (
        report.triangles
        == len(wedge.faces)
        == sum(len(UsdGeom.Mesh(p).GetFaceVertexCountsAttr().Get()) for p in meshes(stage))
    )
    assert np.allclose(report.size, np.ptp(expected, axis=0), atol=1e-6)
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Z", 1.0)
    assert stage.GetDefaultPrim().GetPath() == "/thing"


@pytest.mark.parametrize("form", FORMS)
def test_triangles_face_outward_and_normals_with_them(wedge, tmp_path, form):
    stage, _, _ = opened(saved(wedge, tmp_path, form), tmp_path)
    assert meshes(stage)
    for prim in meshes(stage):
        mesh = UsdGeom.Mesh(prim)
        points = np.array(mesh.GetPointsAttr().Get())
        corners = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
        a, b, c = points[corners[:, 0]], points[corners[:, 1]], points[corners[:, 2]]
        assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0.0  # six times the volume
        normals = np.array(mesh.GetNormalsAttr().Get())
        of_corners = normals[corners] if mesh.GetNormalsInterpolation() == "vertex" else normals.reshape(-1, 3, 3)
        face = np.cross(b - a, c - a)
        face /= np.linalg.norm(face, axis=1, keepdims=True)
        assert (np.einsum("tkj,tj->tk", of_corners, face) > 0.3).all()
        assert np.allclose(np.linalg.norm(of_corners, axis=2), 1.0, atol=1e-5)


@pytest.mark.parametrize("up", ["Y", "Z"])
@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_axes_and_units_of_the_target(wedge, tmp_path, up, unit):
    stage, report, points = opened(saved(wedge, tmp_path, "ply"), tmp_path, up_axis=up, meters_per_unit=unit)
    vertices = np.asarray(wedge.vertices) / unit
    assert same_places(points, vertices if up == "Z" else vertices[:, [0, 2, 1]] * (1, 1, -1), 1e-5 / unit)
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == (up, unit)
    assert max(report.size) == pytest.approx(np.ptp(wedge.vertices, axis=0).max())


def test_units_and_axes_of_the_source(wedge, tmp_path):
    source = saved(wedge, tmp_path, "stl")
    _, _, points = opened(source, tmp_path, source_unit=0.001, source_up_axis="Y")
    assert same_places(points, np.asarray(wedge.vertices)[:, [0, 2, 1]] * (1, -1, 1) * 0.001, 1e-8)


def test_collada_says_its_axes_and_units(wedge, tmp_path):
    source = saved(wedge, tmp_path, "dae")
    text = source.read_text()
    head, tail = text.split("<asset>", 1)
    tail = tail.split("</asset>", 1)[1]
    source.write_text(f'{head}<asset><unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis></asset>{tail}')
    _, _, points = opened(source, tmp_path)
    assert same_places(points, np.asarray(wedge.vertices) * 0.0254, 1e-6)


@pytest.mark.parametrize(("origin", "expected"), [("center", (0, 0, 0)), ("bottom", (0, 0, 0.5))])
def test_origins(wedge, tmp_path, origin, expected):
    moved = wedge.copy()
    moved.apply_translation((3, 4, 5))
    _, report, points = opened(saved(moved, tmp_path, "ply"), tmp_path, origin=Origin(origin))
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    assert np.allclose(middle, np.array(expected) * report.size, atol=1e-5)


def test_nodes_of_a_scene_are_placed_and_mirrored_ones_turned(wedge, tmp_path):
    scene = trimesh.Scene()
    turned = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3), (0.1, 0, 0))
    mirrored = trimesh.transformations.translation_matrix((0, 2, 0)) @ np.diag((-1.0, 1, 2, 1))
    for matrix in (turned, mirrored):
        scene.add_geometry(wedge, transform=matrix)
    scene.export(tmp_path / "two.glb")
    stage, report, points = opened(tmp_path / "two.glb", tmp_path)
    corners = np.c_[wedge.vertices, np.ones(len(wedge.vertices))]
    expected = np.concatenate([corners @ matrix.T for matrix in (turned, mirrored)])[:, [0, 2, 1]] * (1, -1, 1)
    assert report.parts == 2
    assert same_places(points, expected)
    for prim in meshes(stage):
        mesh = UsdGeom.Mesh(prim)
        local = np.array(mesh.GetPointsAttr().Get())
        local = local - local.mean(axis=0)
        a, b, c = local[np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)].transpose(1, 0, 2)
        assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0.0


def gltf_with(material, images, tmp_path, *, alpha=255):
    """Write a square of glTF with a material in its own words; return the file."""
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], np.float32)
    uvs = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], np.float32)  # glTF's origin is the upper left
    indices = np.array([0, 1, 2, 0, 2, 3], np.uint16)
    buffer = points.tobytes() + uvs.tobytes() + indices.tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    for name in images:
        Image.fromarray(np.full((4, 4, 4), (200, 100, 50, alpha), np.uint8)).save(tmp_path / name)
    model = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [material],
        "images": [{"uri": name} for name in images],
        "textures": [{"source": index} for index in range(len(images))],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "buffers": [{"byteLength": len(buffer), "uri": uri}],
    }  # fmt: skip
    file = tmp_path / "square.gltf"
    file.write_text(json.dumps(model))
    return file


def surface(stage):
    """Return the surface shader of the only material."""
    [material] = [UsdShade.Material(prim) for prim in stage.Traverse() if prim.IsA(UsdShade.Material)]
    return material.ComputeSurfaceSource()[0]


def source_of(shader, name):
    """Return the picture shader that an input is connected to, and the output."""
    found = shader.GetInput(name).GetConnectedSource()
    return UsdShade.Shader(found[0].GetPrim()), str(found[1])


def test_materials_of_gltf(tmp_path):
    material = {
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.2, 0.4, 0.6, 1.0], "baseColorTexture": {"index": 0},
            "metallicFactor": 0.25, "roughnessFactor": 0.75, "metallicRoughnessTexture": {"index": 1},
        },
        "normalTexture": {"index": 2}, "emissiveFactor": [0.1, 0.2, 0.3], "doubleSided": True,
    }  # fmt: skip
    stage, _, _ = opened(gltf_with(material, ["color.png", "orm.png", "normal.png"], tmp_path), tmp_path)
    shader = surface(stage)
    color, output = source_of(shader, "diffuseColor")
    assert (output, color.GetInput("sourceColorSpace").Get()) == ("rgb", "sRGB")
    assert np.allclose(color.GetInput("scale").Get(), (0.2, 0.4, 0.6, 1.0), atol=0.5 / 255)
    file = Path(color.GetInput("file").Get().resolvedPath)
    assert np.array(Image.open(file))[0, 0, :3].tolist() == [200, 100, 50]
    packed, output = source_of(shader, "roughness")
    assert (output, packed.GetInput("sourceColorSpace").Get()) == ("g", "raw")
    assert source_of(shader, "metallic")[1] == "b"
    assert np.allclose(packed.GetInput("scale").Get(), (1.0, 0.75, 0.25, 1.0))
    assert np.allclose(source_of(shader, "normal")[0].GetInput("bias").Get(), (-1, -1, -1, 0))
    assert np.allclose(shader.GetInput("emissiveColor").Get(), (0.1, 0.2, 0.3), atol=0.5 / 255)
    [mesh] = meshes(stage)
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    points = np.array(UsdGeom.Mesh(mesh).GetPointsAttr().Get())
    assert np.allclose(st, points[:, [0, 2]])  # USD's origin is the lower left
    assert UsdGeom.Mesh(mesh).GetDoubleSidedAttr().Get() is True


@pytest.mark.parametrize(("mode", "threshold"), [("OPAQUE", None), ("BLEND", None), ("MASK", 0.3)])
def test_opacity_of_gltf(tmp_path, mode, threshold):
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": mode}
    if threshold:
        material["alphaCutoff"] = threshold
    stage, _, _ = opened(gltf_with(material, ["color.png"], tmp_path, alpha=90), tmp_path)
    shader = surface(stage)
    opacity = shader.GetInput("opacity")
    assert opacity.HasConnectedSource() is (mode != "OPAQUE")
    assert not opacity.HasConnectedSource() or source_of(shader, "opacity")[1] == "a"
    found = shader.GetInput("opacityThreshold")
    assert (found.Get() if found else None) == (pytest.approx(threshold) if threshold else None)


def test_materials_of_obj(tmp_path):
    Image.new("RGB", (4, 4), (10, 20, 30)).save(tmp_path / "wood.png")
    (tmp_path / "thing.mtl").write_text("newmtl wood\nmap_Kd wood.png\nnewmtl red\nKd 0.8 0.1 0.1\nd 0.5\n")
    (tmp_path / "thing.obj").write_text(
        "mtllib thing.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
        "usemtl wood\nf 1/1 2/2 3/3\nusemtl red\nf 1 3 4\n"
    )
    stage, report, _ = opened(tmp_path / "thing.obj", tmp_path)
    looks = {prim.GetName(): UsdShade.Material(prim) for prim in stage.Traverse() if prim.IsA(UsdShade.Material)}
    assert set(looks) == {"wood", "red"}
    red = looks["red"].ComputeSurfaceSource()[0]
    assert np.allclose(red.GetInput("diffuseColor").Get(), (0.8, 0.1, 0.1), atol=0.5 / 255)
    wood = source_of(looks["wood"].ComputeSurfaceSource()[0], "diffuseColor")[0]
    assert Path(wood.GetInput("file").Get().resolvedPath).is_file()
    assert report.notes == []


def test_colors_of_points_are_linear(wedge, tmp_path):
    wedge.visual.vertex_colors = np.tile((188, 0, 255, 255), (len(wedge.vertices), 1)).astype(np.uint8)
    stage, _, _ = opened(saved(wedge, tmp_path, "ply"), tmp_path)
    [mesh] = meshes(stage)
    assert np.allclose(UsdGeom.Mesh(mesh).GetDisplayColorAttr().Get(), (0.502886, 0, 1), atol=1e-3)


def test_smooth_and_sharp_edges_where_there_are_no_normals(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=3)
    stage, _, _ = opened(saved(ball, tmp_path, "stl"), tmp_path)
    [mesh] = map(UsdGeom.Mesh, meshes(stage))
    points = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get())]
    assert np.einsum("ij,ij->i", points, np.array(mesh.GetNormalsAttr().Get())).min() > 0.999
    stage, _, _ = opened(saved(trimesh.creation.box(), tmp_path, "stl"), tmp_path)
    [mesh] = map(UsdGeom.Mesh, meshes(stage))
    assert np.allclose(np.abs(np.array(mesh.GetNormalsAttr().Get())).max(axis=1), 1.0)


def test_large_parts_are_left_flat(tmp_path, monkeypatch):
    monkeypatch.setattr(repairs, "MAX_SMOOTHED", 10)
    stage, _, _ = opened(saved(trimesh.creation.box(), tmp_path, "stl"), tmp_path)
    [mesh] = map(UsdGeom.Mesh, meshes(stage))
    assert not mesh.GetNormalsAttr().HasAuthoredValue()
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none"


# FBX and URDF


def test_fbx(tmp_path):
    pytest.importorskip("assimp_py")
    # ASCII FBX in centimeters, Y up: a square of 2 m by 1 m with the lower left corner at (1, 0, 0) m.
    (tmp_path / "square.fbx").write_text(FBX)
    _, report, points = opened(tmp_path / "square.fbx", tmp_path)
    assert report.triangles == 2
    assert same_places(points, np.array([(1, 0, 0), (3, 0, 0), (3, 0, 1), (1, 0, 1)], float))


FBX = """; FBX 7.4.0 project file
FBXHeaderExtension:  {
    FBXHeaderVersion: 1003
    FBXVersion: 7400
}
GlobalSettings:  {
    Version: 1000
    Properties70:  {
        P: "UpAxis", "int", "Integer", "",1
        P: "UpAxisSign", "int", "Integer", "",1
        P: "FrontAxis", "int", "Integer", "",2
        P: "FrontAxisSign", "int", "Integer", "",1
        P: "CoordAxis", "int", "Integer", "",0
        P: "CoordAxisSign", "int", "Integer", "",1
        P: "UnitScaleFactor", "double", "Number", "",1
    }
}
Objects:  {
    Geometry: 1001, "Geometry::Square", "Mesh" {
        Vertices: *12 {
            a: 0,0,0,200,0,0,200,100,0,0,100,0
        }
        PolygonVertexIndex: *4 {
            a: 0,1,2,-4
        }
        GeometryVersion: 124
    }
    Model: 1002, "Model::Square", "Mesh" {
        Version: 232
        Properties70:  {
            P: "Lcl Translation", "Lcl Translation", "", "A",100,0,0
        }
    }
}
Connections:  {
    C: "OO",1002,0
    C: "OO",1001,1002
}
"""


SKIN = """
    Deformer: 2001, "Deformer::Skin", "Skin" {
        Version: 101
    }
    Deformer: 2002, "SubDeformer::Cluster", "Cluster" {
        Version: 100
        Indexes: *4 {
            a: 0,1,2,3
        }
        Weights: *4 {
            a: 1,1,1,1
        }
        Transform: *16 {
            a: 1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1
        }
        TransformLink: *16 {
            a: 1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1
        }
    }
    Model: 2003, "Model::Bone", "LimbNode" {
        Version: 232
        Properties70:  {
            P: "Lcl Translation", "Lcl Translation", "", "A",0,0,700
        }
    }
}
Connections:  {
    C: "OO",2001,1001
    C: "OO",2002,2001
    C: "OO",2003,2002
    C: "OO",2003,0
"""


def test_a_skinned_fbx_has_the_pose_in_which_it_was_bound_and_says_so(tmp_path, monkeypatch):
    pytest.importorskip("assimp_py")
    # The bone has moved by 7 m since it was bound.
    (tmp_path / "skinned.fbx").write_text(FBX.replace("}\nConnections:  {\n", SKIN.removeprefix("\n"), 1))
    _, report, points = opened(tmp_path / "skinned.fbx", tmp_path)
    [note] = report.notes
    assert "was bound" in note
    assert "Export it as GLB" in note
    assert same_places(points, np.array([(1, 0, 0), (3, 0, 0), (3, 0, 1), (1, 0, 1)], float))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.warns(UsdsdgWarning, match=r"skinned\.fbx.*was bound.*Export it as GLB"):
        converted(str(tmp_path / "skinned.fbx"), Options())


def test_urdf(wedge, tmp_path):
    pytest.importorskip("yourdfpy")
    wedge.export(tmp_path / "arm.stl")
    (tmp_path / "robot.urdf").write_text(
        """<robot name="r">
  <material name="blue"><color rgba="0 0 0.8 1"/></material>
  <link name="base"><visual><geometry><box size="1 2 3"/></geometry><material name="blue"/></visual></link>
  <link name="arm"><visual><origin xyz="0 0 1"/><geometry><mesh filename="package://any/arm.stl" scale="2 2 2"/>
  </geometry></visual></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="5 0 0" rpy="0 0 1.5707963"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
    )
    stage, report, points = opened(tmp_path / "robot.urdf", tmp_path)
    box = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-1, 1) for z in (-1.5, 1.5)])
    arm = np.asarray(wedge.vertices) * 2.0 + (0, 0, 1)
    assert same_places(points, np.concatenate([box, arm[:, [1, 0, 2]] * (-1, 1, 1) + (5, 0, 0)]))
    assert report.notes == ["joints are rigid, in their zero pose"]
    [base] = [prim for prim in meshes(stage) if prim.GetName() == "base"]
    color = UsdShade.MaterialBindingAPI(base).ComputeBoundMaterial()[0].ComputeSurfaceSource()[0]
    assert np.allclose(color.GetInput("diffuseColor").Get(), (0, 0, 0.8))


def test_a_urdf_without_its_mesh_is_an_error(tmp_path):
    pytest.importorskip("yourdfpy")
    (tmp_path / "robot.urdf").write_text(
        '<robot name="r"><link name="a"><visual><geometry><mesh filename="gone.stl"/></geometry></visual></link>'
        "</robot>"
    )
    with pytest.raises(AssetError, match=r"the mesh gone.stl of a is not there"):
        opened(tmp_path / "robot.urdf", tmp_path)


# What is broken

BROKEN = {
    "empty.obj": (b"", "is an empty file"),
    "text.stl": (b"hello", "text.stl"),
    "cut.glb": (b"glTF\x02\x00\x00\x00\xff\xff\x00\x00", "cannot be read as GLB"),
    "not.gltf": (b"{", "cannot be read as GLTF"),
    "points.ply": (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                   b"end_header\n0 0 0\n", "no triangles"),
    "lines.obj": (b"v 0 0 0\nv 1 0 0\nl 1 2\n", "no triangles"),
    "flat.obj": (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no triangle is left"),
    "pointer.fbx": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "git lfs pull"),
    "not.fbx": (b"Kaydara FBX Binary  \x00 cut", "cannot be read as FBX"),
    "not.urdf": (b"<robot", "cannot be read as URDF"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_refused_with_a_reason(tmp_path, name):
    content, reason = BROKEN[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises((AssetUnreadable, AssetError), match=reason):
        convert(tmp_path / name, tmp_path / "out" / "x.usd", Options())
    assert not (tmp_path / "out").exists()


def test_repairs_are_reported(tmp_path):
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\nf 2 3 1\n")
    _, report, points = opened(tmp_path / "bad.obj", tmp_path)
    assert report.triangles == 1
    assert len(points) == 3
    assert [line.split(" ", 2)[0] for line in report.repairs] == ["removed"] * 3
    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.invert()
    _, report, _ = opened(saved(ball, tmp_path, "stl"), tmp_path)
    assert report.repairs == ["turned 1 closed parts right side out"]


@pytest.mark.parametrize("meters", [400, 70])
def test_odd_sizes_are_named_with_the_unit_that_jobs_would_take(wedge, tmp_path, meters):
    """A pin of 70 units is one of 70 mm rather than of 70 cm."""
    wedge.apply_scale(meters / 0.4)
    file = saved(wedge, tmp_path, "stl")
    _, report, _ = opened(file, tmp_path)
    assert report.notes == [
        f"thing.stl is {meters} m large, which is odd for an object; if it is in mm, convert it with --unit mm"
    ]
    [asset] = mesh_folder.read_assets({"thing": [str(file)]}, "auto")
    assert asset.scale == UNITS["mm"]


def test_missing_pictures_are_named(tmp_path):
    (tmp_path / "thing.obj").write_text("mtllib gone.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    _, report, _ = opened(tmp_path / "thing.obj", tmp_path)
    assert report.notes == ["gone.mtl is missing beside thing.obj, so its part of the look is left out"]


# Options and the command


def test_label_and_collider(wedge, tmp_path):
    stage, _, _ = opened(saved(wedge, tmp_path, "obj"), tmp_path, label="mug", collider="convexHull")
    assert get_labels(stage.GetDefaultPrim()) == {"class": ["mug"]}
    [mesh] = meshes(stage)
    assert UsdPhysics.MeshCollisionAPI(mesh).GetApproximationAttr().Get() == "convexHull"
    stage, _, _ = opened(saved(wedge, tmp_path, "obj"), tmp_path)
    assert get_labels(stage.GetDefaultPrim()) == {}
    assert not meshes(stage)[0].HasAPI(UsdPhysics.CollisionAPI)


def test_options_that_cannot_be(tmp_path):
    for wrong in ({"up_axis": "X"}, {"collider": "hull"}, {"source_unit": 0.0}):
        with pytest.raises(ConfigError):
            replace(Options(), **wrong)
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(Unsupported, match=r"a converted mesh is a file"):
        convert(tmp_path / "a.obj", tmp_path / "a.glb", Options())
    with pytest.raises(Unsupported, match=r"is no mesh file"):
        convert(tmp_path / "a.xyz", tmp_path / "a.usd", Options())


def test_names_that_usd_cannot_have_are_told(tmp_path):
    mesh = trimesh.creation.box()
    odd = tmp_path / os.fsdecode(b"caf\xe9.stl")
    for file in (tmp_path / "box.stl", odd):
        file.write_bytes(mesh.export(file_type="stl"))
    with pytest.raises(AssetUnreadable, match="is not UTF-8, as USD needs paths to be"):
        convert(odd, tmp_path / "out.usd", Options())
    for name in (os.fsdecode(b"caf\xe9.usd"), "two\nlines.usd"):
        with pytest.raises(OutputNotWritable, match="which needs one line of UTF-8; give another OUT"):
            convert(tmp_path / "box.stl", tmp_path / name, Options())
    assert {each.name for each in tmp_path.iterdir()} == {"box.stl", odd.name}


def test_the_command(wedge, tmp_path):
    source = saved(wedge, tmp_path, "stl")
    target = tmp_path / "deep" / "mug.usd"
    given = ["convert", str(source), str(target), "--unit", "cm", "--up", "y", "--origin", "bottom", "--label", "Mug"]
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 0, result.output
    assert "12 triangles" in result.output
    stage = Usd.Stage.Open(str(target))
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert get_labels(stage.GetDefaultPrim()) == {"class": ["Mug"]}
    box = (
        UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
        .ComputeWorldBound(stage.GetDefaultPrim())
        .ComputeAlignedRange()
    )
    assert box.GetMin()[1] == pytest.approx(0.0, abs=1e-6)
    assert box.GetSize()[1] == pytest.approx(0.004)
    assert isinstance(box.GetMin(), Gf.Vec3d)


def test_the_command_says_what_is_wrong(tmp_path):
    (tmp_path / "mug.obj").write_text("v 0 0 0\n")
    for given, reason in (
        ([str(tmp_path / "mag.obj"), "x.usd"], f"did you mean {tmp_path / 'mug.obj'}?"),
        ([str(tmp_path / "mug.obj"), "x.usd"], "no triangles"),
        ([str(tmp_path / "mug.obj"), "x.usd", "--unit", "yard"], "expected one of m, cm, mm, inch, foot"),
        ([str(tmp_path / "mug.obj"), "x.usd", "--collider", "hull"], "expected one of none, convexHull"),
    ):
        result = CliRunner().invoke(app, ["convert", *given])
        assert result.exit_code == 1
        assert reason in result.output


def test_a_target_that_cannot_be_written(wedge, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputNotWritable, match="cannot be written"):
        convert(saved(wedge, tmp_path, "obj"), tmp_path / "file" / "x.usd", Options())


@pytest.mark.parametrize(
    ("unit", "reason"),
    [
        ("1e300", "beyond what a mesh can hold"), ("1e-300", "beyond what a mesh can hold"),
        ("inf", "expected a number above 0"), ("nan", "expected a number above 0"),
    ],
)  # fmt: skip
def test_a_unit_that_a_mesh_cannot_have_is_refused(wedge, tmp_path, unit, reason):
    source, target = saved(wedge, tmp_path, "obj"), tmp_path / "new" / "o.usd"
    result = CliRunner().invoke(app, ["convert", str(source), str(target), "--unit", unit])
    assert result.exit_code == 1
    assert reason in result.output
    assert not target.parent.exists()

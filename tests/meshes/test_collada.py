"""COLLADA files: skinned meshes, and what trimesh and pycollada leave out without a word."""

import numpy as np
import pytest
from pxr import UsdGeom

from tests.meshes.test_conversion import meshes, opened

pytest.importorskip("collada")

POINTS = np.array([(0, 0, 0), (1, 0, 0), (1, 2, 0), (0, 2, 0), (1, 4, 0), (0, 4, 0)], float)
BIND_SHAPE = np.array([[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0.25], [0, 0, 0, 1]])


def numbers(values):
    return " ".join(map(repr, np.asarray(values, float).ravel().tolist()))


def source(name, values, stride, kind="float"):
    return (
        f'<source id="{name}"><float_array id="{name}-a" count="{np.size(values)}">{numbers(values)}</float_array>'
        f'<technique_common><accessor source="#{name}-a" count="{np.size(values) // stride}" stride="{stride}">'
        + "".join(f'<param name="{axis}" type="{kind}"/>' for axis in "XYZW"[: min(stride, 4)])
        + "</accessor></technique_common></source>"
    )


def geometry(name, points, *, more=""):
    """Quads along a strip, each corner with a normal of its own."""
    count = len(points) // 2 - 1
    corners = [0, 1, 2, 3] + ([3, 2, 4, 5] if count == 2 else [])
    pairs = " ".join(f"{corner} 0" for corner in corners)
    return (
        f'<geometry id="{name}"><mesh>{source(f"{name}-p", points, 3)}{source(f"{name}-n", [(0, 0, 1)], 3)}'
        f'<vertices id="{name}-v"><input semantic="POSITION" source="#{name}-p"/></vertices>'
        f'<polylist count="{count}"{more}><input semantic="VERTEX" source="#{name}-v" offset="0"/>'
        f'<input semantic="NORMAL" source="#{name}-n" offset="1"/><vcount>{"4 " * count}</vcount><p>{pairs}</p>'
        "</polylist></mesh></geometry>"
    )


def document(geometries, controllers, nodes):
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        '<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>'
        f"<library_geometries>{geometries}</library_geometries><library_controllers>{controllers}</library_controllers>"
        f'<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#scene"/></scene></COLLADA>'
    )


def skin(weights, inverse):
    """A skin of two joints, lower and upper; `weights` are (N, 2), of which zeros are left out."""
    pairs, counts = [], []
    for row in weights:
        own = [(joint, weight) for joint, weight in enumerate(row) if weight]
        counts.append(len(own))
        pairs += own
    values = [weight for _, weight in pairs]
    indices = " ".join(f"{joint} {number}" for number, (joint, _) in enumerate(pairs))
    return (
        f'<controller id="skin"><skin source="#strip"><bind_shape_matrix>{numbers(BIND_SHAPE)}</bind_shape_matrix>'
        '<source id="j"><Name_array id="j-a" count="2">lower upper</Name_array><technique_common>'
        '<accessor source="#j-a" count="2" stride="1"><param name="JOINT" type="name"/></accessor></technique_common>'
        f"</source>{source('m', inverse, 16, 'float4x4')}{source('w', values, 1)}"
        '<joints><input semantic="JOINT" source="#j"/><input semantic="INV_BIND_MATRIX" source="#m"/></joints>'
        f'<vertex_weights count="{len(weights)}"><input semantic="JOINT" source="#j" offset="0"/>'
        f'<input semantic="WEIGHT" source="#w" offset="1"/><vcount>{" ".join(map(str, counts))}</vcount>'
        f"<v>{indices}</v></vertex_weights></skin></controller>"
    )


BONES = """<node id="a" sid="lower" type="JOINT"><translate>10 0 0</translate><rotate>0 0 1 90</rotate>
<node id="b" sid="upper" type="JOINT"><matrix>1 0 0 0 0 1 0 2 0 0 1 0 0 0 0 1</matrix><rotate>1 0 0 -30</rotate>
<scale>2 1 1</scale></node></node>
<node id="body" name="body"><translate>99 99 99</translate><instance_controller url="#skin"><skeleton>#a</skeleton>
</instance_controller></node>"""


def moved(degrees, axis, offset=(0, 0, 0), scale=(1, 1, 1)):
    """A matrix for column vectors: scale, then a rotation about x or z, then an offset."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turned = {
        "x": [[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]],
        "z": [[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]],
    }
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(turned[axis]) @ np.diag(scale)
    matrix[:3, 3] = offset
    return matrix


def test_a_skinned_mesh_has_the_pose_of_its_file(tmp_path):
    """Where its joints are, wherever its own node is; beside a plain mesh, which stays."""
    weights = np.array([(1, 0), (1, 0), (0.25, 0.75), (0.5, 0.5), (0, 1), (0, 2)], float)
    inverse = np.stack([np.eye(4), moved(0, "z", (0, -2, 0))])
    plain = '<node id="plain"><translate>0 0 5</translate><instance_geometry url="#flat"/></node>'
    text = document(geometry("strip", POINTS) + geometry("flat", POINTS[:4]), skin(weights, inverse), BONES + plain)
    (tmp_path / "man.dae").write_text(text)
    stage, report, points = opened(tmp_path / "man.dae", tmp_path)
    lower = moved(90, "z", (10, 0, 0))
    upper = lower @ moved(0, "z", (0, 2, 0)) @ moved(-30, "x", scale=(2, 1, 1))
    places = np.c_[POINTS, np.ones(6)] @ BIND_SHAPE.T
    shares = weights / weights.sum(axis=1, keepdims=True)
    matrices = [joint @ bind for joint, bind in zip((lower, upper), inverse)]
    expected = np.einsum("nk,kij,nj->ni", shares, np.stack(matrices), places)[:, :3]
    expected = np.concatenate([expected, POINTS[:4] + np.array([0, 0, 5])])
    for one, other in ((points, expected), (expected, points)):
        assert np.linalg.norm(one[:, None] - other, axis=2).min(axis=1).max() < 1e-5
    assert report.triangles == 6
    assert report.notes == ["the skeleton is left out; the object has the pose of the file"]
    for prim in meshes(stage):
        mesh = UsdGeom.Mesh(prim)
        places = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get())].reshape(-1, 3, 3)
        flat = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
        normals = np.array(mesh.GetNormalsAttr().Get())
        rows = (
            np.arange(len(normals))
            if len(normals) == places.shape[0] * 3
            else np.array(mesh.GetFaceVertexIndicesAttr().Get())
        )
        assert (np.einsum("tki,ti->tk", normals[rows].reshape(-1, 3, 3), flat) > 0.0).all()


def test_a_damaged_skin_is_named_beside_what_is_whole(tmp_path):
    broken = skin(np.eye(2)[[0, 0, 1]], np.stack([np.eye(4)] * 2))  # three weights for six points
    plain = '<node id="plain"><instance_geometry url="#flat"/></node>'
    text = document(geometry("strip", POINTS) + geometry("flat", POINTS[:4]), broken, BONES + plain)
    (tmp_path / "man.dae").write_text(text)
    _, report, points = opened(tmp_path / "man.dae", tmp_path)
    assert len(points) == 4
    assert report.notes == ["the skinned mesh body is damaged, so it is left out"]


def test_morph_targets_leave_their_base(tmp_path):
    morph = '<controller id="skin"><morph source="#strip" method="NORMALIZED"></morph></controller>'
    (tmp_path / "man.dae").write_text(document(geometry("strip", POINTS), morph, BONES))
    _, report, points = opened(tmp_path / "man.dae", tmp_path)
    np.testing.assert_allclose(np.sort(points, axis=0), np.sort(POINTS + 99, axis=0))
    assert report.notes[0] == "morph targets are left out"
    assert not any("a part of the file" in note for note in report.notes)


def test_a_mesh_whose_material_is_missing_is_drawn(tmp_path):
    bound = '<bind_material><technique_common><instance_material symbol="paint" target="#gone"/>'
    bound += "</technique_common></bind_material>"
    node = f'<node id="n"><instance_geometry url="#strip">{bound}</instance_geometry></node>'
    (tmp_path / "a.dae").write_text(document(geometry("strip", POINTS, more=' material="paint"'), "", node))
    _, report, points = opened(tmp_path / "a.dae", tmp_path)
    assert len(points) == 6
    assert report.notes == ["the material gone is missing in the file, so its part of the look is left out"]


def test_what_is_not_read_is_named(tmp_path):
    curve = '<geometry id="curve"><spline closed="0"/></geometry>'
    nodes = '<node id="n"><instance_geometry url="#strip"/></node><node id="c"><instance_geometry url="#curve"/></node>'
    nodes += '<node id="k"><instance_camera url="#gone"/></node>'
    (tmp_path / "a.dae").write_text(document(geometry("strip", POINTS) + curve, "", nodes))
    _, report, points = opened(tmp_path / "a.dae", tmp_path)
    assert len(points) == 6
    assert report.notes
    assert all(note.startswith("a part of the file is left out: ") for note in report.notes)
    assert any("#curve" in note or "geometry" in note.lower() for note in report.notes)
    assert not any("amera" in note for note in report.notes)

"""Boxes, masks and visibility of GeomSubsets are those of a stage where each subset is a mesh of its own."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.session.settings.store import get_settings
from usdsdg.stage.keypoints import set_keypoints
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.semantics.labels import add_labels

SETTING = "/syntheticdata/sensors/perSubsetSegmentation"
SIZE = (90, 70)
# What faces of the thing are of: no subset, one with a label, one without, another one.
PARTS = ("rest", "red", "plain", "blue")
LABELS = {"red": "red", "blue": "blue", "covered": "covered"}
ROWS = (
    "bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d", "bounding_box_2d_amodal",
    "oriented_bounding_box_2d", "oriented_bounding_box_2d_amodal",
)  # fmt: skip
BY_ID = ("occlusion", "truncation")
NAMES = (*ROWS, *BY_ID, "visibility", "occlusion_graph", "amodal_instance_segmentation", "keypoints",
         "instance_segmentation", "object_coordinates")  # fmt: skip


def bumpy_ball(rng):
    """Points and quads of a ball with bumps."""
    theta, phi = np.meshgrid(np.linspace(0.1, 3.0, 9), np.linspace(0, 2 * np.pi, 12, endpoint=False), indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
    points *= rng.uniform(0.7, 1.3, (len(points), 1))
    corner = [(row * 12 + k, row * 12 + (k + 1) % 12) for row in range(8) for k in range(12)]
    return points, np.array([(a, b, b + 12, a + 12) for a, b in corner])


def author_mesh(stage, path, points, faces):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(points.astype(np.float32))
    mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr(faces.reshape(-1).tolist())
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def author(stage, *, divided):
    """A ball in parts behind a pole and beyond the left edge, as one mesh with subsets or as one mesh for each part."""
    rng = np.random.default_rng(4)
    points, faces = bumpy_ball(rng)
    part = rng.integers(0, 4, len(faces))
    if divided:
        thing = author_mesh(stage, "/World/thing", points, faces)
        # Of a face in several subsets the last counts, so that the first one is left without any.
        chosen = {"covered": np.flatnonzero(part == 3)[:5]}
        chosen |= {name: np.flatnonzero(part == k) for k, name in enumerate(PARTS) if k > 0}
        for name, indices in chosen.items():
            subset = UsdGeom.Subset.Define(stage, f"/World/thing/{name}")
            subset.CreateElementTypeAttr("face")
            subset.CreateIndicesAttr(indices.tolist())
    else:
        thing = UsdGeom.Xform.Define(stage, "/World/thing")
        for name, k in {"rest": 0, "covered": 4, "red": 1, "plain": 2, "blue": 3}.items():
            author_mesh(stage, f"/World/thing/{name}", points, faces[part == k])
    UsdGeom.Xformable(thing).AddTransformOp().Set(
        Gf.Matrix4d().SetScale(Gf.Vec3d(1, 1.4, 0.8)) * Gf.Matrix4d().SetTranslate(Gf.Vec3d(-1.6, 0, 0))
    )
    add_labels(thing.GetPrim(), {"class": ["thing"]})
    for name, label in LABELS.items():
        if prim := stage.GetPrimAtPath(f"/World/thing/{name}"):
            add_labels(prim, {"class": [label]})
    pole = UsdGeom.Cube.Define(stage, "/World/pole")
    pole.AddTransformOp().Set(Gf.Matrix4d().SetScale(Gf.Vec3d(0.2, 0.2, 2)) * Gf.Matrix4d().SetTranslate((-0.9, -3, 0)))
    add_labels(pole.GetPrim(), {"class": ["pole"]})
    set_keypoints(pole.GetPrim(), {f"far{k}": (k - 4.0, 30.0, 0.1 * k) for k in range(9)})
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTransformOp().Set(look_at_matrix((0, -8, 1), (0, 0, 0), up=(0, 0, 1)))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, 100.0))
    return thing.GetPrim()


def cut_out(stage, prim):
    """Bind a material with holes."""
    material = UsdShade.Material.Define(stage, "/World/Holes")
    shader = UsdShade.Shader.Define(stage, "/World/Holes/Shader")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.4)
    shader.CreateInput("opacityThreshold", Sdf.ValueTypeNames.Float).Set(0.3)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def captured(lens, holes, *, divided):
    """Payloads of all annotators of a new stage, by name."""
    from usdsdg.session.stage_context import new_stage

    get_settings().set(SETTING, divided)
    stage = new_stage()
    UsdGeom.SetStageUpAxis(stage, "Z")
    thing = author(stage, divided=divided)
    if holes:
        cut_out(stage, thing)
    if lens:
        stage.GetPrimAtPath("/World/Camera").CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set(lens)
    product = rep.create.render_product("/World/Camera", SIZE)
    annotators = {name: rep.annotators.get(name).attach(product) for name in NAMES}
    rep.orchestrator.step()
    return {name: annotator.get_data() for name, annotator in annotators.items()}


@pytest.mark.parametrize(("lens", "holes"), [(None, False), (None, True), ("fisheyePolynomial", False)])
def test_subsets_are_labeled_as_meshes_of_their_own_are(stage, lens, holes):
    parts, meshes = (captured(lens, holes, divided=divided) for divided in (True, False))
    assert "/World/thing/covered" not in parts["bounding_box_3d"]["info"]["primPaths"]
    paths = parts["instance_segmentation"]["info"]["idToLabels"]
    assert paths == meshes["instance_segmentation"]["info"]["idToLabels"]
    assert set(paths.values()) > {"/World/thing", "/World/thing/red", "/World/thing/blue", "/World/pole"}
    for name in ("instance_segmentation", "object_coordinates", "keypoints"):
        np.testing.assert_array_equal(parts[name]["data"], meshes[name]["data"], err_msg=name)
    assert set(parts["keypoints"]["data"]["hiddenBy"]) & {int(k) for k, path in paths.items() if "thing/" in path}
    for name in ROWS:
        found, expected = (by_path(each[name]) for each in (parts, meshes))
        assert found == expected, name
        assert len(found) == 4
    for name in BY_ID:
        found, expected = (sorted(map(str, each[name])) for each in (parts, meshes))
        assert found == expected
    assert visibility(parts) == visibility(meshes)
    assert sorted(parts["occlusion_graph"]["data"].tolist()) == sorted(meshes["occlusion_graph"]["data"].tolist())
    found, expected = (masks(each["amodal_instance_segmentation"]) for each in (parts, meshes))
    assert found.keys() == expected.keys()
    for path, mask in found.items():
        np.testing.assert_array_equal(mask, expected[path], err_msg=path)


def by_path(payload):
    """Rows with their class and id by prim path."""
    info, rows = payload["info"], {}
    for path, id_, row in zip(info["primPaths"], info["bboxIds"], payload["data"]):
        named = {name: row[name].tolist() for name in row.dtype.names if name != "semanticId"}
        rows[path] = (int(id_), info["idToLabels"][str(row["semanticId"])], named)
    return rows


def visibility(payloads):
    given = payloads["visibility"]
    return {
        path: (row.tolist(), hidden)
        for path, row, hidden in zip(given["info"]["primPaths"], given["data"], given["info"]["hiddenBy"])
    }


def masks(payload):
    return dict(zip(payload["info"]["primPaths"], payload["data"]))


def test_boxes_follow_which_faces_a_subset_has(stage):
    get_settings().set(SETTING, True)
    UsdGeom.SetStageUpAxis(stage, "Z")
    author(stage, divided=True)
    product = rep.create.render_product("/World/Camera", SIZE)
    annotator = rep.annotators.get("bounding_box_3d").attach(product)
    rep.orchestrator.step()
    before = by_path(annotator.get_data())
    faces = stage.GetPrimAtPath("/World/thing/red").GetAttribute("indices")
    faces.Set(faces.Get()[:3])
    rep.orchestrator.step()
    after = by_path(annotator.get_data())
    assert after["/World/thing/red"] != before["/World/thing/red"]
    stage.RemovePrim("/World/thing/blue")
    rep.orchestrator.step()
    whole = by_path(annotator.get_data())
    assert "/World/thing/blue" not in whole
    get_settings().set(SETTING, False)
    rep.orchestrator.step()
    assert by_path(annotator.get_data()).keys() == {"/World/thing", "/World/pole"}

"""BopWriter: models placed by the written poses give the masks and depths that are written."""

import json

import numpy as np
import pytest
import trimesh
from PIL import Image
from pxr import Gf, Usd, UsdGeom, UsdSkel

import usdsdg as rep
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.verify import verify
from usdsdg.writers.formats.bop.bop_models import MOST_SHAPES

WIDTH, HEIGHT = 96, 72


def scene():
    """Three objects, one partly hidden, one reaching out of the picture, in centimeters."""
    rep.settings.set_stage_meters_per_unit(0.01)
    create = rep.functional.create
    create.cube(
        position=(0, 0, 20), rotation=(20, 30, 40), scale=(0.4, 0.3, 0.2), semantics={"class": "box"}, name="box"
    )
    create.cone(position=(25, -40, 25), rotation=(0, 10, 0), scale=0.25, semantics={"class": "hat"}, name="hat")
    create.sphere(position=(-78, 10, 30), scale=0.5, semantics={"class": "ball"}, name="ball")
    create.cylinder(position=(28, 30, 20), scale=0.5, semantics={"class": "can"}, name="can")
    create.xform(name="group", position=(5, 0, 0), scale=(1, 1, -1))
    create.cube(position=(-30, 40, -60), rotation=(5, 0, 0), scale=0.1, semantics={"class": "dice"}, parent="/group")
    camera = create.camera(position=(5, -200, 60), look_at=(0, 0, 20), clipping_range=(1, 100000))
    return rep.create.render_product(camera, (WIDTH, HEIGHT))


def write(folder, products, steps=1, **options):
    writer = rep.WriterRegistry.get("BopWriter")
    writer.initialize(output_dir=str(folder), **options)
    writer.attach(products)
    for _ in range(steps):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()
    rep.orchestrator.wait_until_complete()
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    from usdsdg.session import session
    from usdsdg.session.stage_context import new_stage

    session.restart()
    new_stage()
    return write(tmp_path_factory.mktemp("bop"), scene())


def table(folder, name, scene=0):
    return json.loads((folder / f"train_pbr/{scene:06d}/{name}.json").read_text())


def picture(folder, path):
    return np.array(Image.open(folder / "train_pbr/000000" / path))


def drawn(folder, pose, matrix):
    """Return the distance [mm] of a model at each pixel, by intersecting rays with its triangles; inf beside it."""
    model = trimesh.load(folder / f"models/obj_{pose['obj_id']:06d}.ply", process=False)
    rotation = np.array(pose["cam_R_m2c"]).reshape(3, 3)
    corners = (model.vertices @ rotation.T + pose["cam_t_m2c"])[model.faces]
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ np.linalg.inv(matrix).T
    nearest = np.full(len(rays), np.inf)
    for a, b, c in corners:
        normal = np.cross(b - a, c - a)
        with np.errstate(all="ignore"):
            t = (normal @ a) / (rays @ normal)
        hit = rays * t[:, None]
        inside = np.isfinite(t) & (t > 0)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.cross(q - p, hit - p) @ normal >= -1e-9 * np.abs(normal).max() ** 2
        nearest[inside] = np.minimum(nearest[inside], t[inside])
    return nearest.reshape(HEIGHT, WIDTH)


def test_models_at_their_poses_are_the_masks_and_the_depths(folder):
    camera = table(folder, "scene_camera")["0"]
    matrix = np.array(camera["cam_K"]).reshape(3, 3)
    poses, infos = table(folder, "scene_gt")["0"], table(folder, "scene_gt_info")["0"]
    assert len(poses) == len(infos) == 5
    depth = picture(folder, "depth/000000.png") * camera["depth_scale"]
    for number, (pose, info) in enumerate(zip(poses, infos)):
        again = drawn(folder, pose, matrix)
        whole = picture(folder, f"mask/000000_{number:06d}.png") > 0
        visible = picture(folder, f"mask_visib/000000_{number:06d}.png") > 0
        assert (np.isfinite(again) != whole).sum() <= max(3, 0.01 * whole.sum())  # where a ray meets an edge
        assert not (visible & ~whole).any()
        both = visible & np.isfinite(again)
        assert np.abs(again[both] - depth[both]).max() < 0.6  # half a step of 0.1 mm, and coarse spheres
        assert info["px_count_visib"] == visible.sum()
        assert info["px_count_valid"] == whole.sum()
        rows, columns = np.flatnonzero(visible.any(axis=1)), np.flatnonzero(visible.any(axis=0))
        expected = [columns[0], rows[0], columns[-1] - columns[0], rows[-1] - rows[0]]
        assert info["bbox_visib"] == [int(each) for each in expected]
        assert info["visib_fract"] == pytest.approx(info["px_count_visib"] / info["px_count_all"])
        assert np.allclose(
            np.array(pose["cam_R_m2c"]).reshape(3, 3) @ np.array(pose["cam_R_m2c"]).reshape(3, 3).T,
            np.eye(3),
            atol=1e-5,
        )


def test_what_reaches_out_of_the_picture_counts_whole(folder):
    names = [each["name"] for each in json.loads((folder / ".usdsdg/classes.json").read_text())["tables"][0]["classes"]]
    poses, infos = table(folder, "scene_gt")["0"], table(folder, "scene_gt_info")["0"]
    [ball] = [info for pose, info in zip(poses, infos) if pose["obj_id"] == names.index("ball") + 1]
    [hat] = [info for pose, info in zip(poses, infos) if pose["obj_id"] == names.index("hat") + 1]
    assert ball["bbox_obj"][0] < 0
    assert ball["px_count_all"] > ball["px_count_valid"]
    assert hat["px_count_all"] == hat["px_count_valid"]


def test_models_are_in_millimeters(folder):
    info = json.loads((folder / "models/models_info.json").read_text())
    names = [each["name"] for each in json.loads((folder / ".usdsdg/classes.json").read_text())["tables"][0]["classes"]]
    box = info[str(names.index("box") + 1)]
    sizes = [box[f"size_{axis}"] for axis in "xyz"]
    assert np.allclose(sizes, (400, 300, 200), atol=0.01)
    assert box["diameter"] == pytest.approx(np.linalg.norm((400, 300, 200)), abs=0.02)
    assert np.allclose([box[f"min_{axis}"] for axis in "xyz"], (-200, -150, -100), atol=0.01)
    assert sorted(int(each) for each in info) == [1, 2, 3, 4, 5]
    assert json.loads((folder / "models/names.json").read_text()) == {str(n): names[n - 1] for n in range(1, 6)}


def test_frames_scenes_and_far_depths(stage, tmp_path):
    first = scene()
    camera = rep.functional.create.camera(position=(0, -300, 60), look_at=(0, 0, 20), clipping_range=(1, 100000))
    second = rep.create.render_product(camera, (WIDTH, HEIGHT))
    with pytest.warns(UsdsdgWarning, match=r"beyond 1.31 m has the depth 0"):
        folder = write(tmp_path, [first, second], steps=2, depth_scale=0.02, split="val")
    assert sorted(path.name for path in (folder / "val").iterdir()) == ["000000", "000001"]
    poses = json.loads((folder / "val/000001/scene_gt.json").read_text())
    assert list(poses) == ["0", "1"]
    assert (np.array(Image.open(folder / "val/000001/depth/000001.png")) == 0).all()


def test_shapes_and_scales_of_a_class_are_models_of_their_own(stage, tmp_path):
    create = rep.functional.create
    for x, scale in ((0, 0.2), (1, 0.2), (2, 0.3)):
        create.cube(position=(x, 0, 0), scale=scale, rotation=(x * 20, 0, 0), semantics={"class": "box"})
    product = rep.create.render_product(create.camera(position=(1, -6, 0), look_at=(1, 0, 0)), (WIDTH, HEIGHT))
    with pytest.warns(UsdsdgWarning, match="objects of the class 'box' differ in shape or scale"):
        folder = write(tmp_path, product)
    assert [each["obj_id"] for each in table(folder, "scene_gt")["0"]] == [1, 1, 1001]


def shaped(folder, edit, steps):
    """Write the frames of a labeled mesh of one triangle, before each of which `edit` changes it."""
    create = rep.functional.create
    create.cube(position=(-2, 0, 0), scale=0.2, semantics={"class": "box"})
    create.xform(name="group", position=(0.5, 0, 0), semantics={"class": "sail"})
    mesh = UsdGeom.Mesh.Define(current_stage(), "/group/mesh")
    mesh.CreatePointsAttr([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0, 0, 0.5)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.CreateDoubleSidedAttr(True)
    product = rep.create.render_product(create.camera(position=(0, -6, 0), look_at=(0, 0, 0)), (WIDTH, HEIGHT))
    writer = rep.WriterRegistry.get("BopWriter")
    writer.initialize(output_dir=str(folder))
    writer.attach(product)
    for step in range(steps):
        edit(step, mesh)
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()
    poses = table(folder, "scene_gt")
    info = json.loads((folder / "models/models_info.json").read_text())
    return [[each["obj_id"] for each in poses[str(step)]] for step in range(steps)], info


def test_another_shape_in_a_later_frame_is_a_model_of_its_own(stage, tmp_path):
    forget_warnings()

    def edit(step, mesh):
        size = (0.5, 0.5, 0.8, 0.8, 0.5)[step]
        mesh.GetPointsAttr().Set([(-size, 0, -size), (size, 0, -size), (0, 0, size)])
        UsdGeom.XformCommonAPI(mesh.GetPrim().GetParent()).SetTranslate((step * 0.1, 0, 0))

    with pytest.warns(UsdsdgWarning, match="objects of the class 'sail' differ in shape"):
        ids, info = shaped(tmp_path, edit, 5)
    assert ids == [[1, 2], [1, 2], [1, 1002], [1, 1002], [1, 2]]
    assert {key: round(each["size_x"]) for key, each in info.items()} == {"1": 200, "2": 1000, "1002": 1600}


def test_another_prim_below_is_another_shape(stage, tmp_path):
    def edit(step, mesh):
        if step == 1:
            mesh.GetPrim().SetActive(False)
            rep.functional.create.cube(parent="/group", scale=0.5)

    ids, info = shaped(tmp_path, edit, 2)
    assert ids == [[1, 2], [1, 1002]]
    assert round(info["1002"]["size_y"]) == 500


def test_a_shape_that_is_another_in_every_frame_has_few_models(stage, tmp_path):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="/group deforms, and BOP's models are rigid"):
        ids, info = shaped(
            tmp_path,
            lambda step, mesh: mesh.GetPointsAttr().Set([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0, 0, 0.3 + step * 0.05)]),
            MOST_SHAPES + 3,
        )
    assert len(info) == 1 + MOST_SHAPES
    assert ids[-4:] == [[1, ids[-1][1]]] * 4


def _sampled_points(mesh):
    mesh.GetPointsAttr().Set([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0, 0, 0.5)], 0)
    mesh.GetPointsAttr().Set([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0, 0, 0.9)], 24)


def _moved_part(mesh):
    move = mesh.AddTranslateOp()
    move.Set((0, 0, 0), 0)
    move.Set((0, 0, 1), 24)


def _skinned(mesh):
    stage = mesh.GetPrim().GetStage()
    UsdSkel.Root.Define(stage, "/group")
    skeleton = UsdSkel.Skeleton.Define(stage, "/group/bones")
    UsdSkel.BindingAPI.Apply(mesh.GetPrim()).CreateSkeletonRel().SetTargets([skeleton.GetPath()])


@pytest.mark.parametrize(
    ("deform", "why"),
    [
        (_sampled_points, r"points of /group/mesh has time samples"),
        (_moved_part, r"/group/mesh moves within it"),
        (_skinned, r"/group/mesh is skinned"),
    ],
)
def test_a_prim_that_deforms_over_time_is_named(stage, tmp_path, deform, why):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match=rf"/group deforms \({why}\), and its model is rigid"):
        shaped(tmp_path, lambda step, mesh: deform(mesh), 1)


def test_a_part_with_a_label_of_its_own_deforms_nothing(stage, tmp_path, recwarn):
    def edit(step, mesh):
        add_labels(mesh.GetPrim(), {"class": "cloth"})
        _moved_part(mesh)
        rep.functional.create.cube(parent="/group", scale=0.2)

    forget_warnings()
    shaped(tmp_path, edit, 1)
    assert not [each for each in recwarn if "deforms" in str(each.message)]


def test_labeled_parts_are_not_in_the_model_of_the_whole(stage, tmp_path):
    create = rep.functional.create
    create.xform(name="car", semantics={"class": "car"})
    create.cube(parent="/car", scale=0.5)
    create.sphere(parent="/car", position=(0, 0, 0.6), scale=0.2, semantics={"class": "lamp"})
    UsdGeom.Xformable(current_stage().GetPrimAtPath("/car")).AddTranslateOp(opSuffix="far").Set(Gf.Vec3d(0, 1, 0))
    product = rep.create.render_product(create.camera(position=(0, -6, 0), look_at=(0, 0, 0)), (WIDTH, HEIGHT))
    folder = write(tmp_path, product)
    info = json.loads((folder / "models/models_info.json").read_text())
    assert [round(info[number]["size_z"]) for number in ("1", "2")] == [500, 200]


def test_subsets_that_are_told_apart_have_models_of_their_faces(stage, tmp_path):
    rep.settings.carb_settings("/syntheticdata/sensors/perSubsetSegmentation", True)
    cube = rep.functional.create.cube(rotation=(20, 30, 40), semantics={"class": "box"}, as_mesh=True)
    mesh = UsdGeom.Mesh(next(each for each in Usd.PrimRange(cube) if each.IsA(UsdGeom.Mesh)))
    for name, faces in (("lid", [0, 3, 5]), ("plain", [1])):
        part = UsdGeom.Subset.CreateGeomSubset(mesh, name, "face", faces)
        if name == "lid":
            add_labels(part.GetPrim(), {"class": ["lid"]})
    camera = rep.functional.create.camera(position=(0, -5, 1), look_at=(0, 0, 0))
    folder = write(tmp_path, rep.create.render_product(camera, (WIDTH, HEIGHT)))
    poses = table(folder, "scene_gt")["0"]
    matrix = np.array(table(folder, "scene_camera")["0"]["cam_K"]).reshape(3, 3)
    assert len(poses) == 2
    for number, pose in enumerate(poses):
        whole = picture(folder, f"mask/000000_{number:06d}.png") > 0
        assert whole.sum() > 50
        assert (np.isfinite(drawn(folder, pose, matrix)) != whole).sum() <= 3  # where a ray meets an edge
    assert verify(folder).faults == []


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"depth_scale": 0.0}, "expected millimeters above 0"),
        ({"image_output_format": "exr"}, "expected png or jpg"),
        ({"split": "a/b"}, "expected the name of a folder"),
    ],
)
def test_options_that_cannot_be(tmp_path, options, reason):
    with pytest.raises(WriterError, match=reason):
        rep.WriterRegistry.get("BopWriter", init_params={"output_dir": str(tmp_path), **options})


def test_an_object_that_is_scaled_to_nothing_is_not_drawn_and_ends_nothing(stage, tmp_path):
    for name, depth in (("card", 0.0), ("box", 0.5)):
        cube = UsdGeom.Cube.Define(stage, f"/World/{name}")
        cube.AddScaleOp().Set(Gf.Vec3f(0.5, 0.5, depth))
        add_labels(cube.GetPrim(), {"class": [name]})
    camera = rep.functional.create.camera(position=(0, -4, 0), look_at=(0, 0, 0))
    with pytest.warns(UsdsdgWarning, match="/World/card: its transform"):
        folder = write(tmp_path, rep.create.render_product(camera, (32, 32)))
    assert len(table(folder, "scene_gt")["0"]) == 1
    assert json.loads((folder / "models" / "names.json").read_text()) == {"1": "box"}


@pytest.mark.parametrize("kind", ["BopWriter", "YCBVideoWriter"])
@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_poses_that_are_no_numbers_end_nothing(stage, tmp_path, kind, number):
    """An object, a part of another one, and a point of an instancer."""
    add_labels(UsdGeom.Xform.Define(stage, "/World/car").GetPrim(), {"class": ["car"]})
    for path in ("/World/lost", "/World/car/body", "/World/car/lost"):
        cube = UsdGeom.Cube.Define(stage, path)
        cube.CreateSizeAttr(1.0)
        cube.AddTranslateOp().Set(Gf.Vec3d(number if path.endswith("lost") else 0.0, 0, 0))
    add_labels(stage.GetPrimAtPath("/World/lost"), {"class": ["can"]})
    points = UsdGeom.PointInstancer.Define(stage, "/World/points")
    add_labels(UsdGeom.Cube.Define(stage, "/World/points/mug").GetPrim(), {"class": ["mug"]})
    points.CreatePrototypesRel().SetTargets(["/World/points/mug"])
    points.CreateProtoIndicesAttr([0])
    points.CreatePositionsAttr([Gf.Vec3f(number, 0, 0)])
    camera = rep.functional.create.camera(position=(0, -4, 0), look_at=(0, 0, 0))
    own = {"num_frames": 1, "exact": True, "pose": True, "class_name_to_index_map": {"car": 1, "can": 2, "mug": 3}}
    options = own if kind == "YCBVideoWriter" else {}
    writer = rep.WriterRegistry.get(kind, init_params={"output_dir": str(tmp_path), **options})
    writer.attach(rep.create.render_product(camera, (32, 32)))
    rep.orchestrator.step(delta_time=0.0)
    writer.detach()
    rep.orchestrator.wait_until_complete()
    if kind == "BopWriter":
        [model] = json.loads((tmp_path / "models/models_info.json").read_text()).values()
        assert [model[f"size_{axis}"] for axis in "xyz"] == [1000.0] * 3
    else:
        found = np.loadtxt(tmp_path / "data/models/car/points.xyz")
        np.testing.assert_allclose(np.ptp(found, axis=0), 1.0)


def test_models_of_concave_faces_and_tapered_shapes_are_their_masks(stage, tmp_path):
    rep.settings.set_stage_meters_per_unit(0.01)
    outline = [(-20, -20), (20, -20), (20, 0), (0, 0), (0, 20), (-20, 20)]
    sheet = UsdGeom.Mesh.Define(stage, "/L")
    sheet.CreatePointsAttr([(x - 30, 0, y) for x, y in outline])
    sheet.CreateFaceVertexCountsAttr([6])
    sheet.CreateFaceVertexIndicesAttr([1, 2, 3, 4, 5, 0])
    rod, pill = UsdGeom.Cylinder_1.Define(stage, "/Rod"), UsdGeom.Capsule_1.Define(stage, "/Pill")
    for shape, place, axis in ((rod, (20, 0, -15), "X"), (pill, (25, 0, 20), "Y")):
        shape.CreateRadiusBottomAttr(12.0)
        shape.CreateRadiusTopAttr(5.0)
        shape.CreateHeightAttr(25.0)
        shape.CreateAxisAttr(axis)
        UsdGeom.XformCommonAPI(shape).SetTranslate(place)
        UsdGeom.XformCommonAPI(shape).SetRotate((0, 0, 60))
    for shape in (sheet, rod, pill):
        add_labels(shape.GetPrim(), {"class": [shape.GetPrim().GetName()]})
    camera = rep.functional.create.camera(position=(0, -200, 0), look_at=(0, 0, 0), clipping_range=(1, 100000))
    folder = write(tmp_path, rep.create.render_product(camera, (WIDTH, HEIGHT)))
    matrix = np.array(table(folder, "scene_camera")["0"]["cam_K"]).reshape(3, 3)
    poses = table(folder, "scene_gt")["0"]
    assert len(poses) == 3
    for number, pose in enumerate(poses):
        whole = picture(folder, f"mask/000000_{number:06d}.png") > 0
        again = np.isfinite(drawn(folder, pose, matrix))
        assert whole.sum() > 100
        assert (again != whole).sum() <= max(3, 0.02 * whole.sum())


def test_parts_without_faces_are_named(stage, tmp_path):
    group = UsdGeom.Xform.Define(stage, "/Group")
    add_labels(group.GetPrim(), {"class": ["lamp"]})
    UsdGeom.Cube.Define(stage, "/Group/Cube")
    wire = UsdGeom.BasisCurves.Define(stage, "/Group/Wire")
    wire.CreatePointsAttr([(0, 0, 0), (0, 0, 3)])
    wire.CreateCurveVertexCountsAttr([2])
    wire.CreateTypeAttr("linear")
    UsdGeom.NurbsPatch.Define(stage, "/Group/Shade")
    camera = rep.functional.create.camera(position=(0, -20, 0), look_at=(0, 0, 0))
    with pytest.warns(UsdsdgWarning) as caught:
        write(tmp_path, rep.create.render_product(camera, (WIDTH, HEIGHT)))
    said = [str(each.message) for each in caught]
    for part, kind in (("Wire", "BasisCurves"), ("Shade", "NurbsPatch")):
        named = f"/Group/{part}: no faces are read of {kind}, so that the model of /Group is without it"
        assert any(each.startswith(named) for each in said)


@pytest.mark.parametrize(("near", "far"), [(0.1, 100.0), (9.9, 100.0), (0.1, 9.9)])
def test_ends_that_no_ray_hits_and_what_is_clipped_verify(stage, tmp_path, near, far):
    """A blade that is pointed, where rays miss its tip, and a box of which the near or the far plane leaves a half."""
    stage = current_stage()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    blade = UsdGeom.Mesh.Define(stage, "/blade")
    blade.CreatePointsAttr([(-1, -0.2, 0), (-1, 0.2, 0), (2, 0.03, 0)])
    blade.CreateFaceVertexCountsAttr([3])
    blade.CreateFaceVertexIndicesAttr([0, 1, 2])
    blade.CreateSubdivisionSchemeAttr("none")
    blade.AddTranslateOp().Set((0, 1.2, 0))
    box = UsdGeom.Cube.Define(stage, "/box")
    box.CreateSizeAttr(1.0)
    box.AddRotateYOp().Set(45.0)
    box.AddScaleOp().Set(Gf.Vec3f(3, 0.5, 0.5))
    for prim in (blade.GetPrim(), box.GetPrim()):
        add_labels(prim, {"class": [prim.GetName()]})
    camera = UsdGeom.Camera.Define(stage, "/eye")
    camera.AddTranslateOp().Set((0, 0, 10))
    camera.CreateFocalLengthAttr(35.0)
    camera.CreateClippingRangeAttr((near, far))
    folder = write(tmp_path, rep.create.render_product("/eye", (WIDTH, HEIGHT)))
    report = verify(folder)
    assert report.formats["BopWriter"] == 1
    assert not [fault for fault in report.faults if "projects" in fault.what]


@pytest.mark.parametrize("shift", [(0, 0), (4, 0), (0, -4)])
def test_a_pose_that_is_off_by_pixels_is_found(stage, tmp_path, shift):
    folder = write(tmp_path, scene())
    file = folder / "train_pbr/000000/scene_gt.json"
    poses, camera = table(folder, "scene_gt"), table(folder, "scene_camera")["0"]
    for axis in (0, 1):
        pose = poses["0"][0]["cam_t_m2c"]
        pose[axis] += shift[axis] * pose[2] / camera["cam_K"][0]
    file.write_text(json.dumps(poses))
    found = [fault for fault in verify(folder).faults if "object 0 projects to its box" in fault.what]
    assert bool(found) == any(shift)

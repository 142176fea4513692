"""Annotators beyond Replicator's, against other ways to the same: pictures rendered anew, and a ray caster in NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

import usdsdg as rep
from tests.annotators import ray_caster
from tests.annotators.ray_caster import CAMERA, RayCaster, add_cube, place
from tests.annotators.scenes import add_camera
from tests.stage.geometry.characters import add_character
from usdsdg.errors import AnnotatorError
from usdsdg.session.stage_context import set_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.semantics.labels import add_labels

SIZE = (96, 64)


def attached(name, product, **params):
    return rep.annotators.get(name, init_params=params).attach(product)


@pytest.fixture
def stage():
    """Boxes seen from above at a slant, some of them beside the picture's edges, one behind another."""
    stage = set_stage(ray_caster.new_stage())
    UsdGeom.Xformable(stage.GetPrimAtPath(CAMERA)).ClearXformOpOrder()
    UsdGeom.Xformable(stage.GetPrimAtPath(CAMERA)).AddTransformOp().Set(
        look_at_matrix((0, -9, 6), (0, 0, 0), up=(0, 0, 1))
    )
    add_cube(stage, "/World/Ground", translate=(0, 0, -1), scale=(40, 40, 0.2))
    add_cube(stage, "/World/Middle", "middle", rotate=(10, 20, 30), scale=(1, 2, 0.5))
    add_cube(stage, "/World/Behind", "behind", translate=(0.4, 2.5, 0.3), rotate=(0, 0, 40), scale=(1, 1, 1.5))
    add_cube(stage, "/World/Left", "left", translate=(-4.4, 0.5, 0), rotate=(0, 0, 20), scale=(3, 1, 1))
    add_cube(stage, "/World/Low", "low", translate=(1.5, -4.2, 0), rotate=(50, 0, 0))
    add_cube(stage, "/World/Far", "far", translate=(0, 60, 0))
    pair = UsdGeom.Xform.Define(stage, "/World/Pair").GetPrim()
    place(pair, translate=(3, 1, 0), rotate=(0, 0, -25), scale=(1, 1, 1.2))
    add_labels(pair, {"class": "pair"})
    add_cube(stage, "/World/Pair/a", translate=(0, 0, 0), scale=(0.5, 0.5, 1))
    add_cube(stage, "/World/Pair/b", translate=(0.9, 0, 0), rotate=(0, 45, 0), scale=(0.7, 0.5, 0.5))
    return stage


def rows_of(data):
    return dict(zip(data["info"]["primPaths"], data["data"], strict=True))


# --- truncation ---


def test_boxes_and_truncation_are_those_of_a_picture_three_times_as_large(stage):
    product = rep.create.render_product(CAMERA, SIZE)
    wide_camera = UsdGeom.Camera.Define(stage, "/World/Wide")
    camera = UsdGeom.Camera(stage.GetPrimAtPath(CAMERA))
    camera.CreateHorizontalApertureOffsetAttr(1.5)
    camera.CreateVerticalApertureOffsetAttr(-0.8)
    wide_camera.AddTransformOp().Set(camera.GetLocalTransformation())
    wide_camera.CreateFocalLengthAttr(camera.GetFocalLengthAttr().Get())
    wide_camera.CreateHorizontalApertureAttr(3 * camera.GetHorizontalApertureAttr().Get())
    wide_camera.CreateHorizontalApertureOffsetAttr(1.5)
    wide_camera.CreateVerticalApertureOffsetAttr(-0.8)
    wide_camera.CreateClippingRangeAttr(camera.GetClippingRangeAttr().Get())
    wide = rep.create.render_product("/World/Wide", (3 * SIZE[0], 3 * SIZE[1]))
    boxes, ratios = attached("bounding_box_2d_amodal", product), attached("truncation", product)
    whole, seen = attached("visibility", wide), attached("visibility", product)
    rep.orchestrator.step()
    found, expected, inside = rows_of(boxes.get_data()), rows_of(whole.get_data()), rows_of(seen.get_data())
    assert set(found) == set(inside)
    assert {path for path in found if found[path]["truncationRatio"] > 0} >= {"/World/Left", "/World/Low"}
    for path, row in found.items():
        other = expected[path]
        corners = [row[name] for name in ("x_min", "y_min", "x_max", "y_max")]
        assert corners == [
            other["x_min"] - SIZE[0], other["y_min"] - SIZE[1], other["x_max"] - SIZE[0], other["y_max"] - SIZE[1]
        ]  # fmt: skip
        share = 1 - inside[path]["amodalPixels"] / other["amodalPixels"]
        assert row["truncationRatio"] == pytest.approx(share, abs=1e-6)
    np.testing.assert_array_equal(ratios.get_data()["truncationRatio"], boxes.get_data()["data"]["truncationRatio"])


def test_a_fisheye_sees_on_beyond_its_picture_and_a_panorama_has_nothing_beyond(stage, monkeypatch):
    camera = stage.GetPrimAtPath(CAMERA)
    half = np.radians(25)  # at the left and right edge
    UsdGeom.Camera(camera).CreateHorizontalApertureAttr(20.0)
    UsdGeom.Camera(camera).CreateFocalLengthAttr(10.0 / np.tan(half))
    camera.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeEquidistant")
    product = rep.create.render_product(CAMERA, SIZE)
    boxes = attached("bounding_box_2d_amodal", product)
    rep.orchestrator.step()
    found = rows_of(boxes.get_data())
    view = read_camera(stage, CAMERA, SIZE)
    # The formula of the lens, for pixels around the picture too.
    v, u = np.mgrid[-SIZE[1] : 2 * SIZE[1], -SIZE[0] : 2 * SIZE[0]] + 0.5
    x, y = (u - SIZE[0] / 2).ravel(), (SIZE[1] / 2 - v).ravel()
    radius = np.hypot(x, y)
    angle = radius / (SIZE[0] / 2) * half
    in_camera = np.stack([np.sin(angle) * x / radius, np.sin(angle) * y / radius, -np.cos(angle)], axis=1)
    caster, directions = RayCaster(stage), in_camera @ view.local_to_world[:3, :3]
    origins = np.broadcast_to(view.local_to_world[3, :3], directions.shape)
    for path in ("/World/Left", "/World/Low", "/World/Middle"):
        hit, _ = caster._intersect(caster.gprims.index(path), origins, directions, view.clipping_range)
        covered = np.isfinite(hit).reshape(u.shape) & (angle.reshape(u.shape) < np.pi)
        rows, columns = np.nonzero(covered)
        expected = columns.min() - SIZE[0], rows.min() - SIZE[1], columns.max() - SIZE[0], rows.max() - SIZE[1]
        corners = [found[path][name] for name in ("x_min", "y_min", "x_max", "y_max")]
        np.testing.assert_allclose(corners, expected, atol=1)
        inside = covered[SIZE[1] : 2 * SIZE[1], SIZE[0] : 2 * SIZE[0]].sum()
        assert found[path]["truncationRatio"] == pytest.approx(1 - inside / covered.sum(), abs=0.01)
    camera.GetAttribute("cameraProjectionType").Set("fisheyeSpherical")
    rep.orchestrator.step()
    assert not boxes.get_data()["data"]["truncationRatio"].any()


# --- object coordinates ---


def test_object_coordinates_are_positions_in_the_boxes(stage):
    product = rep.create.render_product(CAMERA, SIZE)
    coordinates, picture = (
        attached("object_coordinates", product),
        attached("object_coordinates", product, colorize=True),
    )
    masks = attached("instance_segmentation_fast", product)
    rep.orchestrator.step()
    view, caster = read_camera(stage, CAMERA, SIZE), RayCaster(stage)
    aovs = caster.labels(view)
    found, names = coordinates.get_data(), masks.get_data()["info"]["idToLabels"]
    assert found["data"].shape == (SIZE[1], SIZE[0], 4)
    assert set(found["info"]["primPaths"]) == set(names.values()) - {"BACKGROUND", "UNLABELLED"}
    ids = masks.get_data()["data"]
    for path, box in zip(found["info"]["primPaths"], found["info"]["boxes"], strict=True):
        number = next(key for key, name in names.items() if name == path)
        world_to_prim = np.linalg.inv(
            np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(path)))
        )
        below = [k for k, gprim in enumerate(caster.gprims) if gprim.startswith(path)]
        shown = (ids == number) & np.isin(aovs["instance"], below)  # rounding may differ at edges
        assert shown.sum() >= 0.95 * (ids == number).sum() > 10
        local = aovs["position"][shown].astype(float) @ world_to_prim[:3, :3] + world_to_prim[3, :3]
        expected = (local - box[0]) / (box[1] - box[0])
        np.testing.assert_allclose(found["data"][shown][:, :3], expected, atol=1e-4)
        assert (found["data"][shown][:, 3] == 1).all()
    assert not found["data"][ids < 2].any()
    np.testing.assert_array_equal(picture.get_data()["data"], np.floor(found["data"] * 255 + 0.5).astype(np.uint8))


def test_object_coordinates_do_not_change_with_the_pose(stage):
    product = rep.create.render_product(CAMERA, SIZE)
    coordinates = attached("object_coordinates", product)
    rep.orchestrator.step()
    before = coordinates.get_data()["data"]
    # Everything moves together, to where float32 has 2 mm left.
    for prim in stage.GetPrimAtPath("/World").GetChildren():
        op = UsdGeom.Xformable(prim).AddTranslateOp(opSuffix="far")
        order = UsdGeom.Xformable(prim).GetXformOpOrderAttr()
        order.Set([order.Get()[-1], *order.Get()[:-1]])
        op.Set(Gf.Vec3d(20000, 10000, 0))
    rep.orchestrator.step()
    after = coordinates.get_data()["data"]
    same = (before[..., 3] == after[..., 3]).mean()
    assert same > 0.99
    both = (before[..., 3] == 1) & (after[..., 3] == 1)
    assert np.median(np.abs(before - after)[both]) < 2e-3


# --- keypoints ---


def closest_hits(stage, origin, points):
    """Return the distance of the first of all cubes toward each point, and its path."""
    caster = RayCaster(stage)
    lines = points - origin
    directions = lines / np.linalg.norm(lines, axis=1)[:, None]
    origins = np.broadcast_to(origin, directions.shape)
    hits = np.array([caster._intersect(k, origins, directions, None)[0] for k in range(len(caster.gprims))])
    return hits.min(axis=0), [caster.gprims[k] for k in hits.argmin(axis=0)]


def test_keypoints_are_projected_and_hidden_as_rays_say(stage):
    rng = np.random.default_rng(1)
    local = {}
    for name in ("Middle", "Behind", "Left", "Low", "Far", "Pair/a"):
        faces = rng.uniform(-0.5, 0.5, (8, 3))
        faces[np.arange(8), rng.integers(0, 3, 8)] = rng.choice([-0.5, 0.5], 8)
        local[name] = {f"point_{k}": faces[k] for k in range(8)} | {"center": (0.0, 0.0, 0.0)}
        rep.functional.modify.keypoints(f"/World/{name}", local[name])
    product = rep.create.render_product(CAMERA, SIZE)
    found, masks = attached("keypoints", product), attached("instance_segmentation_fast", product)
    rep.orchestrator.step()
    rows, info = found.get_data()["data"], found.get_data()["info"]
    view = read_camera(stage, CAMERA, SIZE)
    assert info["keypointNames"] == ["center", *(f"point_{k}" for k in range(8))]
    assert len(rows) == 6 * 9
    ids = {name: key for key, name in masks.get_data()["info"]["idToLabels"].items()}
    states = []
    for row, path in zip(rows, info["primPaths"], strict=True):
        matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(path)))
        point = np.append(local[path[7:]][info["keypointNames"][row["keypointId"]]], 1) @ matrix
        np.testing.assert_allclose(row["position"], point[:3], atol=1e-4)
        x, y, z, _ = point @ view.world_to_camera
        focal = SIZE[0] * view.focal_length / view.horizontal_aperture
        pixel = np.array([SIZE[0] / 2 + focal * x / -z, SIZE[1] / 2 - focal * y / -z])
        np.testing.assert_allclose((row["x"], row["y"]), pixel, atol=1e-3)
        distance, hit = closest_hits(stage, view.local_to_world[3, :3], point[None, :3])
        far = np.linalg.norm(point[:3] - view.local_to_world[3, :3])
        assert row["distance"] == pytest.approx(far, rel=1e-5)
        inside = (pixel >= 0).all() and (pixel < SIZE).all()
        visible = distance[0] >= far - 0.005
        assert row["visibility"] == (0 if not inside else 2 if visible else 1), (path, row)
        owner = "/World/Pair" if hit[0].startswith("/World/Pair") else hit[0]
        assert row["hiddenBy"] == (ids.get(owner, 1) if inside and not visible else 0)
        own = "/World/Pair" if path.startswith("/World/Pair") else path
        assert row["instanceId"] == ids.get(own, row["instanceId"])
        states.append(row["visibility"])
    assert np.bincount(states).min() >= 5


@pytest.mark.parametrize(
    "projection", ["orthographic", "from within", "fisheyeEquidistant", "fisheyeSpherical", "omniDirectionalStereo"]
)
def test_keypoints_of_every_kind_of_lens_are_where_the_pixel_of_their_surface_is(stage, projection):
    camera = UsdGeom.Camera(stage.GetPrimAtPath(CAMERA))
    if projection == "orthographic":
        camera.CreateProjectionAttr("orthographic")
        camera.CreateHorizontalApertureAttr(100.0)
    elif projection == "from within":  # with its near plane behind it, above everything
        camera.CreateProjectionAttr("orthographic")
        camera.CreateHorizontalApertureAttr(100.0)
        camera.CreateClippingRangeAttr(Gf.Vec2f(-20.0, 5.0))
        camera.AddTranslateOp(opSuffix="down").Set(Gf.Vec3d(0, 0, -12))
    else:
        camera.GetPrim().CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set(projection)
    names = {f"p{k}": (0.4 * (k % 3 - 1), 0.4 * (k // 3 - 1), 0.5) for k in range(9)}
    rep.functional.modify.keypoints("/World/Middle", names)
    product = rep.create.render_product(CAMERA, (192, 128))
    found, points = attached("keypoints", product), attached("PtWorldPos", product)
    distance = attached("distance_to_camera", product)
    rep.orchestrator.step()
    world = points.get_data()[..., :3].astype(float)
    visible = found.get_data()["data"][found.get_data()["data"]["visibility"] == 2]
    assert len(visible) >= 6
    for row in visible:
        column, line = int(row["x"]), int(row["y"])
        nearby = slice(max(line - 1, 0), line + 2), slice(max(column - 1, 0), column + 2)
        around, far = world[nearby].reshape(-1, 3), distance.get_data()[nearby].ravel()
        step = np.ptp(around, axis=0).max()
        apart = np.linalg.norm(around - row["position"], axis=1)
        assert apart.min() < step + 0.02
        assert abs(row["distance"] - far[apart.argmin()]) < apart.min() + 0.02


def test_keypoints_of_instances_point_instances_and_hidden_prims(stage):
    for home in ("/Lib/peg", "/Proto/peg"):
        UsdGeom.Xform.Define(stage, home[:-4])
        UsdGeom.Xform.Define(stage, home)
        add_cube(stage, f"{home}/mesh", scale=(0.2, 0.2, 0.2))
        rep.functional.modify.keypoints(home, {"tip": (0, 0, 0.1)})
        add_labels(stage.GetPrimAtPath(home), {"class": "peg"})
    UsdGeom.Imageable(stage.GetPrimAtPath("/Lib")).MakeInvisible()
    instance = stage.DefinePrim("/World/Instance/peg", "Xform")
    instance.GetReferences().AddInternalReference("/Proto/peg")
    instance.SetInstanceable(True)
    UsdGeom.Xformable(instance).AddTranslateOp().Set(Gf.Vec3d(0, -2, 0.5))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Points")
    instancer.CreatePrototypesRel().SetTargets(["/World/Points/peg"])
    stage.DefinePrim("/World/Points/peg", "Xform").GetReferences().AddInternalReference("/Proto/peg")
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(-1, -3, 0.5), Gf.Vec3f(1, -3, 0.5)])
    UsdGeom.Imageable(stage.GetPrimAtPath("/Proto")).MakeInvisible()
    found = attached("keypoints", rep.create.render_product(CAMERA, SIZE))
    rep.orchestrator.step()
    info = found.get_data()["info"]
    at = dict(zip(info["primPaths"], found.get_data()["data"]["position"].tolist(), strict=True))
    assert {path for path in at if path.startswith("/World")} == {
        "/World/Instance/peg", "/World/Points/peg[0]", "/World/Points/peg[1]"
    }  # fmt: skip
    assert not any(path.startswith(("/Lib", "/Proto")) for path in at)
    np.testing.assert_allclose(at["/World/Points/peg[1]"], (1, -3, 0.6), atol=1e-6)
    np.testing.assert_allclose(at["/World/Instance/peg"], (0, -2, 0.6), atol=1e-6)
    ids = found.get_data()["data"]["instanceId"]
    assert len(set(ids.tolist())) == 3
    assert 1 not in ids


# --- correspondence ---


def check_correspondence(stage, found, states, shown, moved_to, view):
    """Compare with rays: `shown` (H, W, 3) points of the first picture, NaN for none, `moved_to` (H, W, 3) them now."""
    some = np.isfinite(shown).all(axis=-1)
    points = moved_to[some]
    pixels, _ = view.project(points)
    assert np.isnan(found[~some]).all()
    assert not states[~some].any()
    np.testing.assert_allclose(found[some], pixels, atol=2e-2)
    near_edge = (np.abs(pixels - np.round(np.clip(pixels, 0, (view.width, view.height)))) < 1e-2).any(axis=1)
    inside = ((pixels >= 0) & (pixels < (view.width, view.height))).all(axis=1)
    distance, _ = closest_hits(stage, view.local_to_world[3, :3], points)
    far = np.linalg.norm(points - view.local_to_world[3, :3], axis=1)
    visible = distance > far * (1 - 1e-3)
    unsure = np.abs(distance - far * (1 - 5e-4)) < far * 1e-3
    expected = np.where(~inside, 0, np.where(visible, 2, 1))
    wrong = (states[some] != expected) & ~near_edge & ~(unsure & ~visible)
    assert wrong.mean() < 2e-3, np.bincount(expected[wrong])
    assert np.bincount(expected, minlength=3).min() > 30


def points_shown(stage, camera):
    """Return the points that pixels show, NaN for none, and the gprims, from the slow ray caster."""
    view = read_camera(stage, camera, SIZE)
    aovs = RayCaster(stage).labels(view)
    seen = aovs["instance"][..., None] >= 0
    origins, directions = ray_caster.rays(view)
    distance = aovs["distance_to_camera"].astype(float).ravel()[:, None]
    with np.errstate(invalid="ignore"):
        points = (origins + distance * directions).reshape(*aovs["instance"].shape, 3)
    return np.where(seen, points, np.nan), aovs["instance"]


def test_the_points_of_one_camera_are_found_in_another(stage):
    other = add_camera(stage, "/World/Other", (5, -7, 5), (0, 0.5, 0))
    product, second = rep.create.render_product(CAMERA, SIZE), rep.create.render_product(other, (80, 60))
    found = attached("dense_correspondence", product, camera=second.path)
    by_camera = attached("dense_correspondence", product, camera="/World/Other")
    rep.orchestrator.step()
    data = found.get_data()
    assert data["info"]["camera"] == "/World/Other"
    assert data["info"]["resolution"] == (80, 60)
    np.testing.assert_array_equal(data["data"], by_camera.get_data()["data"])
    shown, _ = points_shown(stage, CAMERA)
    check_correspondence(
        stage, data["data"], data["info"]["visibility"], shown, shown, read_camera(stage, other, (80, 60))
    )


def test_the_points_of_an_earlier_picture_are_found_where_their_objects_are_now(stage):
    product = rep.create.render_product(CAMERA, SIZE)
    found = attached("dense_correspondence", product, captures=1)
    rep.orchestrator.step()
    assert not found.get_data()["info"]["visibility"].any()
    shown, gprims = points_shown(stage, CAMERA)
    caster = RayCaster(stage)
    before = {path: matrix_of(stage, path) for path in caster.gprims}
    place(stage.GetPrimAtPath("/World/Middle"), translate=(1, 0.5, 0.2), rotate=(40, 0, 80), scale=(1, 2, 0.5))
    place(stage.GetPrimAtPath("/World/Pair"), translate=(2.5, 0, 0), rotate=(0, 0, 30), scale=(1, 1, 1.2))
    camera = UsdGeom.Xformable(stage.GetPrimAtPath(CAMERA))
    camera.GetOrderedXformOps()[0].Set(look_at_matrix((1, -9, 5), (0.5, 0, 0), up=(0, 0, 1)))
    rep.orchestrator.step()
    moved = np.full_like(shown, np.nan)
    for index, path in enumerate(caster.gprims):
        own = gprims == index
        local = np.append(shown[own], np.ones((own.sum(), 1)), axis=1) @ np.linalg.inv(before[path])
        moved[own] = (local @ matrix_of(stage, path))[:, :3]
    data = found.get_data()
    check_correspondence(
        stage, data["data"], data["info"]["visibility"], shown, moved, read_camera(stage, CAMERA, SIZE)
    )


def matrix_of(stage, path):
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(path)))


def test_points_of_what_is_gone_are_nowhere(stage):
    product = rep.create.render_product(CAMERA, SIZE)
    found, masks = (
        attached("dense_correspondence", product, captures=2),
        attached("instance_segmentation_fast", product),
    )
    rep.orchestrator.step()
    names = masks.get_data()["info"]["idToLabels"]
    middle = masks.get_data()["data"] == next(key for key, name in names.items() if name == "/World/Middle")
    rep.orchestrator.step()
    stage.RemovePrim("/World/Middle")
    rep.orchestrator.step()
    data = found.get_data()
    assert np.isnan(data["data"][middle]).all()
    assert not data["info"]["visibility"][middle].any()
    rows, columns = np.nonzero(data["info"]["visibility"] == 2)
    np.testing.assert_allclose(data["data"][rows, columns], np.stack([columns, rows], 1) + 0.5, atol=1e-2)
    assert len(rows) > 1000


@pytest.mark.parametrize("captures", [-1, 1.5, True])
def test_a_wrong_number_of_captures_is_refused(stage, captures):
    found = attached("dense_correspondence", rep.create.render_product(CAMERA, SIZE), captures=captures)
    with pytest.raises(AnnotatorError, match="captures"):
        rep.orchestrator.step()
    found.detach()


def test_points_of_a_skinned_character_move_with_its_skin(stage):
    add_character(stage, "/World/Man")
    place(stage.GetPrimAtPath(CAMERA), translate=(0, 0, 0))
    UsdGeom.Xformable(stage.GetPrimAtPath(CAMERA)).ClearXformOpOrder()
    bounds = UsdGeom.BBoxCache(Usd.TimeCode(0), ["default"]).ComputeWorldBound(stage.GetPrimAtPath("/World/Man"))
    middle, size = bounds.ComputeAlignedRange().GetMidpoint(), bounds.ComputeAlignedRange().GetSize().GetLength()
    for path in ("Ground", "Middle", "Behind", "Left", "Low", "Far", "Pair"):
        stage.RemovePrim(f"/World/{path}")
    UsdGeom.Xformable(stage.GetPrimAtPath(CAMERA)).AddTransformOp().Set(
        look_at_matrix(middle + Gf.Vec3d(0.3, -2, 0.4) * size, middle, up=(0, 0, 1))
    )
    product = rep.create.render_product(CAMERA, SIZE)
    rep.AnnotatorRegistry.register_annotator_from_aov(aov="prim", name="face")
    try:
        found, faces = attached("dense_correspondence", product, captures=1), attached("face", product)
        timeline = get_timeline()
        timeline.set_current_time(0.0)
        rep.orchestrator.step(delta_time=0.0)
        before = faces.get_data()
        timeline.set_current_time(8 / stage.GetTimeCodesPerSecond())
        rep.orchestrator.step(delta_time=0.0)
        after, data = faces.get_data(), found.get_data()
    finally:
        rep.AnnotatorRegistry.unregister_annotator("face")
    rows, columns = np.nonzero(data["info"]["visibility"] == 2)
    pixels = data["data"][rows, columns]
    assert len(rows) > 100
    assert np.abs(pixels - np.stack([columns, rows], 1) - 0.5).max() > 1  # it moved
    there = after[pixels[:, 1].astype(int), pixels[:, 0].astype(int)]
    # The center of the pixel there may show the face beside.
    assert (there == before[rows, columns]).mean() > 0.7

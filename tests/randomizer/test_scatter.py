"""Positions that `scatter_2d` and `scatter_3d` write."""

import numpy as np
import pytest
import trimesh
from pxr import Gf, UsdGeom

import usdsdg as rep
from tests.sampled_cases import in_soak
from usdsdg import errors
from usdsdg.errors import GraphError
from usdsdg.graph import evaluate
from usdsdg.scatter import positions as scatter_positions
from usdsdg.scatter.collisions import collide
from usdsdg.scatter.solid import Solids
from usdsdg.scatter.volume import inside
from usdsdg.session import stage_context
from usdsdg.stage.geometry.triangles import triangles_below
from usdsdg.stage.poses import transforms


def run():
    evaluate.graph().evaluate()


def positions(item):
    stage = stage_context.current_stage()
    return np.array([transforms.local_to_world(stage.GetPrimAtPath(path))[3] for path in item.prims])[:, :3]


def collisions(paths, others=()):
    """Return the pairs that collide, testing every pair."""
    stage = stage_context.current_stage()
    bodies = []
    for path in [*paths, *others]:
        prim = stage.GetPrimAtPath(path)
        origin = np.array(transforms.local_to_world(prim).ExtractTranslation())
        bodies.append((Solids().around(origin, triangles_below([prim])), origin))
    return [
        (i, j)
        for i in range(len(paths))
        for j in range(i + 1, len(bodies))
        if collide(bodies[i][0], bodies[j][0], bodies[j][1] - bodies[i][1])
    ]


def test_origins_lie_on_a_rotated_surface_at_the_given_offset(stage):
    floor = rep.create.plane(position=(1, 2, 3), rotation=(40, 20, 10), scale=(4, 2, 1))
    balls = rep.create.sphere(count=50, scale=0.1)
    rep.randomizer.scatter_2d(floor, offset=0.25, input_prims=balls)
    run()
    to_floor = np.linalg.inv(np.array(transforms.local_to_world(stage.GetPrimAtPath(f"{floor.prims[0]}/Plane"))))
    local = positions(balls) @ to_floor[:3, :3] + to_floor[3, :3]
    np.testing.assert_allclose(local[:, 2], 0.25, atol=1e-6)
    assert (np.abs(local[:, :2]) <= 0.5).all()
    assert local[:, 0].std() > 0.2


def test_bounds_clip_the_surface_and_parent_transforms_are_inverted(stage):
    parent = UsdGeom.Xform.Define(stage, "/World/cart")
    parent.AddTranslateOp().Set(Gf.Vec3d(3, 0, 0))
    parent.AddRotateXYZOp().Set(Gf.Vec3f(0, 0, 30))
    parent.AddScaleOp().Set(Gf.Vec3f(2))
    balls = rep.create.sphere(count=30, parent="/World/cart", scale=0.1)
    hill = rep.create.sphere(scale=4)
    rep.randomizer.scatter_2d(hill, min_samp=(None, -0.5, 0.5), max_samp=(None, 0.5, None), input_prims=balls)
    run()
    found = positions(balls)
    assert (np.abs(found[:, 1]) <= 0.5 + 1e-9).all()
    assert (found[:, 2] >= 0.5 - 1e-9).all()
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 2.0, rtol=0.01)


def test_objects_avoid_each_other_and_obstacles(stage):
    floor = rep.create.plane(scale=3)
    pillar = rep.create.cylinder(scale=(0.5, 0.5, 2))
    shapes = [rep.create.cube(count=20, scale=0.2, rotation=rep.distribution.uniform((0, 0, 0), (90, 90, 90)))]
    shapes.append(rep.create.torus(count=20, scale=0.3))
    run()
    paths = [path for item in shapes for path in item.prims]
    rep.randomizer.scatter_2d(floor, no_coll_prims=pillar, check_for_collisions=True, input_prims=paths)
    run()
    assert collisions(paths, pillar.prims) == []


def test_without_the_check_only_obstacles_are_avoided(stage):
    floor, pillar = rep.create.plane(scale=2), rep.create.cylinder(scale=(1, 1, 2))
    balls = rep.create.sphere(count=60, scale=0.3)
    rep.randomizer.scatter_2d(floor, no_coll_prims=pillar, input_prims=balls)
    run()
    assert collisions(balls.prims) != []
    assert (np.hypot(*positions(balls)[:, :2].T) > 0.64).all()


def test_objects_may_be_listed_as_obstacles_and_their_pivots_are_placed(stage):
    room = UsdGeom.Xform.Define(stage, "/World/room")
    boxes = rep.create.cube(count=8, parent="/World/room", scale=0.2, pivot=(0, 0, -1))
    floor = rep.create.plane(scale=2, position=(0, 0, 1))
    rep.randomizer.scatter_2d(floor, no_coll_prims=str(room.GetPath()), check_for_collisions=True, input_prims=boxes)
    run()
    np.testing.assert_allclose(positions(boxes)[:, 2], 1.1, atol=1e-6)
    assert collisions(boxes.prims) == []


def test_a_floor_without_free_space_raises_an_error_that_names_the_object(stage, monkeypatch):
    monkeypatch.setattr(scatter_positions, "MAX_TRIES", 1_000)
    floor = rep.create.plane()
    boxes = rep.create.cube(count=3, scale=0.9)
    rep.randomizer.scatter_2d(floor, check_for_collisions=True, input_prims=boxes)
    with pytest.raises(ValueError, match=r"no free position for /Replicator/Cube_Xform\w* after 1,000 tries"):
        run()


@in_soak
def test_without_free_space_objects_overlap_on_the_floor_where_errors_are_let_pass(stage, monkeypatch):
    monkeypatch.setattr(errors, "_lenient", True)
    floor = rep.create.plane()
    boxes = rep.create.cube(count=3, scale=0.9)
    rep.randomizer.scatter_2d(floor, check_for_collisions=True, input_prims=boxes)
    with pytest.warns(errors.UsdsdgWarning, match="no free position for"):
        run()
    assert np.all(np.abs(positions(boxes)[:, :2]) <= 0.5)
    assert len({tuple(position) for position in positions(boxes)}) == 3
    assert collisions(boxes.prims)


def test_positions_repeat_with_the_seed_and_change_with_the_execution(stage):
    def scattered(seed=None, extra=False):
        stage_context.new_stage()
        floor, balls = rep.create.plane(scale=5), rep.create.sphere(count=6, scale=0.2)
        with rep.trigger.on_custom_event("go"):
            if extra:
                rep.randomizer.rotation(input_prims=floor)
                rep.modify.pose(rotation=(0, 0, 0), input_prims=floor)
            rep.randomizer.scatter_2d(floor, seed=seed, check_for_collisions=True, input_prims=balls)
        found = []
        for _ in range(2):
            rep.utils.send_og_event("go")
            run()
            found.append(positions(balls))
        return np.array(found)

    first = scattered()
    assert not np.allclose(first[0], first[1])
    assert np.array_equal(first, scattered())
    assert np.allclose(first, scattered(extra=True), atol=1e-9)
    assert not np.allclose(first, scattered(seed=8))
    rep.set_global_seed(4)
    assert np.array_equal(scattered(seed=8), scattered(seed=8))


def test_origins_lie_inside_the_volume_and_outside_excluded_volumes(stage):
    torus = rep.create.torus(scale=4, rotation=(30, 0, 0), position=(1, 1, 1))
    hole = rep.create.cube(position=(1, 1, 1), scale=(4, 0.8, 4))
    balls = rep.create.sphere(count=100, scale=0.1)
    rep.randomizer.scatter_3d(torus, volume_excl_prims=hole, input_prims=balls)
    run()
    for item, expected in ((torus, True), (hole, False)):
        corners = triangles_below([stage.GetPrimAtPath(item.prims[0])])[0].in_world().corners()
        assert (inside(positions(balls), corners) == expected).all()


def test_without_volume_prims_the_bounds_are_the_volume_and_collisions_are_avoided(stage):
    balls = rep.create.sphere(count=40, scale=0.3)
    rep.randomizer.scatter_3d(
        min_samp=(0, 0, 0), max_samp=(2, 1, 2), check_for_collisions=True, no_coll_prims=[], input_prims=balls
    )
    run()
    found = positions(balls)
    assert (found >= 0).all()
    assert (found <= (2, 1, 2)).all()
    assert collisions(balls.prims) == []
    distances = np.linalg.norm(found[:, None] - found, axis=-1) + np.eye(40)
    assert distances.min() > 0.29


def test_incomplete_bounds_without_a_volume_raise_an_error(stage):
    balls = rep.create.sphere()
    with pytest.raises(ValueError, match="all six numbers"):
        rep.randomizer.scatter_3d(min_samp=(0, 0, 0), input_prims=balls)
    with pytest.raises(GraphError, match="surface_prims is None"):
        rep.randomizer.scatter_2d(None, input_prims=balls)
    with pytest.raises(GraphError, match="resolution_scaling=0"):
        rep.randomizer.scatter_3d(balls, resolution_scaling=0, input_prims=balls)


def test_sampled_voxels_are_shown_at_the_objects(stage):
    block, balls = rep.create.cube(scale=2), rep.create.sphere(count=25, scale=0.1)
    rep.randomizer.scatter_3d(block, voxel_size=0.5, viz_sampled_voxels=True, input_prims=balls)
    run()
    shown = UsdGeom.PointInstancer(stage.GetPrimAtPath("/Replicator/SampledVoxels"))
    centers = np.array(shown.GetPositionsAttr().Get())
    assert len(centers) == 25
    assert (np.abs(centers - positions(balls)) <= 0.25 + 1e-6).all()


@pytest.mark.parametrize(("prevent_overlap", "fraction"), [(True, 1 / 3), (False, 1 / 2)])
def test_overlapping_volumes_are_denser_only_on_request(stage, prevent_overlap, fraction):
    volumes = rep.create.cube(count=2, position=[(0, 0, 0), (1, 0, 0)], scale=(2, 1, 1))
    balls = rep.create.xform(count=400)
    rep.randomizer.scatter_3d(volumes, prevent_vol_overlap=prevent_overlap, input_prims=balls)
    run()
    inside_both = (positions(balls)[:, 0] > 0) & (positions(balls)[:, 0] < 1)
    # Binomial with n = 400: five standard deviations are 0.12.
    assert inside_both.mean() == pytest.approx(fraction, abs=0.12)
    assert (inside_both.mean() > (1 / 3 + 1 / 2) / 2) == (not prevent_overlap)


def test_voxels_have_the_requested_size(stage):
    block, balls = rep.create.cube(scale=3), rep.create.xform(count=5)
    for arguments, edge in (({}, 0.1), ({"resolution_scaling": 0.5}, 0.2), ({"voxel_size": 0.25}, 0.25)):
        rep.randomizer.scatter_3d(block, viz_sampled_voxels=True, input_prims=balls, **arguments)
        run()
        found = stage.GetPrimAtPath("/Replicator/SampledVoxels/Voxel").GetAttribute("size").Get()
        assert found == pytest.approx(edge, rel=0.01)


def test_objects_in_a_volume_avoid_obstacles(stage):
    block, post = rep.create.cube(scale=3), rep.create.cylinder(scale=(1, 1, 4))
    balls = rep.create.sphere(count=30, scale=0.3)
    rep.randomizer.scatter_3d(block, no_coll_prims=post, min_samp=(None, None, 0), input_prims=balls, name="toss")
    run()
    assert (np.hypot(*positions(balls)[:, :2].T) > 0.64).all()
    assert (positions(balls)[:, 2] >= 0).all()


def test_a_thousand_executions_prepare_a_shape_once(stage):
    floor, balls = rep.create.plane(scale=5), rep.create.sphere(count=3, scale=0.1)
    item = rep.randomizer.scatter_2d(floor, check_for_collisions=True, input_prims=balls)
    run()
    assert len(item.node.state["shapes"]) == 1


@in_soak
def test_collisions_agree_with_vertices_inside_of_other_spheres(stage):
    """Random spheres collide exactly if a vertex of one is inside the other."""
    balls = rep.create.sphere(count=12, scale=0.6, position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
    run()
    meshes = []
    for path in balls.prims:
        points, faces = triangles_below([stage.GetPrimAtPath(path)])[0].in_world()
        meshes.append(trimesh.Trimesh(points, faces))
    expected = [
        (i, j)
        for i in range(12)
        for j in range(i + 1, 12)
        if inside(np.array(meshes[i].vertices), meshes[j].triangles).any()
        or inside(np.array(meshes[j].vertices), meshes[i].triangles).any()
    ]
    assert expected
    assert collisions(balls.prims) == expected


def _torus(stage, path, segments=90):
    """A mesh of 2 * segments² triangles, 2.8 wide."""
    u, v = np.meshgrid(*2 * [np.linspace(0, 2 * np.pi, segments, endpoint=False)], indexing="ij")
    ring = 1 + 0.4 * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)], -1).reshape(-1, 3)
    i, j = (each.ravel() for each in np.indices((segments, segments)))
    a, b = i * segments + j, (i + 1) % segments * segments + j
    c, d = (i + 1) % segments * segments + (j + 1) % segments, i * segments + (j + 1) % segments
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(points.astype(np.float32))
    mesh.CreateFaceVertexCountsAttr([4] * segments**2)
    mesh.CreateFaceVertexIndicesAttr(np.stack([a, b, c, d], 1).ravel().tolist())
    UsdGeom.Xformable(mesh).AddTranslateOp()
    return path


@in_soak
def test_large_meshes_without_room_are_given_up_in_bounded_time(stage):
    """About five seconds on one core."""
    meshes = [_torus(stage, f"/World/Torus{number}") for number in range(5)]
    plane = rep.create.plane(scale=0.5)
    with rep.trigger.on_custom_event("go"):
        rep.randomizer.scatter_2d(plane, check_for_collisions=True, input_prims=meshes)
    rep.utils.send_og_event("go")
    with pytest.raises(
        GraphError, match=r"no free position for /World/Torus1 after [0-9],[0-9]{3} tries \(1 of 5 objects has one\)"
    ):
        run()


@pytest.mark.parametrize("value", [rep.distribution.uniform, lambda *_: "high", lambda *_: float("nan")])
def test_numbers_of_scatter_are_not_drawn(stage, value):
    plane, cube = rep.create.plane(), rep.create.cube()
    with pytest.raises(errors.ArgumentError, match=r"scatter_2d: offset is .*expected one number"):
        rep.randomizer.scatter_2d(plane, offset=value(0, 1), input_prims=cube)
    with pytest.raises(errors.ArgumentError, match=r"scatter_2d: offset is .*expected one number"):
        rep.functional.randomizer.scatter_2d(cube.prims[0], plane.prims[0], offset=value(0, 1))
    with pytest.raises(errors.ArgumentError, match=r"scatter_3d: voxel_size is .*expected one number"):
        rep.randomizer.scatter_3d(plane, voxel_size=value(0, 1), input_prims=cube)

"""Meshes that are split into convex parts: hollows stay hollow, and the parts are one collider."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from pxr import Gf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, make_body, mesh, new_stage, playing, position
from tests.sampled_cases import in_soak
from usdsdg import errors
from usdsdg.stage.schemas import physx
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes import convex_decomposition
from usdsdg_physics.parse.shapes.convex_hulls import SPLITTING_LABEL, HullCache
from usdsdg_physics.parse.shapes.convex_pieces import convex_pieces

pytest.importorskip("coacd")


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path_factory):
    """A cache that the tests of a session share, so that each mesh is split once."""
    wp.init()  # or kernels, too, would be compiled anew for the folder of the session
    folder = tmp_path_factory.getbasetemp() / "convex_parts_cache"
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder))


def _box(low, high, first):
    x, y, z = zip(low, high)
    corners = [(a, b, c) for a in x for b in y for c in z]
    faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 7, 5],
        [4, 6, 7],
        [0, 5, 1],
        [0, 4, 5],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
    ]
    faces += [[1, 5, 7], [1, 7, 3]]
    return corners, (np.array(faces) + first).tolist()


_FLOOR = ((-0.3, -0.3, 0.0), (0.3, 0.3, 0.1))
_WALLS = [((-0.3, -0.3, 0.1), (-0.2, 0.3, 0.4)), ((0.2, -0.3, 0.1), (0.3, 0.3, 0.4))]
_ENDS = [((-0.2, -0.3, 0.1), (0.2, -0.2, 0.4)), ((-0.2, 0.2, 0.1), (0.2, 0.3, 0.4))]


def _crate(stage, path="/World/crate", *, body=True, approximation="convexDecomposition", boards=None):
    """A square crate, open above: 0.6 m wide, 0.4 m high, walls and floor of 0.1 m; or other boards of it."""
    boards = boards or [_FLOOR, *_WALLS, *_ENDS]
    points, faces = [], []
    for low, high in boards:
        corners, own = _box(low, high, len(points))
        points, faces = points + corners, faces + own
    prim = mesh(stage, path, np.array(points), np.array(faces)).GetPrim()
    UsdGeom.Xformable(prim).AddTranslateOp()
    UsdPhysics.CollisionAPI.Apply(prim)
    UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(approximation)
    if body:
        make_body(prim)
    return prim


@pytest.mark.parametrize("approximation", ["convexDecomposition", "sdf", "meshSimplification"])
def test_a_box_falls_into_a_crate(approximation):
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    crate = _crate(stage, approximation=approximation)
    box = add(stage, "/World/box", at=(0, 0, 0.6))
    playing(stage).advance(1.0)
    assert position(box)[2] == pytest.approx(0.2, abs=0.01)
    assert position(crate) == pytest.approx([0, 0, 0], abs=0.01)


def test_a_static_decomposition_is_hollow_and_moves_as_one():
    stage = new_stage()
    crate = _crate(stage, body=False)
    box = add(stage, "/World/box", at=(0, 0, 0.3))
    engine = playing(stage)
    engine.advance(0.5)
    assert position(box)[2] == pytest.approx(0.2, abs=0.01)
    crate.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, -0.5))
    engine.advance(1.0)
    assert position(box)[2] == pytest.approx(-0.3, abs=0.01)
    UsdPhysics.CollisionAPI(crate).GetCollisionEnabledAttr().Set(False)
    engine.advance(0.5)
    assert position(box)[2] < -1.0


def test_parts_are_one_collider_with_the_mass_of_the_mesh():
    stage = new_stage()
    crate = _crate(stage)
    scene = parse(stage, HullCache())
    assert [collider.parts for collider in scene.colliders.values()] == [len(scene.colliders)] * len(scene.colliders)
    volume = 0.6 * 0.6 * 0.1 + 0.3 * (0.6 * 0.6 - 0.4 * 0.4)
    engine = playing(stage)
    assert [hit.collision for hit in engine.overlap_box((1, 1, 1), (0, 0, 0))] == ["/World/crate"]
    assert [hit.collision for hit in engine.raycast_all((0, 0, 5), (0, 0, -1), 9)] == ["/World/crate"]
    engine.advance(1 / 60)
    assert engine._session.world.mass == pytest.approx([1000 * volume], rel=0.1)
    UsdPhysics.MassAPI.Apply(crate).CreateMassAttr(3.0)
    engine.advance(1 / 60)
    assert engine._session.world.mass == pytest.approx([3.0])


@in_soak
def test_the_number_of_parts_is_limited():
    stage = new_stage()
    crate = _crate(stage, boards=[_FLOOR, *_WALLS])  # three parts
    api = physx.PhysxConvexDecompositionCollisionAPI.Apply(crate)
    api.CreateMaxConvexHullsAttr(2)
    api.CreateHullVertexLimitAttr(16)
    scene = parse(stage, HullCache())
    assert len(scene.colliders) == 2
    assert all(len(collider.shape.solid.vertices) <= 16 for collider in scene.colliders.values())


def test_a_mesh_is_split_once_with_progress_and_then_read(monkeypatch):
    monkeypatch.setattr(convex_decomposition, "_VERSION", "test")
    stage = new_stage()
    _crate(stage, boards=[_FLOOR, _WALLS[0]])
    heard = []
    first = parse(stage, HullCache(progress=lambda *report: heard.append(report)))
    assert heard == [(SPLITTING_LABEL, 1, None)]
    monkeypatch.setattr(convex_decomposition, "_split", lambda *_: pytest.fail("split again"))
    assert parse(stage, HullCache(progress=lambda *report: heard.append(report))) == first
    assert len(heard) == 1, "nothing is said of what is not done"


def test_parts_that_a_damaged_disk_gives_back_are_made_anew(tmp_path):
    """One bit of the file is another one; what is read is what was written, or nothing."""
    file, rng = tmp_path / "parts.npz", np.random.default_rng(0)
    parts = [rng.normal(size=(count, 3)).astype(np.float32) for count in (8, 5)]
    convex_decomposition._write(file, parts)
    whole = file.read_bytes()
    for bit in range(8 * len(whole)):
        damaged = bytearray(whole)
        damaged[bit // 8] ^= 1 << bit % 8
        file.write_bytes(damaged)
        found = convex_decomposition._read(file)
        assert found is None or all(np.array_equal(*pair) for pair in zip(found, parts, strict=True))


def test_contacts_and_triggers_name_the_whole():
    stage = new_stage()
    gate = add(stage, "/World/gate", scale=(2, 2, 2), body=False)
    physx.PhysxTriggerAPI.Apply(gate)
    crate = _crate(stage)
    physx.PhysxContactReportAPI.Apply(crate).CreateThresholdAttr(0.0)
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    engine, entered = playing(stage), []
    engine.subscribe_triggers(lambda event: entered.append(event.other))
    engine.advance(0.5)
    assert entered == ["/World/crate"]
    assert {(event.collider0, event.collider1) for event in engine.contacts} == {("/World/crate", "/World/ground")}


def test_other_approximations_that_become_parts_are_named_once():
    stage = new_stage()
    for index in range(2):
        _crate(stage, f"/World/crate{index}", approximation="sdf")
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="/World/crate0.*'sdf'.*convex parts") as caught:
        parse(stage, HullCache())
    errors.forget_warnings()
    assert len(caught) == 1


def test_convex_pieces_become_parts_exactly():
    boards = [_FLOOR, *_WALLS, *_ENDS]
    pieces = [_box(low, high, 8 * k) for k, (low, high) in enumerate(boards)]
    points = np.array([corner for corners, _ in pieces for corner in corners], np.float32)
    triangles = np.array([face for _, faces in pieces for face in faces], np.int32)
    parts, rest = convex_pieces(points, triangles, 32, 64)
    assert len(rest) == 0
    for part, (low, high) in zip(parts, boards, strict=True):
        np.testing.assert_array_equal(part.min(0), np.float32(low))
        np.testing.assert_array_equal(part.max(0), np.float32(high))


def test_faces_with_points_of_their_own_are_one_piece():
    corners, faces = _box((0, 0, 0), (1, 2, 3), 0)
    points = np.array(corners, np.float32)[np.array(faces).reshape(-1)]
    parts, rest = convex_pieces(points, np.arange(len(points), dtype=np.int32).reshape(-1, 3), 4, 64)
    assert len(rest) == 0
    assert [len(part) for part in parts] == [8]


def test_what_is_open_hollow_or_not_convex_is_left_for_the_split():
    corners, faces = _box((0, 0, 0), (1, 1, 1), 0)
    box, triangles = np.array(corners, np.float32), np.array(faces, np.int32)
    assert convex_pieces(box, triangles[1:], 4, 64)[0] == []
    inside = triangles[:, ::-1] + 8
    hollow = np.concatenate([box, box * 0.5 + 0.25])
    assert convex_pieces(hollow, np.concatenate([triangles, inside]), 4, 64)[0] == []
    # Also where only the hollow has points of its own in each face.
    split = np.concatenate([box, (box * 0.5 + 0.25)[triangles[:, ::-1].reshape(-1)]])
    assert (
        convex_pieces(split, np.concatenate([triangles, 8 + np.arange(36, dtype=np.int32).reshape(-1, 3)]), 4, 64)[0]
        == []
    )
    assert convex_pieces(box, triangles, 4, 7)[0] == []
    dented = np.concatenate([box, [[0.5, 0.5, 0.5]]]).astype(np.float32)
    top = [face for face in faces if np.all(box[face][:, 2] == 1)]
    rim = [
        edge
        for face in top
        for edge in (face[:2], face[1:], face[::2][::-1])
        if sorted(edge)
        not in [sorted(other) for own in top if own is not face for other in (own[:2], own[1:], own[::2])]
    ]
    crater = [face for face in faces if face not in top] + [[*edge, 8] for edge in rim]
    parts, rest = convex_pieces(dented, np.array(crater, np.int32), 4, 64)
    assert parts == []
    assert len(rest) == len(crater)


def test_fewer_parts_than_pieces_are_left_for_the_split():
    corners, faces = _box((0, 0, 0), (1, 1, 1), 0)
    points = np.concatenate([np.array(corners, np.float32) + 3 * k for k in range(3)])
    triangles = np.concatenate([np.array(faces, np.int32) + 8 * k for k in range(3)])
    assert len(convex_pieces(points, triangles, 3, 64)[0]) == 3
    assert convex_pieces(points, triangles, 2, 64)[0] == []


def test_a_flat_floor_has_no_thickness_and_a_flat_body_names_its_own():
    """Convex parts of a floor of 100 m were 1.1 m thick, without a word."""
    stage = new_stage()
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    for name, size in (("floor", 50.0), ("sheet", 0.2)):
        flat = mesh(stage, f"/World/{name}", size * corners, np.array([[0, 1, 2], [0, 2, 3]])).GetPrim()
        UsdPhysics.CollisionAPI.Apply(flat)
        UsdPhysics.MeshCollisionAPI.Apply(flat).CreateApproximationAttr("convexDecomposition")
    UsdGeom.Xformable(flat).AddTranslateOp().Set(Gf.Vec3d(3, 0, 0.1))
    make_body(flat)
    box = add(stage, "/World/box", at=(0.3, 0.2, 0.3))
    ball = add(stage, "/World/ball", "Sphere", at=(1.0, 0.2, 0.3))
    with pytest.warns(errors.UsdsdgWarning, match="/World/sheet is flat"):
        playing(stage).advance(1.5)
    errors.forget_warnings()
    assert position(box)[2] == pytest.approx(0.1, abs=2e-4)
    assert position(ball)[2] == pytest.approx(0.1, abs=2e-4)
    assert position(flat)[2] == pytest.approx(0.0, abs=1e-3)


def test_kept_parts_of_which_any_byte_is_damaged_are_split_anew(tmp_path):
    file, parts = tmp_path / "a.npz", [np.arange(12, dtype=np.float32).reshape(4, 3)] * 2
    convex_decomposition._write(file, parts)
    whole = file.read_bytes()
    for place in range(len(whole)):
        for mask in (0x01, 0x08, 0x60):
            file.write_bytes(whole[:place] + bytes([whole[place] ^ mask]) + whole[place + 1 :])
            found = convex_decomposition._read(file)
            assert found is None or np.array_equal(found, parts)

"""Parsing a stage: owners, shapes, units, materials, and warnings of what is left out."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade
from scipy.spatial import ConvexHull

from tests.physics.scenes import (
    add,
    collide,
    fallen,
    make_body,
    mesh,
    new_stage,
    physics_material,
    playing,
    position,
    warnings_of,
)
from usdsdg import errors
from usdsdg.stage.schemas import physx
from usdsdg_physics.parse.left_out import warn_unsupported
from usdsdg_physics.parse.physics_prims import find_physics_prims
from usdsdg_physics.parse.scene import parse, read_gravity
from usdsdg_physics.parse.shapes.convex_hulls import MAX_HULL_VERTICES, HullCache
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.extents import local_box

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)


def _parse(stage):
    return parse(stage, HullCache())


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
@pytest.mark.parametrize("kind", ["Capsule", "Cylinder", "Cone"])
def test_axis_of_round_shapes(kind, axis):
    """The shape's +Z, turned by its rotation, is the gprim's axis."""
    stage = new_stage()
    prim = add(stage, "/World/shape", kind, scale=(0.5, 0.5, 0.5), body=False)
    prim.GetAttribute("axis").Set(axis)
    prim.GetAttribute("radius").Set(0.4)
    prim.GetAttribute("height").Set(3.0)
    shape = _parse(stage).colliders["/World/shape"].shape
    assert shape.kind == kind.lower()
    assert shape.size == pytest.approx((0.2, 0.75, 0.0))
    up = Gf.Rotation(Gf.Quatd(shape.rotation[3], *shape.rotation[:3])).TransformDir(Gf.Vec3d(0, 0, 1))
    assert np.array(up) == pytest.approx(np.eye(3)["XYZ".index(axis)], abs=1e-9)


def test_schema_sizes_without_attributes():
    """UsdGeom's fallbacks: cube edge 2, sphere radius 1, capsule 0.5 x 1, cylinder and cone 1 x 2."""
    stage = new_stage()
    for kind in ("Cube", "Sphere", "Capsule", "Cylinder", "Cone"):
        add(stage, f"/World/{kind}", kind, scale=(1, 1, 1), body=False)
    sizes = {path.split("/")[-1]: c.shape.size for path, c in _parse(stage).colliders.items()}
    assert sizes == {
        "Cube": (1, 1, 1),
        "Sphere": (1, 0, 0),
        "Capsule": (0.5, 0.5, 0),
        "Cylinder": (1, 1, 0),
        "Cone": (1, 1, 0),
    }


def test_uneven_scale_keeps_what_stays_a_primitive():
    stage = new_stage()
    for kind in ("Cube", "Sphere", "Capsule", "Cylinder", "Cone"):
        add(stage, f"/World/{kind}", kind, scale=(1, 1, 3), body=False)
    add(stage, "/World/oval", "Cylinder", scale=(1, 2, 1), body=False)
    kinds = {path.split("/")[-1]: c.shape.kind for path, c in _parse(stage).colliders.items()}
    assert kinds == {
        "Cube": "box",
        "Sphere": "hull",
        "Capsule": "hull",
        "Cylinder": "cylinder",
        "Cone": "cone",
        "oval": "hull",
    }


def test_ellipsoid_hull_has_the_extent_of_the_scaled_sphere():
    stage = new_stage()
    add(stage, "/World/egg", "Sphere", scale=(1, 1, 3), body=False)
    shape = _parse(stage).colliders["/World/egg"].shape
    points = shape.solid.vertices * shape.size
    assert np.abs(points).max(axis=0) == pytest.approx([1, 1, 3], rel=0.05)
    assert len(points) <= MAX_HULL_VERTICES


def test_sheared_box_is_a_hull_in_the_right_place():
    """A turned cube under an uneven scale is no box any more; its corners tell where it is."""
    stage = new_stage()
    UsdGeom.Xform.Define(stage, "/World/flat").AddScaleOp().Set(Gf.Vec3f(1, 1, 0.2))
    prim = add(stage, "/World/flat/box", rotate=(30, 20, 10), scale=(1, 1, 1), body=False)
    shape = _parse(stage).colliders["/World/flat/box"].shape
    assert shape.kind == "hull"
    matrix = UsdGeom.XformCache().GetLocalToWorldTransform(prim)
    expected = np.array([matrix.Transform(Gf.Vec3d(*corner)) for corner in CORNERS])
    turn = Gf.Rotation(Gf.Quatd(shape.rotation[3], *shape.rotation[:3]))
    points = [np.array(turn.TransformDir(Gf.Vec3d(*map(float, p)))) for p in shape.solid.vertices * shape.size]
    found = np.array(points) + shape.position
    # Every corner of one set has its twin in the other.
    apart = np.linalg.norm(found[:, None] - expected[None], axis=2)
    assert apart.min(axis=0).max() < 1e-5
    assert apart.min(axis=1).max() < 1e-5


def test_colliders_belong_to_the_nearest_body():
    stage = new_stage()
    for path in ("/World/outer", "/World/outer/inner", "/World/outer/inner/reset"):
        UsdGeom.Xform.Define(stage, path)
    for path in ("/World/outer", "/World/outer/inner"):
        make_body(stage.GetPrimAtPath(path))
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/outer/inner/reset")).SetResetXformStack(True)
    for path in ("/World/free", "/World/outer/a", "/World/outer/inner/b", "/World/outer/inner/reset/c"):
        add(stage, path, body=False)
    owners = {path: collider.body for path, collider in _parse(stage).colliders.items()}
    assert owners == {
        "/World/free": "",
        "/World/outer/a": "/World/outer",
        "/World/outer/inner/b": "/World/outer/inner",
        "/World/outer/inner/reset/c": "",
    }


def test_disabled_body_is_static():
    stage = new_stage()
    prim = add(stage, "/World/box")
    UsdPhysics.RigidBodyAPI(prim).CreateRigidBodyEnabledAttr(False)
    scene = _parse(stage)
    assert not scene.bodies
    assert scene.colliders["/World/box"].body == ""


def test_instances_share_a_hull_and_collide():
    stage = new_stage()
    asset = mesh(stage, "/Asset/mesh", CORNERS, [[0, 1, 2], [5, 6, 7], [3, 4, 0]])
    stage.GetPrimAtPath("/Asset").SetSpecifier(Sdf.SpecifierClass)
    collide(asset.GetPrim())
    for i in range(3):
        prim = stage.DefinePrim(f"/World/i{i}", "Xform")
        prim.GetReferences().AddInternalReference("/Asset")
        prim.SetInstanceable(True)
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(5 * i, 0, 1 + i))
        UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(0.1 * (i + 1)))
        make_body(prim)
    add(stage, "/World/ground", at=(5, 0, -0.1), scale=(20, 20, 0.1), body=False)
    hulls = HullCache()
    scene = parse(stage, hulls)
    assert {path: c.body for path, c in scene.colliders.items() if c.body} == {
        f"/World/i{i}/mesh": f"/World/i{i}" for i in range(3)
    }
    assert len({id(c.shape.solid) for c in scene.colliders.values() if c.shape.solid}) == 1
    playing(stage).advance(2.0)
    for i in range(3):
        assert position(stage.GetPrimAtPath(f"/World/i{i}"))[2] == pytest.approx(0.1 * (i + 1), abs=2e-3)


def test_material_bound_to_an_ancestor():
    stage = new_stage()
    add(stage, "/World/box", body=False)
    ice = physics_material(stage, "/Materials/ice", friction=0.1, restitution=0.3)
    plain = _parse(stage).colliders["/World/box"].material
    assert (plain.friction, plain.restitution) == (0.5, 0.0)
    world = stage.GetPrimAtPath("/World")
    UsdShade.MaterialBindingAPI.Apply(world).Bind(ice, UsdShade.Tokens.weakerThanDescendants, "physics")
    found = _parse(stage).colliders["/World/box"].material
    assert (found.friction, found.restitution) == pytest.approx((0.1, 0.3))


@pytest.mark.parametrize(
    ("approximation", "dynamic", "kind"),
    [
        ("convexHull", True, "hull"),
        ("convexHull", False, "hull"),
        ("none", True, "hull"),
        ("none", False, "mesh"),
        ("meshSimplification", False, "mesh"),
        ("boundingCube", True, "box"),
        ("boundingSphere", True, "sphere"),
    ],
)
def test_mesh_approximations(approximation, dynamic, kind):
    stage = new_stage()
    prim = mesh(stage, "/World/mesh", CORNERS * (1, 2, 3) + 5, [[0, 1, 2], [5, 6, 7], [3, 4, 0]]).GetPrim()
    collide(prim, approximation=approximation)
    if dynamic:
        make_body(prim)
    shape = _parse(stage).colliders["/World/mesh"].shape
    assert shape.kind == kind
    if kind == "box":
        assert shape.size == pytest.approx((1, 2, 3))
        assert shape.position == pytest.approx((5, 5, 5))
    if kind == "sphere":
        assert shape.size[0] == pytest.approx(np.sqrt(14))


def _square(stage, *, holes=(), counts=(3, 3), indices=(0, 1, 2, 0, 2, 3)):
    """A square of two triangles at z = 0 that faces up, x > y and x < y."""
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    square = mesh(stage, "/World/square", points, np.array([[0, 1, 2]]))
    square.GetFaceVertexCountsAttr().Set(list(counts))
    square.GetFaceVertexIndicesAttr().Set(list(indices))
    square.CreateHoleIndicesAttr(list(holes))
    collide(square.GetPrim(), approximation="none")
    return square


def test_nothing_collides_with_a_hole():
    stage = new_stage()
    square = _square(stage, holes=[0])
    through, held = add(stage, "/World/through", at=(0.5, -0.5, 0.2)), add(stage, "/World/held", at=(-0.5, 0.5, 0.2))
    engine = playing(stage)
    hit = engine.raycast((-0.5, 0.5, 5), (0, 0, -1), 9)
    assert hit.collision == "/World/held"
    assert engine.raycast((0.8, -0.2, 5), (0, 0, -1), 9) is None
    engine.advance(1.0)
    assert position(through)[2] < -1
    assert position(held)[2] == pytest.approx(0.1, abs=2e-3)
    # Both are holes, and then none is.
    square.GetHoleIndicesAttr().Set([0, 1])
    with pytest.warns(errors.UsdsdgWarning, match="/World/square has CollisionAPI but no points, or only holes"):
        engine.advance(0.5)
    assert position(held)[2] < -0.5
    through.GetAttribute("xformOp:translate").Set(Gf.Vec3d(0.5, -0.5, 0.2))
    through.GetAttribute("physics:velocity").Set(Gf.Vec3f(0))
    square.GetHoleIndicesAttr().Set([])
    engine.advance(1.0)
    assert position(through)[2] == pytest.approx(0.1, abs=2e-3)
    errors.forget_warnings()


@pytest.mark.parametrize(
    ("counts", "indices", "words"),
    [
        ((3, 3), (0, 1, 7, 0, 2, 3), "1 of its faces does not collide, with points outside 0..3"),
        ((3, 3), (0, -1, 2, 0, 2, 3), "1 of its faces does not collide, with points outside 0..3"),
        ((3, 3, 3), (0, 2, 3), "sum to 9, but faceVertexIndices has 3 entries, so 2 of its faces do not collide"),
        ((3, 3), (0, 2, 3), "sum to 6, but faceVertexIndices has 3 entries, so 1 of its faces does not collide"),
        ((3,), (0, 2, 3, 0, 1, 2), "sum to 3, but faceVertexIndices has 6 entries, of which the rest is not used"),
    ],
)
def test_faces_that_cannot_be_used_are_named_and_the_others_collide(counts, indices, words):
    errors.forget_warnings()
    stage = new_stage()
    _square(stage, counts=counts, indices=indices)
    through, held = add(stage, "/World/through", at=(0.5, -0.5, 0.2)), add(stage, "/World/held", at=(-0.5, 0.5, 0.2))
    with pytest.warns(errors.UsdsdgWarning, match=f"/World/square: .*{words}"):
        playing(stage).advance(1.0)
    assert position(through)[2] < -1
    assert position(held)[2] == pytest.approx(0.1, abs=2e-3)
    errors.forget_warnings()


def test_a_mesh_without_a_face_that_can_be_used_collides_as_the_hull_of_its_points():
    errors.forget_warnings()
    stage = new_stage()
    _square(stage, counts=(3,), indices=(5, 6, 7))
    with pytest.warns(errors.UsdsdgWarning, match="/World/square: none of its faces can be used, so the convex hull"):
        assert _parse(stage).colliders["/World/square"].shape.kind == "hull"
    errors.forget_warnings()


@pytest.mark.parametrize("approximation", ["convexHull", "boundingCube", "boundingSphere", "none"])
@pytest.mark.parametrize("lost", ["not finite", "at one place"])
def test_colliders_of_meshes_without_faces_are_finite_and_have_a_size(approximation, lost):
    """Of points that are not finite the others count, and points at one place are a speck."""
    errors.forget_warnings()
    stage = new_stage()
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0.5], [-1, 1, 1], [np.nan, 0, 0], [0, np.inf, 0]])
    prim = mesh(stage, "/World/mesh", points if lost == "not finite" else np.ones((3, 3)), np.zeros((0, 3))).GetPrim()
    collide(prim, approximation=approximation)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        shape = _parse(stage).colliders["/World/mesh"].shape
    low, high = local_box(shape)
    extent = high - low
    assert np.isfinite(shape.position).all()
    if lost == "not finite" and approximation != "boundingSphere":
        assert np.array(shape.position) + (low + high) / 2 == pytest.approx([0, 0, 0.5], abs=1e-6)
        assert extent == pytest.approx([2, 2, 1], abs=1e-6)
    elif lost == "not finite":  # the corners are the farthest from the middle
        assert extent == pytest.approx(2 * np.full(3, np.sqrt(2.25)), abs=1e-6)
    else:
        assert (extent > 0).all()
        assert (extent < 1e-5).all()
    errors.forget_warnings()


@pytest.mark.parametrize(
    ("name", "given", "counts"),
    [
        ("staticFriction", -0.5, 0.0),
        ("dynamicFriction", -0.5, 0.0),
        ("dynamicFriction", float("nan"), 0.0),
        ("dynamicFriction", float("inf"), 1e6),
        ("restitution", -1.0, 0.0),
        ("restitution", 1.5, 1.0),
        ("restitution", float("nan"), 0.0),
        ("density", -3.0, None),
        ("density", float("nan"), None),
    ],
)
def test_coefficients_that_nothing_has_are_named_once(name, given, counts, recwarn):
    errors.forget_warnings()
    stage = new_stage()
    material = physics_material(stage, "/Materials/odd", friction=0.0)
    UsdPhysics.MaterialAPI(material).CreateDensityAttr(0.0)
    material.GetPrim().GetAttribute(f"physics:{name}").Set(given)
    for index in range(3):
        add(stage, f"/World/box{index}", body=False, material=material)
    found = _parse(stage).colliders["/World/box2"].material
    field = {"staticFriction": "static_friction", "dynamicFriction": "friction"}.get(name, name)
    assert getattr(found, field) == (counts or 0.0)
    (message,) = [str(warning.message) for warning in recwarn]
    used = "not given" if counts is None else f"{counts:g}"
    assert message.startswith(f"/Materials/odd: physics:{name} is {given:g}, so it counts as {used}")
    playing(stage).advance(1 / 60)
    errors.forget_warnings()


@pytest.mark.parametrize("restitution", [0.0, 1.0])
def test_coefficients_at_their_limits_are_not_named(restitution, recwarn):
    stage = new_stage()
    material = physics_material(stage, "/Materials/usual", friction=1.7, restitution=restitution)
    add(stage, "/World/box", body=False, material=material)
    _parse(stage)
    assert not recwarn.list


def test_hull_of_many_points_is_capped_and_close():
    points = np.random.default_rng(0).normal(size=(5000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    hull = HullCache().hull(points)
    assert len(hull.vertices) <= MAX_HULL_VERTICES
    # 64 points well spread on a sphere enclose more than 85 % of its volume.
    assert hull.volume > 0.85 * 4 / 3 * np.pi


@pytest.mark.parametrize("flat", [(1, 1, 0), (1, 0, 0), (0, 0, 0)])
def test_flat_meshes_get_a_thickness_and_a_warning(flat):
    with pytest.warns(errors.UsdsdgWarning, match="/World/sheet is flat"):
        hull = HullCache().hull(CORNERS * flat, prim_path="/World/sheet")
    assert hull.volume > 0
    errors.forget_warnings()


def test_flat_body_rests_on_the_ground():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    sheet = mesh(stage, "/World/sheet", CORNERS[::2] * (0.3, 0.3, 0), [[0, 1, 2], [1, 3, 2]])
    sheet.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.3))
    collide(sheet.GetPrim())
    make_body(sheet.GetPrim())
    with pytest.warns(errors.UsdsdgWarning, match="flat"):
        playing(stage).advance(1.0)
    assert position(sheet.GetPrim())[2] == pytest.approx(0.0, abs=2e-3)
    errors.forget_warnings()


def test_y_up_stage_falls_along_y():
    stage = new_stage(up="Y")
    prim = add(stage, "/World/box")
    playing(stage).advance(0.5)
    assert position(prim) == pytest.approx([0, -fallen(30), 0], abs=1e-3)


def test_centimeter_stage_moves_like_a_meter_stage():
    """The same bounce in both units, to single precision; contact offsets and gravity scale with them."""
    paths = []
    for unit in (1.0, 0.01):
        stage = new_stage(meters_per_unit=unit)
        size = 1 / unit
        add(stage, "/World/ground", at=(0, 0, -0.5 * size), scale=(5 * size, 5 * size, 0.5 * size), body=False)
        prim = add(stage, "/World/box", at=(0, 0, size), rotate=(20, 30, 0), scale=(0.1 * size,) * 3)
        engine, path = playing(stage), []
        engine.subscribe_step(lambda dt, prim=prim, path=path: path.append(position(prim)))
        engine.advance(1.0)
        paths.append(np.array(path) * unit)
    assert paths[0] == pytest.approx(paths[1], abs=2e-3)


def test_filtered_pairs_and_groups_pass_through_each_other():
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(9, 9, 0.1), body=False)
    pair, grouped, other = (
        add(stage, f"/World/{n}", at=(3 * i, 0, 1)) for i, n in enumerate(("pair", "group", "other"))
    )
    UsdPhysics.FilteredPairsAPI.Apply(pair).CreateFilteredPairsRel().AddTarget("/World/ground")
    groups = {}
    for name in ("ground", "group"):
        groups[name] = UsdPhysics.CollisionGroup.Define(stage, f"/World/{name}_group")
        groups[name].GetCollidersCollectionAPI().CreateIncludesRel().AddTarget(f"/World/{name}")
    groups["group"].CreateFilteredGroupsRel().AddTarget("/World/ground_group")
    playing(stage).advance(1.0)
    assert position(pair)[2] < -1
    assert position(grouped)[2] < -1
    assert position(other)[2] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize("filters", ["box", "floor", "empty"])
def test_collision_groups_of_the_same_name_are_as_one(filters):
    """Both what they hold and what they filter counts for all; a group of another name stays by itself."""
    stage = new_stage()
    add(stage, "/World/floor", at=(0, 0, -0.1), scale=(9, 9, 0.1), body=False)
    box, other = (add(stage, f"/World/{name}", at=at) for name, at in (("box", (0, 0, 1)), ("other", (3, 0, 1))))
    groups = {}
    for name, merged in (("box", "things"), ("more", "things"), ("floor", "grounds"), ("empty", "grounds")):
        groups[name] = UsdPhysics.CollisionGroup.Define(stage, f"/World/{name}_group")
        groups[name].CreateMergeGroupNameAttr(merged)
        if name in ("box", "floor"):
            groups[name].GetCollidersCollectionAPI().CreateIncludesRel().AddTarget(f"/World/{name}")
    others = UsdPhysics.CollisionGroup.Define(stage, "/World/other_group")
    others.CreateMergeGroupNameAttr("others")
    others.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget("/World/other")
    source, target, alone = {
        "box": ("more", "empty", "empty"), "floor": ("empty", "box", "empty"), "empty": ("floor", "more", "more"),
    }[filters]  # fmt: skip
    groups[source].CreateFilteredGroupsRel().AddTarget(f"/World/{target}_group")
    assert not warnings_of(stage)
    engine = playing(stage)
    engine.advance(1.0)
    assert position(box)[2] < -1
    assert position(other)[2] == pytest.approx(0.1, abs=2e-3)
    groups[alone].GetMergeGroupNameAttr().Set("")
    box.GetAttribute("xformOp:translate").Set((0, 0, 1))
    box.GetAttribute("physics:velocity").Set((0, 0, 0))
    engine.advance(1.0)
    assert position(box)[2] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize("far", [1e16, 1e300, float("inf"), float("nan")])
def test_a_body_too_far_away_is_named_and_the_others_are_simulated(far):
    """A rotation beside 1e18 was a singular matrix for NumPy, and ended everything."""
    stage = new_stage()
    add(stage, "/World/far", at=(far, 0, 0), rotate=(10, 20, 30))
    add(stage, "/World/near")
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match=r"above 1e\+15, and are not simulated: /World/far"):
        warn_unsupported(find_physics_prims(stage, Sdf.Path.absoluteRootPath))
    assert list(_parse(stage).bodies) == ["/World/near"]


@pytest.mark.parametrize("direction", [(float("nan"), 0, 0), (float("inf"), 0, -1)])
def test_a_direction_of_gravity_that_is_none_is_named(direction):
    stage = new_stage()
    scene = UsdPhysics.Scene.Define(stage, "/World/physics")
    scene.CreateGravityDirectionAttr(Gf.Vec3f(*direction))
    scene.CreateGravityMagnitudeAttr(float("nan"))
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning) as said:
        assert read_gravity(stage, scene.GetPrim(), Units(meters=1.0, kilograms=1.0)) == (0.0, 0.0, -9.81)
    texts = [str(each.message) for each in said]
    assert any("/World/physics: physics:gravityDirection is" in text and "down" in text for text in texts)
    assert any("/World/physics: physics:gravityMagnitude is nan, so 9.81 m/s² is used" in text for text in texts)


def test_gravity_below_zero_is_that_of_the_earth_and_named():
    stage = new_stage()
    scene = UsdPhysics.Scene(stage.GetPrimAtPath("/PhysicsScene"))
    assert not warnings_of(stage)
    scene.CreateGravityMagnitudeAttr(-float("inf"))
    assert not warnings_of(stage)
    scene.GetGravityMagnitudeAttr().Set(-5.0)
    (message,) = warnings_of(stage)
    assert message.startswith(
        "/PhysicsScene: physics:gravityMagnitude is -5, and numbers below 0 stand for that of the E"
    )
    assert read_gravity(stage, scene.GetPrim(), Units(meters=1.0, kilograms=1.0)) == (0.0, 0.0, -9.81)


def test_bodies_whose_positions_are_rounded_to_millimeters_are_named():
    stage = new_stage(meters_per_unit=0.01)
    add(stage, "/World/near", at=(1e6, 0, 0))
    assert not warnings_of(stage)
    add(stage, "/World/far", at=(0, -1e7, 0))
    (message,) = warnings_of(stage)
    assert (
        "up to 1e+05 m from the origin they are multiples of 7.8 mm, so bodies there move in jumps: /World/far"
        in message
    )


@pytest.mark.parametrize(
    ("name", "given"),
    [("localPos0", Gf.Vec3f(float("nan"), 0, 0)), ("localRot1", Gf.Quatf(float("inf"), 0, 0, 0))],
)
def test_a_joint_whose_frame_is_not_finite_is_left_out(name, given):
    """NumPy found no singular values of it, and ended everything."""
    stage = new_stage()
    joint = UsdPhysics.FixedJoint.Define(stage, "/World/joint")
    for number, body in enumerate(("/World/one", "/World/other")):
        add(stage, body, at=(number, 0, 0))
        joint.GetPrim().GetRelationship(f"physics:body{number}").SetTargets([body])
    joint.GetPrim().GetAttribute(f"physics:{name}").Set(given)
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match=rf"/World/joint: .*physics:localRot{name[-1]} is not finite"):
        assert not _parse(stage).joints


@pytest.mark.parametrize("axis", ["x", "Q", ""])
@pytest.mark.parametrize("kind", [UsdPhysics.RevoluteJoint, UsdPhysics.PrismaticJoint, UsdPhysics.SphericalJoint])
def test_an_axis_of_a_joint_that_is_none_is_x(kind, axis):
    stage = new_stage()
    add(stage, "/World/body")
    joint = kind.Define(stage, "/World/joint")
    joint.CreateBody1Rel().SetTargets(["/World/body"])
    joint.CreateAxisAttr(axis)
    if kind is UsdPhysics.SphericalJoint:
        joint.CreateConeAngle0LimitAttr(30.0)
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match=f"/World/joint: physics:axis '{axis}' is none of X, Y, Z"):
        found = _parse(stage)
    joint.CreateAxisAttr("X")
    assert found.joints["/World/joint"].axes == _parse(stage).joints["/World/joint"].axes


def _joint(stage):
    add(stage, "/World/box")
    joint = stage.DefinePrim("/World/joint", "PhysxPhysicsGearJoint")
    joint.CreateRelationship("physics:body0", custom=False).AddTarget("/World/box")


def _no_collider(stage):
    make_body(UsdGeom.Xform.Define(stage, "/World/ghost").GetPrim())


def _body_inside_an_instance(stage):
    add(stage, "/Asset/box")
    stage.GetPrimAtPath("/Asset").SetSpecifier(Sdf.SpecifierClass)
    prim = stage.DefinePrim("/World/instance", "Xform")
    prim.GetReferences().AddInternalReference("/Asset")
    prim.SetInstanceable(True)


def _curves(stage):
    collide(UsdGeom.BasisCurves.Define(stage, "/World/curves").GetPrim())


def _inertia(stage):
    mass = UsdPhysics.MassAPI.Apply(add(stage, "/World/box"))
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(1, float("nan"), 1))


def _size(stage):
    UsdGeom.Sphere(add(stage, "/World/ball", "Sphere")).CreateRadiusAttr(float("nan"))


def _points(stage):
    points = np.concatenate([CORNERS, [[np.nan, 0, 0]]])
    collide(mesh(stage, "/World/mesh", points, np.array([[0, 1, 2], [1, 2, 8]])).GetPrim(), approximation="none")


def _prototypes(stage):
    add(stage, "/World/screw")
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/screws")
    instancer.CreatePrototypesRel().SetTargets(["/World/screw"])
    instancer.CreateProtoIndicesAttr([0, 3])
    instancer.CreatePositionsAttr([Gf.Vec3f(0), Gf.Vec3f(1)])


@pytest.mark.parametrize(
    ("author", "words"),
    [
        (_inertia, "/World/box: physics:diagonalInertia is"),
        (_size, "/World/ball: radius is nan"),
        (_points, "/World/mesh: 1 of its points"),
        (_prototypes, r"/World/screws has the protoIndices \[3\]"),
        (_joint, "/World/joint"),
        (_no_collider, "/World/ghost.*no collider"),
        (_body_inside_an_instance, "instances.*/World/instance/box"),
        (_curves, "/World/curves.*BasisCurves"),
    ],
)
def test_warnings_name_what_is_left_out(author, words):
    errors.forget_warnings()
    stage = new_stage()
    author(stage)
    with pytest.warns(errors.UsdsdgWarning, match=words):
        playing(stage).advance(1 / 60)
    errors.forget_warnings()


def _simulated(author):
    """Return where two bodies that a hinge connects, and one on a slide, are after a few steps, and the warnings."""
    stage = new_stage()
    held, swung = add(stage, "/World/held", at=(0, 0, 1)), add(stage, "/World/swung", at=(0.5, 0, 1))
    add(stage, "/World/free", at=(0, 2, 1))
    UsdPhysics.MassAPI.Apply(held)
    hinge = UsdPhysics.RevoluteJoint.Define(stage, "/World/hinge")
    hinge.CreateBody0Rel().SetTargets([held.GetPath()])
    hinge.CreateBody1Rel().SetTargets([swung.GetPath()])
    hinge.CreateAxisAttr("Y")
    hinge.CreateLocalPos1Attr(Gf.Vec3f(-5, 0, 0))
    UsdPhysics.DriveAPI.Apply(hinge.GetPrim(), "angular").CreateDampingAttr(0.1)
    physx.PhysxCollisionAPI.Apply(held)
    physx.PhysxRigidBodyAPI.Apply(held)
    physx.PhysxForceAPI.Apply(held)
    author(stage)
    errors.forget_warnings()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        playing(stage).advance(10 / 60)
    errors.forget_warnings()
    places = [position(stage.GetPrimAtPath(f"/World/{name}")) for name in ("held", "swung", "free")]
    return np.array(places), [str(each.message) for each in caught]


@pytest.mark.parametrize(
    "name",
    [
        "physxRigidBody:linearDamping", "physxRigidBody:lockedPosAxis", "physxRigidBody:maxAngularVelocity",
        "physics:mass", "physics:diagonalInertia", "physxCollision:contactOffset",
        "physxForce:force", "drive:angular:physics:maxForce", "physics:localRot1",
    ],
)  # fmt: skip
def test_an_attribute_of_another_type_than_its_schema_is_named_and_counts_as_not_given(name):
    """A file declares it as text; all moves as without it."""
    path = "/World/hinge" if "drive" in name or "local" in name else "/World/held"

    def author(stage):
        spec = stage.GetRootLayer().GetPrimAtPath(path)
        if name in spec.attributes:
            del spec.properties[name]
        Sdf.AttributeSpec(spec, name, Sdf.ValueTypeNames.String).default = "quick"

    found, told = _simulated(author)
    assert found == pytest.approx(_simulated(lambda _: None)[0], abs=1e-9)
    assert any(each.startswith(f"{path}: {name} is 'quick'") for each in told)


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("physics:velocity", (0.0, np.inf, 0.0)),
        ("physics:velocity", (1e38, 0.0, 0.0)),
        ("physics:angularVelocity", (np.nan, 0.0, 0.0)),
        ("physics:centerOfMass", (1e38, 0.0, 0.0)),
        ("physxForce:force", (np.nan, 0.0, 0.0)),
        ("physxForce:torque", (0.0, -1e38, 0.0)),
    ],
)
def test_vectors_that_no_body_has_are_named_and_count_as_not_given(name, given):
    """The bodies that joints connect to it would end at poses that are no numbers, too."""

    def author(stage):
        stage.GetPrimAtPath("/World/held").GetAttribute(name).Set(Gf.Vec3f(*given))

    found, told = _simulated(author)
    assert found == pytest.approx(_simulated(lambda _: None)[0], abs=1e-9)
    assert any(each.startswith(f"/World/held: {name} is ") for each in told)


@pytest.mark.parametrize("length", [1e-30, 1e38])
def test_the_rotation_of_a_joint_may_have_any_length(length):
    """A quarter turn about Z; squares of its numbers are beyond the range of 32 bits."""

    def author(size):
        turn = Gf.Quatf(size, Gf.Vec3f(0, 0, size))
        return lambda stage: [
            stage.GetPrimAtPath("/World/hinge").GetAttribute(f"physics:localRot{end}").Set(turn) for end in (0, 1)
        ]

    found, told = _simulated(author(length))
    assert found == pytest.approx(_simulated(author(1.0))[0], abs=1e-5)
    assert not any("localRot" in each for each in told)


def test_body_without_collider_falls():
    stage = new_stage()
    ghost = UsdGeom.Xform.Define(stage, "/World/ghost").GetPrim()
    make_body(ghost)
    with pytest.warns(errors.UsdsdgWarning):
        playing(stage).advance(0.5)
    assert position(ghost)[2] == pytest.approx(-fallen(30), abs=1e-3)
    errors.forget_warnings()


def test_parsing_works_without_registered_schemas():
    """PhysX attributes are read by name: this stage was never told their types."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(
        '#usda 1.0\ndef Cube "box" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", '
        '"PhysxRigidBodyAPI", "PhysxCollisionAPI"]) {\n bool physxRigidBody:disableGravity = 1\n'
        " float physxRigidBody:angularDamping = 0.7\n float physxCollision:contactOffset = 0.003\n"
        " float physxCollision:restOffset = 0.001\n}\n"
    )
    scene = _parse(Usd.Stage.Open(layer))
    assert not scene.bodies["/box"].gravity
    assert scene.bodies["/box"].angular_damping == pytest.approx(0.7)
    assert scene.colliders["/box"].gap == pytest.approx(0.002 * 0.01)
    assert scene.colliders["/box"].margin == pytest.approx(0.001 * 0.01)


@pytest.mark.parametrize(("kind", "half"), [("Cube", 1), ("Sphere", 1), ("Capsule", 0.5), ("Cylinder", 1), ("Mesh", 1)])
def test_a_rest_offset_below_the_middle_of_a_collider_is_named(kind, half, recwarn):
    errors.forget_warnings()
    stage = new_stage(meters_per_unit=0.01)
    for name, part in (("/World/outer", 0.2), ("/World/inner", -0.9), ("/World/beyond", -1.0)):
        if kind == "Mesh":
            mesh(stage, name, CORNERS, ConvexHull(CORNERS).simplices)
        prim = add(stage, name, kind, scale=(1, 1, 1))
        prim.CreateAttribute("physxCollision:restOffset", Sdf.ValueTypeNames.Float).Set(part * half)
    _parse(stage)
    messages = [str(warning.message) for warning in recwarn]
    assert len(messages) == 1
    assert messages[0].startswith("/World/beyond: physxCollision:restOffset")
    assert f"above {-half:.3g}." in messages[0]


@pytest.mark.parametrize("kind", ["Plane", "Mesh"])
def test_a_surface_may_have_any_rest_offset(kind, recwarn):
    stage = new_stage()
    if kind == "Mesh":
        mesh(stage, "/World/ground", CORNERS, ConvexHull(CORNERS).simplices)
    prim = add(stage, "/World/ground", kind, scale=(1, 1, 1), body=False)
    if kind == "Mesh":
        UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Set("none")
    prim.CreateAttribute("physxCollision:restOffset", Sdf.ValueTypeNames.Float).Set(-3.0)
    _parse(stage)
    assert not [str(warning.message) for warning in recwarn]


def test_several_scenes_and_the_bodies_of_others_are_named():
    stage = new_stage()
    UsdPhysics.Scene.Define(stage, "/Slow").CreateGravityMagnitudeAttr(1.0)
    for name, owner in (("mine", "/PhysicsScene"), ("slow", "/Slow"), ("free", None)):
        body = add(stage, f"/World/{name}")
        if owner:
            UsdPhysics.RigidBodyAPI(body).CreateSimulationOwnerRel().SetTargets([owner])
    with pytest.warns(
        errors.UsdsdgWarning, match=r"in the first, /PhysicsScene, .* of the others, .*: /World/slow\. Remove"
    ):
        playing(stage)

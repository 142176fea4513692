"""Mass, center of mass and inertia against closed forms and against random points inside the shapes."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from tests.physics.scenes import add, mesh, new_stage, physics_material, playing, position
from tests.sampled_cases import crossed
from usdsdg import errors
from usdsdg_physics.model.mass import body_mass, volume_integrals
from usdsdg_physics.parse.scene import parse
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.scene.records import Shape


def _properties(stage, path):
    scene = parse(stage, HullCache())
    return body_mass(scene.bodies[path], [c for c in scene.colliders.values() if c.body == path])


def _inside(kind: str, size, p):
    radius, half, _ = size
    across = np.hypot(p[:, 0], p[:, 1])
    if kind == "box":
        return (np.abs(p) <= size).all(axis=1)
    if kind == "sphere":
        return np.linalg.norm(p, axis=1) <= radius
    if kind == "capsule":
        return np.hypot(across, np.maximum(np.abs(p[:, 2]) - half, 0)) <= radius
    if kind == "cylinder":
        return (across <= radius) & (np.abs(p[:, 2]) <= half)
    return (across <= radius * (half - p[:, 2]) / (2 * half)) & (np.abs(p[:, 2]) <= half)


@pytest.mark.parametrize("kind", ["box", "sphere", "capsule", "cylinder", "cone"])
def test_integrals_of_primitives_match_random_points(kind):
    """2e6 points: the standard error of each moment is below 0.2 % of its scale."""
    size = {"box": (0.3, 0.5, 0.7), "sphere": (0.4, 0.0, 0.0)}.get(kind, (0.3, 0.5, 0.0))
    reach = 0.85
    points = np.random.default_rng(1).uniform(-reach, reach, (2_000_000, 3))
    inside = points[_inside(kind, size, points)]
    cube = (2 * reach) ** 3
    volume_per_point = cube / len(points)
    volume, center, covariance = volume_integrals(Shape(kind, size))
    assert volume == pytest.approx(len(inside) * volume_per_point, rel=0.01)
    assert center == pytest.approx(inside.mean(axis=0), abs=2e-3)
    assert covariance == pytest.approx(inside.T @ inside * volume_per_point, abs=0.01 * np.trace(covariance))


def test_hull_mass_follows_scale_and_rotation():
    """A box of points, scaled unevenly and turned, weighs what the box primitive weighs."""
    stage = new_stage()
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    prim = mesh(stage, "/World/mesh", corners, [[0, 1, 2]]).GetPrim()
    prim.GetAttribute("faceVertexIndices").Set([0, 1, 3, 2, 4, 5, 7, 6])
    prim.GetAttribute("faceVertexCounts").Set([4, 4])
    UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    UsdGeom.Xformable(prim).AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40))
    UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(0.1, 0.2, 0.3))
    UsdPhysics.CollisionAPI.Apply(prim)
    UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr("convexHull")
    UsdPhysics.RigidBodyAPI.Apply(prim)
    add(stage, "/World/box", at=(1, 2, 3), rotate=(20, 30, 40), scale=(0.1, 0.2, 0.3))
    hull, box = _properties(stage, "/World/mesh"), _properties(stage, "/World/box")
    assert hull.mass == pytest.approx(box.mass, rel=1e-5) == pytest.approx(1000 * 0.2 * 0.4 * 0.6)
    assert hull.inertia == pytest.approx(box.inertia, rel=1e-4, abs=1e-6)
    assert hull.center == pytest.approx(np.zeros(3), abs=1e-6)


@pytest.mark.parametrize(("kind", "shear"), crossed(["Sphere", "Capsule", "Cylinder", "Cone"], [False, True]))
def test_a_round_shape_that_is_scaled_unevenly_has_its_own_mass(kind, shear):
    """Of random points, whose standard error is a third of the tolerance at most; its hull has a tenth less volume."""
    stage = new_stage()
    path, scale = "/World/round", np.array([1.0, 1.5, 2.5])
    if shear:
        UsdGeom.Xform.Define(stage, "/World/squeezed").AddScaleOp().Set(Gf.Vec3f(*map(float, scale)))
        path = "/World/squeezed/round"
        prim = add(stage, path, kind, rotate=(20, 30, 40), scale=(0.3, 0.3, 0.3), body=False)
        UsdPhysics.RigidBodyAPI.Apply(stage.GetPrimAtPath("/World/squeezed"))
    else:
        prim = add(stage, path, kind, scale=tuple(0.3 * scale))
    size = {"Sphere": (1.0, 0.0, 0.0), "Capsule": (0.5, 0.5, 0.0)}.get(kind, (1.0, 1.0, 0.0))
    points = np.random.default_rng(1).uniform(-1.01, 1.01, (500_000, 3))
    inside = points[_inside(kind.lower(), size, points)]
    matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))[:3, :3]
    placed = inside @ matrix
    mass = 1000 * 2.02**3 * len(inside) / len(points) * np.linalg.det(matrix)
    center = placed.mean(axis=0)
    spread = (placed - center).T @ (placed - center) / len(inside)
    found = _properties(stage, "/World/squeezed" if shear else path)
    assert found.mass == pytest.approx(mass, rel=0.01)
    assert found.center == pytest.approx(center, abs=5e-3)
    inertia = mass * (np.trace(spread) * np.eye(3) - spread)
    assert found.inertia == pytest.approx(inertia, abs=0.01 * np.trace(inertia))


def test_the_mass_of_an_ellipsoid_is_in_closed_form():
    stage = new_stage()
    add(stage, "/World/egg", "Sphere", scale=(0.1, 0.1, 0.3))
    found = _properties(stage, "/World/egg")
    mass = 1000 * 4 / 3 * np.pi * 0.1 * 0.1 * 0.3
    assert found.mass == pytest.approx(mass, rel=1e-6)
    moments = [0.1**2 + 0.3**2, 0.1**2 + 0.3**2, 2 * 0.1**2]
    assert found.inertia == pytest.approx(np.diag(moments) * mass / 5, rel=1e-6)


def test_compound_body_shifts_its_center():
    """A 1 kg and a 3 kg cube 4 m apart: the center is 1 m from the heavy one."""
    stage = new_stage()
    body = UsdGeom.Xform.Define(stage, "/World/body").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(body)
    for name, x, kilograms in (("light", 0.0, 1.0), ("heavy", 4.0, 3.0)):
        part = add(stage, f"/World/body/{name}", at=(x, 0, 0), body=False)
        UsdPhysics.MassAPI.Apply(part).CreateMassAttr(kilograms)
    found = _properties(stage, "/World/body")
    assert found.mass == pytest.approx(4.0)
    assert found.center == pytest.approx([3.0, 0.0, 0.0], abs=1e-6)
    own = 0.2**2 / 6.0
    expected = 1.0 * (own + 9.0) + 3.0 * (own + 1.0)
    assert found.inertia[1, 1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("source", "expected"),
    [("default", 1000.0), ("material", 200.0), ("body", 300.0), ("collider", 400.0), ("mass", 7.0 / 0.008)],
)
def test_density_comes_from_the_nearest_authority(source, expected):
    stage = new_stage()
    body = UsdGeom.Xform.Define(stage, "/World/body").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(body)
    material = None if source == "default" else physics_material(stage, "/World/m", density=200.0)
    part = add(stage, "/World/body/part", body=False, material=material)
    if source in ("body", "collider", "mass"):
        UsdPhysics.MassAPI.Apply(body).CreateDensityAttr(300.0)
    if source == "collider":
        UsdPhysics.MassAPI.Apply(part).CreateDensityAttr(400.0)
    if source == "mass":
        UsdPhysics.MassAPI(body).CreateMassAttr(7.0)
    assert _properties(stage, "/World/body").mass == pytest.approx(expected * 0.008)


def test_authored_inertia_and_center_win():
    stage = new_stage()
    prim = add(stage, "/World/box", scale=(2, 2, 2))
    api = UsdPhysics.MassAPI.Apply(prim)
    api.CreateMassAttr(5.0)
    api.CreateCenterOfMassAttr(Gf.Vec3f(0.1, 0, 0))
    api.CreateDiagonalInertiaAttr(Gf.Vec3f(1, 2, 3))
    api.CreatePrincipalAxesAttr(Gf.Quatf(Gf.Rotation(Gf.Vec3d(0, 0, 1), 90).GetQuat()))
    found = _properties(stage, "/World/box")
    assert found.mass == pytest.approx(5.0)
    assert found.center == pytest.approx([0.2, 0, 0])
    assert found.inertia == pytest.approx(np.diag([2, 1, 3]), abs=1e-6)


def test_a_body_does_not_turn_about_an_axis_whose_moment_is_zero():
    """As in PhysX, where it turns by nothing at all; it turned as if it had next to no inertia there."""
    stage = new_stage()
    box = add(stage, "/World/box", gravity=False)
    mass = UsdPhysics.MassAPI.Apply(box)
    mass.CreateMassAttr(1.0)
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.0, 0.1, 0.2))
    errors.forget_warnings()
    engine = playing(stage)
    with pytest.warns(errors.UsdsdgWarning, match="^/World/box: physics:diagonalInertia has zeros beside"):
        engine.apply_forces(["/World/box"], torques=[(1.0, 1.0, 1.0)])
    engine.step(1 / 60)
    found = np.radians(box.GetAttribute("physics:angularVelocity").Get())
    assert found == pytest.approx(np.array([0.0, 10.0, 5.0]) / 60, rel=0.01, abs=1e-4)


def test_principal_axes_without_an_inertia_turn_that_of_the_colliders():
    """Of a box of 2 kg, also of one that lies turned in its body; where it spins to is PhysX's answer."""
    stage = new_stage()
    axes = Gf.Quatf(0.9, 0.1, 0.2, 0.3).GetNormalized()
    box = add(stage, "/World/box", scale=(0.1, 0.3, 0.5), gravity=False)
    body = UsdGeom.Xform.Define(stage, "/World/body").GetPrim()
    add(stage, "/World/body/box", rotate=(20, 30, 40), scale=(0.1, 0.3, 0.5), body=False)
    UsdPhysics.RigidBodyAPI.Apply(body)
    for prim in (box, body):
        api = UsdPhysics.MassAPI.Apply(prim)
        api.CreateMassAttr(2.0)
        api.CreatePrincipalAxesAttr(axes)
    across = np.array([0.6, 0.2, 0.2]) ** 2 + np.array([1.0, 1.0, 0.6]) ** 2
    turned = np.array(Gf.Matrix3d().SetRotate(Gf.Quatd(axes)))
    expected = turned.T @ np.diag(2.0 / 12.0 * across) @ turned
    assert _properties(stage, "/World/box").inertia == pytest.approx(expected, abs=1e-6)
    assert _properties(stage, "/World/body").inertia == pytest.approx(expected, abs=1e-6)
    UsdPhysics.RigidBodyAPI(box).CreateAngularVelocityAttr((90, 120, 30))
    body.SetActive(False)
    playing(stage).advance(1.0)
    rotation = UsdGeom.XformCache().GetLocalToWorldTransform(box).RemoveScaleShear().ExtractRotationQuat()
    found = np.array([rotation.GetReal(), *rotation.GetImaginary()])
    assert abs(found @ [0.279, 0.817, 0.487, -0.134]) > np.cos(np.radians(1.0))  # half of 2 degrees


def test_center_and_inertia_of_a_child_collider_count():
    """Numbers are those that PhysX (ovphysx 0.7.0) reports: a cube of 3 kg about (0.5, 0, 0), and one of 1 kg."""
    stage = new_stage()
    body = UsdGeom.Xform.Define(stage, "/World/body").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(body)
    for name, x, mass, center, inertia in (("a", 0.0, 3.0, (0.5, 0, 0), None), ("b", 1.0, 1.0, None, (1, 2, 3))):
        cube = add(stage, f"/World/body/{name}", at=(x, 0, 0), scale=(0.5,) * 3, body=False)
        api = UsdPhysics.MassAPI.Apply(cube)
        api.CreateMassAttr(mass)
        if center is not None:
            api.CreateCenterOfMassAttr(Gf.Vec3f(*center) * 2)  # in the prim's own space, which is scaled
        if inertia is not None:
            api.CreateDiagonalInertiaAttr(Gf.Vec3f(*inertia))
    found = _properties(stage, "/World/body")
    assert found.mass == pytest.approx(4.0)
    assert found.center == pytest.approx([0.625, 0, 0])
    assert found.inertia == pytest.approx(np.diag([1.5, 3.4375, 4.4375]), abs=1e-6)


def test_principal_axes_of_a_child_collider_turn_with_it():
    stage = new_stage()
    body = UsdGeom.Xform.Define(stage, "/World/body").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(body)
    cube = add(stage, "/World/body/cube", rotate=(0, 0, 90), scale=(0.5,) * 3, body=False)
    UsdPhysics.MassAPI.Apply(cube).CreateDiagonalInertiaAttr(Gf.Vec3f(1, 2, 3))
    assert _properties(stage, "/World/body").inertia == pytest.approx(np.diag([2.0, 1.0, 3.0]), abs=1e-6)


def test_units_do_not_change_the_mass():
    """The same cube of 20 cm, authored in centimeters and in meters."""
    meters, centimeters = new_stage(), new_stage(meters_per_unit=0.01)
    add(meters, "/World/box", scale=(0.1, 0.1, 0.1))
    add(centimeters, "/World/box", scale=(10, 10, 10))
    assert _properties(centimeters, "/World/box").mass == pytest.approx(_properties(meters, "/World/box").mass)
    assert _properties(centimeters, "/World/box").inertia == pytest.approx(_properties(meters, "/World/box").inertia)


@pytest.mark.parametrize("given", [-1.0, float("nan")])
def test_a_mass_that_nothing_has_is_named_and_counts_as_not_given(given):
    stage = new_stage()
    UsdPhysics.MassAPI.Apply(add(stage, "/World/box")).CreateMassAttr(given)
    errors.forget_warnings()
    with pytest.warns(errors.UsdsdgWarning, match="/World/box: physics:mass is (-1|nan)"):
        found = _properties(stage, "/World/box")
    errors.forget_warnings()
    assert found.mass == pytest.approx(1000 * 0.2**3)


@pytest.mark.parametrize("mass", [1e7, 1e12])
def test_what_is_too_heavy_for_the_solver_rests_and_is_named(mass, recwarn):
    errors.forget_warnings()
    stage = new_stage()
    add(stage, "/World/ground", at=(0, 0, -0.1), scale=(5, 5, 0.1), body=False)
    prim = add(stage, "/World/box", at=(0, 0, 0.12))
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
    engine = playing(stage)
    engine.advance(2.0)
    assert position(prim)[2] == pytest.approx(0.1, abs=5e-4)
    named = [str(warning.message) for warning in recwarn if "counts as 1e+08 kg" in str(warning.message)]
    assert len(named) == (mass > 1e8)
    assert all(message.startswith("/World/box has a mass of 1e+12 kg") for message in named)

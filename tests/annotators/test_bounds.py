"""Bounds against points on the surface of each shape, made here from the schema's definitions."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from tests.stage.geometry.characters import LENGTH, add_character
from usdsdg.annotators.bounds import hulls
from usdsdg.stage.geometry.skinning import Skinning


def read_hull(prim, time) -> Any:
    return hulls.read_hull(prim, time, Skinning())


_TURN = np.linspace(0, 2 * np.pi, 721)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN), np.zeros_like(_TURN)], axis=1)


def _along_axis(points: np.ndarray, axis: str) -> np.ndarray:
    """Points made around z, turned to have `axis` as their axis."""
    return np.roll(points, {"X": 1, "Y": 2, "Z": 0}[axis], axis=1)


def _sphere(radius: float) -> np.ndarray:
    polar = np.linspace(0, np.pi, 181)[:, None, None]
    rings = np.concatenate(
        [_CIRCLE[None, :, :2] * np.sin(polar), np.broadcast_to(np.cos(polar), (181, 721, 1))], axis=2
    )
    return radius * rings.reshape(-1, 3)


def _disc(radius: float, z: float) -> np.ndarray:
    return _CIRCLE * radius + [0, 0, z]


def _shifted(points: np.ndarray, z: float) -> np.ndarray:
    return points + np.array([0, 0, z])


SURFACES = {
    "Sphere": lambda p: _sphere(p["radius"]),
    "Cylinder": lambda p: np.concatenate([_disc(p["radius"], s * p["height"] / 2) for s in (-1, 1)]),
    "Cone": lambda p: np.concatenate([_disc(p["radius"], -p["height"] / 2), [[0, 0, p["height"] / 2]]]),
    "Capsule": lambda p: np.concatenate([_shifted(_sphere(p["radius"]), s * p["height"] / 2) for s in (-1, 1)]),
    "Cube": lambda p: np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * p["size"] / 2,
}

lengths = st.floats(0.1, 3)
matrices = st.lists(st.floats(-2, 2), min_size=12, max_size=12)


@pytest.mark.parametrize("kind", SURFACES)
@pytest.mark.parametrize("axis", "XYZ")
@given(radius=lengths, height=lengths, entries=matrices)
@settings(max_examples=15, deadline=None)
def test_bounds_touch_the_surface_under_any_affine_map(kind, axis, radius, height, entries):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/shape", kind)
    sizes = {"radius": radius, "height": height, "size": radius}
    for name in sizes:
        if prim.HasAttribute(name):
            prim.GetAttribute(name).Set(sizes[name])
    if prim.HasAttribute("axis"):
        prim.GetAttribute("axis").Set(axis)
    matrix = np.eye(4)
    matrix[:, :3] = np.array(entries).reshape(4, 3)

    hull = read_hull(prim, Usd.TimeCode.Default())
    low, high = hull(matrix)

    surface = _along_axis(SURFACES[kind](sizes), axis) @ matrix[:3, :3] + matrix[3, :3]
    size = np.abs(matrix[:3, :3]).sum() * (radius + height)
    assert (surface >= low - 1e-6 * size).all()
    assert (surface <= high + 1e-6 * size).all()
    # Samples are a degree apart at most, so the outermost lies within 1 - cos(1 deg) = 1.5e-4 of the surface's reach.
    np.testing.assert_allclose(surface.min(axis=0), low, atol=2e-4 * size)
    np.testing.assert_allclose(surface.max(axis=0), high, atol=2e-4 * size)


@pytest.mark.parametrize("axis", "XYZ")
def test_a_plane_is_bounded_as_usd_computes_its_extent(axis):
    stage = Usd.Stage.CreateInMemory()
    plane = UsdGeom.Plane.Define(stage, "/plane")
    plane.CreateWidthAttr(3.0)
    plane.CreateLengthAttr(5.0)
    plane.CreateAxisAttr(axis)
    expected = UsdGeom.Boundable.ComputeExtentFromPlugins(plane, Usd.TimeCode.Default())
    bounds = read_hull(plane.GetPrim(), Usd.TimeCode.Default())(np.eye(4))
    np.testing.assert_allclose(bounds, np.array(expected))


def _mesh(points, indices) -> Usd.Prim:
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(*p) for p in points])
    mesh.CreateFaceVertexIndicesAttr(indices)
    mesh.CreateFaceVertexCountsAttr([3] * (len(indices) // 3))
    mesh.CreateExtentAttr([Gf.Vec3f(-9, -9, -9), Gf.Vec3f(9, 9, 9)])
    _mesh.stage = stage  # prims do not keep their stage alive
    return mesh.GetPrim()


def test_a_mesh_is_bounded_by_the_points_its_faces_use_not_by_its_authored_extent():
    prim = _mesh([(0, 0, 0), (1, 0, 0), (0, 2, 0), (50, 50, 50)], [0, 1, 2])
    bounds = read_hull(prim, Usd.TimeCode.Default())(np.eye(4))
    np.testing.assert_array_equal(bounds, [[0, 0, 0], [1, 2, 0]])


def test_points_that_are_not_numbers_do_not_count():
    prim = _mesh([(0, 0, 0), (1, 0, 0), (0, float("nan"), 0), (0, 1, 0)], [0, 1, 2, 0, 1, 3])
    bounds = read_hull(prim, Usd.TimeCode.Default())(np.eye(4))
    np.testing.assert_array_equal(bounds, [[0, 0, 0], [1, 1, 0]])


@pytest.mark.parametrize("indices", [[0, 1, 2, 0, 2, 3, 4, 4], [0, 1, 2, 0, 2]])
def test_bounds_of_subsets_where_indices_are_more_or_fewer_than_counts_say(indices):
    prim = _mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (9, 9, 9)], indices)
    mesh = UsdGeom.Mesh(prim)
    mesh.GetFaceVertexCountsAttr().Set([3, 3])
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, "Second", UsdGeom.Tokens.face, [1])
    assert read_hull(subset.GetPrim(), Usd.TimeCode.Default())(np.eye(4))[1].max() <= 1


def test_a_mesh_without_points_has_no_bounds():
    assert read_hull(_mesh([], []), Usd.TimeCode.Default()) is None


def test_a_skinned_mesh_is_as_large_as_its_skeleton_makes_it():
    stage = Usd.Stage.CreateInMemory()
    mesh = add_character(stage).GetPrim()
    upright, bent = (read_hull(mesh, Usd.TimeCode(code))(np.eye(4)) for code in (0, 24))
    np.testing.assert_allclose(upright, [[-0.3, -0.3, 0], [0.3, 0.3, LENGTH]], atol=1e-6)
    np.testing.assert_allclose(bent[:, 0], [-0.3, 0.3], atol=1e-6)
    np.testing.assert_allclose([bent[0, 1], bent[0, 2]], [-LENGTH / 2, -0.5], atol=1e-6)


@pytest.mark.parametrize("radii", [(0.8, 0.3), (0.2, 0.9), (0.5, 0.5), (0.4, 0.0)])
def test_a_tapered_capsule_is_as_large_as_usd_says(radii):
    stage = Usd.Stage.CreateInMemory()
    capsule = UsdGeom.Capsule_1.Define(stage, "/Capsule")
    capsule.CreateHeightAttr(2.0)
    capsule.CreateRadiusBottomAttr(radii[0])
    capsule.CreateRadiusTopAttr(radii[1])
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(capsule), Usd.TimeCode.Default())
    found = read_hull(capsule.GetPrim(), Usd.TimeCode.Default())(np.eye(4))
    np.testing.assert_allclose(found, np.array(extent), atol=1e-6)


@pytest.mark.parametrize("kind", ["Mesh", "Points", "BasisCurves"])
def test_bounds_are_those_of_points_that_velocities_have_moved(kind):
    stage = Usd.Stage.CreateInMemory()
    stage.SetTimeCodesPerSecond(24)
    prim = stage.DefinePrim("/Moving", kind)
    rest = np.array([(0, 0, 0), (1, 2, 0), (2, 0, 1)], np.float32)
    prim.GetAttribute("points").Set(Vt.Vec3fArray.FromNumpy(rest), 0)
    prim.GetAttribute("velocities").Set([Gf.Vec3f(24, 0, 0), Gf.Vec3f(24, 0, 0), Gf.Vec3f(48, 0, 0)], 0)
    if kind == "Mesh":
        prim.GetAttribute("faceVertexCounts").Set([3])
        prim.GetAttribute("faceVertexIndices").Set([0, 1, 2])
    else:
        prim.GetAttribute("widths").Set([0.5, 0.5, 0.5])
        prim.GetAttribute("widths").SetMetadata("interpolation", "vertex")
    if kind == "BasisCurves":
        prim.GetAttribute("curveVertexCounts").Set([3])
    moved = rest + np.array([(3, 0, 0), (3, 0, 0), (6, 0, 0)])  # 3 time codes, an eighth of a second
    around = 0.0 if kind == "Mesh" else 0.25
    expected = [moved.min(axis=0) - around, moved.max(axis=0) + around]
    np.testing.assert_allclose(read_hull(prim, Usd.TimeCode(3))(np.eye(4)), expected, atol=1e-6)


@pytest.mark.parametrize("kind", ["Points", "BasisCurves"])
@pytest.mark.parametrize(
    ("name", "widths", "interpolation", "radii"),
    [
        ("widths", [0.2, 0.6, 1.0], "vertex", [0.1, 0.3, 0.5]),
        ("widths", [0.4], "constant", [0.2, 0.2, 0.2]),
        ("widths", None, None, [0.5, 0.5, 0.5]),
        ("primvars:widths", [0.8], "constant", [0.4, 0.4, 0.4]),
    ],
)
def test_points_and_curves_are_bounded_by_the_balls_that_are_drawn(kind, name, widths, interpolation, radii):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Round", kind)
    centers = np.array([(0, 0, 0), (1, 2, 0), (2, 0, 1)], np.float32)
    prim.GetAttribute("points").Set(Vt.Vec3fArray.FromNumpy(centers))
    if kind == "BasisCurves":
        prim.GetAttribute("curveVertexCounts").Set([3])
        prim.GetAttribute("type").Set("linear")
    if widths:
        attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.FloatArray, False)
        attribute.Set(widths)
        attribute.SetMetadata("interpolation", interpolation)
    turn = np.eye(4)
    turn[:3, :3] = Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(1, 2, 3), 50)) * Gf.Matrix3d().SetDiagonal(Gf.Vec3d(1, 2, 3))
    surface = np.concatenate([center + _sphere(radius) for center, radius in zip(centers, radii)]) @ turn[:3, :3]
    bounds = read_hull(prim, Usd.TimeCode.Default())(turn)
    np.testing.assert_allclose(bounds, [surface.min(axis=0), surface.max(axis=0)], atol=1e-3)


@pytest.mark.parametrize(("refined", "top"), [(False, 0), (True, 7)])
def test_a_hole_has_no_surface_to_bound_unless_its_points_shape_other_faces(refined, top):
    prim = _mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 7)], [0, 1, 2, 0, 1, 3])
    UsdGeom.Mesh(prim).CreateHoleIndicesAttr([1])
    prim.CreateAttribute("refinementEnableOverride", Sdf.ValueTypeNames.Bool).Set(refined)
    assert read_hull(prim, Usd.TimeCode.Default())(np.eye(4))[1, 2] == top

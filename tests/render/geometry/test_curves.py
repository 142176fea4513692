"""Curves as tubes and points as spheres: where they run, how thick they are, closed, named when broken."""

import numpy as np
import pytest
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom, Vt
from scipy.interpolate import BSpline, CubicHermiteSpline

from usdsdg.annotators.bounds.balls import read_balls
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg_render.geometry.curves.polylines import read_polylines
from usdsdg_render.geometry.curves.tubes import Tessellation, tessellate_curves, tessellate_points
from usdsdg_render.sync.extract import SceneExtractor

DEFAULT = Usd.TimeCode.Default()
ZIGZAG = np.array([(0, 0, 0), (1, 2, 0), (3, -1, 1), (4, 1, 0), (6, 0, 2), (7, 3, 0), (9, 0, 0)], float)


# A cubic of four vertices.
NURBS = {
    "kind": "NurbsCurves",
    "vertices": ZIGZAG[:4],
    "order": [4],
    "knots": [0, 0, 0, 0, 1, 1, 1, 1],
    "ranges": [Gf.Vec2d(0, 1)],
}


def make(kind="BasisCurves", vertices=ZIGZAG, counts=None, widths=(0.2,), interpolation="constant", **attributes):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Hair", kind)
    prim.GetAttribute("points").Set(Vt.Vec3fArray.FromNumpy(np.asarray(vertices, np.float32)))
    if kind != "Points":
        prim.GetAttribute("curveVertexCounts").Set([len(vertices)] if counts is None else counts)
    if widths is not None:
        prim.GetAttribute("widths").Set(list(map(float, widths)))
        prim.GetAttribute("widths").SetMetadata("interpolation", interpolation)
    for name, value in attributes.items():
        prim.GetAttribute(name).Set(value)
    return stage, prim


def solid(surface: Tessellation) -> trimesh.Trimesh:
    """One watertight mesh: rings and caps share their places."""
    return trimesh.Trimesh(surface.points, surface.triangles, process=True)


def only_line(prim, steps=8):
    (polylines,) = read_polylines(prim, DEFAULT, None, steps)
    assert len(polylines.points) == 1
    return polylines.points[0], polylines.radii[0], polylines.closed


# Where curves run


def test_linear_curves_pass_their_vertices():
    _, prim = make(type="linear")
    points, radii, closed = only_line(prim)
    np.testing.assert_allclose(points, ZIGZAG)
    np.testing.assert_allclose(radii, 0.1, rtol=1e-6)
    assert not closed


def test_bezier_curves_follow_the_bernstein_form():
    _, prim = make(type="cubic", basis="bezier")
    points, _, _ = only_line(prim, steps=8)
    t = np.linspace(0, 1, 9)[:, None]
    pieces = []
    for first in (0, 3):
        a, b, c, d = ZIGZAG[first : first + 4]
        pieces.append((1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d)
    np.testing.assert_allclose(points, np.concatenate([pieces[0][:-1], pieces[1]]), atol=1e-6)


@pytest.mark.parametrize(("wrap", "used"), [("nonperiodic", 4), ("periodic", 3)])
def test_bezier_vertices_that_are_left_over_are_told(wrap, used):
    _, fitting = make(vertices=ZIGZAG[:used], type="cubic", basis="bezier", wrap=wrap)
    expected = only_line(fitting)[0]
    _, prim = make(vertices=ZIGZAG[:5], type="cubic", basis="bezier", wrap=wrap)
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="/Hair: Bezier curves of 5 vertices have some left over"):
        found = only_line(prim)[0]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("wrap", ["nonperiodic", "pinned", "periodic"])
def test_b_splines_are_scipys(wrap):
    _, prim = make(type="cubic", basis="bspline", wrap=wrap)
    found, _, closed = only_line(prim, steps=4)
    vertices = ZIGZAG
    if wrap == "pinned":
        vertices = np.concatenate([[2 * ZIGZAG[0] - ZIGZAG[1]], ZIGZAG, [2 * ZIGZAG[-1] - ZIGZAG[-2]]])
        np.testing.assert_allclose(found[[0, -1]], ZIGZAG[[0, -1]], atol=1e-6)
    elif wrap == "periodic":
        vertices = np.concatenate([ZIGZAG, ZIGZAG[:3]])
    spline = BSpline(np.arange(len(vertices) + 4), vertices, 3)
    t = np.linspace(3, len(vertices), 4 * (len(vertices) - 3) + 1)
    expected = spline(t)
    np.testing.assert_allclose(found, expected[:-1] if closed else expected, atol=1e-6)
    assert closed == (wrap == "periodic")


def test_catmull_rom_curves_are_hermite_splines_of_central_differences():
    _, prim = make(type="cubic", basis="catmullRom", wrap="nonperiodic")
    found, _, _ = only_line(prim, steps=4)
    inner = ZIGZAG[1:-1]
    spline = CubicHermiteSpline(np.arange(len(inner)), inner, (ZIGZAG[2:] - ZIGZAG[:-2]) / 2)
    np.testing.assert_allclose(found, spline(np.linspace(0, len(inner) - 1, len(found))), atol=1e-6)


def test_hermite_curves_follow_their_tangents():
    tangents = np.random.default_rng(0).normal(size=ZIGZAG.shape)
    _, prim = make("HermiteCurves", tangents=Vt.Vec3fArray.FromNumpy(tangents.astype(np.float32)))
    found, _, _ = only_line(prim, steps=4)
    spline = CubicHermiteSpline(np.arange(len(ZIGZAG)), ZIGZAG, tangents)
    np.testing.assert_allclose(found, spline(np.linspace(0, len(ZIGZAG) - 1, len(found))), atol=1e-6)


def test_a_rational_quadratic_is_a_circle():
    half = np.sqrt(0.5)
    vertices = [(1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 1, 0), (-1, 0, 0)]
    _, prim = make(
        "NurbsCurves", vertices, order=[3], knots=[0, 0, 0, 1, 1, 2, 2, 2], ranges=[Gf.Vec2d(0, 2)],
        pointWeights=[1, half, 1, half, 1],
    )  # fmt: skip
    found, _, _ = only_line(prim)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, atol=1e-6)
    np.testing.assert_allclose(found[[0, -1]], [[1, 0, 0], [-1, 0, 0]], atol=1e-6)


def test_widths_of_every_interpolation():
    linear = {"type": "linear", "vertices": ZIGZAG[[0, 1, 2, 3, 4, 5]], "counts": [3, 3]}
    for interpolation, widths, expected in (
        ("constant", [0.4], [[0.4] * 3] * 2),
        ("uniform", [0.4, 0.6], [[0.4] * 3, [0.6] * 3]),
        ("vertex", [1, 2, 3, 4, 5, 6], [[1, 2, 3], [4, 5, 6]]),
        ("varying", [1, 2, 3, 4, 5, 6], [[1, 2, 3], [4, 5, 6]]),
    ):
        _, prim = make(widths=widths, interpolation=interpolation, **linear)
        (polylines,) = read_polylines(prim, DEFAULT, None, 4)
        np.testing.assert_allclose(polylines.radii * 2, expected, atol=1e-6)
    # Of two Bezier segments, varying values belong to their three ends.
    _, prim = make(type="cubic", basis="bezier", widths=[1, 2, 4], interpolation="varying")
    _, radii, _ = only_line(prim, steps=2)
    np.testing.assert_allclose(radii * 2, [1, 1.5, 2, 3, 4])


@pytest.mark.parametrize(("order", "knots"), [(2, [0, 0, 1, 1.1, 7, 7.2, 9, 9]), (3, [0, 0, 0, 1, 1, 7, 9, 9, 9])])
def test_nurbs_reach_their_corners_wherever_the_knots_are(order, knots):
    vertices = ZIGZAG[:6]
    _, prim = make("NurbsCurves", vertices, order=[order], knots=knots, ranges=[Gf.Vec2d(0, 9)])
    found, _, _ = only_line(prim)
    spline = BSpline(np.array(knots, float), vertices, order - 1)
    corners = spline(np.clip(np.unique(knots), 0, 9 - 1e-12))
    away = np.linalg.norm(found[:, None] - corners[None], axis=2).min(axis=0)
    np.testing.assert_allclose(away, 0, atol=1e-6)
    assert order > 2 or len(found) == 6, "a polygon needs no samples between its vertices"


def test_varying_widths_of_nurbs_are_those_at_their_knots():
    knots = [0, 0, 0, 0, 1, 4, 4, 4, 4]
    widths = {"widths": [1, 2, 5], "interpolation": "varying"}
    _, prim = make("NurbsCurves", ZIGZAG[:5], order=[4], knots=knots, ranges=[Gf.Vec2d(0, 4)], **widths)
    points, radii, _ = only_line(prim, steps=3)
    at_knots = BSpline(np.array(knots, float), ZIGZAG[:5], 3)([0, 1, 4 - 1e-12])
    distance = np.linalg.norm(points[:, None] - at_knots[None], axis=2)
    np.testing.assert_allclose(distance.min(axis=0), 0, atol=1e-5)
    np.testing.assert_allclose(radii[distance.argmin(axis=0)] * 2, [1, 2, 5], atol=1e-6)


# How they are drawn


def test_a_straight_tube_is_a_closed_cylinder_facing_out():
    _, prim = make(vertices=[(0, 0, 0), (0, 0, 3)], type="linear", widths=[0.5])
    surface = tessellate_curves(prim, DEFAULT, Skinning())
    mesh = solid(surface)
    assert mesh.is_watertight
    sides = 16
    area = 0.5 * sides * 0.25**2 * np.sin(2 * np.pi / sides)
    assert mesh.volume == pytest.approx(3 * area, rel=1e-5)
    flat = np.cross(
        *(surface.points[surface.triangles[:, k]] - surface.points[surface.triangles[:, 0]] for k in (1, 2))
    )
    assert (np.einsum("ti,tci->tc", flat, surface.normals) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=-1), 1.0, atol=1e-5)


@pytest.mark.parametrize("basis", ["bspline", "catmullRom"])
def test_closed_curves_are_closed_tubes_without_a_twist(basis):
    knot = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    trefoil = np.stack(
        [np.sin(knot) + 2 * np.sin(2 * knot), np.cos(knot) - 2 * np.cos(2 * knot), -np.sin(3 * knot)], -1
    )
    _, prim = make(vertices=trefoil, type="cubic", basis=basis, wrap="periodic")
    surface = tessellate_curves(prim, DEFAULT, Skinning())
    mesh = solid(surface)
    assert mesh.is_watertight
    assert mesh.euler_number == 0, "a torus"
    edges = np.linalg.norm(mesh.vertices[mesh.edges_unique[:, 0]] - mesh.vertices[mesh.edges_unique[:, 1]], axis=1)
    assert edges.max() < 0.35, "no edge crosses the tube because its ends do not meet"


ESS = np.array([(-0.8, -0.5, 0), (-0.3, 0.8, 0), (0.3, -0.8, 0), (0.8, 0.5, 0)])


def bernstein(count, vertices=ESS):
    t = np.linspace(0, 1, count)[:, None]
    return np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3]) @ vertices


@pytest.mark.parametrize("width", [0.1, 0.004])
def test_chords_stay_close_to_a_curve(width):
    _, prim = make(vertices=ESS, widths=[width], type="cubic", basis="bezier")
    surface = tessellate_curves(prim, DEFAULT, Skinning())
    rings = (len(surface.points) - 2 * 17) // 16  # the rest is caps
    centers = surface.points[: 16 * rings].reshape(rings, 16, 3).mean(axis=1)
    along = np.linspace(0, 1, 20)[:, None, None]
    chords = (centers[:-1] * (1 - along) + centers[1:] * along).reshape(-1, 3)
    distance = np.linalg.norm(chords[:, None] - bernstein(4000)[None], axis=2).min(axis=1).max()
    # The share of the radius or of the extent that docs/geometry.md states; float32 and the samples of the curve.
    assert distance < max(0.05 * width / 2, 1.6 / 2000) + 5e-4 * 0.05
    assert rings in (17, 33, 65)


@pytest.mark.parametrize(
    ("vertices", "count", "most"),
    [
        (np.linspace(0, 1, 4)[:, None] * np.ones(3), 1, 2 * 16 * 9),  # straight
        (ESS, 400, 512_000),
        (ESS, 2_000, 1_000_000),
    ],
)
def test_what_is_straight_or_many_is_not_refined_beyond_its_bounds(vertices, count, most):
    _, prim = make(vertices=np.tile(vertices, (count, 1)), counts=[4] * count, type="cubic", basis="bezier")
    assert len(tessellate_curves(prim, DEFAULT, Skinning()).triangles) <= most


def test_deforming_curves_keep_their_topology():
    _, prim = make(vertices=ESS, widths=[0.004], type="cubic", basis="bezier")
    points = prim.GetAttribute("points")
    points.Set(Vt.Vec3fArray.FromNumpy(ESS.astype(np.float32)), 0)
    points.Set(Vt.Vec3fArray.FromNumpy((ESS * (1, 0.01, 1)).astype(np.float32)), 10)
    counts = {len(tessellate_curves(prim, Usd.TimeCode(time), Skinning()).triangles) for time in (0, 5, 10)}
    assert len(counts) == 1


def test_deforming_curves_keep_their_triangles_at_corners():
    bent = np.array([(0, 0, 0), (1, 0, 0), (1, 0, 1), (2, 0, 1)], float)
    _, prim = make(vertices=bent, type="linear")
    points = prim.GetAttribute("points")
    rng = np.random.default_rng(0)
    for time in range(6):
        moved = bent + rng.uniform(-0.2, 0.2, bent.shape) * (time > 0)
        points.Set(Vt.Vec3fArray.FromNumpy(moved.astype(np.float32)), time)
    first = tessellate_curves(prim, Usd.TimeCode(0), Skinning())
    for time in (1, 2.5, 5):
        surface = tessellate_curves(prim, Usd.TimeCode(time), Skinning())
        np.testing.assert_array_equal(surface.triangles, first.triangles)


def test_bent_tubes_keep_their_thickness():
    angle = np.linspace(0, np.pi, 50)
    arc = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    _, prim = make(vertices=arc, type="linear", widths=[0.2])
    mesh = solid(tessellate_curves(prim, DEFAULT, Skinning()))
    # Pappus: the area of the section times the way of its middle.
    section = 8 * 0.1**2 * np.sin(2 * np.pi / 16)
    assert mesh.volume == pytest.approx(section * np.pi, rel=2e-3)


@pytest.mark.parametrize("wrap", ["nonperiodic", "periodic"])
@pytest.mark.parametrize(
    "vertices",
    [
        [(0, 0, 0), (2, 0, 0), (2, 2, 0)],
        [(0, 0, 0), (2, 0.3, 0), (0, 0.6, 0), (2, 0.9, 0)],
        [(0, 0, 0), (4, 0, 0), (4, 0.6, 0), (4.6, 0.6, 0)],
        [(0, 0, 0), (2, 0, 0), (1, 0, 0), (1, 1, 0)],  # turns back
        [(0, 0, 0), (1, 0, 0), (1, 0, 0), (1, 1, 0)],  # twice the same place
    ],
)
def test_tubes_are_as_thick_along_chords_at_corners(vertices, wrap):
    """Seen from above, a tube covers what is nearer to its chords than the radius of the circle in its section."""
    vertices, radius = np.array(vertices, float), 0.1
    _, prim = make(vertices=vertices, type="linear", wrap=wrap, widths=[2 * radius])
    surface = tessellate_curves(prim, DEFAULT, Skinning())
    chords = list(zip(vertices, np.roll(vertices, -1, axis=0)))[: None if wrap == "periodic" else -1]
    x, y = np.random.default_rng(0).uniform(vertices.min(0) - 0.2, vertices.max(0) + 0.2, (4000, 3))[:, :2].T
    places = np.stack([x, y, np.full_like(x, 5.0)], axis=-1)
    mesh = trimesh.Trimesh(surface.points, surface.triangles, process=False)
    drawn = mesh.ray.intersects_any(places, np.tile([0.0, 0.0, -1.0], (len(x), 1)))
    off_chords, off_ends = np.full(len(x), np.inf), np.full(len(x), np.inf)
    for start, end in chords:
        along = end[:2] - start[:2]
        share = (places[:, :2] - start[:2]) @ along / max(along @ along, 1e-12)
        distance = np.linalg.norm(places[:, :2] - start[:2] - np.clip(share, 0, 1)[:, None] * along, axis=1)
        off_chords = np.minimum(off_chords, distance)
        off_ends = np.minimum(off_ends, np.where((share > 0) & (share < 1), distance, np.inf))
    inside, outside = radius * np.cos(np.pi / 16), radius * 1.001  # sections have 16 sides
    assert drawn[off_ends < inside * 0.99].all()
    assert not drawn[off_chords > outside].any()
    inner = vertices if wrap == "periodic" else vertices[1:-1]
    at_corners = np.linalg.norm(places[:, None, :2] - inner[None, :, :2], axis=2).min(axis=1)
    # Facets of the ball, too.
    assert drawn[(at_corners < inside * np.cos(np.pi / 16) * 0.99)].all()


def test_textures_run_evenly_along_tubes_with_corners():
    _, prim = make(vertices=[(0, 0, 0), (2, 0, 0), (2, 2, 0)], type="linear", widths=[0.2])
    surface = tessellate_curves(prim, DEFAULT, Skinning())
    side = surface.uvs[: -2 * 16].reshape(-1, 2)
    places = surface.points[surface.triangles[: -2 * 16]].reshape(-1, 3)
    np.testing.assert_allclose(side[places[:, 0] < 0.1, 1], 0.0)
    np.testing.assert_allclose(side[places[:, 1] > 1.9, 1], 1.0)
    np.testing.assert_allclose(side[np.linalg.norm(places - (2, 0, 0), axis=1) < 0.2, 1], 0.5)


def painted(prim, interpolation, count, name="displayColor"):
    """Random colors along the curves of a prim, and the prototype that shows them."""
    colors = np.random.default_rng(1).uniform(0.1, 0.9, (count, 3)).astype(np.float32)
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, Sdf.ValueTypeNames.Color3fArray, interpolation)
    primvar.Set(Vt.Vec3fArray.FromNumpy(colors))
    extractor = SceneExtractor(prim.GetStage())
    extractor.update()
    (prototype,) = extractor.scene.prototypes
    assert prototype.colors is not None
    return colors, prototype.points[prototype.triangles].reshape(-1, 3), prototype.colors.reshape(-1, 4)[:, :3]


@pytest.mark.parametrize(
    ("kind", "interpolation"),
    [
        *((kind, each) for kind in ("linear", "catmullRom", "HermiteCurves") for each in ("vertex", "varying")),
        ("NurbsCurves", "vertex"),  # varying values belong to knots
    ],
)
def test_colors_run_along_curves(kind, interpolation):
    """Vertices of straight curves that these pass have their colors; between them colors run evenly."""
    heights = np.array([0, 1, 2, 3, 4.0])
    straight = np.concatenate([heights[:, None] * (0, 1, 0) + (x, 0, 0) for x in (0, 5)])
    common = {"vertices": straight, "counts": [5, 5]}
    if kind == "HermiteCurves":
        _, prim = make(kind, tangents=[Gf.Vec3f(0, 1, 0)] * 10, **common)
    elif kind == "NurbsCurves":
        _, prim = make(kind, order=[2, 2], knots=[0, 0, 1, 2, 3, 4, 4] * 2, **common)
    elif kind == "linear":
        _, prim = make(type="linear", **common)
    else:
        _, prim = make(type="cubic", basis=kind, wrap="pinned", **common)
    colors, at, found = painted(prim, interpolation, 10)
    for x, own in ((0, colors[:5]), (5, colors[5:])):
        here = np.abs(at[:, 0] - x) < 1
        expected = np.stack([np.interp(at[here, 1], heights, own[:, k]) for k in range(3)], axis=-1)
        np.testing.assert_allclose(found[here], expected, atol=1e-5)


def test_vertex_colors_of_b_splines_are_blended_as_their_points_are():
    vertices = np.arange(6.0)[:, None] * (0, 1, 0)
    _, prim = make(vertices=vertices, type="cubic", basis="bspline", wrap="nonperiodic")
    colors, at, found = painted(prim, "vertex", 6)
    spline = BSpline(np.arange(10.0), colors, 3)
    for height in (1, 2, 3, 4):  # where segments meet
        here = np.abs(at[:, 1] - height) < 1e-5
        assert here.any()
        np.testing.assert_allclose(found[here], np.broadcast_to(spline(height + 2.0), (here.sum(), 3)), atol=1e-5)


def test_colors_of_closed_curves_run_through_their_start():
    square = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)]
    _, prim = make(vertices=square, type="linear", wrap="periodic")
    colors, at, found = painted(prim, "varying", 4)
    on_last = (np.abs(at[:, 0]) < 0.2) & (at[:, 1] > 0.2) & (at[:, 1] < 3.8)
    assert not on_last.any(), "there are corners only"
    for corner, color in zip(square, colors):
        here = np.linalg.norm(at - corner, axis=1) < 0.3
        np.testing.assert_allclose(found[here], np.broadcast_to(color, (here.sum(), 3)), atol=1e-5)


def test_points_are_spheres_of_their_widths():
    centers = [(0, 0, 0), (5, 0, 0), (0, 5, 0)]
    _, prim = make("Points", centers, widths=[1, 2, 3], interpolation="vertex")
    surface = tessellate_points(prim, DEFAULT, Skinning())
    for k, (center, width) in enumerate(zip(centers, (1, 2, 3))):
        mine = surface.triangles[surface.owners == k]
        at = surface.points[mine] - np.array(center)
        np.testing.assert_allclose(np.linalg.norm(at, axis=-1), width / 2, atol=1e-5)
        np.testing.assert_allclose(surface.normals[surface.owners == k], at / (width / 2), atol=1e-4)
        volume = trimesh.Trimesh(surface.points, mine).volume
        assert 0.98 < volume / (np.pi / 6 * width**3) < 1.0


def test_many_points_are_drawn_coarser():
    rng = np.random.default_rng(0)
    _, prim = make("Points", rng.normal(size=(60_000, 3)), widths=[0.01])
    assert len(tessellate_points(prim, DEFAULT, Skinning()).triangles) == 60_000 * 32


def test_they_come_into_the_scene_like_every_gprim():
    stage, prim = make(type="linear")
    second = UsdGeom.Points.Define(stage, "/Cloud")
    second.CreatePointsAttr([Gf.Vec3f(0, 0, 5)])
    second.CreateWidthsAttr([1.0])
    UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    extractor = SceneExtractor(stage)
    extractor.update()
    assert extractor.scene.instances.paths == ("/Hair", "/Cloud")
    assert extractor.scene.instances.local_to_world[0, 3, :3].tolist() == [1, 2, 3]
    bounds = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), DEFAULT)
    drawn = extractor.scene.prototypes[0].points
    assert (drawn.min(0) >= np.array(bounds[0]) - 1e-5).all()
    assert (drawn.max(0) <= np.array(bounds[1]) + 1e-5).all()
    prim.GetAttribute("widths").Set([0.8])
    extractor.update()
    assert extractor.scene.prototypes[extractor.scene.instances.prototype[0]].points[:, 2].max() > drawn[:, 2].max()


# Broken data


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"counts": [99]}, "sum to 99"),
        ({"counts": [4], "type": "linear"}, "the last 3 points belong to no curve .* sum to 4"),
        ({"vertices": ZIGZAG[:3], "type": "cubic"}, "need 4 or more"),
        ({"vertices": ZIGZAG[:1], "type": "linear"}, "curves of 1 vertex are not drawn"),
        ({"widths": None}, "no widths"),
        ({"widths": [1, 2], "interpolation": "vertex", "type": "linear"}, "too few for the curves"),
        ({"kind": "HermiteCurves"}, "tangents"),
        ({"kind": "NurbsCurves", "order": [3], "knots": [0, 1]}, "knots do not fit"),
        ({**NURBS, "knots": [0, 0, 0, 1, 0, 1, 1, 1]}, r"knots are \[0.0, .*\] is not drawn. .* do not decrease"),
        ({**NURBS, "knots": [0, 0, 0, 0, np.nan, 1, 1, 1]}, "knots are .*nan.* is not drawn"),
        ({**NURBS, "knots": [0] * 8}, "first and the last of the curve differ"),
        ({**NURBS, "order": [1]}, "order 1 is not drawn. Correct order"),
        ({**NURBS, "order": [5], "knots": list(range(9))}, "order 5 with 4 vertices is not drawn"),
        ({**NURBS, "ranges": [Gf.Vec2d(2, 3)]}, r"ranges \(2.0, 3.0\) name no part .* from 0 to 1; all of it is drawn"),
        ({**NURBS, "pointWeights": [0.0] * 4}, "1 curve is not drawn, .* or its weights give no points"),
        ({"normals": [Gf.Vec3f(0, 0, 1)] * 7, "type": "linear"}, "ribbons"),
        ({"kind": "Points", "widths": None}, "no widths"),
        ({"kind": "Points", "widths": [1, 2], "interpolation": "vertex"}, "too few for 7 points"),
        ({"kind": "Points", "widths": [0]}, "7 points are NaN or infinite or of no width"),
        ({"widths": [0]}, "1 curve is not drawn, since points or widths of it are NaN or infinite, or no width is > 0"),
        ({"widths": [-1]}, "no width is > 0"),
        ({"widths": [np.nan]}, "1 curve is not drawn"),
        ({"vertices": np.zeros((4, 3)), "type": "linear", "wrap": "periodic"}, "too thin or too short"),
        ({"vertices": np.full((4, 3), np.inf)}, "1 curve is not drawn"),
        ({"basis": "bogus"}, "basis 'bogus' is none of bezier, bspline, catmullRom; bezier is used"),
        ({"wrap": "bogus"}, "wrap 'bogus' is none of"),
    ],
)
def test_what_cannot_be_drawn_is_named(changes, said):
    stage, _ = make(**changes)
    with pytest.warns(UserWarning, match=f"/Hair.*{said}"):
        SceneExtractor(stage).update()


@pytest.mark.parametrize("kind", ["BasisCurves", "Points"])
@pytest.mark.parametrize("bad", [-1, 2])
def test_indices_of_widths_that_name_none_take_the_first_one(kind, bad):
    _, prim = make(kind, ZIGZAG[:3], widths=None, **({"type": "linear"} if kind == "BasisCurves" else {}))
    widths = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("widths", Sdf.ValueTypeNames.FloatArray, "vertex")
    widths.Set([0.5, 2.0])
    widths.SetIndices([1, bad, 1])
    with pytest.warns(UserWarning, match=r"/Hair: 1 entry of primvars:widths:indices outside of its 2 widths"):
        surface = (tessellate_points if kind == "Points" else tessellate_curves)(prim, DEFAULT, Skinning())
    widths.SetIndices([1, 0, 1])
    expected = (tessellate_points if kind == "Points" else tessellate_curves)(prim, DEFAULT, Skinning())
    assert np.array_equal(surface.points, expected.points)
    widths.SetIndices([1, bad, 1])
    assert read_balls(prim, DEFAULT, Skinning())[1].max() == 1.0


def test_broken_points_and_widths_leave_the_others():
    _, prim = make("Points", [(0, 0, 0), (np.nan, 0, 0), (1, 0, 0)], widths=[1, 1, -1], interpolation="vertex")
    with pytest.warns(UserWarning, match="2 points are NaN"):
        assert set(tessellate_points(prim, DEFAULT, Skinning()).owners) == {0}
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (np.nan, 1, 0)]
    _, prim = make(vertices=vertices, counts=[2, 2], widths=[0, 1, 1, 1], interpolation="vertex", type="linear")
    with pytest.warns(UserWarning, match="1 curve is not drawn"):
        assert set(tessellate_curves(prim, DEFAULT, Skinning()).owners) == {0}
    _, prim = make(vertices=[(0, 0, 0), (0, 0, 0), (0, 0, 0)], type="linear")
    surface = tessellate_curves(prim, DEFAULT, Skinning())
    assert surface is None or np.isfinite(surface.normals).all()

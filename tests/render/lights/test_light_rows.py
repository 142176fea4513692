"""UsdLux to light rows: the schema's formulas, units, scale, shaping, and warnings."""

import math
import warnings

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from usdsdg.stage.poses.transforms import local_to_world
from usdsdg_render.lights.light_reader import LightReader
from usdsdg_render.lights.light_rows import read_light
from usdsdg_render.lights.light_values import temperature_color
from usdsdg_render.lights.power import ellipse_perimeter, ellipsoid_area
from usdsdg_render.scene import structs

ALIVE = []  # a prim does not keep its stage


def light(kind, **inputs):
    stage = Usd.Stage.CreateInMemory()
    ALIVE.append(stage)
    prim = stage.DefinePrim("/Light", kind)
    for name, value in inputs.items():
        prim.GetAttribute("inputs:" + name.replace("__", ":")).Set(value)
    return stage, prim


def row_of(prim, meters_per_unit=1.0):
    return read_light(prim, np.array(local_to_world(prim)), meters_per_unit)


@pytest.mark.parametrize(("level", "count"), [(255.0, 1), (2.0, 0)])
def test_colors_in_levels_of_0_to_255_are_warned_of_once(level, count):
    _, first = light("SphereLight", color=Gf.Vec3f(level, 0.0, 0.0))
    _, second = light("RectLight", color=Gf.Vec3f(0.0, level, 0.0))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        row_of(first), row_of(second)
    assert [str(each.message).startswith("/Light: inputs:color is 255") for each in said] == [True] * count


def scaled(prim, *scale):
    UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(*scale))


def ellipsoid_surface(a, b, c):
    """Area of an ellipsoid by quadrature over its two angles."""
    t = (np.arange(2000) + 0.5) * 2 * math.pi / 2000
    theta = ((np.arange(1000) + 0.5) * math.pi / 1000)[:, None]
    along = np.stack([a * np.cos(theta) * np.cos(t), b * np.cos(theta) * np.sin(t), -c * np.sin(theta) + 0 * t], -1)
    across = np.stack([-a * np.sin(theta) * np.sin(t), b * np.sin(theta) * np.cos(t), 0 * theta * t], -1)
    return np.linalg.norm(np.cross(along, across), axis=-1).mean() * math.pi * 2 * math.pi


def tube_surface(b, c, length):
    t = (np.arange(2000) + 0.5) * 2 * math.pi / 2000
    return length * np.hypot(b * np.sin(t), c * np.cos(t)).mean() * 2 * math.pi


def flux_per_pi(row):
    """Luminance times emitting area, as the kernels see the light."""
    radius, width, height = float(row["radius"]), float(row["width"]), float(row["height"])
    second, third = radius * row["aspect"].astype(float)
    area = {
        structs.LIGHT_SPHERE: lambda: 4 * math.pi * radius**2,
        structs.LIGHT_DISK: lambda: math.pi * radius * second,
        structs.LIGHT_RECT: lambda: width * height,
        structs.LIGHT_CYLINDER: lambda: tube_surface(radius, second, height),
        structs.LIGHT_ELLIPSOID: lambda: ellipsoid_surface(radius, second, third),
    }[int(row["kind"])]()
    return np.asarray(row["radiance"], float) * area


SIZES = {
    "SphereLight": ({"radius": 0.3}, 4 * math.pi * 0.09),
    "DiskLight": ({"radius": 0.3}, math.pi * 0.09),
    "RectLight": ({"width": 2.0, "height": 0.5}, 1.0),
    "CylinderLight": ({"length": 2.0, "radius": 0.3}, 2 * math.pi * 0.3 * 2.0),
}


@pytest.mark.parametrize("kind", SIZES)
def test_luminance_is_intensity_times_two_to_the_exposure_times_color(kind):
    _, prim = light(kind, intensity=5.0, exposure=3.0, color=Gf.Vec3f(0.5, 1.0, 0.25), **SIZES[kind][0])
    np.testing.assert_allclose(row_of(prim)["radiance"], 40.0 * np.array([0.5, 1.0, 0.25]), rtol=1e-6)


@pytest.mark.parametrize("kind", SIZES)
@pytest.mark.parametrize("scale", [1.0, 4.0])
def test_normalize_divides_by_the_world_area(kind, scale):
    sizes, area = SIZES[kind]
    _, prim = light(kind, intensity=5.0, normalize=True, **sizes)
    scaled(prim, scale, scale, scale)
    row = row_of(prim)
    np.testing.assert_allclose(row["radiance"], 5.0 / (area * scale**2), rtol=1e-5)
    np.testing.assert_allclose(flux_per_pi(row), 5.0, rtol=1e-5)


@pytest.mark.parametrize("kind", ["SphereLight", "DiskLight", "CylinderLight"])
def test_normalize_keeps_the_power_under_any_scale(kind):
    _, prim = light(kind, intensity=5.0, normalize=True, **SIZES[kind][0])
    scaled(prim, 1, 3, 2)
    # The area of an ellipsoid is approximated within 1.1 %.
    np.testing.assert_allclose(flux_per_pi(row_of(prim)), 5.0, rtol=0.012)


@pytest.mark.parametrize(
    "name", ["diffuse", "specular", "shaping__cone__angle", "shaping__cone__softness", "shaping__focus"]
)
def test_invalid_numbers_warn_and_are_replaced(name):
    _, prim = light("SphereLight")
    UsdLux.ShapingAPI.Apply(prim)
    before = row_of(prim)
    prim.GetAttribute("inputs:" + name.replace("__", ":")).Set(math.nan)
    with pytest.warns(UserWarning, match=f"/Light.*{name.rsplit('__', 1)[-1]}"):
        after = row_of(prim)
    if "shaping" in name:
        assert after["shaping_cos"] <= before["shaping_cos"]
    else:
        assert after == before


def test_default_sizes_and_intensities_are_the_schemas():
    assert row_of(light("SphereLight")[1])["radius"] == 0.5
    assert row_of(light("CylinderLight")[1])["height"] == 1.0
    assert row_of(light("RectLight")[1])["width"] == 1.0
    assert row_of(light("DiskLight")[1])["radiance"][0] == 1.0


@pytest.mark.parametrize("normalize", [False, True])
@pytest.mark.parametrize("angle", [0.0, 0.001, 0.1, 0.53, 5.0, 90.0, 180.0])
def test_a_surface_facing_a_distant_light_receives_its_intensity_in_lux(angle, normalize):
    _, prim = light("DistantLight", intensity=400.0, angle=angle, normalize=normalize)
    row = row_of(prim)
    cosine = float(row["cos_angle"])
    assert cosine == pytest.approx(math.cos(math.radians(angle / 2)), abs=1e-7)
    # Irradiance of a cone of constant radiance: L * pi * sin^2.
    lux = row["radiance"] if cosine == 1.0 else row["radiance"] * math.pi * (1 - cosine**2)
    np.testing.assert_allclose(lux, 400.0, rtol=1e-5)


def test_temperature_is_white_at_6500_and_blackbody_elsewhere():
    np.testing.assert_allclose(temperature_color(6500.0), 1.0)
    warm = np.array(UsdLux.BlackbodyTemperatureAsRgb(3000)) / np.array(UsdLux.BlackbodyTemperatureAsRgb(6500))
    _, prim = light("SphereLight", colorTemperature=3000.0)
    np.testing.assert_allclose(row_of(prim)["radiance"], 1.0)
    prim.GetAttribute("inputs:enableColorTemperature").Set(True)
    np.testing.assert_allclose(row_of(prim)["radiance"], warm, rtol=1e-6)
    assert warm[0] > warm[1] > warm[2]


@pytest.mark.parametrize(
    ("kind", "half_axes"),
    [("SphereLight", (0.3, 0.6, 0.9)), ("DiskLight", (0.3, 0.6)), ("CylinderLight", (0.6, 0.9))],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_scaled_ellipses_have_the_same_luminance(kind, half_axes, sign, recwarn):
    _, prim = light(kind, intensity=7.0, **SIZES[kind][0])
    scaled(prim, sign, 2, 3)
    row = row_of(prim)
    axes = float(row["radius"]) * np.array([1.0, *row["aspect"]])[: len(half_axes)]
    np.testing.assert_allclose(axes, half_axes, rtol=1e-6)
    np.testing.assert_allclose(row["radiance"], 7.0, rtol=1e-6)
    np.testing.assert_allclose(row["x_axis"], (sign, 0, 0), atol=1e-7)
    assert not recwarn.list


def test_sheared_lights_warn():
    stage, _ = light("RectLight")
    UsdGeom.Xformable(UsdGeom.Xform.Define(stage, "/Parent")).AddScaleOp().Set(Gf.Vec3f(1, 3, 1))
    child = stage.DefinePrim("/Parent/Light", "RectLight")
    UsdGeom.Xformable(child).AddRotateZOp().Set(30.0)
    with pytest.warns(UserWarning, match="/Parent/Light.*sheared"):
        assert row_of(child) is not None


@pytest.mark.parametrize(("kind", "hint"), [("SphereLight", "treatAsPoint"), ("CylinderLight", "treatAsLine")])
def test_points_and_lines_keep_the_flux_of_their_size(kind, hint):
    _, prim = light(kind, intensity=5.0, **SIZES[kind][0])
    whole = row_of(prim)
    prim.GetAttribute(hint).Set(True)
    row = row_of(prim)
    assert row["radius"] == pytest.approx(1e-3)
    assert row["height"] == whole["height"]
    np.testing.assert_allclose(flux_per_pi(row), flux_per_pi(whole), rtol=1e-5)


def test_rect_scale_applies_to_each_side():
    _, prim = light("RectLight", width=2.0, height=0.5)
    scaled(prim, 3, 4, 5)
    row = row_of(prim)
    assert (row["width"], row["height"], row["radiance"][0]) == (6.0, 2.0, 1.0)


def test_area_formulas_are_exact_for_circles_and_spheres():
    assert ellipsoid_area(2, 2, 2) == pytest.approx(16 * math.pi)
    assert ellipse_perimeter(2, 2) == pytest.approx(4 * math.pi)


def test_frame_and_position_come_from_the_transform():
    stage, _ = light("RectLight")
    parent = UsdGeom.Xform.Define(stage, "/Parent")
    parent.AddRotateXYZOp().Set(Gf.Vec3f(30, 40, 50))
    parent.AddScaleOp().Set(Gf.Vec3f(2))
    child = stage.DefinePrim("/Parent/Light", "RectLight")
    UsdGeom.Xformable(child).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    matrix = np.array(local_to_world(child))
    row = read_light(child, matrix, 1.0)
    np.testing.assert_allclose(row["position"], matrix[3, :3], rtol=1e-6)
    for name, axis in zip(("x_axis", "y_axis", "z_axis"), np.eye(3)):
        np.testing.assert_allclose(row[name], axis @ matrix[:3, :3] / 2.0, atol=1e-6)


def test_shaping_applies_only_if_authored():
    _, prim = light("SphereLight")
    row = row_of(prim)
    assert (row["shaping_cos"], row["shaping_focus"], row["shaping_softness"]) == (-1.0, 0.0, 0.0)
    shaping = UsdLux.ShapingAPI.Apply(prim)
    shaping.CreateShapingConeAngleAttr(30.0)
    shaping.CreateShapingConeSoftnessAttr(0.25)
    shaping.CreateShapingFocusAttr(2.0)
    row = row_of(prim)
    assert row["shaping_cos"] == pytest.approx(math.cos(math.radians(30)))
    assert (row["shaping_focus"], row["shaping_softness"]) == (2.0, 0.25)
    shaping.CreateShapingFocusTintAttr(Gf.Vec3f(0.25, 0.5, 1.0))
    np.testing.assert_allclose(row_of(prim)["focus_tint"], (0.25, 0.5, 1.0))
    shaping.GetShapingConeAngleAttr().Set(180.0)
    assert row_of(prim)["shaping_cos"] == -1.0


def test_multipliers_and_camera_visibility():
    _, prim = light("SphereLight", diffuse=0.5, specular=0.0)
    row = row_of(prim)
    assert (row["diffuse"], row["specular"], row["visible"]) == (0.5, 0.0, 1)
    prim.CreateAttribute("visibleInPrimaryRay", Sdf.ValueTypeNames.Bool).Set(False)
    assert row_of(prim)["visible"] == 0


def test_names_without_inputs_are_accepted_and_inputs_win():
    _, prim = light("SphereLight")
    prim.CreateAttribute("intensity", Sdf.ValueTypeNames.Float).Set(30.0)
    prim.CreateAttribute("radius", Sdf.ValueTypeNames.Float).Set(0.25)
    row = row_of(prim)
    assert (row["radiance"][0], row["radius"]) == (30.0, 0.25)
    prim.GetAttribute("inputs:intensity").Set(2.0)
    assert row_of(prim)["radiance"][0] == 2.0


@pytest.mark.parametrize("inputs", [{"intensity": 0.0}, {"color": Gf.Vec3f(0)}])
def test_dark_lights_are_skipped(inputs, recwarn):
    assert row_of(light("SphereLight", **inputs)[1]) is None
    assert not recwarn.list


@pytest.mark.parametrize(
    "inputs",
    [{"intensity": -1.0}, {"intensity": math.nan}, {"exposure": 5000.0}, {"radius": 0.0}, {"radius": -1.0}],
)
def test_invalid_lights_warn_and_are_off(inputs):
    with pytest.warns(UserWarning, match="/Light"):
        assert row_of(light("SphereLight", **inputs)[1]) is None


def test_zero_scale_warns_and_is_off():
    _, prim = light("SphereLight")
    scaled(prim, 1, 0, 1)
    with pytest.warns(UserWarning, match="/Light"):
        assert row_of(prim) is None


def test_a_point_light_with_normalize_keeps_its_power():
    _, prim = light("SphereLight", radius=0.0, normalize=True, intensity=9.0)
    row = row_of(prim, meters_per_unit=0.01)
    assert row["radius"] == pytest.approx(0.1)  # a millimeter in a stage of centimeters
    np.testing.assert_allclose(flux_per_pi(row), 9.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("author", "name"),
    [
        (lambda p: UsdLux.ShapingAPI.Apply(p).CreateShapingIesFileAttr("a.ies"), "ies:file names a.ies"),
        (lambda p: UsdLux.LightAPI(p).GetFiltersRel().AddTarget("/Filter"), "light:filters"),
        (lambda p: UsdLux.LightAPI(p).GetIntensityAttr().AddConnection("/Knob.outputs:out"), "of inputs:intensity the"),
        (lambda p: UsdLux.ShadowAPI.Apply(p).CreateShadowColorAttr(Gf.Vec3f(-1, 0, 0)), "shadow:color"),
    ],
)
def test_ignored_inputs_warn(author, name):
    _, prim = light("SphereLight")
    author(prim)
    with pytest.warns(UserWarning, match=f"/Light.*{name}"):
        lights = LightReader().read([prim], [np.array(local_to_world(prim))], 1.0, [])
    assert len(lights.table) == 1
    assert not lights.profiles
    assert not lights.links


def test_power_is_positive_and_grows_with_the_flux():
    dim = row_of(light("SphereLight", radius=0.1)[1])["power"]
    bright = row_of(light("SphereLight", radius=0.2)[1])["power"]
    assert dim > 0
    assert bright == pytest.approx(4 * dim)
    assert row_of(light("DistantLight")[1])["power"] > 0


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("kind", ["SphereLight", "DiskLight", "RectLight", "CylinderLight", "DistantLight"])
@pytest.mark.parametrize("normalize", [False, True])
def test_other_brightness_and_color_give_the_row_of_a_fresh_reading(kind, normalize):
    _, prim = light(kind, normalize=normalize, diffuse=0.5)
    UsdLux.ShapingAPI.Apply(prim).CreateShapingConeAngleAttr(40.0)
    scaled(prim, 1, 2, 3)
    move = UsdGeom.Xformable(prim).AddTranslateOp()
    reader, rng = LightReader(), np.random.default_rng(0)

    def rows(reader):
        return reader.read([prim], np.array(local_to_world(prim))[None], 0.01, ()).table

    edits = {
        "intensity": lambda: float(rng.choice([0.0, 3.0, 1e30, math.nan, 500.0])),
        "exposure": lambda: float(rng.uniform(-2, 2)),
        "color": lambda: Gf.Vec3f(*rng.random(3).tolist()),
        "enableColorTemperature": lambda: bool(rng.integers(2)),
        "colorTemperature": lambda: float(rng.uniform(2000, 9000)),
    }
    lit = 0
    for _ in range(60):
        for name in rng.choice([*edits], 2):
            prim.GetAttribute(f"inputs:{name}").Set(edits[name]())
        if rng.random() < 0.2:
            move.Set(Gf.Vec3d(*rng.random(3).tolist()))
        reader.invalidate_emission({prim.GetPath()})
        found = rows(reader)
        assert found.tobytes() == rows(LightReader()).tobytes()
        lit += len(found)
    assert 10 < lit < 60


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
def test_lights_that_are_read_together_move_alone_and_have_the_rows_of_a_fresh_reading():
    """The row of a light depends neither on the lights beside it nor on where it stood before."""
    stage, rng = Usd.Stage.CreateInMemory(), np.random.default_rng(1)
    prims = [
        stage.DefinePrim(f"/L{k}", f"{kind}Light")
        for k, kind in enumerate(("Sphere", "Disk", "Rect", "Cylinder", "Distant") * 4)
    ]
    for prim in prims:
        prim.GetAttribute("inputs:normalize").Set(bool(rng.integers(2)))
        UsdGeom.Xformable(prim).AddTransformOp()
    reader, lit = LightReader(), 0
    for _ in range(20):
        for prim in rng.choice(len(prims), 5):
            scale = rng.choice([0.0, 0.5, 3.0], 3, p=[0.02, 0.49, 0.49])
            turned = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            matrix = np.eye(4)
            matrix[:3, :3], matrix[3, :3] = scale[:, None] * turned, rng.uniform(-9, 9, 3)
            prims[prim].GetAttribute("xformOp:transform").Set(Gf.Matrix4d(matrix.tolist()))
        matrices = np.array([np.array(local_to_world(prim)) for prim in prims])
        found = reader.read(prims, matrices, 0.01, ()).table
        alone = [row for prim in prims if (row := row_of(prim, 0.01)) is not None]
        assert found.tobytes() == b"".join(row.tobytes() for row in alone)
        lit += len(found)
    assert 200 < lit < 400  # some were off

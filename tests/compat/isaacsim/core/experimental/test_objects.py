"""`isaacsim.core.experimental.objects` and `.materials`."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import UsdGeom, UsdLux, UsdPhysics, UsdShade

from usdsdg.compat.isaacsim.core.experimental import materials, objects


@pytest.mark.parametrize("kind", ["Cube", "Sphere", "Cylinder", "Cone", "Capsule", "Plane"])
def test_shapes_are_defined_with_standard_ops_and_wrapped_again(stage, kind):
    made = getattr(objects, kind)(["/World/a", "/World/b"], positions=(1, 2, 3), colors="red")
    assert made.prims[1].GetTypeName() == kind
    assert [op.GetOpName() for op in UsdGeom.Xformable(made.prims[0]).GetOrderedXformOps()] == [
        "xformOp:translate", "xformOp:orient", "xformOp:scale",
    ]  # fmt: skip
    assert made.geoms[0].GetDisplayColorAttr().Get()[0] == (1, 0, 0)
    again = getattr(objects, kind)("/World/.*")
    assert again.paths == ["/World/a", "/World/b"]
    np.testing.assert_allclose(again.get_world_poses()[0].numpy(), [(1, 2, 3)] * 2)
    assert isinstance(objects.Shape.fetch_instances("/World/a")[0], getattr(objects, kind))


def test_sizes_have_a_row_per_prim_and_update_extents(stage):
    cubes = objects.Cube(["/World/a", "/World/b"], sizes=[[1.0], [4.0]])
    assert cubes.get_sizes().numpy().tolist() == [[1], [4]]
    assert [tuple(corner) for corner in cubes.geoms[1].GetExtentAttr().Get()] == [(-2, -2, -2), (2, 2, 2)]
    pipe = objects.Cylinder("/World/pipe", radii=0.5, heights=3.0, axes="X")
    assert [tuple(corner) for corner in pipe.geoms[0].GetExtentAttr().Get()] == [(-1.5, -0.5, -0.5), (1.5, 0.5, 0.5)]
    assert pipe.get_axes() == ["X"]
    with pytest.raises(AssertionError, match="axes"):
        pipe.set_axes("W")
    with pytest.raises(AssertionError, match="Cylinder, not a Cube"):
        objects.Cube("/World/pipe")


def test_colors_by_name_are_those_of_css_and_of_plots():
    from usdsdg.compat.wrappers.colors import rgb_rows

    np.testing.assert_allclose(rgb_rows(["g", "lime", "#ff8000"], 3), [(0, 0.5, 0), (0, 1, 0), (1, 128 / 255, 0)])
    np.testing.assert_allclose(rgb_rows("0.25", 2), [(0.25,) * 3] * 2)
    np.testing.assert_allclose(
        rgb_rows(["tab:Green", "C2", "C12", "#2ca02c"], 4), [(44 / 255, 160 / 255, 44 / 255)] * 4
    )
    np.testing.assert_allclose(rgb_rows("none", 1), [(0, 0, 0)])
    for name in ("nocolor", "tab:nocolor", "C"):
        with pytest.raises(ValueError, match="unknown color"):
            rgb_rows(name, 1)


def test_lights_take_colors_by_name_and_as_numbers(stage):
    lights = objects.SphereLight(["/World/a", "/World/b"])
    lights.set_colors(["red", "#0000ff"])
    assert lights.get_colors().numpy().tolist() == [[1, 0, 0], [0, 0, 1]]
    lights.set_colors("lime", indices=[1])
    lights.set_colors([0.25, 0.5, 1.0], indices=0)
    assert lights.get_colors().numpy().tolist() == [[0.25, 0.5, 1], [0, 1, 0]]
    lights.set_colors([[0.5, 0.5, 0.5], [1, 1, 1]])
    assert lights.get_colors().numpy().tolist() == [[0.5, 0.5, 0.5], [1, 1, 1]]


def test_meshes_have_a_shape_or_none(stage):
    meshes = objects.Mesh(["/World/a", "/World/b"], primitives=["Cube", "Sphere"])
    assert meshes.num_faces[0] == 6
    points = meshes.get_points()[0].numpy()
    assert (points.min(), points.max()) == (-0.5, 0.5)
    empty = objects.Mesh("/World/c")
    empty.set_points([[(0, 0, 0), (1, 0, 0), (0, 1, 0)]])
    empty.set_face_specs(vertex_indices=[[0, 1, 2]], vertex_counts=[[3]])
    assert (empty.num_faces, empty.get_points()[0].shape) == ([1], (3, 3))
    with pytest.raises(AssertionError, match="Teapot"):
        objects.Mesh("/World/d", primitives="Teapot")


@pytest.mark.parametrize(
    ("kind", "arguments"),
    [
        ("CylinderLight", {"radii": 2.0, "lengths": 3.0}), ("DiskLight", {"radii": 2.0}),
        ("DistantLight", {"angles": 2.0}), ("DomeLight", {"radii": 2.0}),
        ("RectLight", {"widths": 2.0, "heights": 3.0}), ("SphereLight", {"radii": 2.0}),
    ],
)  # fmt: skip
def test_lights_are_set_and_read_one_row_each(stage, kind, arguments):
    light = getattr(objects, kind)(["/World/a", "/World/b"], **arguments)
    light.set_intensities([100, 200])
    light.set_colors((1, 0.5, 0))
    light.set_exposures(2)
    light.set_enabled_color_temperatures([True, False])
    assert light.get_intensities().numpy().tolist() == [[100], [200]]
    assert light.get_colors().numpy().tolist() == [[1, 0.5, 0]] * 2
    assert light.get_enabled_color_temperatures().numpy().tolist() == [[True], [False]]
    for name, value in arguments.items():
        getter = "get_guide_radii" if kind == "DomeLight" else f"get_{name}"
        assert getattr(light, getter)().numpy()[0, 0] == value
    assert isinstance(light.lights[0], getattr(UsdLux, kind))
    assert isinstance(objects.Light.fetch_instances("/World/b")[0], getattr(objects, kind))


@pytest.mark.parametrize("axis", ["Y", "Z"])
def test_a_ground_plane_is_seen_and_collides_along_the_up_axis(stage, axis):
    UsdGeom.SetStageUpAxis(stage, axis)
    ground = objects.GroundPlane("/World/ground", sizes=10.0)
    points = ground.meshes.get_points()[0].numpy()
    assert np.ptp(points, axis=0).tolist() == ([10, 0, 10] if axis == "Y" else [10, 10, 0])
    mesh = ground.meshes.geoms[0]
    a, b, c = (points[index] for index in list(mesh.GetFaceVertexIndicesAttr().Get())[:3])
    normal = np.cross(b - a, c - a)
    assert normal["XYZ".index(axis)] > 0
    plane = ground.planes.prims[0]
    assert plane.HasAPI(UsdPhysics.CollisionAPI)
    assert ground.planes.get_axes() == [axis]
    assert objects.GroundPlane("/World/ground", templates=None).planes.paths == [str(plane.GetPath())]
    with pytest.raises(ValueError, match="no template"):
        ground.apply_visual_templates("marble")


def test_materials_are_defined_bound_and_read(stage):
    cube = objects.Cube("/World/cube")
    paint = materials.OmniPbrMaterial("/World/Looks/paint")
    paint.set_input_values("diffuse_color_constant", [0.1, 0.2, 0.3])
    paint.set_input_values("metallic_constant", 1)
    paint.set_input_values("enable_emission", True)
    cube.apply_visual_materials(paint)
    np.testing.assert_allclose(paint.get_input_values("diffuse_color_constant").numpy(), [(0.1, 0.2, 0.3)], atol=1e-6)
    assert paint.get_input_values("enable_emission").numpy().tolist() == [[True]]
    bound, _ = UsdShade.MaterialBindingAPI(cube.prims[0]).ComputeBoundMaterial()
    assert bound.GetPath() == "/World/Looks/paint"
    assert isinstance(cube.get_applied_visual_materials()[0], materials.OmniPbrMaterial)
    with pytest.raises(ValueError, match="no input 'color'"):
        paint.set_input_values("color", 1)
    with pytest.raises(RuntimeError, match="no value"):
        paint.get_input_values("specular_level")


def test_each_kind_of_material_is_recognized(stage):
    made = {
        "/World/a": materials.OmniPbrMaterial, "/World/b": materials.OmniGlassMaterial,
        "/World/c": materials.PreviewSurfaceMaterial,
    }  # fmt: skip
    for path, kind in made.items():
        kind(path)
    found = materials.VisualMaterial.fetch_instances([*made, "/World"])
    assert [type(each) for each in found] == [*made.values(), type(None)]
    assert materials.OmniGlassMaterial.are_of_type(list(made)).numpy().tolist() == [[False], [True], [False]]
    with pytest.warns(UserWarning, match="clipped"):
        found[2].set_input_values("roughness", 7.0)
    assert found[2].get_input_values("roughness").numpy().tolist() == [[1]]


def test_physics_materials_are_bound_for_physics(stage):
    ground = objects.GroundPlane("/World/ground")
    rubber = materials.RigidBodyMaterial(
        ["/World/r_0", "/World/r_1"], static_frictions=0.9, dynamic_frictions=[0.8, 0.7], restitutions=0.5
    )
    static, dynamic = rubber.get_friction_coefficients()
    np.testing.assert_allclose(np.hstack([static.numpy(), dynamic.numpy()]), [(0.9, 0.8), (0.9, 0.7)], atol=1e-6)
    ground.apply_physics_materials(rubber)
    assert ground.get_applied_physics_materials()[0].paths == ["/World/r_0"]


def test_cameras_have_lenses_in_stage_units_of_which_usd_has_tenths(stage):
    cameras = objects.Camera(["/World/a", "/World/b"], positions=[[0, 0, 1], [0, 0, 2]])
    first, second = (UsdGeom.Camera(prim) for prim in cameras.prims)
    cameras.set_focal_lengths([[2.4], [5.0]])
    cameras.set_apertures(horizontal_apertures=3.6, indices=[1])
    assert second.GetFocalLengthAttr().Get() == pytest.approx(50.0)
    assert second.GetHorizontalApertureAttr().Get() == pytest.approx(36.0)
    assert first.GetHorizontalApertureAttr().Get() == pytest.approx(20.955)
    assert cameras.get_focal_lengths().numpy() == pytest.approx(np.array([[2.4], [5.0]]))
    assert cameras.get_apertures(indices=1)[0].numpy() == pytest.approx(np.array([[3.6]]))
    cameras.set_aperture_offsets(vertical_offsets=[0.1, 0.2])
    assert second.GetVerticalApertureOffsetAttr().Get() == pytest.approx(2.0)
    cameras.enforce_square_pixels([240, 320], modes=["horizontal", "vertical"])
    for camera in (first, second):
        width, height = (camera.GetHorizontalApertureAttr().Get(), camera.GetVerticalApertureAttr().Get())
        assert width / height == pytest.approx(320 / 240)
    assert first.GetHorizontalApertureAttr().Get() == pytest.approx(20.955)
    assert second.GetVerticalApertureAttr().Get() == pytest.approx(15.2908)
    with pytest.raises(AssertionError, match="at least one"):
        cameras.set_apertures()
    with pytest.raises(ValueError, match="no mode"):
        cameras.enforce_square_pixels([1, 1], modes="both")


def test_cameras_have_ranges_focus_and_shutter_in_the_units_of_usd(stage):
    cameras = objects.Camera(["/World/a", "/World/b"])
    cameras.set_clipping_ranges(far_distances=[[10.0], [20.0]])
    cameras.set_clipping_ranges(0.5, indices=[0])
    assert UsdGeom.Camera(cameras.prims[0]).GetClippingRangeAttr().Get() == (0.5, 10.0)
    assert [each.numpy().tolist() for each in cameras.get_clipping_ranges()] == [[[0.5], [1.0]], [[10.0], [20.0]]]
    cameras.set_focus_distances(3.0)
    cameras.set_fstops([0.0, 2.8])
    assert cameras.get_focus_distances().numpy().tolist() == [[3.0], [3.0]]
    assert cameras.get_fstops().numpy() == pytest.approx(np.array([[0.0], [2.8]]))
    cameras.set_shutter_times(close_times=0.25)
    assert [each.numpy().tolist() for each in cameras.get_shutter_times(indices=0)] == [[[0.0]], [[0.25]]]
    cameras.set_projections(["perspective", "orthographic"])
    cameras.set_stereo_roles("left")
    assert cameras.get_projections() == ["perspective", "orthographic"]
    assert cameras.get_stereo_roles(indices=[1]) == ["left"]

"""Textures projected onto meshes: covered surface, UVs, and updates when projector or target move."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.errors import GraphError, Unsupported
from usdsdg.graph import evaluate
from usdsdg.stage.geometry.triangles import triangles_below
from usdsdg.stage.poses import transforms
from usdsdg.stage.semantics import labels


@pytest.fixture
def textures(tmp_path):
    groups = []
    for stem in ("rust", "moss", "dirt"):
        for role in ("diffuse", "normal"):
            (tmp_path / f"{stem}_{role}.png").write_bytes(b"")
        groups.append({role: str(tmp_path / f"{stem}_{role}.png") for role in ("diffuse", "normal")})
    return groups


def baked(stage, item):
    """World points (T, 3, 3) and UVs (T, 3, 2) of a projection."""
    (prim,) = (child for child in stage.GetPrimAtPath(item.prims[0]).GetChildren() if child.IsA(UsdGeom.Mesh))
    mesh = UsdGeom.Mesh(prim)
    matrix = np.array(transforms.local_to_world(prim))
    points = np.array(mesh.GetPointsAttr().Get()).reshape(-1, 3) @ matrix[:3, :3] + matrix[3, :3]
    uvs = np.array(UsdGeom.PrimvarsAPI(prim).GetPrimvar("st").Get())
    return points.reshape(-1, 3, 3), uvs.reshape(-1, 3, 2)


# Rotations with which -X of a projector points along -Z and -X of the world, and +Y along +Y.
DOWN = (0, -90, 0)
AGAINST_X = (0, 0, 0)


def area(corners):
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2


def test_a_projection_covers_the_area_of_its_projector_on_a_wall(stage):
    wall = rep.create.cube(scale=(4, 4, 1), position=(0, 0, -0.5))
    proxy = rep.create.xform(position=(1, 0.5, 0), rotation=DOWN, scale=(1, 2, 1))
    item = rep.create.projection_material(proxy, input_prims=wall, semantics=[("class", "logo")])
    points, uvs = baked(stage, item)
    assert area(points) == pytest.approx(2.0)
    np.testing.assert_allclose(points[..., 2], 0.01 * 2 ** (1 / 3), atol=1e-6)
    # Seen against the projection, with the projector's Y up, the texture is upright and not mirrored.
    np.testing.assert_allclose(uvs, (points[..., :2] - (0.5, -0.5)) / (1, 2), atol=1e-6)
    assert labels.get_labels(stage.GetPrimAtPath(item.prims[0])) == {"class": ["logo"]}


def test_defects_on_a_floor_are_as_wide_as_the_z_of_their_proxies_and_as_high_as_the_y(stage):
    """Scripts with defects turn cubes by 90 degrees about Z in a stage with Y up, so that -X points down."""
    rep.settings.set_stage_up_axis("Y")
    floor = rep.create.cube(scale=(4, 1, 4), position=(0, -0.5, 0))
    centers = [(-1, 0, 0), (0, 0, 0), (1, 0, 1)]
    proxies = rep.create.cube(count=3, position=centers, rotation=(0, 0, 90), scale=(1, 0.2, 0.5))
    with rep.get.prims(path_pattern=f"{floor.prims[0]}(/.*)?$"):
        item = rep.create.projection_material(proxies, [("class", "scratch")], offset_scale=0)
    assert len(item.prims) == 3
    for path, center in zip(item.prims, centers):
        points, _ = baked(stage, rep.get.prim_at_path(path))
        assert area(points) == pytest.approx(0.1)
        np.testing.assert_allclose((points.min((0, 1)) + points.max((0, 1))) / 2, center, atol=1e-6)
        np.testing.assert_allclose(np.ptp(points.reshape(-1, 3), axis=0), (0.2, 0, 0.5), atol=1e-6)
        assert labels.get_labels(stage.GetPrimAtPath(path)) == {"class": ["scratch"]}


def test_several_projectors_project_onto_the_targets_in_turn(stage):
    walls = rep.create.cube(count=2, position=[(0, 0, 0), (5, 0, 0)])
    proxies = rep.create.xform(count=4, position=[(0.5, 0, 0), (5.5, 0, 0), (5.5, 0, 0), (5.5, 0, 0)])
    item = rep.create.projection_material(proxies, input_prims=walls)
    areas = [area(baked(stage, rep.get.prim_at_path(path))[0]) for path in item.prims]
    assert areas == pytest.approx([1, 1, 0, 1])
    with pytest.raises(GraphError, match="3 projectors and 2 targets; give one projector"):
        rep.create.projection_material(list(proxies.prims[:3]), input_prims=walls)


def test_on_a_sphere_only_the_front_faces_within_the_box_are_covered(stage):
    ball = rep.create.sphere(scale=2)
    proxy = rep.create.xform(position=(3, 0, 0), rotation=AGAINST_X, scale=(5, 1, 1))
    item = rep.create.projection_material(proxy, offset_scale=0.0, input_prims=ball)
    points, uvs = baked(stage, item)
    assert len(points) > 50
    assert (points[..., 0] > 0.6).all()
    assert (np.abs(points[..., 1:]) <= 0.5 + 1e-6).all()
    radius = np.linalg.norm(points, axis=-1)
    assert ((radius > 0.98) & (radius < 1 + 1e-6)).all()
    # Seen along the projection the texture is not distorted: it fills the unit square once.
    flat = np.abs(np.linalg.det(uvs[:, 1:] - uvs[:, :1])).sum() / 2
    assert flat == pytest.approx(1.0, abs=1e-3)


def test_the_bounding_box_of_a_proxy_with_geometry_is_projected(stage):
    floor = rep.create.plane(scale=10)
    proxy = rep.create.cube(scale=3, position=(0, 0, 1), rotation=DOWN)
    points, _ = baked(stage, rep.create.projection_material(proxy, input_prims=floor))
    assert area(points) == pytest.approx(9.0)


def test_a_projection_that_covers_nothing_is_an_empty_mesh(stage):
    floor = rep.create.plane(scale=10)
    for position, rotation in (((0, 0, 5), DOWN), ((0, 0, 0), (0, 90, 0))):
        proxy = rep.create.xform(position=position, rotation=rotation)
        points, _ = baked(stage, rep.create.projection_material(proxy, input_prims=floor))
        assert len(points) == 0


def test_moving_the_projector_and_its_textures(stage, textures):
    floor = rep.create.plane(scale=10)
    proxy = rep.create.xform(rotation=DOWN)
    with floor:
        item = rep.create.projection_material(proxy)
    with rep.trigger.on_custom_event("go"):
        rep.modify.projection_material(
            position=rep.distribution.uniform((-4, -4, 0), (4, 4, 0)),
            texture_group=rep.distribution.sequence(textures),
            input_prims=item,
        )
    centers, groups = [], []
    for _ in range(3):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        points, _ = baked(stage, item)
        assert area(points) == pytest.approx(1.0)
        centers.append(tuple(((points.min((0, 1)) + points.max((0, 1))) / 2)[:2].round(4)))
        material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(item.prims[0])).ComputeBoundMaterial()
        shader = material.ComputeSurfaceSource("mdl")[0]
        groups.append({role: shader.GetInput(f"{name}_texture").Get().path for role, name in
                         (("diffuse", "diffuse"), ("normal", "normalmap"))})  # fmt: skip
    assert len(set(centers)) == 3
    assert groups == textures


def test_a_projection_follows_a_target_that_moves_in_the_same_trigger(stage):
    wall, proxy = rep.create.plane(scale=0.5), rep.create.xform(rotation=DOWN)
    with rep.trigger.on_custom_event("go"):
        rep.modify.pose(position=rep.distribution.uniform((-0.2, -0.2, 0), (0.2, 0.2, 0)), input_prims=wall)
        item = rep.create.projection_material(proxy, offset_scale=0, input_prims=wall)
    rep.utils.send_og_event("go")
    evaluate.graph().evaluate()
    points, _ = baked(stage, item)
    corners = triangles_below([stage.GetPrimAtPath(wall.prims[0])])[0].in_world().corners()
    np.testing.assert_allclose(points.min((0, 1)), corners.min((0, 1)), atol=1e-6)


def test_decals_are_projected_at_their_position(stage, textures):
    crate = rep.create.cube(scale=2)
    item = rep.create.mesh_decal(
        **textures[0], position=(1, 0.2, 0), rotation=(0, 90, 0), scale=0.5, input_prims=crate,
        semantics=[("class", "sticker")],
    )  # fmt: skip
    points, _ = baked(stage, item)
    assert area(points) == pytest.approx(0.25)
    np.testing.assert_allclose(points[..., 0], 1.001, atol=1e-6)
    np.testing.assert_allclose(points[..., 1].min(), -0.05, atol=1e-6)
    material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(item.prims[0])).ComputeBoundMaterial()
    assert material.ComputeSurfaceSource("mdl")[0].GetInput("diffuse_texture").Get().path == textures[0]["diffuse"]
    deep = rep.create.mesh_decal(position=(3, 0, 0), rotation=(0, 90, 0), offset_depth=-2, input_prims=crate)
    assert area(baked(stage, deep)[0]) == pytest.approx(1.0)


def test_decals_are_sampled_at_every_firing(stage, textures):
    floor = rep.create.plane(scale=4)
    with rep.trigger.on_custom_event("go"):
        item = rep.create.mesh_decal(
            texture_group=rep.distribution.choice(textures),
            position=rep.distribution.uniform((-1, -1, 0), (1, 1, 0)),
            input_prims=floor,
        )
    seen = set()
    for _ in range(3):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        seen.add(tuple(baked(stage, item)[0].min((0, 1)).round(4)))
    assert len(seen) == 3


def test_every_texture_of_a_group_reaches_its_input(stage, tmp_path):
    roles = {
        "diffuse": ("diffuse_texture", None),
        "normal": ("normalmap_texture", None),
        "roughness": ("reflectionroughness_texture", ("reflection_roughness_texture_influence", 1)),
        "metallic": ("metallic_texture", ("metallic_texture_influence", 1)),
        "opacity": ("opacity_texture", ("enable_opacity", True)),
    }
    files = {role: str(tmp_path / f"{role}.png") for role in roles}
    for file in files.values():
        open(file, "wb").close()
    floor = rep.create.plane(scale=4)
    decal = rep.create.mesh_decal(**files, name="logo", offset_normal=50, input_prims=floor)
    assert decal.prims == ("/Replicator/logo_Xform",)
    # Half a meter above.
    np.testing.assert_allclose(baked(stage, decal)[0][..., 2], 0.5, atol=1e-6)

    def shader(item):
        material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(item.prims[0])).ComputeBoundMaterial()
        return material.ComputeSurfaceSource("mdl")[0]

    single = {role: file for role, file in files.items() if role != "opacity"}
    moved = rep.create.mesh_decal(input_prims=floor)
    rep.modify.projection_material(**single, input_prims=moved)
    group = rep.create.mesh_decal(texture_group=files, input_prims=floor)
    evaluate.graph().evaluate()
    for item, given in ((decal, files), (moved, single), (group, files)):
        for role, file in given.items():
            name, influence = roles[role]
            assert shader(item).GetInput(name).Get().path == file
            assert influence is None or shader(item).GetInput(influence[0]).Get() == influence[1]


def test_groups_of_files_are_drawn_and_their_suffixes_say_what_they_are_for(stage, tmp_path):
    for name in ("Wood_D", "Wood_O", "Moss_D", "Moss_O"):
        Image.new("RGB", (2, 2)).save(tmp_path / f"{name}.png")
    groups = rep.utils.get_files_group(str(tmp_path), ["_D", "_O"])
    floor = rep.create.plane(scale=4)
    with rep.trigger.on_custom_event("go"):
        decal = rep.create.mesh_decal(texture_group=groups, diffuse="_D", opacity="_O", input_prims=floor)
        other = rep.create.mesh_decal(input_prims=floor)
        rep.modify.projection_material(texture_group=groups[1], diffuse="_D", input_prims=other)

    def file(item, name):
        material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(item.prims[0])).ComputeBoundMaterial()
        return Path(material.ComputeSurfaceSource("mdl")[0].GetInput(name).Get().path).name

    seen = set()
    for _ in range(8):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        seen.add((file(decal, "diffuse_texture"), file(decal, "opacity_texture")))
        assert file(other, "diffuse_texture") == "Wood_D.png"
    assert seen == {("Wood_D.png", "Wood_O.png"), ("Moss_D.png", "Moss_O.png")}
    fixed = rep.create.mesh_decal(texture_group=groups[0], diffuse="_D", input_prims=floor)
    assert file(fixed, "diffuse_texture") == "Moss_D.png"


def test_a_decal_may_have_a_given_material(stage):
    floor, red = rep.create.plane(scale=4), rep.create.material_omnipbr(diffuse=(1, 0, 0))
    decal = rep.create.mesh_decal(material=red, input_prims=floor)
    other = rep.create.projection_material(rep.create.xform(), material=red.prims[0], name="paint", input_prims=floor)
    assert other.prims == ("/Replicator/paint_Xform",)
    for item in (decal, other):
        bound, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(item.prims[0])).ComputeBoundMaterial()
        assert str(bound.GetPath()) == red.prims[0]
    assert rep.create_mesh_decal is rep.create.mesh_decal


def test_a_projector_can_be_rotated_and_scaled(stage):
    floor = rep.create.plane(scale=10)
    item = rep.create.mesh_decal(input_prims=floor)
    rep.modify.projection_material(position=(1, 2, 0), rotation=(0, 0, 90), scale=(3, 1, 1), input_prims=item)
    evaluate.graph().evaluate()
    points, _ = baked(stage, item)
    np.testing.assert_allclose(np.ptp(points.reshape(-1, 3), axis=0)[:2], (1, 3), atol=1e-5)
    np.testing.assert_allclose((points.min((0, 1)) + points.max((0, 1)))[:2] / 2, (1, 2), atol=1e-5)


def test_invalid_texture_groups_raise_errors(stage, textures):
    floor = rep.create.plane(scale=4)
    with pytest.raises(GraphError, match=r"texture_group is \{'difuse': 'a\.png'\}; expected a mapping with the keys"):
        rep.create.mesh_decal(texture_group={"difuse": "a.png"}, input_prims=floor)
    item = rep.create.mesh_decal(input_prims=floor)
    rep.modify.projection_material(diffuse=textures[0]["diffuse"].replace("rust", "rost"), input_prims=item)
    with pytest.raises(GraphError, match=r"did you mean rust_diffuse\.png"):
        evaluate.graph().evaluate()


def test_invalid_projections_raise_errors(stage, textures):
    floor, proxy = rep.create.plane(), rep.create.xform()
    with pytest.raises(GraphError, match="0 targets"):
        rep.create.projection_material(proxy)
    with pytest.raises(GraphError, match="one of material"):
        rep.create.mesh_decal(material="/m", diffuse="a.png", input_prims=floor)
    with pytest.raises(Unsupported, match="decal is not available"):
        rep.create.mesh_decal("/World/decal", input_prims=floor)
    rep.modify.projection_material(
        texture_group=textures[0], diffuse="_D", input_prims=rep.create.mesh_decal(input_prims=floor)
    )
    with pytest.raises(GraphError, match="has no '_D'; it has diffuse, normal"):
        evaluate.graph().evaluate()
    rep.modify.projection_material(input_prims=floor)
    with pytest.raises(GraphError, match="is not a projection"):
        evaluate.graph().evaluate()

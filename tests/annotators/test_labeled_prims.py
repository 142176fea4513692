import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

from tests.annotators.ray_caster import RayCaster, add_cube, add_sphere, new_stage, place
from tests.stage.geometry.characters import LENGTH, add_character
from usdsdg.annotators import LabeledPrimReader, ownership
from usdsdg.annotators.bounds import hulls
from usdsdg.annotators.ownership import LabeledStage
from usdsdg.annotators.prims import prim_bounds
from usdsdg.annotators.prims.prim_bounds import PrimBounds
from usdsdg.stage.semantics.labels import add_labels, remove_labels


@pytest.fixture
def stage():
    return new_stage()


def read(stage, filters=()):
    return LabeledPrimReader(stage).read(RayCaster(stage).gprims, filters)


def xform(stage, path, **pose):
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    place(prim, **pose)
    return prim


def test_gprims_below_a_labeled_prim_are_owned_by_it_and_bounded_in_its_frame(stage):
    car = xform(stage, "/World/Car", translate=(5, 0, 0), rotate=(0, 0, 90))
    add_labels(car, {"class": ["Car"]})
    add_cube(stage, "/World/Car/Body", size=2.0)
    add_sphere(stage, "/World/Car/Wheel", radius=0.5, translate=(2, 0, -1))
    add_cube(stage, "/World/Ground")

    entities = read(stage)

    assert entities.prim_paths == ("/World/Car",)
    np.testing.assert_allclose(entities.bounds[0], [[-1, -1, -1.5], [2.5, 1, 1]])
    np.testing.assert_allclose([0, 0, 0, 1] @ entities.local_to_world[0], [5, 0, 0, 1])
    np.testing.assert_allclose([1, 0, 0, 1] @ entities.local_to_world[0], [5, 1, 0, 1], atol=1e-12)
    names = [RayCaster(stage).gprims[g] for g in entities.groups[0]]
    assert names == ["/World/Car/Body", "/World/Car/Wheel"]
    assert entities.row_of_gprim.tolist() == [0, 0, -1]


def test_labels_are_inherited_joined_and_printed_in_lower_case(stage):
    add_labels(stage.GetPrimAtPath("/World"), {"class": ["Outside"], "place": ["Yard"]})
    add_cube(stage, "/World/Box", "Box")
    selection = read(stage).select(None)
    assert selection.labels == ({"class": "outside,box", "place": "yard"},)


@pytest.fixture
def car_with_wheel(stage):
    add_labels(xform(stage, "/World/Car"), {"class": ["car"]})
    add_cube(stage, "/World/Car/Body")
    wheel = add_sphere(stage, "/World/Car/Wheel", translate=(3, 0, 0))
    add_labels(wheel, {"part": ["wheel"]})
    return stage


def test_without_a_filter_the_nearest_labeled_prim_owns_a_gprim(car_with_wheel):
    entities = read(car_with_wheel)
    assert entities.prim_paths == ("/World/Car", "/World/Car/Wheel")
    assert entities.row_of_gprim.tolist() == [0, 1]


def test_a_filter_gives_a_part_to_the_nearest_prim_that_passes(car_with_wheel):
    entities = read(car_with_wheel, ["class:*"])
    selection = entities.select("class:*")
    [row] = selection.rows
    assert entities.prim_paths[row] == "/World/Car"
    assert entities.groups[row] == (0, 1)
    np.testing.assert_allclose(entities.bounds[row, 1], [3.5, 0.5, 0.5])
    assert selection.member_of_gprim.tolist() == [0, 0]
    assert selection.labels == ({"class": "car"},)
    # The unfiltered view of the same reading is not changed by it.
    assert entities.select(None).member_of_gprim.tolist() == [0, 1]


@pytest.mark.parametrize("filters", [["class:!car"], []], ids=["announced", "not announced"])
def test_what_inherits_a_label_that_is_ruled_out_is_left_out(stage, filters):
    add_labels(xform(stage, "/World/Car"), {"class": ["car"]})
    add_cube(stage, "/World/Car/Body")
    add_cube(stage, "/World/Car/Wheel", "wheel")
    add_cube(stage, "/World/Tree", "tree")
    entities = read(stage, filters)
    selection = entities.select("class:!car")
    assert selection.labels == ({"class": "tree"},)
    assert [entities.prim_paths[row] for row in selection.rows] == ["/World/Tree"]
    gprims = RayCaster(stage).gprims
    assert [gprims[k] for k, member in enumerate(selection.member_of_gprim) if member >= 0] == ["/World/Tree"]


def test_a_material_that_is_ruled_out_leaves_out_what_shows_it(stage):
    add_labels(xform(stage, "/World/Car"), {"class": ["car"]})
    body = add_cube(stage, "/World/Car/Body")
    material = UsdShade.Material.Define(stage, "/World/Steel")
    add_labels(material.GetPrim(), {"class": ["steel"]})
    UsdShade.MaterialBindingAPI.Apply(body).Bind(material)
    assert read(stage, ["class:!steel"]).select("class:!steel").labels == ()


def test_a_filter_that_was_not_announced_still_keeps_and_drops_entities(stage):
    add_cube(stage, "/World/A", "apple")
    add_cube(stage, "/World/B", "pear")
    selection = read(stage).select("class:pear")
    assert selection.member_of_gprim.tolist() == [-1, 0]
    assert selection.labels == ({"class": "pear"},)


def test_a_mirrored_point_in_a_reset_xform_stack_is_bounded_in_the_owners_frame(stage):
    owner = xform(stage, "/World/Owner", translate=(10, 0, 0))
    add_labels(owner, {"class": ["thing"]})
    cube = add_cube(stage, "/World/Owner/Cube", translate=(12, 0, 0))
    UsdGeom.Xformable(cube).SetResetXformStack(True)
    np.testing.assert_allclose(read(stage).bounds[0], [[1.5, -0.5, -0.5], [2.5, 0.5, 0.5]])


# What changed: an old reader must say what a fresh one says.


def edit_owner_pose(stage):
    place(stage.GetPrimAtPath("/World/Car"), translate=(1, 2, 3), rotate=(10, 20, 30))


def edit_part_pose(stage):
    place(stage.GetPrimAtPath("/World/Car/Wheel"), translate=(0, 7, 0))


def edit_size(stage):
    UsdGeom.Cube(stage.GetPrimAtPath("/World/Car/Body")).GetSizeAttr().Set(9.0)


def edit_label(stage):
    add_labels(stage.GetPrimAtPath("/World/Car"), {"class": ["van"]}, mode="replace")


def edit_label_value(stage):
    stage.GetPrimAtPath("/World/Car").GetAttribute("semantics:labels:class").Set(["lorry"])
    add_labels(stage.GetPrimAtPath("/World/Car"), {"class": ["lorry"]}, mode="replace")


def edit_add_label_below(stage):
    add_labels(stage.GetPrimAtPath("/World/Car/Body"), {"class": ["body"]})


def edit_remove_labels(stage):
    remove_labels(stage.GetPrimAtPath("/World/Car/Wheel"))


def edit_new_part(stage):
    add_cube(stage, "/World/Car/Roof", translate=(0, 0, 4))


def edit_remove_part(stage):
    stage.RemovePrim("/World/Car/Wheel")


def edit_grandparent_scale(stage):
    place(stage.GetPrimAtPath("/World"), scale=(2, 2, 2))


EDITS = [value for name, value in sorted(globals().items()) if name.startswith("edit_")]


def assert_equal(one, other):
    assert (one.prim_paths, one.groups, one.labels) == (other.prim_paths, other.groups, other.labels)
    np.testing.assert_allclose(one.bounds, other.bounds)
    np.testing.assert_allclose(one.local_to_world, other.local_to_world)
    np.testing.assert_array_equal(one.row_of_gprim, other.row_of_gprim)
    for predicate, selection in other.selections.items():
        np.testing.assert_array_equal(one.select(predicate).rows, selection.rows)
        assert one.select(predicate).labels == selection.labels


@given(edits=st.lists(st.sampled_from(EDITS), max_size=4, unique=True))
@settings(max_examples=40, deadline=None)
def test_a_reader_follows_edits(edits):
    stage = new_stage()
    add_labels(xform(stage, "/World/Car"), {"class": ["car"]})
    add_cube(stage, "/World/Car/Body")
    add_labels(add_sphere(stage, "/World/Car/Wheel", translate=(3, 0, 0)), {"part": ["wheel"]})
    reader = LabeledPrimReader(stage)
    reader.read(RayCaster(stage).gprims, ["class:*"])
    for edit in edits:
        try:
            edit(stage)
        except (RuntimeError, TypeError, AttributeError, ValueError):
            continue  # the part was removed before; Tf raises, and there is nothing to follow
        gprims = RayCaster(stage).gprims
        assert_equal(reader.read(gprims, ["class:*"]), LabeledPrimReader(stage).read(gprims, ["class:*"]))


def test_only_what_moved_is_bounded_again(stage, monkeypatch):
    add_cube(stage, "/World/A", "a")
    add_cube(stage, "/World/B", "b")
    reader = LabeledPrimReader(stage)
    gprims = RayCaster(stage).gprims
    reader.read(gprims)
    monkeypatch.setattr(
        "usdsdg.annotators.prims.prim_bounds.read_hull", lambda *_, **__: pytest.fail("geometry was read again")
    )
    monkeypatch.setattr(PrimBounds, "_of_gprim", lambda *_: pytest.fail("bounds were computed again"))
    place(stage.GetPrimAtPath("/World/A"), translate=(1, 0, 0))
    reader.read(gprims)


def test_a_mesh_shared_by_instances_gets_an_entity_each(stage):
    stage.DefinePrim("/Prototypes")
    source = UsdGeom.Xform.Define(stage, "/Prototypes/Mug").GetPrim()
    mesh = UsdGeom.Mesh.Define(stage, "/Prototypes/Mug/Mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    for name in "AB":
        prim = stage.DefinePrim(f"/World/{name}", "Xform")
        prim.GetReferences().AddInternalReference(source.GetPath())
        prim.SetInstanceable(True)
        add_labels(prim, {"class": ["mug"]})
    entities = LabeledPrimReader(stage).read(("/World/A/Mesh", "/World/B/Mesh"))
    assert entities.prim_paths == ("/World/A", "/World/B")
    np.testing.assert_allclose(entities.bounds[1], [[0, 0, 0], [1, 1, 0]])


def test_a_mesh_edited_in_the_source_of_instances_is_bounded_again(stage):
    source = UsdGeom.Xform.Define(stage, "/Prototypes/Mug").GetPrim()
    cube = UsdGeom.Cube.Define(stage, "/Prototypes/Mug/Cube")
    for name in "AB":
        prim = stage.DefinePrim(f"/World/{name}", "Xform")
        prim.GetReferences().AddInternalReference(source.GetPath())
        prim.SetInstanceable(True)
        add_labels(prim, {"class": ["mug"]})
    reader = LabeledPrimReader(stage)
    gprims = ("/World/A/Cube", "/World/B/Cube")
    reader.read(gprims)
    cube.CreateSizeAttr(6.0)
    np.testing.assert_allclose(reader.read(gprims).bounds, [[[-3] * 3, [3] * 3]] * 2)


# Point instancers


@pytest.fixture
def forest(stage):
    """Two trees, drawn by points 7 and 9 of an instancer whose prototype holds a trunk and a labeled crown."""
    xform(stage, "/World/Forest", translate=(0, 0, 1))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Forest/Points")
    xform(stage, "/World/Forest/Points/Tree", scale=(2, 2, 2))
    add_cube(stage, "/World/Forest/Points/Tree/Trunk")
    add_cube(stage, "/World/Forest/Points/Tree/Crown", translate=(0, 0, 3))
    instancer.CreatePrototypesRel().SetTargets(["/World/Forest/Points/Tree"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreateIdsAttr([7, 9])
    instancer.CreatePositionsAttr([Gf.Vec3f(10, 0, 0), Gf.Vec3f(20, 0, 0)])
    half = np.sqrt(0.5)
    instancer.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0), Gf.Quath(half, half, 0, 0)])
    return stage


TREES = tuple(f"/World/Forest/Points/Tree/{part}[{point}]" for point in (7, 9) for part in ("Trunk", "Crown"))


def test_a_label_in_a_prototype_gives_an_entity_per_point(forest):
    add_labels(forest.GetPrimAtPath("/World/Forest/Points/Tree"), {"class": ["tree"]})
    entities = LabeledPrimReader(forest).read(TREES)
    assert entities.prim_paths == ("/World/Forest/Points/Tree[7]", "/World/Forest/Points/Tree[9]")
    assert entities.groups == ((0, 1), (2, 3))
    np.testing.assert_allclose(entities.bounds, [[[-0.5, -0.5, -0.5], [0.5, 0.5, 3.5]]] * 2)
    # Twice as large, ten along x, one up; the second is turned by 90 degrees about x, so its z is the world's -y.
    np.testing.assert_allclose([0, 0, 3, 1] @ entities.local_to_world[0], [10, 0, 7, 1], atol=1e-3)
    np.testing.assert_allclose([0, 0, 3, 1] @ entities.local_to_world[1], [20, -6, 1, 1], atol=1e-2)


def test_a_label_above_an_instancer_gives_one_entity_around_all_points(forest):
    add_labels(forest.GetPrimAtPath("/World/Forest"), {"class": ["forest"]})
    reader = LabeledPrimReader(forest)
    entities = reader.read(TREES)
    assert entities.prim_paths == ("/World/Forest",)
    # half-precision orientations
    np.testing.assert_allclose(entities.bounds[0], [[9, -7, -1], [21, 1, 7]], atol=1e-2)
    UsdGeom.PointInstancer(forest.GetPrimAtPath("/World/Forest/Points")).GetPositionsAttr().Set(
        [Gf.Vec3f(10, 0, 0), Gf.Vec3f(50, 0, 0)]
    )
    np.testing.assert_allclose(reader.read(TREES).bounds[0, 1, 0], 51, atol=1e-2)


def test_two_instancers_share_a_prototype(forest):
    add_labels(forest.GetPrimAtPath("/World/Forest/Points/Tree/Crown"), {"class": ["crown"]})
    second = UsdGeom.PointInstancer.Define(forest, "/World/Z")
    second.CreatePrototypesRel().SetTargets(["/World/Forest/Points/Tree"])
    second.CreateProtoIndicesAttr([0])
    second.CreateIdsAttr([7])
    second.CreatePositionsAttr([Gf.Vec3f(0, 0, 100)])
    drawn = [("/World/Forest/Points", 7), ("/World/Forest/Points", 9), ("/World/Z", 7)]
    names = [f"/World/Forest/Points/Tree/{part}[{path}:{id_}]" for path, id_ in drawn for part in ("Trunk", "Crown")]
    entities = LabeledPrimReader(forest).read(names)
    assert entities.prim_paths == tuple(names[1::2])
    assert [g for g in entities.groups] == [(1,), (3,), (5,)]
    np.testing.assert_allclose(entities.local_to_world[2][3], [0, 0, 106, 1], atol=1e-3)


def test_a_prototype_elsewhere_belongs_to_the_instancer_that_draws_it(stage):
    add_labels(xform(stage, "/World/Forest"), {"class": ["forest"]})
    add_cube(stage, "/Prototypes/Tree/Trunk")
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Forest/Points")
    instancer.CreatePrototypesRel().SetTargets(["/Prototypes/Tree"])
    instancer.CreateProtoIndicesAttr([0])
    instancer.CreatePositionsAttr([Gf.Vec3f(5, 0, 0)])
    entities = LabeledPrimReader(stage).read(("/Prototypes/Tree/Trunk[0]",))
    assert entities.prim_paths == ("/World/Forest",)
    np.testing.assert_allclose(entities.bounds[0], [[4.5, -0.5, -0.5], [5.5, 0.5, 0.5]])


def test_instancers_inside_prototypes(stage):
    """A row of flower beds, each a row of flowers: entries are path[flower][bed]."""
    flower = add_cube(stage, "/World/Beds/Bed/Flowers/Flower")
    add_labels(flower, {"class": ["flower"]})
    for path, target, step in (("/World/Beds", "/World/Beds/Bed", (10, 0, 0)),
                               ("/World/Beds/Bed/Flowers", "/World/Beds/Bed/Flowers/Flower", (0, 1, 0))):  # fmt: skip
        instancer = UsdGeom.PointInstancer.Define(stage, path)
        instancer.CreatePrototypesRel().SetTargets([target])
        instancer.CreateProtoIndicesAttr([0, 0])
        instancer.CreatePositionsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(*step)])
    entries = tuple(f"/World/Beds/Bed/Flowers/Flower[{i}][{o}]" for o in (0, 1) for i in (0, 1))
    entities = LabeledPrimReader(stage).read(entries)
    assert entities.prim_paths == entries
    np.testing.assert_allclose(
        entities.local_to_world[:, 3, :3], [[0, 0, 0], [0, 1, 0], [10, 0, 0], [10, 1, 0]], atol=1e-6
    )


def test_readers_with_different_filters_take_turns(car_with_wheel, monkeypatch):
    reader, gprims = LabeledPrimReader(car_with_wheel), RayCaster(car_with_wheel).gprims
    for filters in ([], ["class:*"], ["part:*"]):
        reader.read(gprims, filters)
    monkeypatch.setattr(PrimBounds, "_of_gprim", lambda *_: pytest.fail("bounds were computed again"))
    entities = reader.read(gprims, ["class:*"])
    assert entities.select("class:*").labels == ({"class": "car"},)
    assert entities.select("part:*").labels == ({"part": "wheel"},)
    assert reader.read(gprims, [None]).select(None).member_of_gprim.tolist() == [0, 1]


def test_boxes_of_characters_follow_time_and_edits(stage):
    mesh = add_character(stage, "/World/Man")
    add_labels(stage.GetPrimAtPath("/World/Man"), {"class": ["man"]})
    reader = LabeledPrimReader(stage)

    def highest(code):
        return reader.read((str(mesh.GetPath()),), time=Usd.TimeCode(code)).bounds[0, 1, 2]

    assert highest(0) == pytest.approx(LENGTH)
    bent = highest(24)
    assert bent < LENGTH - 0.5
    skeleton = stage.GetPrimAtPath("/World/Man/Skeleton")
    UsdGeom.Xformable(skeleton).AddTranslateOp().Set(Gf.Vec3d(0, 0, 7))
    assert highest(24) == pytest.approx(bent + 7, abs=1e-5)
    UsdSkel.BindingAPI(skeleton).GetAnimationSourceRel().ClearTargets(True)
    assert highest(24) == pytest.approx(LENGTH + 7, abs=1e-5)


def test_boxes_follow_value_clips_of_what_no_layer_authors(stage, tmp_path):
    clip = Usd.Stage.CreateNew(str(tmp_path / "clip.usda"))
    size = UsdGeom.Cube.Define(clip, "/M").CreateSizeAttr()
    size.Set(2.0, 0)
    size.Set(4.0, 10)
    clip.Save()
    file = Sdf.AssetPath(clip.GetRootLayer().identifier)
    clips = {"primPath": "/M", "assetPaths": Sdf.AssetPathArray([file]), "manifestAssetPath": file}
    clips |= {"active": Vt.Vec2dArray([(0, 0)]), "times": Vt.Vec2dArray([(0, 0), (10, 10)])}
    cube = UsdGeom.Cube.Define(stage, "/World/Cube")
    cube.GetPrim().SetMetadata("clips", {"default": clips})
    add_labels(cube.GetPrim(), {"class": ["cube"]})
    reader = LabeledPrimReader(stage)
    for code in (0, 10, 5):
        bounds = reader.read(("/World/Cube",), time=Usd.TimeCode(code)).bounds
        np.testing.assert_allclose(np.ptp(bounds[0], axis=0), cube.GetSizeAttr().Get(code))


def test_a_new_time_reads_the_geometry_of_what_varies_alone(stage, monkeypatch):
    for name in ("Still", "Growing"):
        add_labels(add_cube(stage, f"/World/{name}"), {"class": [name]})
    size = UsdGeom.Cube(stage.GetPrimAtPath("/World/Growing")).GetSizeAttr()
    size.Set(1.0, 0)
    size.Set(3.0, 10)
    reader = LabeledPrimReader(stage)
    gprims = RayCaster(stage).gprims
    reader.read(gprims, time=Usd.TimeCode(0))
    seen = []

    def noted(prim, *rest, **options):
        seen.append(prim.GetName())
        return hulls.read_hull(prim, *rest, **options)

    monkeypatch.setattr(prim_bounds, "read_hull", noted)
    found = reader.read(gprims, time=Usd.TimeCode(5))
    assert seen == ["Growing"]
    widths = dict(zip(found.prim_paths, found.bounds[:, 1, 0] - found.bounds[:, 0, 0]))
    assert widths["/World/Growing"] == pytest.approx(2.0)


def test_labels_of_materials_follow_what_is_bound_in_mid_run(stage):
    box = add_cube(stage, "/World/Box", "box")
    materials = [UsdShade.Material.Define(stage, f"/World/Looks/{name}") for name in ("Oak", "Tin")]
    for material in materials:
        add_labels(material.GetPrim(), {"class": [material.GetPrim().GetName()]})
    binding = UsdShade.MaterialBindingAPI.Apply(box)
    reader = LabeledPrimReader(stage)

    def labels() -> list[str]:
        return list(reader.read(["/World/Box"]).labels[0]["class"])

    assert labels() == ["box"]
    for material, label in zip(materials, ("oak", "tin")):
        binding.Bind(material)
        assert labels() == ["box", label]
    binding.UnbindAllBindings()
    assert labels() == ["box"]


def test_the_points_of_copies_of_an_asset_are_read_once_and_own_ones_are_their_own(stage, monkeypatch):
    asset = new_stage()
    mesh = UsdGeom.Mesh.Define(asset, "/Part/Mesh")
    points, corners = [(0, 0, 0), (1, 0, 0), (0, 2, 0)], [0, 1, 2]
    mesh.GetPointsAttr().Set(points)
    mesh.GetFaceVertexCountsAttr().Set([3])
    mesh.GetFaceVertexIndicesAttr().Set(corners)
    for k in range(4):
        part = xform(stage, f"/World/Part_{k}", translate=(k, 0, 0))
        part.GetReferences().AddReference(asset.GetRootLayer().identifier, "/Part")
        add_labels(part, {"class": ["part"]})
    own = UsdGeom.Mesh.Get(stage, "/World/Part_2/Mesh")
    own.GetPointsAttr().Set([(0, 0, 0), (3, 0, 0), (0, 2, 0)])
    place(stage.GetPrimAtPath("/World/Part_3/Mesh"), scale=(2, 2, 2))
    reads = []
    read_hull = prim_bounds.read_hull
    monkeypatch.setattr(prim_bounds, "read_hull", lambda prim, *a, **k: reads.append(prim) or read_hull(prim, *a, **k))

    reader, gprims = LabeledPrimReader(stage), [f"/World/Part_{k}/Mesh" for k in range(4)]
    np.testing.assert_array_equal(reader.read(gprims).bounds[:, 1, :2], [(1, 2), (1, 2), (3, 2), (2, 4)])
    assert len(reads) == 2
    mesh.GetPointsAttr().Set([(0, 0, 0), (7, 0, 0), (0, 2, 0)])  # in the asset
    np.testing.assert_array_equal(reader.read(gprims).bounds[:, 1, :2], [(7, 2), (7, 2), (3, 2), (14, 4)])


@pytest.mark.parametrize("first", ["A", "B"])
def test_a_copy_of_an_asset_with_holes_of_its_own_is_bounded_by_its_own_faces(first, stage):
    asset = UsdGeom.Mesh.Define(stage, "/Library/Strip")
    asset.CreatePointsAttr([(x, y, 0) for x in (0, 1, 5) for y in (0, 1)])
    asset.CreateFaceVertexCountsAttr([4, 4])
    asset.CreateFaceVertexIndicesAttr([0, 2, 3, 1, 2, 4, 5, 3])
    asset.CreateSubdivisionSchemeAttr("none")
    for name in ("A", "B"):
        copy = stage.DefinePrim(f"/World/{name}")
        copy.GetReferences().AddInternalReference("/Library/Strip")
        add_labels(copy, {"class": ["strip"]})
    holed = UsdGeom.Mesh.Get(stage, "/World/B")
    holed.CreateHoleIndicesAttr([1])
    reader, gprims = (
        LabeledPrimReader(stage),
        [f"/World/{name}" for name in sorted("AB", key=lambda each: each != first)],
    )

    def ends():
        read = reader.read(gprims)
        return {path[-1]: float(bounds[1, 0]) for path, bounds in zip(read.prim_paths, read.bounds)}

    assert ends() == {"A": 5.0, "B": 1.0}
    holed.CreateCreaseIndicesAttr([0, 1])
    holed.CreateSubdivisionSchemeAttr("catmullClark")  # the hole's points shape the face beside it
    assert ends() == {"A": 5.0, "B": 5.0}
    holed.GetSubdivisionSchemeAttr().Set("none")
    assert ends() == {"A": 5.0, "B": 1.0}


def test_what_comes_and_goes_leaves_the_labels_and_bounds_of_others_alone(stage, monkeypatch):
    add_labels(xform(stage, "/World/Car"), {"class": ["car"]})
    for name in ("Body", "Wheel"):
        add_cube(stage, f"/World/Car/{name}", name)
    reader = LabeledPrimReader(stage)
    reader.read(RayCaster(stage).gprims)
    found, bounded = [], []
    chains, bounds = LabeledStage._find_chains, PrimBounds._of_gprim
    monkeypatch.setattr(
        LabeledStage, "_find_chains", lambda self, gprims: [found.extend(gprims), chains(self, gprims)][1]
    )
    monkeypatch.setattr(
        PrimBounds, "_of_gprim", lambda self, path, *rest: [bounded.append(str(path)), bounds(self, path, *rest)][1]
    )
    add_cube(stage, "/World/Box", "Box")
    after = reader.read(RayCaster(stage).gprims)
    assert set(found) == set(bounded) == {"/World/Box"}
    assert after.prim_paths == read(stage).prim_paths
    np.testing.assert_array_equal(after.bounds, read(stage).bounds)


def test_a_label_that_changes_is_the_only_one_that_is_read_again(stage, monkeypatch):
    car = xform(stage, "/World/Car")
    for prim in (car, add_cube(stage, "/World/Car/Body"), add_cube(stage, "/World/Box")):
        add_labels(prim, {"class": [prim.GetName()]})
    reader, gprims = LabeledPrimReader(stage), RayCaster(stage).gprims
    reader.read(gprims)
    seen = []
    get = ownership.get_labels
    monkeypatch.setattr(ownership, "get_labels", lambda prim, time: [seen.append(prim.GetName()), get(prim, time)][1])
    car.GetAttribute("semantics:labels:class").Set(["van"])
    found = reader.read(gprims).select(None)
    assert [each["class"] for each in found.labels] == ["van,body", "box"]
    assert set(seen) == {"Car", "Body"}, "what is below inherits it"


def test_a_labeled_material_that_comes_and_goes_elsewhere_labels_what_is_bound_to_it(stage):
    add_cube(stage, "/World/Box", "Box")
    box = stage.GetPrimAtPath("/World/Box")
    UsdShade.MaterialBindingAPI.Apply(box)
    box.CreateRelationship("material:binding", False).SetTargets(["/Looks/Steel"])
    reader, gprims = LabeledPrimReader(stage), RayCaster(stage).gprims
    for _ in range(2):
        assert reader.read(gprims).select(None).labels == ({"class": "box"},)
        add_labels(UsdShade.Material.Define(stage, "/Looks/Steel").GetPrim(), {"class": ["steel"]})
        assert reader.read(gprims).select(None).labels == ({"class": "box,steel"},)
        stage.RemovePrim("/Looks")

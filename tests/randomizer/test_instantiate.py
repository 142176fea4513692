"""Prims that `randomizer.instantiate` creates."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import usdsdg as rep
from usdsdg.errors import AssetNotFound, GraphError
from usdsdg.graph import evaluate
from usdsdg.scatter.collisions import collide
from usdsdg.scatter.solid import Solids
from usdsdg.session import stage_context
from usdsdg.stage.geometry.triangles import triangles_below
from usdsdg.stage.semantics import labels


@pytest.fixture
def files(tmp_path):
    paths = []
    for kind in ("Cube", "Sphere", "Cone"):
        layer = Usd.Stage.CreateNew(str(tmp_path / f"{kind}.usda"))
        root = UsdGeom.Xform.Define(layer, "/Root")
        layer.SetDefaultPrim(root.GetPrim())
        layer.DefinePrim("/Root/shape", kind)
        layer.Save()
        paths.append(str(tmp_path / f"{kind}.usda"))
    return paths


def fire():
    rep.utils.send_og_event("go")
    evaluate.graph().evaluate()


def kinds(stage, item):
    """Return the type of the shape that each object references."""
    found = []
    for path in item.prims:
        shapes = [
            prim
            for prim in Usd.PrimRange(stage.GetPrimAtPath(path), Usd.TraverseInstanceProxies())
            if prim.IsA(UsdGeom.Gprim)
        ]
        assert len(shapes) == 1
        found.append(shapes[0].GetTypeName())
    return found


@pytest.mark.parametrize("mode", ["scene_instance", "reference"])
@pytest.mark.parametrize("use_cache", [True, False])
def test_every_execution_samples_other_assets(stage, files, mode, use_cache):
    with rep.trigger.on_custom_event("go"):
        item = rep.randomizer.instantiate(files, size=20, mode=mode, use_cache=use_cache)
    assert len(item.prims) == 20
    seen = []
    for _ in range(3):
        fire()
        seen.append(tuple(kinds(stage, item)))
        assert set(seen[-1]) == {"Cube", "Sphere", "Cone"}
    assert len(set(seen)) == 3
    children = [stage.GetPrimAtPath(f"{path}/Ref") for path in item.prims]
    assert all(child.IsInstance() == (mode == "scene_instance") for child in children)
    assert bool(stage.GetPrimAtPath("/Replicator/SampledAssets/Cache")) == use_cache


def test_the_cache_is_not_rendered(stage, files):
    item = rep.randomizer.instantiate(files, size=4)
    shown = [
        prim
        for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
        if prim.IsA(UsdGeom.Gprim)
    ]
    assert len(shown) == len(item.prims) == 4


def test_the_first_sample_is_referenced_immediately_and_by_the_first_execution(stage, files):
    with rep.trigger.on_custom_event("go"):
        item = rep.randomizer.instantiate(files, size=8)
    before = kinds(stage, item)
    fire()
    assert kinds(stage, item) == before


def test_objects_can_be_posed_labeled_and_made_rigid_bodies(stage, files):
    toy = [("class", "toy")]
    with (
        rep.trigger.on_custom_event("go"),
        rep.randomizer.instantiate(files, size=3, mode="reference", semantics=toy) as item,
    ):
        rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
        rep.physics.collider()
    fire()
    prims = [stage.GetPrimAtPath(path) for path in item.prims]
    assert [labels.get_labels(prim) for prim in prims] == [{"class": ["toy"]}] * 3
    assert len({tuple(prim.GetAttribute("xformOp:translate").Get()) for prim in prims}) == 3


def test_weights_and_sampling_without_replacement(stage, files):
    only = rep.randomizer.instantiate(files, size=10, weights=[0, 1, 0])
    assert set(kinds(stage, only)) == {"Sphere"}
    each = rep.randomizer.instantiate(files, size=3, with_replacements=False)
    assert sorted(kinds(stage, each)) == ["Cone", "Cube", "Sphere"]
    with pytest.raises(GraphError, match="size=4 without replacements, but only 3 paths"):
        rep.randomizer.instantiate(files, size=4, with_replacements=False)


def test_prims_of_the_stage_can_be_instantiated(stage):
    shapes = [rep.create.cube(name="a"), rep.create.sphere(name="b")]
    item = rep.randomizer.instantiate(rep.create.group(shapes), size=12)
    placed = triangles_below([stage.GetPrimAtPath(path) for path in item.prims])
    assert {len(each.triangles.faces) for each in placed} == {
        len(each.triangles.faces) for shape in shapes for each in triangles_below([stage.GetPrimAtPath(shape.prims[0])])
    }


def test_own_seeds_replace_the_global_one(files):
    def drawn(seed, own):
        stage = stage_context.new_stage()
        rep.set_global_seed(seed)
        item = rep.randomizer.instantiate(files, size=12, seed=own, name="toys")
        assert item.prims[0].startswith("/Replicator/SampledAssets/toys/")
        return kinds(stage, item)

    own = drawn(1, own=5)
    assert drawn(2, own=5) == drawn(5, own=None) == drawn(5, own=-1) == own
    assert drawn(1, own=6) != own
    assert drawn(1, own=None) != drawn(2, own=None)


def test_prototypes_of_point_instances_are_sampled(stage, files):
    with rep.trigger.on_custom_event("go"):
        item = rep.randomizer.instantiate(files, size=50, mode="point_instance")
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath(item.prims[0]))
    seen = []
    for _ in range(2):
        fire()
        indices = list(instancer.GetProtoIndicesAttr().Get())
        targets = instancer.GetPrototypesRel().GetTargets()
        seen.append([kinds_of_prototype(stage, targets[index]) for index in indices])
    assert len(targets) == 3
    assert set(seen[0]) == {"Cube", "Sphere", "Cone"}
    assert seen[0] != seen[1]
    assert len(triangles_below([instancer.GetPrim()])) == 50


def kinds_of_prototype(stage, path):
    return next(prim.GetTypeName() for prim in Usd.PrimRange(stage.GetPrimAtPath(path)) if prim.IsA(UsdGeom.Gprim))


def test_point_instances_are_posed_individually(stage, files):
    with rep.randomizer.instantiate(files, size=30, mode="point_instance") as item:
        rep.modify.pose(
            position=rep.distribution.uniform((0, 0, 0), (1, 2, 3)),
            rotation=rep.distribution.uniform((0, 0, 0), (0, 0, 90)),
            scale=rep.distribution.uniform(0.5, 1.0),
        )
    evaluate.graph().evaluate()
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath(item.prims[0]))
    assert len({tuple(position) for position in instancer.GetPositionsAttr().Get()}) == 30
    assert all(0.5 <= scale[0] == scale[1] < 1 for scale in instancer.GetScalesAttr().Get())
    rotations = [Gf.Rotation(Gf.Quatd(rotation)) for rotation in instancer.GetOrientationsAttr().Get()]
    assert all(0 <= rotation.GetAngle() <= 90.5 for rotation in rotations)


def test_point_instances_are_rotated_and_scattered_individually_without_collisions(stage, files):
    floor = rep.create.plane(scale=30)
    with rep.randomizer.instantiate(files, size=40, mode="point_instance") as item:
        rep.randomizer.rotation()
        rep.randomizer.scatter_2d(floor, offset=1, check_for_collisions=True)
    instancer = stage.GetPrimAtPath(item.prims[0])
    UsdGeom.Xformable(instancer).AddTranslateOp().Set(Gf.Vec3d(3, 0, 5))
    evaluate.graph().evaluate()
    placed = triangles_below([instancer])
    origins = [each.to_world[3, :3] for each in placed]
    assert [round(float(origin[2]), 5) for origin in origins] == [1.0] * 40
    assert len({tuple(rotation.GetImaginary()) for rotation in instancer.GetAttribute("orientations").Get()}) == 40
    bodies = [Solids().around(origin, [each]) for origin, each in zip(origins, placed)]
    assert not any(collide(bodies[i], bodies[j], origins[j] - origins[i]) for i in range(40) for j in range(i + 1, 40))


def test_point_instances_do_not_support_look_at(stage, files):
    item = rep.randomizer.instantiate(files, size=3, mode="point_instance")
    rep.modify.pose(look_at=(0, 0, 1), input_prims=item)
    with pytest.raises(
        GraphError, match=r"look_at cannot be given to point instances, as those of .*; use position, rotation, scale"
    ):
        evaluate.graph().evaluate()


@pytest.mark.parametrize(
    ("stride", "expected"),
    [(None, ["Cube", "Cube", "Sphere", "Sphere", "Cone", "Cone"]), (2, ["Cube", "Sphere", "Cone"] * 2)],
)
def test_assets_may_be_a_distribution(stage, files, stride, expected):
    with rep.trigger.on_custom_event("go"):
        item = rep.randomizer.instantiate(rep.distribution.sequence(files, stride=stride), size=2)
    seen = []
    for _ in range(3):
        fire()
        seen += kinds(stage, item)
    assert seen == expected
    with pytest.raises(GraphError, match="give weights to the distribution"):
        rep.randomizer.instantiate(rep.distribution.choice(files), size=2, weights=[1, 2, 3])


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"seed": "x"}, GraphError, "seed is 'x'; expected a whole number"),
        ({"mode": "copies"}, GraphError, "mode='copies'; known: scene_instance"),
        ({"size": -1}, GraphError, "count is -1"),
        ({"paths": []}, GraphError, "paths is empty"),
        ({"paths": ["/nowhere/at/all.usd"]}, AssetNotFound, r"all\.usd"),
    ],
)
def test_invalid_arguments_of_instantiate_raise_errors(stage, files, arguments, error, message):
    with pytest.raises(error, match=message):
        rep.randomizer.instantiate(**{"paths": files, "size": 2, **arguments})


def test_assets_sampled_later_collide_too(stage, files):
    with rep.trigger.on_frame():
        population = rep.randomizer.instantiate(rep.distribution.sequence(files), size=2)
        with population:
            rep.physics.rigid_body(contact_offset=0.02)
    shown = set()
    for _ in range(4):
        evaluate.graph().evaluate(preview=True)
        for path in population.prims:
            (shape,) = [each for each in Usd.PrimRange(stage.GetPrimAtPath(path)) if each.IsA(UsdGeom.Gprim)]
            shown.add(shape.GetTypeName())
            assert shape.HasAPI(UsdPhysics.CollisionAPI), path
            assert shape.GetAttribute("physxCollision:contactOffset").Get() == pytest.approx(0.02)
            assert stage.GetPrimAtPath(path).HasAPI(UsdPhysics.RigidBodyAPI)
    assert shown == {"Cube", "Sphere", "Cone"}


@pytest.mark.parametrize("mode", ["scene_instance", "reference", "point_instance"])
@pytest.mark.parametrize("visible", [True, False])
def test_instances_of_prims_of_the_stage_are_visible_whether_these_are_or_not(stage, mode, visible):
    cube = rep.create.cube(visible=visible, semantics=[("class", "cube")])
    row = rep.randomizer.instantiate(cube, size=3, mode=mode)
    with row:
        rep.modify.pose(position=rep.distribution.sequence([(0, -2, 0), (0, 2, 0), (0, 0, 2)]))
    camera = rep.create.camera(position=(15, 0, 1), look_at=(0, 0, 1))
    masks = rep.annotators.get("instance_segmentation", init_params={"colorize": False})
    masks.attach(rep.create.render_product(camera, (96, 96)))
    rep.orchestrator.step()
    is_shown = visible and mode == "point_instance"
    assert (UsdGeom.Imageable(stage.GetPrimAtPath(cube.prims[0])).ComputeVisibility() == "inherited") == is_shown
    assert len(np.unique(masks.get_data()["data"])) == 1 + 3 + is_shown


SIZES = {
    "choice": (lambda: rep.distribution.choice([0, 2, 5]), {0, 2, 5}),
    "sequence": (lambda: rep.distribution.sequence([1, 3]), {1, 3}),
    "uniform": (lambda: rep.distribution.uniform(1, 4), {1, 2, 3}),
}


def shapes_on(stage):
    """Return the gprims that a renderer would show, outside of prototypes and classes."""
    shown = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    return [prim for prim in shown if prim.IsA(UsdGeom.Gprim)]


@pytest.mark.parametrize("mode", ["scene_instance", "reference"])
@pytest.mark.parametrize("kind", SIZES)
def test_a_drawn_size_is_how_many_objects_an_execution_shows(stage, files, mode, kind):
    make, possible = SIZES[kind]
    with rep.trigger.on_custom_event("go"):
        item = rep.randomizer.instantiate(files, size=make(), mode=mode)
        with item:
            rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (9, 9, 9)))
            rep.modify.semantics([("class", "toy")])
    counts = []
    for _ in range(30):
        fire()
        counts.append(len(shapes_on(stage)))
    assert set(counts) == possible
    assert len(item.prims) >= max(possible)
    if kind == "sequence":
        assert counts[:4] == [1, 3, 1, 3]


def test_objects_that_a_drawn_size_shows_again_are_posed_labeled_and_bodies(stage, files):
    with rep.trigger.on_custom_event("go"):
        item = rep.randomizer.instantiate(files, size=rep.distribution.sequence([1, 3]))
        with item:
            rep.modify.semantics([("class", "toy")])
            rep.modify.pose(position=rep.distribution.sequence([(1, 0, 0), (2, 0, 0), (3, 0, 0)], stride=3))
            rep.physics.rigid_body(velocity=(0, 0, 1))
    for count in (1, 3, 1, 3):
        fire()
        prims = [stage.GetPrimAtPath(path) for path in item.prims]
        shown = [prim for prim in prims if prim.IsActive()]
        assert shown == prims[:count]
        assert [labels.get_labels(prim) for prim in shown] == [{"class": ["toy"]}] * count
        assert [prim.GetAttribute("xformOp:translate").Get()[0] for prim in shown] == [1, 2, 3][:count]
        assert [prim.GetAttribute("physics:velocity").Get() for prim in shown] == [(0, 0, 1)] * count
        assert all(prim.HasAPI(UsdPhysics.RigidBodyAPI) for prim in shown)
        assert all(prim.HasAPI(UsdPhysics.CollisionAPI) for prim in shapes_on(stage))


def test_a_drawn_size_is_how_many_point_instances_an_execution_shows(stage, files):
    with rep.trigger.on_custom_event("go"):
        item = rep.randomizer.instantiate(files, size=rep.distribution.sequence([4, 2, 0]), mode="point_instance")
        with item:
            rep.modify.pose(position=rep.distribution.uniform((1, 1, 1), (9, 9, 9)))
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath(item.prims[0]))
    for count in (4, 2, 0, 4):
        fire()
        assert len(instancer.GetProtoIndicesAttr().Get()) == count
        placed = instancer.ComputeInstanceTransformsAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default())
        assert len({tuple(each.ExtractTranslation()) for each in placed}) == count
        assert all(min(each.ExtractTranslation()) >= 1 for each in placed)


@pytest.mark.parametrize(
    "size", [lambda: rep.distribution.normal(3, 1), lambda: rep.distribution.uniform(-2, 2),
             lambda: rep.distribution.uniform((1, 1), (2, 2)), lambda: rep.distribution.choice([1, 2.5]),
             lambda: rep.distribution.choice([-1, 2])],
)  # fmt: skip
def test_a_drawn_size_that_is_no_number_of_objects_is_an_error(stage, files, size):
    with pytest.raises(GraphError, match=r"size|count"):
        rep.randomizer.instantiate(files, size=size())


def test_sampling_without_replacement_needs_as_many_paths_as_the_largest_size(stage, files):
    with pytest.raises(GraphError, match="size=4 without replacements, but only 3 paths"):
        rep.randomizer.instantiate(files, size=rep.distribution.choice([1, 4]), with_replacements=False)

"""Values of xformOps that come from another layer than before, on prims that are moved again and again."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from tests.sampled_cases import sampled
from usdsdg.stage.schemas import physx
from usdsdg.stage.semantics.label_copies import label_all
from usdsdg.stage.semantics.labels import add_labels, remove_labels
from usdsdg_render.sync.extract import SceneExtractor
from usdsdg_render.usd.stage_tree import StageTree

BALLS = ("/World/a", "/World/b")
FROM_STRONGER = Gf.Vec3d(9, 8, 7)


@pytest.fixture
def weak():
    return Sdf.Layer.CreateAnonymous()


@pytest.fixture
def stage(weak):
    """Balls with ops in a sublayer, which is the edit target."""
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().subLayerPaths.append(weak.identifier)
    stage.SetEditTarget(weak)
    for path in BALLS:
        ball = UsdGeom.Sphere.Define(stage, path)
        ball.AddTranslateOp().Set((1, 2, 3))
        ball.AddScaleOp().Set((2, 2, 2))
    stage.GetPrimAtPath("/World").SetTypeName("Xform")
    return stage


def translate(stage: Usd.Stage) -> Usd.Attribute:
    return stage.GetAttributeAtPath(f"{BALLS[0]}.xformOp:translate")


def in_root(stage: Usd.Stage) -> Usd.Attribute:
    stage.SetEditTarget(stage.GetRootLayer())
    return translate(stage)


def insert_layer(stage: Usd.Stage) -> None:
    layer = Sdf.Layer.CreateAnonymous()
    path = translate(stage).GetPath()
    Sdf.JustCreatePrimAttributeInLayer(layer, path, Sdf.ValueTypeNames.Double3)
    layer.GetAttributeAtPath(path).default = FROM_STRONGER
    stage.GetRootLayer().subLayerPaths.insert(0, layer.identifier)


def remove_spec(stage: Usd.Stage) -> None:
    layer = stage.GetEditTarget().GetLayer()
    del layer.GetPrimAtPath(BALLS[0]).properties["xformOp:translate"]


EDITS = {
    "a value in a stronger layer": lambda stage: in_root(stage).Set(FROM_STRONGER),
    "a block in a stronger layer": lambda stage: in_root(stage).Block(),
    "a block": lambda stage: translate(stage).Block(),
    "no value any more": lambda stage: translate(stage).Clear(),
    "no spec any more": remove_spec,
    "a stronger sublayer": insert_layer,
    "a sample": lambda stage: translate(stage).Set(FROM_STRONGER, 3.0),
    "no ops": lambda stage: UsdGeom.Xformable(stage.GetPrimAtPath(BALLS[0])).ClearXformOpOrder(),
    "a muted layer": lambda stage: stage.MuteLayer(stage.GetRootLayer().subLayerPaths[0]),
}


def assert_fresh(extractor: SceneExtractor, stage: Usd.Stage) -> None:
    extractor.update()
    fresh = SceneExtractor(stage)
    fresh.update()
    assert extractor.scene.instances.paths == fresh.scene.instances.paths
    np.testing.assert_array_equal(extractor.scene.instances.local_to_world, fresh.scene.instances.local_to_world)


def move(stage: Usd.Stage, x: float) -> None:
    with Sdf.ChangeBlock():
        for path in BALLS:
            if attribute := stage.GetAttributeAtPath(f"{path}.xformOp:translate"):
                attribute.Set(Gf.Vec3d(x, 0, 1))


@pytest.mark.parametrize("edit", EDITS)
def test_poses_are_those_of_a_new_extraction(edit, stage):
    extractor = SceneExtractor(stage)
    for k in range(3):
        move(stage, k)
        assert_fresh(extractor, stage)
    EDITS[edit](stage)
    assert_fresh(extractor, stage)
    for k in range(3):
        move(stage, 10 + k)
        assert_fresh(extractor, stage)


LAYER_EDITS = {
    "cleared": lambda stage, layer: layer.Clear(),
    "replaced": lambda stage, layer: layer.TransferContent(Sdf.Layer.CreateAnonymous()),
    "removed": lambda stage, layer: stage.GetRootLayer().subLayerPaths.__delitem__(0),
    "muted": lambda stage, layer: stage.MuteLayer(layer.identifier),
}


@pytest.mark.parametrize("edit", LAYER_EDITS)
def test_poses_of_a_layer_that_applies_schemas_too_go_with_it(edit, stage):
    """Schemas that do not matter to an image, on the prim that is moved and on one above another."""
    inner = UsdGeom.Sphere.Define(stage, f"{BALLS[1]}/inner")
    inner.AddTranslateOp().Set((0, 0, 1))
    layer = Sdf.Layer.CreateAnonymous()
    stage.GetRootLayer().subLayerPaths.insert(0, layer.identifier)
    stage.SetEditTarget(layer)
    for path in BALLS:
        UsdPhysics.CollisionAPI.Apply(stage.GetPrimAtPath(path))
    for op in (translate(stage), inner.GetTranslateOp().GetAttr()):
        op.Set(FROM_STRONGER)
    extractor = SceneExtractor(stage)
    assert_fresh(extractor, stage)
    LAYER_EDITS[edit](stage, layer)
    assert_fresh(extractor, stage)
    assert extractor.scene.instances.local_to_world[0, 3, :3].tolist() == [1, 2, 3]


def apply_in(layer: Sdf.Layer, path: str, schema: str = "PhysicsCollisionAPI") -> None:
    Sdf.CreatePrimInLayer(layer, path).SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=[schema]))


def set_op_and_apply(layer: Sdf.Layer) -> None:
    layer.GetAttributeAtPath(f"{BALLS[0]}.xformOp:translate").default = FROM_STRONGER
    apply_in(layer, BALLS[0])


def apply_and_set_below(layer: Sdf.Layer) -> None:
    apply_in(layer, "/World", "SemanticsLabelsAPI:class")
    layer.GetAttributeAtPath(f"{BALLS[1]}.xformOp:translate").default = FROM_STRONGER


def apply_and_resize(layer: Sdf.Layer) -> None:
    apply_in(layer, BALLS[0])
    Sdf.JustCreatePrimAttributeInLayer(layer, f"{BALLS[0]}.radius", Sdf.ValueTypeNames.Double)
    layer.GetAttributeAtPath(f"{BALLS[0]}.radius").default = 0.25


def apply_and_hide(layer: Sdf.Layer) -> None:
    apply_in(layer, "/World")
    Sdf.JustCreatePrimAttributeInLayer(layer, f"{BALLS[0]}.visibility", Sdf.ValueTypeNames.Token)
    layer.GetAttributeAtPath(f"{BALLS[0]}.visibility").default = "invisible"


def apply_and_reorder(layer: Sdf.Layer) -> None:
    apply_in(layer, "/World")
    layer.GetPrimAtPath(BALLS[0]).nameChildrenOrder = ["y", "x"]


BLOCKS = {
    "a pose": set_op_and_apply,
    "a pose below": apply_and_set_below,
    "a size": apply_and_resize,
    "a hidden prim below": apply_and_hide,
    "the order of prims below": apply_and_reorder,
}


def drawn(extractor: SceneExtractor) -> list[tuple]:
    scene = extractor.scene
    sizes = [float(np.ptp(scene.prototypes[each].points)) for each in scene.instances.prototype]
    return list(zip(scene.instances.paths, scene.instances.local_to_world.tolist(), sizes))


@pytest.mark.parametrize("edit", BLOCKS)
def test_what_is_set_in_one_block_with_a_schema_that_does_not_matter(edit, stage, weak):
    """USD's notice names the schema only."""
    for name in ("x", "y"):
        UsdGeom.Sphere.Define(stage, f"{BALLS[0]}/{name}")
    extractor = SceneExtractor(stage)
    for k in range(3):
        move(stage, k)
        assert_fresh(extractor, stage)
    before = drawn(extractor)
    with Sdf.ChangeBlock():
        BLOCKS[edit](weak)
    assert_fresh(extractor, stage)
    fresh = SceneExtractor(stage)
    fresh.update()
    assert drawn(extractor) == drawn(fresh) != before


def test_a_layer_that_is_cleared_moves_the_root_prim_back_that_has_its_schema(stage):
    """The only prim of which the layer has anything."""
    layer = Sdf.Layer.CreateAnonymous()
    stage.GetRootLayer().subLayerPaths.insert(0, layer.identifier)
    stage.SetEditTarget(layer)
    world = UsdGeom.Xformable(stage.GetPrimAtPath("/World"))
    world.AddTranslateOp().Set(FROM_STRONGER)
    world.GetPrim().AddAppliedSchema("PhysicsRigidBodyAPI")
    extractor = SceneExtractor(stage)
    assert_fresh(extractor, stage)
    assert extractor.scene.instances.local_to_world[0, 3, :3].tolist() == [10, 10, 10]
    layer.Clear()
    assert_fresh(extractor, stage)
    assert extractor.scene.instances.local_to_world[0, 3, :3].tolist() == [1, 2, 3]


def test_labels_alone_read_nothing_again(stage, monkeypatch):
    """Also those of many prims at once; but what a script sets in one block with them is read."""
    extractor = SceneExtractor(stage)
    extractor.update()
    prims = [stage.GetPrimAtPath(path) for path in BALLS]
    with monkeypatch.context() as patched:
        patched.setattr(StageTree, "resync", lambda tree, roots: pytest.fail(f"{roots} were read again"))
        add_labels(prims[0], {"class": ["ball"]})
        extractor.update()
        label_all([*prims, stage.GetPrimAtPath("/World")], {"color": ["red"]})
        extractor.update()
        remove_labels(prims[0])
        physx.PhysxRigidBodyAPI.Apply(prims[1])
        extractor.update()
    with Sdf.ChangeBlock():
        add_labels(prims[0], {"shape": ["round"]})
        translate(stage).Set(FROM_STRONGER)
    assert_fresh(extractor, stage)
    assert extractor.scene.instances.local_to_world[0, 3, :3].tolist() == list(FROM_STRONGER)


def test_a_stronger_spec_may_get_its_value_later(stage, weak):
    extractor = SceneExtractor(stage)
    for k in range(2):
        move(stage, k)
        assert_fresh(extractor, stage)
    stage.SetEditTarget(stage.GetRootLayer())
    translate(stage).SetDocumentation("Moved by hand.")
    stage.SetEditTarget(weak)
    for k in range(3):
        move(stage, 5 + k)
        assert_fresh(extractor, stage)
    stage.GetRootLayer().GetAttributeAtPath(translate(stage).GetPath()).default = FROM_STRONGER
    assert_fresh(extractor, stage)
    assert extractor.scene.instances.local_to_world[0, 3, :3].tolist() == list(FROM_STRONGER)


def test_poses_that_changed_before_are_read_without_looking_up_their_ops(stage, monkeypatch):
    extractor = SceneExtractor(stage)
    for k in range(2):
        move(stage, k)
        extractor.update()
    monkeypatch.setattr("usdsdg_render.usd.transforms.local_matrices", _read_none)
    move(stage, 7)
    extractor.update()
    assert extractor.scene.instances.local_to_world[0, 3, :3].tolist() == [7, 0, 1]


def _read_none(cache: UsdGeom.XformCache, prims: list[Usd.Prim], sampled: bool) -> list:
    assert not prims
    return []


@pytest.mark.parametrize("seed", sampled(range(8), 3))
def test_poses_after_many_edits_are_those_of_a_new_extraction(seed, stage, weak):
    """Values, blocks and new specs in both layers, of one prim while others move."""
    rng = np.random.default_rng(seed)
    extractor = SceneExtractor(stage)
    for _ in range(60):
        for path in BALLS:
            if rng.random() < 0.5:
                stage.SetEditTarget(weak if rng.random() < 0.9 else stage.GetRootLayer())
                ball = stage.GetPrimAtPath(path)
                op = ball.GetAttribute(("xformOp:translate", "xformOp:scale")[int(rng.integers(2))])
                edits = (op.Block, op.Clear, lambda op=op: op.SetDocumentation(str(rng.random())))
                if rng.random() < 0.25:
                    edits[int(rng.integers(3))]()
                else:
                    op.Set(type(op.Get() or Gf.Vec3f())(*rng.uniform(1, 9, 3).tolist()))
        assert_fresh(extractor, stage)

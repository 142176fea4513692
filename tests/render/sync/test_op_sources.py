"""Values of xformOps that come from another layer than before, on prims that are moved again and again."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg_render.sync.extract import SceneExtractor

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


@pytest.mark.parametrize("seed", range(8))
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

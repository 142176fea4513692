"""Every file under the assets root, where there is one, extracts to a scene that is sound."""

import os
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.render.sync.scene_checks import assert_sound
from usdsdg_render.sync.extract import SceneExtractor

ROOT = os.environ.get("USDSDG_ASSETS_ROOT")
FILES = sorted(p for p in Path(ROOT).rglob("*") if p.suffix in (".usd", ".usda", ".usdc", ".usdz")) if ROOT else []
pytestmark = [
    pytest.mark.skipif(not FILES, reason="USDSDG_ASSETS_ROOT is not set"),
    # What these files lack is named by warnings; here only the result counts.
    pytest.mark.filterwarnings("ignore::UserWarning"),
]


@pytest.mark.parametrize("file", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_file_extracts(file):
    stage = Usd.Stage.Open(str(file))
    extractor = SceneExtractor(stage)
    extractor.update()
    assert_sound(extractor.scene)
    before = dict(extractor.scene.versions)
    extractor.update()
    assert extractor.scene.versions == before


@pytest.mark.parametrize("file", [f for f in FILES if "/Isaac/" in str(f)], ids=lambda path: path.stem)
def test_drawn_bounds_are_those_that_usd_computes(file):
    stage = Usd.Stage.Open(str(file))
    extractor = SceneExtractor(stage)
    extractor.update()
    scene = extractor.scene
    gprims = [p for p in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()) if p.IsA(UsdGeom.Gprim)]
    if not gprims:
        assert not len(scene.instances.prototype)
        return
    corners = np.concatenate(
        [
            np.c_[scene.prototypes[k].points[scene.prototypes[k].triangles].reshape(-1, 3), np.ones(3 * count)] @ matrix
            for k, matrix in zip(scene.instances.prototype, scene.instances.local_to_world)
            for count in [len(scene.prototypes[k].triangles)]
        ]
    )
    purposes = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render]
    # Lights have bounds too; only gprims count here.
    expected = [np.full(3, np.inf), np.full(3, -np.inf)]
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), purposes)
    for prim in gprims:
        box = cache.ComputeWorldBound(prim).ComputeAlignedRange()
        expected[0] = np.minimum(expected[0], box.GetMin())
        expected[1] = np.maximum(expected[1], box.GetMax())
    size = (expected[1] - expected[0]).max()
    # USD turns boxes, we turn points, so a turned object may be smaller than its box but never larger.
    assert (corners[:, :3].min(axis=0) >= expected[0] - 1e-5 * size).all()
    assert (corners[:, :3].max(axis=0) <= expected[1] + 1e-5 * size).all()
    assert np.ptp(corners[:, :3], axis=0).max() > 0.6 * size

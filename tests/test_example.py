"""Content for examples."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Usd, UsdGeom

import usdsdg as rep


def test_textures_are_images_that_randomizers_take(stage):
    textures = rep.example.TEXTURES
    assert len(set(textures)) == 6
    for file in textures:
        with Image.open(file) as image:
            assert np.array(image).ndim == 3
    with rep.create.cube():
        rep.randomizer.texture(textures=textures)
    folder = Path(rep.example.TEXTURES_DIR)
    assert {Path(file) for file in textures if "Warehouse" in file} <= set(folder.iterdir())
    with pytest.raises(AttributeError, match="it has ASSETS, ASSETS_DIR, TEXTURES, TEXTURES_DIR"):
        _ = rep.example.MODELS
    with pytest.raises(AttributeError, match="get_assets_root_path"):
        _ = rep.example.MODELS_DIR


def test_assets_are_files_that_are_created_instantiated_and_have_variants(stage):
    assets = rep.example.ASSETS
    assert len(assets) == len(set(assets)) > 4
    assert sorted(rep.utils.get_usd_files(rep.example.ASSETS_DIR)) == assets
    (part,) = rep.create.from_usd(assets[0], semantics=[("class", "part")]).prims
    box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_]).ComputeWorldBound(
        stage.GetPrimAtPath(part)
    )
    assert 0 < max(box.ComputeAlignedRange().GetSize()) < 1
    with rep.randomizer.instantiate(assets, size=4) as several:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 0)))
    sphere = rep.create.from_usd(f"{rep.example.ASSETS_DIR}/variant.usd")
    with rep.trigger.on_frame(), sphere:
        rep.modify.variant("colorVariant", rep.distribution.sequence(["blue", "red", "green"]))
    colors = []
    for _ in range(3):
        rep.orchestrator.step()
        below = Usd.PrimRange(stage.GetPrimAtPath(sphere.prims[0]), Usd.TraverseInstanceProxies())
        (ball,) = (prim for prim in below if prim.IsA(UsdGeom.Sphere))
        colors.append(UsdGeom.Sphere(ball).GetDisplayColorAttr().Get()[0])
    assert colors == [(0, 0, 1), (1, 0, 0), (0, 1, 0)]
    assert len(several.prims) == 4

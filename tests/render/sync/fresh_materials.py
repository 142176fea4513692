"""The materials that an extractor has followed, against those of a new one."""

import numpy as np
from pxr import Usd

from usdsdg_render.sync.extract import SceneExtractor


def rows(extractor: SceneExtractor) -> np.ndarray:
    """The row of the material of each instance."""
    extractor.update()
    scene = extractor.scene
    return scene.materials[scene.material_slots[scene.instances.slot_offset]]


def assert_fresh(extractor: SceneExtractor, stage: Usd.Stage) -> None:
    np.testing.assert_array_equal(rows(extractor), rows(SceneExtractor(stage)))

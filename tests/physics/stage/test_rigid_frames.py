"""The rigid frames of prims: the same bits, whether matrices are split one by one or together."""

from __future__ import annotations

import numpy as np
import pytest

from usdsdg.stage.poses.rotations import compose
from usdsdg_physics.scene import rigid_frames


@pytest.mark.parametrize("meters_per_unit", [1.0, 0.01])
def test_matrices_that_are_split_together_have_the_same_bits(monkeypatch, meters_per_unit):
    rng = np.random.default_rng(1)
    mirrored = np.where(rng.random((300, 3)) < 0.1, -1.0, 1.0)
    matrices = compose(
        1e2 * rng.normal(size=(300, 3)), rng.normal(size=(300, 4)), mirrored * 10.0 ** rng.uniform(-3, 3, size=(300, 3))
    )
    matrices[:50, :3, :3] += rng.normal(size=(50, 3, 3))  # sheared
    matrices[50:60, 1, :3] = 0.0  # flat
    monkeypatch.setattr(rigid_frames, "_known", {})
    alone = [
        (rigid_frames.rigid_pose(each, meters_per_unit), rigid_frames.body_from_prim(each, meters_per_unit))
        for each in matrices
    ]
    monkeypatch.setattr(rigid_frames, "_known", {})
    rigid_frames.split_together(list(matrices), meters_per_unit)
    for each, (pose, constant) in zip(matrices, alone, strict=True):
        assert rigid_frames.rigid_pose(each, meters_per_unit).tobytes() == pose.tobytes()
        assert rigid_frames.body_from_prim(each, meters_per_unit).tobytes() == constant.tobytes()


def test_what_was_split_first_is_forgotten_first(monkeypatch):
    monkeypatch.setattr(rigid_frames, "_known", {})
    monkeypatch.setattr(rigid_frames, "_MAX_KNOWN", 5)
    matrices = compose(np.arange(12.0).reshape(4, 3), (0, 0, 0, 1))
    for start in (0.0, 100.0):
        rigid_frames.split_together([matrix + start * np.eye(4) for matrix in matrices], 1.0)
    assert len(rigid_frames._known) == 5
    assert rigid_frames.rigid_pose(matrices[0], 1.0)[:3].tolist() == [0, 1, 2]
    assert len(rigid_frames._known) == 5

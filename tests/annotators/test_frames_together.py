"""Pictures of one capture whose images lie one after the other, as on a GPU: what each shows, as if it were alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from tests.annotators.ray_caster import add_cube, add_sphere, make_frame, new_stage, place
from usdsdg.annotators import Frame, LabeledPrimReader
from usdsdg.annotators.kinds.boxes import bounding_box_2d_tight
from usdsdg.annotators.kinds.segmentation import instance_segmentation, semantic_segmentation
from usdsdg.annotators.pixels.look_up_table import LookUpTable

PARAMS = {"semanticTypes": None, "semanticFilter": None, "colorize": False, "mapping": None}


def frames() -> tuple[list[Frame], list[Frame]]:
    """Three views of a stage, each alone and on the host, and together in one array of Warp."""
    stage, alone = new_stage(), []
    cube = add_cube(stage, "/World/cube", "cube", translate=(-1, 0, 0))
    add_sphere(stage, "/World/ball", "ball", translate=(1, 0, 0))
    reader = LabeledPrimReader(stage)
    for x in (-1, 0, 9):
        place(cube, translate=(x, 0, 0))  # in front of the camera, then out of view
        alone.append(make_frame(stage, (70, 40), reader=reader))
    whole = wp.array(np.stack([each.aovs["instance"] for each in alone]), dtype=wp.int32, device="cpu")
    together: list[Frame] = []
    for k, each in enumerate(alone):
        images = each.aovs | {"instance": whole[k]}
        together.append(replace(each, aovs=images, gprims=alone[0].gprims, memo={}, together=[]))
    for each in together:
        each.together.extend(together)
    return alone, together


@pytest.mark.parametrize("annotator", [instance_segmentation, semantic_segmentation])
@pytest.mark.parametrize("colorize", [False, True])
@pytest.mark.parametrize("mapping", [None, {"class:cube": 40, "class:ball": [9, 8, 7, 6]}])
@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1]])
def test_segmentations_are_those_of_each_frame_alone(annotator, colorize, mapping, order):
    alone, together = frames()
    params = PARAMS | {"colorize": colorize, "mapping": mapping}
    for k in order:
        expected, found = annotator(alone[k], params), annotator(together[k], params)
        assert np.array_equal(expected.data, found.data.numpy())
        assert expected.info == found.info


def test_boxes_are_those_of_each_frame_alone():
    alone, together = frames()
    for one, of_all in zip(alone, together, strict=True):
        expected, found = (bounding_box_2d_tight(each, PARAMS) for each in (one, of_all))
        assert expected.data.tobytes() == found.data.tobytes()
        assert expected.info["primPaths"] == found.info["primPaths"]
    assert [len(bounding_box_2d_tight(each, PARAMS).data) for each in together] == [2, 2, 1]


def test_a_table_of_one_frame_is_looked_up_for_that_frame_alone():
    first, *others = frames()[1]
    values = np.arange(len(first.gprims) + 1, dtype=np.uint32)
    own, shared = LookUpTable(values), LookUpTable(values, is_of_all=True)
    first.look_up(own)
    first.look_up(shared)
    assert all(shared in each.memo for each in others)
    assert not any(own in each.memo for each in others)

from typing import Any

import numpy as np
import pytest

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import mask_of, street
from usdsdg import annotators
from usdsdg.annotators.colors import colors_of_ids

KINDS = ["semantic_segmentation", "instance_segmentation", "instance_id_segmentation"]


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (64, 48))


def compute(frame, name, **params) -> Any:
    return annotators.get(name, init_params=params).compute(frame).data


def annotation(frame, name, params) -> Any:
    return annotators.get(name, init_params=params).compute(frame)


@pytest.mark.parametrize("kind", KINDS)
def test_colors_are_those_of_the_segmentation_times_the_shade(frame, kind):
    light = np.array([1.0, 2.0, 3.0])
    shaded = compute(frame, f"shaded_{kind}", useCandyColours=False, lightSource=tuple(light))
    flat = compute(frame, kind, colorize=True)[..., :3]
    cosine = frame.aovs["normals"].astype(float) @ light / np.linalg.norm(light)
    expected = flat * (0.75 + 0.25 * cosine[..., None])
    expected[frame.aovs["instance"] < 0] = 0
    assert np.abs(shaded - expected).max() <= 1
    assert shaded.shape == (48, 64, 3)
    assert shaded.dtype == np.uint8


@pytest.mark.parametrize("kind", KINDS)
def test_candy_colors_are_pale_and_one_per_id(frame, kind):
    # Lit from where no normal differs: every pixel of an id has the same shade only on a flat side.
    ids = compute(frame, kind, colorize=False)
    shaded = compute(frame, f"shaded_{kind}").astype(float)
    assert not shaded[frame.aovs["instance"] < 0].any()
    for each in np.unique(ids[frame.aovs["instance"] >= 0]):
        colors = shaded[ids == each]
        hues = colors / colors.max(axis=1, keepdims=True)
        assert np.ptp(hues, axis=0).max() < 0.03, "one color, lighter and darker"
        # Saturation from 0.3 to 0.6, brightness from 0.9, at least half of it lit.
        assert 0.38 < hues.min(axis=1).mean() < 0.72
        assert colors.max(axis=1).min() >= 0.45 * 255 - 1


def test_a_mapping_chooses_colors(frame):
    red = compute(
        frame, "shaded_semantic_segmentation", useCandyColours=False, mapping={"class:apple": [200, 0, 0, 255]}
    )
    apple = red[mask_of(frame, "/World/Apple1")]
    assert (apple[:, 0] >= 100).all()
    assert not apple[:, 1:].any()


def test_instances_can_be_mapped_by_label_and_by_path(frame):
    both = {"class:apple": [9, 8, 7], "/World/Apple2": [1, 2, 3]}
    seen = annotation(frame, "instance_segmentation", {"mapping": both, "colorize": True})
    assert (seen.data[mask_of(frame, "/World/Apple1")] == (9, 8, 7, 255)).all()
    assert (seen.data[mask_of(frame, "/World/Apple2")] == (1, 2, 3, 255)).all()
    assert seen.info["idToLabels"]["(9, 8, 7, 255)"] == "/World/Apple1"
    assert seen.info["idToSemantics"]["(1, 2, 3, 255)"] == {"class": "apple"}
    pear = (seen.data[mask_of(frame, "/World/Pear")] == colors_of_ids(np.arange(2, 12))[:, None]).all(axis=2)
    assert pear.all(axis=1).any(), "the others keep theirs"

    ids = {"class:apple": 70, "/World/Pear": 71}
    seen = annotation(frame, "instance_segmentation_fast", {"mapping": ids})
    assert (seen.data[mask_of(frame, "/World/Apple2")] == 70).all()
    assert seen.info["idToLabels"][71] == "/World/Pear"
    assert seen.info["idToSemantics"][70] == {"class": "apple"}


def test_gprims_can_be_mapped_by_path_and_by_label(frame):
    mapping = {"/World/Ground": 99, "class:pear": 98}
    seen = annotation(frame, "instance_id_segmentation_fast", {"mapping": mapping})
    assert (seen.data[mask_of(frame, "/World/Ground")] == 99).all()
    assert (seen.data[mask_of(frame, "/World/Pear")] == 98).all()
    assert seen.info["idToLabels"][99] == "/World/Ground"
    assert seen.info["idToLabels"][98] == "/World/Pear"

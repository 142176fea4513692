from types import SimpleNamespace

import numpy as np
import pytest
import warp as wp

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.errors import WriterError


@pytest.fixture(scope="module")
def frames():
    stage = street()
    return {
        f"/Render/HydraTextures/{name}": make_frame(stage, (16, 12), product=f"/Render/HydraTextures/{name}", index=3)
        for name in ("left", "right")
    }


def reader(layout, products=()):
    wanted = [annotators.get("rgb"), annotators.get("bounding_box_2d_tight"), annotators.get("camera_params")]
    return SimpleNamespace(
        data_structure=layout,
        render_products=products,
        shares_arrays=False,
        reads_numpy=False,
        annotators_of=lambda path: wanted,
    )


def one(frames):
    return dict(list(frames.items())[:1])


COMMON = {"swhFrameNumber", "reference_time", "distribution_outputs", "trigger_outputs", "named_outputs"}


def test_legacy_layout_of_one_product(frames):
    payload = annotators.build_payload(reader("legacy"), one(frames))
    assert set(payload) == COMMON | {"rgb", "bounding_box_2d_tight", "camera_params", "rp_left"}
    assert payload["rgb"].shape == (12, 16, 4)
    assert set(payload["bounding_box_2d_tight"]) == {"data", "info"}
    assert payload["rp_left"]["camera"] == "/World/Camera"
    np.testing.assert_array_equal(payload["rp_left"]["resolution"], [16, 12])
    assert payload["swhFrameNumber"] == 3
    assert payload["reference_time"] == (3, 60)


def test_legacy_layout_of_several_products_appends_their_names(frames):
    payload = annotators.build_payload(reader("legacy"), frames)
    assert {"rgb-left", "rgb-right", "camera_params-left", "rp_right"} <= set(payload)
    assert "rgb" not in payload


def test_a_product_that_is_switched_off_does_not_rename_the_others(frames):
    payload = annotators.build_payload(reader("legacy", products=tuple(frames)), one(frames))
    assert {"rgb-left", "rp_left"} <= set(payload)
    assert "rgb" not in payload


def test_annotator_layout(frames):
    payload = annotators.build_payload(reader("annotator"), frames, trigger_outputs={"on_time": 2})
    assert set(payload["annotators"]) == {"rgb", "bounding_box_2d_tight", "camera_params", "camera", "resolution"}
    assert set(payload["annotators"]["rgb"]) == {"left", "right"}
    assert set(payload["annotators"]["bounding_box_2d_tight"]["left"]) == {"data", "idToLabels", "bboxIds", "primPaths"}
    assert payload["trigger_outputs"] == {"on_time": 2}


def test_render_product_layout(frames):
    payload = annotators.build_payload(reader("renderProduct"), frames)
    assert set(payload["renderProducts"]) == {"left", "right"}
    seen = payload["renderProducts"]["left"]
    assert set(seen) == {"rgb", "bounding_box_2d_tight", "camera_params", "camera", "resolution"}
    assert seen["rgb"]["data"].shape == (12, 16, 4)
    assert "cameraProjection" in seen["camera_params"]


def test_an_unknown_layout_is_refused(frames):
    with pytest.raises(WriterError, match="renderProduct"):
        annotators.build_payload(reader("flat"), frames)


@pytest.mark.parametrize("layout", ["legacy", "annotator", "renderProduct"])
def test_a_writer_may_write_into_what_it_gets(frames, layout):
    before = {path: frame.aovs["LdrColor"].copy() for path, frame in frames.items()}
    for value in leaves(annotators.build_payload(reader(layout), frames)):
        value[...] = np.zeros((), value.dtype)
    for path, frame in frames.items():
        np.testing.assert_array_equal(frame.aovs["LdrColor"], before[path])
    again = annotators.build_payload(reader("legacy"), one(frames))
    assert again["bounding_box_2d_tight"]["data"]["x_max"].any()
    assert again["camera_params"]["cameraViewTransform"].any()


def leaves(value):
    if isinstance(value, dict):
        for item in value.values():
            yield from leaves(item)
    elif isinstance(value, np.ndarray):
        yield value


def test_a_writer_gets_warp_arrays_of_annotators_with_a_device(frames):
    wanted = [annotators.get(name, device="cuda:7") for name in ("rgb", "semantic_segmentation", "distance_to_camera")]
    wanted += [annotators.get("bounding_box_2d_tight", device="cuda:7"), annotators.get("normals", device="cpu")]
    payload = annotators.build_payload(
        SimpleNamespace(
            data_structure="legacy",
            render_products=(),
            shares_arrays=True,
            reads_numpy=True,
            annotators_of=lambda path: wanted,
        ),
        one(frames),
    )
    (frame,) = one(frames).values()
    for name, aov in (("rgb", "LdrColor"), ("distance_to_camera", "distance_to_camera")):
        assert isinstance(payload[name], wp.array)
        np.testing.assert_array_equal(payload[name].numpy(), frame.aovs[aov])
    ids = payload["semantic_segmentation"]["data"]
    assert (ids.dtype, ids.shape) == (wp.int32, (12, 16))
    # Warp has no records, and "cpu" means NumPy.
    assert payload["bounding_box_2d_tight"]["data"].dtype.names
    assert isinstance(payload["normals"], np.ndarray)


def test_a_writer_that_changes_tables_changes_those_of_no_other(frames):
    def write(**kept):
        wanted = [annotators.get("bounding_box_2d_tight"), annotators.get("semantic_segmentation")]
        reader = SimpleNamespace(
            data_structure="legacy", render_products=(), reads_numpy=True, annotators_of=lambda path: wanted, **kept
        )
        payload = annotators.build_payload(reader, one(frames))
        return [payload[name]["info"] for name in ("bounding_box_2d_tight", "semantic_segmentation")]

    shared = write(shares_arrays=True)
    before = [len(info["idToLabels"]) for info in shared]
    assert all(before)
    for info in write(shares_arrays=False):
        info["idToLabels"].clear()
    assert [len(info["idToLabels"]) for info in shared] == before
    assert [len(info["idToLabels"]) for info in write(shares_arrays=False)] == before

"""Annotators that scripts register: from AOVs, from nodes; detaching by name."""

import numpy as np
import pytest

from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.annotators import AnnotatorRegistry, NodeConnectionTemplate
from usdsdg.errors import AnnotatorRegistryError, Unsupported, UsdsdgWarning, forget_warnings
from usdsdg.session import render_products


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (16, 12))


@pytest.fixture(autouse=True)
def forgotten():
    before = set(annotators.get_registered_annotators())
    yield
    annotators.detach_all()
    render_products.reset()
    for name in set(annotators.get_registered_annotators()) - before:
        annotators.unregister_annotator(name)


@pytest.mark.parametrize(
    ("aov", "dtype", "channels", "expected"),
    [
        ("LdrColor", None, 1, lambda aovs: aovs["LdrColor"]),
        ("LdrColor", np.uint8, 3, lambda aovs: aovs["LdrColor"][..., :3]),
        ("LdrColor", np.float32, 4, lambda aovs: aovs["LdrColor"].astype(np.float32)),
        ("DistanceToCameraSD", np.float32, 1, lambda aovs: aovs["distance_to_camera"]),
        ("DepthLinearized", np.float16, 1, lambda aovs: aovs["distance_to_image_plane"].astype(np.float16)),
        ("DepthLinearizedSD", None, 1, lambda aovs: aovs["distance_to_image_plane"]),
        ("albedo", None, 1, lambda aovs: aovs["albedo"]),
        ("instance", np.int64, 1, lambda aovs: aovs["instance"].astype(np.int64)),
    ],
)
def test_an_aov_under_a_name_a_type_and_a_number_of_channels(frame, aov, dtype, channels, expected):
    AnnotatorRegistry.register_annotator_from_aov(aov, dtype, channels, name="mine", documentation="told")
    annotator = annotators.get("mine").attach(known("/Render/A"))
    wanted = expected(frame.aovs)
    empty = annotator.get_data()
    assert (empty.dtype, empty.size) == (wanted.dtype, 0)
    data = annotator.compute(frame).data
    np.testing.assert_array_equal(data, wanted)
    assert data.dtype == wanted.dtype
    assert annotator.documentation == "told"
    if aov == "LdrColor":
        assert annotator.spec.needs_path_tracing
        assert annotator.aovs == frozenset()
    else:
        assert not annotator.spec.needs_path_tracing
        assert len(annotator.aovs) == 1


def test_attaching_such_an_annotator_calls_back():
    attached = []
    AnnotatorRegistry.register_annotator_from_aov("LdrColor", name="mine", on_attach_callback=attached.append)
    annotator = annotators.get("mine")
    assert attached == []
    annotator.attach(known("/Render/A"))
    assert attached == [annotator]


def test_aovs_that_do_not_exist_are_told_with_near_misses():
    with pytest.raises(AnnotatorRegistryError, match=r"'DepthLinearised'\. Did you mean 'DepthLinearized'"):
        AnnotatorRegistry.register_annotator_from_aov("DepthLinearised", name="mine")
    with pytest.raises(Unsupported, match="AOV 'GenericModelOutput': lidar and radar are out of scope"):
        AnnotatorRegistry.register_annotator_from_aov("GenericModelOutput")
    assert "mine" not in annotators.get_registered_annotators()


@pytest.mark.parametrize("source", ["LdrColor", NodeConnectionTemplate("LdrColor", attributes_mapping={"a": "b"})])
def test_an_augmentation_node_on_its_input(frame, source):
    AnnotatorRegistry.register_annotator_from_node(
        name="blocks",
        input_rendervars=[source],
        node_type_id="omni.replicator.core.AugPixellateExp",
        init_params={"inputs:kernelSize": 4},
        output_data_type=np.uint8,
        output_channels=4,
    )
    blocks = annotators.get("blocks")
    expected = annotators.get("rgb").augment("Pixellate", kernelSize=4).compute(frame).data
    np.testing.assert_array_equal(blocks.compute(frame).data, expected)
    assert blocks.get_name() == "blocks"


def test_isaacs_time_node(frame):
    AnnotatorRegistry.register_annotator_from_node(
        name="ScanTime",
        input_rendervars=[NodeConnectionTemplate("rpFabricTime", attributes_mapping={"outputs:a": "inputs:b"})],
        node_type_id="isaacsim.core.nodes.IsaacReadSimulationTimeAnnotator",
    )
    annotator = annotators.get("ScanTime", init_params={"resetOnStop": True})
    assert annotator.compute(frame).legacy() == {"simulationTime": 0.0}


def test_other_nodes_are_told(frame):
    with pytest.raises(Unsupported, match=r"'mine' from node 'my\.ext\.Node': there is no OmniGraph"):
        AnnotatorRegistry.register_annotator_from_node("mine", ["LdrColor"], "my.ext.Node")
    with pytest.raises(AnnotatorRegistryError, match=r"'LdrColour'\. Did you mean 'LdrColor'"):
        AnnotatorRegistry.register_annotator_from_node("mine", ["LdrColour"], "omni.replicator.core.AugRotateExp")
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="no argument 'angle'"):
        AnnotatorRegistry.register_annotator_from_node(
            "mine", ["LdrColor"], "omni.replicator.core.AugRotateExp", {"angle": 3}
        )
    annotators.unregister_annotator("mine")


def test_detaching_by_name_and_by_product():
    known("/Render/A", "/Render/B")
    first, second = annotators.get("rgb").attach("/Render/A"), annotators.get("rgb").attach("/Render/B")
    depth = annotators.get("distance_to_camera").attach("/Render/A")
    AnnotatorRegistry.detach("rgb", ["/Render/B"])
    assert annotators.attached_annotators() == (first, depth)
    AnnotatorRegistry.detach(depth, None)
    assert annotators.attached_annotators() == (first,)
    AnnotatorRegistry.detach("rgb", None)
    assert not any(each.is_attached for each in (first, second, depth))

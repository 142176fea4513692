"""The object users hold: parameters, attaching, data, names."""

import copy
from types import SimpleNamespace

import numpy as np
import pytest

from tests.annotators.ray_caster import PRODUCT, known, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError, BadPrim, Unsupported, UsdsdgWarning, forget_warnings
from usdsdg.session import render_products


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (32, 24))


@pytest.fixture(autouse=True)
def clean():
    known(PRODUCT)
    yield
    annotators.detach_all()
    render_products.reset()


def test_unknown_names_suggest_near_misses():
    with pytest.raises(AnnotatorRegistryError, match="Did you mean 'bounding_box_2d_tight'"):
        annotators.get("bounding_box_2d_tigth")
    with pytest.raises(AnnotatorRegistryError, match="Did you mean 'rgb'"):
        annotators.get("RGB")


def test_known_but_missing_annotators_say_why():
    with pytest.raises(Unsupported, match="lidar"):
        annotators.get("GenericModelOutput")


def test_unknown_init_parameters_suggest_near_misses():
    with pytest.raises(AnnotatorError, match="Did you mean 'colorize'"):
        annotators.get("semantic_segmentation", init_params={"colourize": True})


def test_types_and_predicate_exclude_each_other():
    with pytest.raises(AnnotatorError, match="exclude each other"):
        annotators.get("occlusion", init_params={"semanticTypes": ["class"], "semanticFilter": "class:*"})


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"semanticTypes": 5}, r"semanticTypes is 5; expected a list of types"),
        ({"semanticTypes": ["class", 3]}, r"semanticTypes is \['class', 3\]"),
        ({"colorize": "yes"}, "colorize is 'yes'; expected True or False"),
        ({"semanticFilter": ["class"]}, r"semanticFilter is \['class'\]; expected a predicate such as 'class:\*'"),
    ],
)
def test_filters_of_another_kind_are_told(params, message):
    name = "semantic_segmentation" if "colorize" in params else "bounding_box_3d"
    with pytest.raises(AnnotatorError, match=message):
        annotators.get(name, init_params=params)


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"semanticTypes": ["clas"]}, r"'clas:\*' selects none .*did you mean class\? there are: .*class:apple"),
        ({"semanticFilter": "class:aple"}, "'class:aple' selects none .*did you mean apple"),
        ({"semanticFilter": "part:*"}, r"'part:\*' selects none of the labels on the stage; there are: "),
    ],
)
def test_a_filter_that_selects_nothing_is_told_once_with_near_misses(params, message):
    annotator = annotators.get("bounding_box_3d", init_params=params)
    scene = street()
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match=message):
        frame = make_frame(scene, (16, 12), filters=[annotator.label_filter])
    assert len(annotator.compute(frame).data) == 0


@pytest.mark.parametrize("mapping", ["{bad", "/nowhere/colors.json", 5])
def test_a_mapping_that_cannot_be_read_is_told(mapping):
    with pytest.raises(AnnotatorError, match="mapping"):
        annotators.get("semantic_segmentation", init_params={"mapping": mapping})


def test_what_an_annotator_is_called(frame):
    annotator = annotators.get("rgb").augment(lambda data: data, name="mine")
    assert (annotator.get_name(), annotator.name, annotator.template_name) == ("mine", "mine", "rgb")
    assert "uint8 (H, W, 4)" in annotator.documentation == annotator.docs
    assert not annotator.is_attached
    with pytest.raises(AnnotatorRegistryError, match="has no node"):
        annotator.get_node()
    assert annotator.attach(PRODUCT, render_product_idxs=[0]).is_attached
    assert annotator.get_node() is annotator
    with pytest.raises(AnnotatorRegistryError, match="detach it before"):
        annotator.initialize()


def test_only_what_is_attached_can_be_detached():
    annotator = annotators.get("rgb").attach(PRODUCT)
    annotator.detach()
    with pytest.raises(AnnotatorError, match="cannot be detached"):
        annotator.detach()
    annotator.detach(PRODUCT)  # from a product Replicator does not mind
    annotator.attach(PRODUCT)
    annotators.detach_all()  # as a new stage does
    annotator.detach()


@pytest.mark.parametrize(
    "wrong",
    [{"device": "gpu"}, {"device": 0}, {"render_product_idxs": ["a"]}, {"init_params": [1]}, {"device": "cudaX"}],
)
def test_arguments_of_the_wrong_type_are_told_when_getting(wrong):
    with pytest.raises(AnnotatorRegistryError, match=next(iter(wrong))):
        annotators.get("rgb", **wrong)


def test_devices_are_named_in_either_case():
    assert annotators.get("rgb", device="CUDA").device == "cuda"


def test_unregistering_what_is_not_registered_warns():
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="no annotator is named 'rgbb'. Did you mean 'rgb'"):
        annotators.AnnotatorRegistry.unregister_annotator("rgbb")
    with pytest.raises(AnnotatorRegistryError, match="3 is no name"):
        annotators.AnnotatorRegistry.unregister_annotator(3)


@pytest.mark.parametrize("params", [{}, {"prims": [], "attribute": "d"}, {"prims": ["/World"]}])
def test_the_attribute_annotator_needs_prims_and_a_name_to_be_attached(params):
    annotator = annotators.get("Attribute", init_params=params)
    with pytest.raises(ValueError, match="needs prims and an attribute"):
        annotator.attach(PRODUCT)
    assert not annotator.is_attached


def test_data_before_attaching_is_an_error():
    with pytest.raises(AnnotatorError, match="attach"):
        annotators.get("rgb").get_data()


@pytest.mark.parametrize("handle", [PRODUCT, [PRODUCT], SimpleNamespace(path=PRODUCT), [SimpleNamespace(path=PRODUCT)]])
def test_attaching_takes_handles_paths_and_lists(handle):
    annotator = annotators.get("rgb")
    assert annotator.attach(handle) is annotator
    assert annotator.is_attached
    assert annotator.render_product == PRODUCT
    assert annotator in annotators.attached_annotators()
    annotator.detach()
    assert annotators.attached_annotators() == ()


def test_one_annotator_watches_one_product():
    with pytest.raises(NotImplementedError):
        annotators.get("rgb").attach(known("/Render/A", "/Render/B"))


def test_what_is_no_render_product_is_refused():
    with pytest.raises(AnnotatorError, match="render product"):
        annotators.get("rgb").attach(42)


def test_products_that_do_not_exist_are_refused_with_near_misses():
    with pytest.raises(BadPrim, match=f"no render product {PRODUCT}s.* did you mean {PRODUCT}?"):
        annotators.get("rgb").attach(f"{PRODUCT}s")
    destroyed = render_products.product_at(PRODUCT)
    destroyed.destroy()
    annotator = annotators.get("rgb")
    with pytest.raises(BadPrim, match="destroyed; there are: none"):
        annotator.attach(destroyed)
    assert not annotator.is_attached
    assert annotators.attached_annotators() == ()


def test_data_is_empty_before_the_first_frame_and_then_the_frames(frame):
    annotator = annotators.get("distance_to_camera").attach(PRODUCT)
    assert annotator.get_data().shape == (0,)
    annotator.compute(frame)
    np.testing.assert_array_equal(annotator.get_data(), frame.aovs["distance_to_camera"])
    copied = annotator.get_data(do_array_copy=True)
    copied[:] = 0
    np.testing.assert_array_equal(annotator.get_data(), frame.aovs["distance_to_camera"])


def test_data_of_another_product_are_none_of_this_one(frame):
    annotator = annotators.get("distance_to_camera").attach(PRODUCT)
    annotator.compute(frame)
    annotator.attach(PRODUCT)
    assert annotator.get_data().shape == (24, 32)
    annotator.attach(known("/Render/Other"))
    assert annotator.get_data().shape == (0,)


@pytest.mark.parametrize("copies", [True, False])
@pytest.mark.parametrize(
    "name", ["semantic_segmentation", "bounding_box_2d_tight", "instance_segmentation", "visibility"]
)
def test_tables_may_be_changed_and_no_other_frame_or_annotator_sees_it(frame, name, copies):
    first, second = (annotators.get(name, do_array_copy=copies).attach(PRODUCT) for _ in range(2))
    first.compute(frame)
    second.compute(frame)
    untouched = copy.deepcopy(second.get_data()["info"])
    info = first.get_data()["info"]
    for table in info.values():
        if isinstance(table, dict):
            for labels in table.values():
                if isinstance(labels, dict):
                    labels.clear()
        if isinstance(table, (dict, list)):
            table.clear()
    for annotator in (first, second):
        np.testing.assert_equal(annotator.get_data()["info"], untouched)


def test_the_three_shapes_of_data(frame):
    boxes = annotators.get("bounding_box_3d").attach(PRODUCT)
    boxes.compute(frame)
    assert set(boxes.get_data()) == {"data", "info"}
    assert set(boxes.get_data(use_legacy_structure=False)) == {"data", "idToLabels", "bboxIds", "primPaths"}
    rgb = annotators.get("rgb").attach(PRODUCT)
    rgb.compute(frame)
    assert isinstance(rgb.get_data(), np.ndarray)
    assert set(rgb.get_data(use_legacy_structure=False)) == {"data"}
    camera = annotators.get("camera_params").attach(PRODUCT)
    camera.compute(frame)
    np.testing.assert_equal(camera.get_data(), camera.get_data(use_legacy_structure=False))
    assert "cameraProjection" in camera.get_data()


def test_initialize_is_for_before_attaching():
    annotator = annotators.get("semantic_segmentation").initialize(colorize=True).attach(PRODUCT)
    with pytest.raises(AnnotatorError, match="detach"):
        annotator.initialize(colorize=False)


def test_requirements_are_the_union():
    wanted = [
        annotators.get("rgb"),
        annotators.get("distance_to_camera"),
        annotators.get("bounding_box_3d", init_params={"semanticTypes": ["class", "part"]}),
    ]
    needs = annotators.requirements(wanted)
    assert needs.aovs == {"distance_to_camera", "instance"}
    assert needs.amodal_masks
    assert needs.path_tracing
    assert set(needs.filters) == {None, "class:*;part:*"}
    assert not annotators.requirements([annotators.get("normals")]).amodal_masks
    assert annotators.requirements([]).aovs == frozenset()


def test_two_annotators_of_one_kind_compute_once_per_frame(frame):
    first, second = annotators.get("occlusion"), annotators.get("occlusion")
    assert first.compute(frame) is second.compute(frame)
    filtered = annotators.get("occlusion", init_params={"semanticFilter": "class:pear"})
    assert len(filtered.compute(frame).data) == 2  # after the row of the rest


def test_data_is_the_callers_own_unless_asked_otherwise(frame):
    own = annotators.get("distance_to_camera").attach(PRODUCT)
    shared = annotators.get("distance_to_camera", do_array_copy=False).attach(PRODUCT)
    for annotator in (own, shared):
        annotator.compute(frame)
    assert not np.shares_memory(own.get_data(), frame.aovs["distance_to_camera"])
    assert np.shares_memory(shared.get_data(), frame.aovs["distance_to_camera"])
    assert not np.shares_memory(shared.get_data(do_array_copy=True), frame.aovs["distance_to_camera"])


def test_a_device_gives_warp_arrays_also_where_it_does_not_exist(frame):
    annotator = annotators.get("instance_segmentation_fast", device="cuda:7").attach(PRODUCT)
    annotator.compute(frame)
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="'cuda:7'"):
        data = annotator.get_data(use_legacy_structure=False)["data"]
    np.testing.assert_array_equal(data.numpy(), annotator.get_data(device="cpu")["data"])
    assert str(data.device) == "cpu"


@pytest.mark.parametrize("name", ["rgb", "distance_to_camera", "instance_segmentation", "normals", "PtWorldPos"])
def test_arrays_on_a_device_are_taken_over_without_a_copy(name, frame):
    shared = annotators.get(name, device="cuda:7", do_array_copy=False).attach(PRODUCT)
    of_host = shared.compute(frame).data
    first = shared.get_data(use_legacy_structure=False)["data"]
    taken = np.from_dlpack(first)
    assert np.shares_memory(taken, of_host)
    np.testing.assert_array_equal(taken, of_host)
    assert taken.shape == of_host.shape
    assert first.ptr == shared.get_data(use_legacy_structure=False)["data"].ptr
    own = shared.get_data(do_array_copy=True, use_legacy_structure=False)["data"]
    assert own.ptr != first.ptr
    np.testing.assert_array_equal(own.numpy(), taken)


def test_an_annotator_can_be_registered_under_another_name(frame):
    annotators.register("depth", "distance_to_camera")
    try:
        data = annotators.get("depth").compute(frame).data
        np.testing.assert_array_equal(data, frame.aovs["distance_to_camera"])
    finally:
        annotators.unregister_annotator("depth")
    with pytest.raises(AnnotatorRegistryError, match="not an Annotator"):
        annotators.register("depth", 3)


@pytest.mark.parametrize("made", [None, np.zeros((2, 2)), {"data": 1}])
def test_a_function_that_returns_no_annotation_is_named(frame, made):
    annotators.define("of_a_script", aovs=["distance_to_camera"], dtype=np.float32)(lambda _frame, _params: made)
    try:
        with pytest.raises(
            AnnotatorError, match=rf"'of_a_script': its function returned {type(made).__name__}; expected"
        ):
            annotators.get("of_a_script").compute(frame)
    finally:
        annotators.unregister_annotator("of_a_script")


def test_a_name_that_is_taken_is_refused():
    with pytest.raises(AnnotatorRegistryError, match=r"^An annotator named 'rgb' exists already"):
        annotators.define("rgb")(lambda _frame, _params: None)

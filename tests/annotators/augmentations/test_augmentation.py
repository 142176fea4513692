"""What an annotator's array passes through: functions, kernels, arguments, seeds, order."""

import dataclasses
import functools
import random
from typing import Any

import numpy as np
import pytest
import warp as wp

import usdsdg as rep
from tests.annotators.ray_caster import PRODUCT, known, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators, distribution
from usdsdg.annotators.augmentations.array_transform import seed_of_frame
from usdsdg.errors import (
    AnnotatorError,
    AnnotatorRegistryError,
    AugmentationError,
    Unsupported,
    UsdsdgWarning,
    forget_warnings,
)
from usdsdg.graph.sampling import set_global_seed
from usdsdg.session import render_products
from usdsdg.warp_start import quiet_warp

quiet_warp()


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (32, 24))


@pytest.fixture(autouse=True)
def clean():
    known(PRODUCT)
    yield
    annotators.detach_all()
    render_products.reset()


def data_of(annotator, frame) -> Any:
    return annotator.compute(frame).data


def at(frame, index):
    return dataclasses.replace(frame, index=index, memo={})


# Functions


def darker(data_in, amount=2):
    data_in //= amount  # in place on purpose: the frame must not notice
    return data_in


def test_a_function_changes_the_array_and_not_the_frame(frame):
    before = frame.aovs["LdrColor"].copy()
    annotator = annotators.get("rgb").augment(darker, amount=4)
    np.testing.assert_array_equal(annotator.compute(frame).data, before // 4)
    np.testing.assert_array_equal(frame.aovs["LdrColor"], before)


def test_a_function_may_call_its_array_as_it_likes(frame):
    data = annotators.get("rgb").augment(lambda picture: picture + 1).compute(frame).data
    np.testing.assert_array_equal(data, frame.aovs["LdrColor"] + 1)


def test_augmentations_compose_in_order(frame):
    chain = annotators.augment_compose("rgb", ["rgba_to_rgb", darker], name="dark")
    assert chain.get_name() == "dark"
    np.testing.assert_array_equal(chain.compute(frame).data, frame.aovs["LdrColor"][..., :3] // 2)


def test_composing_changes_nothing_if_one_of_them_does_not_exist(frame):
    rgb = annotators.get("rgb")
    with pytest.raises(AnnotatorRegistryError, match="Did you mean 'RgbaToRgb'"):
        rgb.augment_compose([darker, "RgbatoRgb"])
    np.testing.assert_array_equal(rgb.compute(frame).data, frame.aovs["LdrColor"])


def test_augmenting_from_outside_leaves_the_source_alone(frame):
    source = annotators.get("rgb")
    dark = annotators.Augmentation.from_function(darker, amount=3).apply(source, name="dark")
    assert (dark.get_name(), source.get_name()) == ("dark", "rgb")
    np.testing.assert_array_equal(source.compute(frame).data, frame.aovs["LdrColor"])
    np.testing.assert_array_equal(dark.compute(frame).data, frame.aovs["LdrColor"] // 3)


@pytest.mark.parametrize(
    "more",
    [
        lambda source: annotators.augment(source, darker, name="dark", amount=3),
        lambda source: annotators.augment_compose(
            source, [annotators.Augmentation.from_function(darker, amount=3)], name="dark"
        ),
    ],
)
def test_augment_changes_an_annotator_itself_as_in_replicator(frame, more):
    # omni.replicator.core 1.12.27, annotators.py: `augment` calls `source_annotator.augment` and returns it.
    source = annotators.get("rgb").attach(PRODUCT)
    assert more(source) is source
    assert source.is_attached
    assert source.get_name() == "dark"
    np.testing.assert_array_equal(source.compute(frame).data, frame.aovs["LdrColor"] // 3)
    np.testing.assert_array_equal(annotators.get("rgb").compute(frame).data, frame.aovs["LdrColor"])


def test_a_composed_annotator_can_be_registered(frame):
    annotators.register("dark_rgb", annotators.augment("rgb", darker))
    try:
        again = annotators.get("dark_rgb")
        assert again.get_name() == "dark_rgb"
        assert again.template_name == "rgb"
        np.testing.assert_array_equal(again.compute(frame).data, frame.aovs["LdrColor"] // 2)
    finally:
        annotators.unregister_annotator("dark_rgb")
    with pytest.raises(AnnotatorRegistryError):
        annotators.get("dark_rgb")


def test_a_registered_augmentation_is_found_by_name(frame):
    annotators.AnnotatorRegistry.register_augmentation("darker", functools.partial(darker, amount=3))
    try:
        data = annotators.get("rgb").augment("darker").compute(frame).data
        np.testing.assert_array_equal(data, frame.aovs["LdrColor"] // 3)
        found = annotators.AnnotatorRegistry.get_augmentation("darker")
        np.testing.assert_array_equal(annotators.get("rgb").augment(found).compute(frame).data, data)
    finally:
        annotators.AnnotatorRegistry.unregister_augmentation("darker")
    with pytest.raises(AnnotatorRegistryError):
        annotators.get_augmentation("darker")


# Arguments


def test_arguments_of_a_call_go_before_those_of_the_augmentation(frame):
    half = annotators.Augmentation.from_function(darker, amount=2)
    data = annotators.get("rgb").augment(half, amount=8).compute(frame).data
    np.testing.assert_array_equal(data, frame.aovs["LdrColor"] // 8)
    np.testing.assert_array_equal(annotators.get("rgb").augment(half).compute(frame).data, frame.aovs["LdrColor"] // 2)


def needy(data_in, amount):
    return data_in * amount


def test_wrong_arguments_are_named_at_once(frame):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match=r"darker has no argument 'amont', which is ignored\. Did you mean 'amount'"):
        annotators.Augmentation.from_function(darker, amont=3)
    with pytest.warns(UsdsdgWarning, match=r"darker has no argument 'xyz', which is ignored\. It has: amount"):
        rgb = annotators.get("rgb").augment(darker, xyz=3)
    np.testing.assert_array_equal(rgb.compute(frame).data, frame.aovs["LdrColor"] // 2)
    with pytest.raises(AugmentationError, match="needy needs amount"):
        annotators.get("rgb").augment(needy)
    annotators.Augmentation.from_function(needy)  # the argument may come with the call


def scaled(data_in, amount=1.0):
    return data_in * amount


def test_arguments_can_be_distributions(frame):
    annotator = annotators.get("distance_to_camera").augment(scaled, amount=distribution.uniform(2.0, 3.0, seed=4))
    seen = frame.aovs["instance"] >= 0

    def amount(index):
        ratio = data_of(annotator, at(frame, index))[seen] / frame.aovs["distance_to_camera"][seen]
        assert np.ptp(ratio) < 1e-6, "one draw per frame"
        return float(ratio.mean())

    drawn = [amount(index) for index in range(8)]
    assert all(2 <= value <= 3 for value in drawn)
    assert len(set(drawn)) == 8
    assert [amount(index) for index in range(8)] == drawn


def test_a_result_of_the_wrong_shape_or_kind_is_refused(frame):
    for function, shape, message in [
        (lambda data_in: None, None, "NoneType"),
        (lambda data_in: data_in[..., 0], (-1, -1, 3), "data_out_shape is \\(24, 32, 3\\)"),
    ]:
        with pytest.raises(AugmentationError, match=message):
            annotators.get("rgb").augment(function, data_out_shape=shape).compute(frame)


def test_a_failing_function_is_named(frame):
    def broken(data_in):
        raise ZeroDivisionError("no")

    with pytest.raises(
        AugmentationError, match=r"broken failed on uint8 of \(24, 32, 4\): ZeroDivisionError"
    ) as caught:
        annotators.get("rgb").augment(broken).compute(frame)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    line = broken.__code__.co_firstlineno + 1
    assert caught.value.__notes__ == [f"(raised at test_augmentation.py:{line}, in {broken.__qualname__})"]


def test_annotators_without_an_array_cannot_be_augmented(frame):
    with pytest.raises(AugmentationError, match="without an array"):
        annotators.get("camera_params").augment(darker).compute(frame)


# Seeds


def noise(data_in, seed):
    return np.random.default_rng(seed).integers(0, 255, data_in.shape, np.uint8)


def drawn(frame, **kwargs):
    return annotators.get("rgb").augment(noise, **kwargs).compute(frame).data.tobytes()


def test_a_seed_repeats_and_differs_by_frame_product_seed_and_name(frame):
    set_global_seed(1)
    elsewhere = dataclasses.replace(frame, render_product="/Render/Other", memo={})
    named = annotators.augment("rgb", noise, name="other").compute(frame).data.tobytes()
    twice = annotators.augment_compose("rgb", [noise, noise]).compute(frame).data.tobytes()
    different = [drawn(frame), drawn(at(frame, 1)), drawn(elsewhere), drawn(frame, seed=5), drawn(frame, seed=0)]
    assert len({*different, named, twice}) == 7
    assert different == [
        drawn(frame), drawn(at(frame, 1)), drawn(elsewhere), drawn(frame, seed=5), drawn(frame, seed=0)
    ]  # fmt: skip
    assert drawn(frame, seed=None) == drawn(frame, seed=-1) == drawn(frame)


def test_other_augmentations_leave_the_draws_as_they_were(frame):
    alone = annotators.augment_compose("rgb", [noise]).compute(frame).data
    after = annotators.augment_compose("rgb", [darker, noise]).compute(frame).data
    np.testing.assert_array_equal(alone, after)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint32, np.float32])
def test_a_seed_can_be_added_to_an_array_as_with_numpy_1(frame, dtype):
    seeds = []

    def shifted(data_in, seed):
        seeds.append(seed)
        random.seed(seed)
        np.random.default_rng(seed)
        return data_in.astype(dtype) * 0 + seed

    data = annotators.get("rgb").augment(shifted, seed=3).compute(frame).data
    assert seeds[0] > 2**16
    # NumPy 1 took the type of the least size that holds both; floats stay what they are.
    assert data.dtype == (np.float32 if dtype is np.float32 else np.uint32)
    np.testing.assert_array_equal(data, dtype(seeds[0]) if dtype is np.float32 else seeds[0])


def test_seeds_suit_every_generator():
    seeds = [seed_of_frame(7, "key", index) for index in range(1000)]
    assert len(set(seeds)) == 1000
    assert all(isinstance(seed, int) and 0 <= seed < 2**31 - 1 for seed in seeds)
    np.random.default_rng(seeds[0])
    np.random.RandomState(seeds[0])


# Warp kernels


@wp.kernel
def swap_channels(data_in: wp.array3d(dtype=wp.uint8), data_out: wp.array3d(dtype=wp.uint8), first: int):
    i, j = wp.tid()
    data_out[i, j, 0] = data_in[i, j, (first + 2) % 3]
    data_out[i, j, 1] = data_in[i, j, (first + 1) % 3]
    data_out[i, j, 2] = data_in[i, j, first % 3]


@wp.kernel
def add_noise(data_in: wp.array2d(dtype=wp.float32), data_out: wp.array2d(dtype=wp.float32), sigma: float, seed: int):
    i, j = wp.tid()
    state = wp.rand_init(seed, i * data_in.shape[1] + j)
    data_out[i, j] = data_in[i, j] + sigma * wp.randn(state)


@wp.kernel
def scale_depth(data_in: wp.array2d(dtype=wp.float32), data_out: wp.array2d(dtype=wp.float32), z_far: float = 100.0):
    i, j = wp.tid()
    data_out[i, j] = data_in[i, j] / z_far


@wp.kernel
def no_result(data_in: wp.array2d(dtype=wp.float32)):
    i, j = wp.tid()
    data_in[i, j] = 0.0


def test_a_kernel_gets_one_thread_per_pixel(frame):
    data = data_of(annotators.get("rgb").augment(swap_channels, first=0), frame)
    np.testing.assert_array_equal(data[..., :3], frame.aovs["LdrColor"][..., 2::-1])
    assert not data[..., 3].any(), "what a kernel does not write is 0"
    assert data.dtype == np.uint8


@pytest.mark.parametrize(("given", "z_far"), [({}, 100), ({"z_far": 10.0}, 10)])
def test_an_argument_of_a_kernel_may_have_a_default(frame, given, z_far):
    data = data_of(annotators.get("distance_to_camera").augment(scale_depth, **given), frame)
    np.testing.assert_allclose(data, frame.aovs["distance_to_camera"] / z_far, rtol=1e-6)


def test_the_shape_of_a_kernels_result_can_be_given(frame):
    rgb = annotators.Augmentation.from_function(swap_channels, data_out_shape=(-1, -1, 3), first=0)
    data = annotators.get("rgb").augment(rgb).compute(frame).data
    np.testing.assert_array_equal(data, frame.aovs["LdrColor"][..., 2::-1])


@pytest.mark.parametrize("channels", [3, 4])
def test_a_shape_of_one_axis_for_all_pixels_is_an_images(frame, channels):
    kernel = rep.Augmentation.from_function(swap_channels, data_out_shape=(-1, channels), first=0)
    data = annotators.get("rgb").augment(kernel).compute(frame).data
    np.testing.assert_array_equal(data[..., :3], frame.aovs["LdrColor"][..., 2::-1])
    assert data.shape == (24, 32, channels)

    function = rep.Augmentation.from_function(lambda data_in: data_in[..., :channels], data_out_shape=(-1, channels))
    data = annotators.get("rgb").augment(function).compute(frame).data
    np.testing.assert_array_equal(data, frame.aovs["LdrColor"][..., :channels])


def test_a_shape_of_one_axis_for_rows_is_kept(frame):
    function = annotators.Augmentation.from_function(lambda data_in: data_in.max(axis=1), data_out_shape=(-1, 4))
    data = annotators.get("rgb").augment(function).compute(frame).data
    np.testing.assert_array_equal(data, frame.aovs["LdrColor"].max(axis=1))


def test_the_default_augmentations_are_functions_of_the_api_itself_too(frame):
    hsv = rep.Augmentation.from_function(rep.aug_rgb_to_hsv, data_out_shape=(-1, 4))
    data = annotators.get("rgb").augment(hsv).compute(frame).data
    np.testing.assert_array_equal(data, data_of(annotators.get("rgb").augment("RgbToHsv"), frame))
    names = [name for name in rep.augmentations_default.__all__ if name.startswith("aug_")]
    assert all(getattr(rep, name) is getattr(rep.augmentations_default, name) for name in names)


def test_a_kernels_noise_has_the_sigma_that_was_asked_for_and_repeats(frame):
    annotator = annotators.get("distance_to_camera").augment(add_noise, sigma=0.1, seed=None)
    seen = frame.aovs["instance"] >= 0
    noise = [data_of(annotator, at(frame, i))[seen] - frame.aovs["distance_to_camera"][seen] for i in (0, 1, 0)]
    # 700 samples know sigma to 2.7 %; four times that.
    assert np.std(noise[0]) == pytest.approx(0.1, rel=0.11)
    assert not np.array_equal(noise[0], noise[1])
    np.testing.assert_array_equal(noise[0], noise[2])


def test_kernels_read_floats_of_other_sizes_and_ids_of_either_sign(frame):
    wide = annotators.get("distance_to_camera").augment(lambda data_in: data_in.astype(np.float64))
    data = wide.augment(add_noise, sigma=0.0).compute(frame).data
    np.testing.assert_array_equal(data, frame.aovs["distance_to_camera"])


@pytest.mark.parametrize(
    ("name", "kernel", "kwargs", "message"),
    [
        ("rgb", add_noise, {"sigma": 1.0}, "declares data_in with 2 axes, and it would be of shape .24, 32, 4."),
        ("distance_to_camera", no_result, {}, "no_result has no array data_out"),
        ("semantic_segmentation", add_noise, {"sigma": 1.0}, "reads float32, the annotator gives uint32"),
        ("rgb", swap_channels, {}, "needs first"),
    ],
)
def test_kernels_that_do_not_fit_are_told(frame, name, kernel, kwargs, message):
    with pytest.raises(AugmentationError, match=message):
        annotators.get(name).augment(kernel, **kwargs).compute(frame)


def test_kernels_for_a_device_that_is_not_there_run_on_the_cpu(frame):
    forget_warnings()
    annotator = annotators.get("rgb", device="cuda:9").augment(swap_channels, first=0)
    with pytest.warns(UsdsdgWarning, match="the CPU does their work"):
        data = data_of(annotator, frame)
    np.testing.assert_array_equal(data[..., :3], frame.aovs["LdrColor"][..., 2::-1])


def test_a_function_may_launch_kernels_of_its_own(frame):
    def own(data_in):
        return wp.array(data_in, dtype=wp.uint8, device="cpu")

    np.testing.assert_array_equal(annotators.get("rgb").augment(own).compute(frame).data, frame.aovs["LdrColor"])


# Nodes


def test_a_node_is_made_from_its_type_and_says_where_pixels_went(frame):
    made = [
        annotators.Augmentation("omni.replicator.core.AugPixellateExp", kernelSize=4),
        annotators.Augmentation.from_node("omni.replicator.core.OgnAugPixellateExp", kernelSize=4),
    ]
    results = [annotators.get("rgb").augment(each).compute(frame) for each in made]
    results.append(annotators.get("rgb").augment("omni.replicator.core.AugPixellateExp", kernelSize=4).compute(frame))
    for result in results:
        np.testing.assert_array_equal(result.data, results[0].data)
        np.testing.assert_array_equal(result.info["xform"], np.eye(3).reshape(9))
    assert set(results[0].legacy()) == {"data", "info"}


def test_transforms_of_several_nodes_multiply(frame):
    turned = annotators.augment_compose("rgb", ["Rotate", "Rotate", "Pixellate"]).compute(frame).info["xform"]
    once = annotators.augment("rgb", "Rotate").compute(frame).info["xform"].reshape(3, 3)
    np.testing.assert_allclose(turned.reshape(3, 3), once @ once)


def test_unknown_nodes_are_unsupported():
    with pytest.raises(Unsupported, match=r"OmniGraph.*Did you mean AugRotateExp"):
        annotators.Augmentation("omni.replicator.core.AugRotatExp")
    with pytest.raises(Unsupported, match="There are: AugBgRandExp"):
        annotators.Augmentation.from_node("my.extension.Whatever")
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="attributes_mapping is ignored"):
        annotators.Augmentation.from_node("AugCanny", attributes_mapping={"a": "b"})


@pytest.mark.parametrize("spellings", [{"cropFactor": 0.5, "crop_factor": 0.5, "offset_factor": (0.2, 0.2)}])
def test_nodes_pass_over_other_spellings_of_their_arguments(frame, spellings):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match=r"no argument 'crop_factor', which is ignored\. Did you mean 'cropFactor'"):
        annotator = annotators.get("rgb").augment("CropResize", **spellings)
    plain = annotators.get("rgb").augment("CropResize", cropFactor=0.5)
    np.testing.assert_array_equal(data_of(annotator, frame), data_of(plain, frame))


@pytest.mark.parametrize(
    "call",
    [
        lambda: annotators.get("rgb").augment("nope"),
        lambda: annotators.get("rgb").augment(3),
        lambda: annotators.register_augmentation("mine", "nope"),
        lambda: annotators.Augmentation.from_function(3),
        lambda: annotators.Augmentation.from_function(darker).apply(3),
    ],
)
def test_what_is_no_augmentation_is_an_augmentation_error(call):
    with pytest.raises(AugmentationError, match=r"^No augmentation is named 'nope'|^3 is no"):
        call()


def test_names_of_augmentations_that_are_not_registered_are_told_as_in_replicator():
    with pytest.raises(AnnotatorRegistryError, match="'nope'"):
        annotators.get_augmentation("nope")
    with pytest.raises(KeyError, match=r"^No augmentation is named 'nope'"):
        annotators.unregister_augmentation("nope")
    with pytest.raises(AnnotatorError, match="3 is no annotator"):
        annotators.augment(3, darker)
    with pytest.raises(AnnotatorError, match="3 is no annotator"):
        annotators.augment_compose(3, [darker])


@pytest.mark.parametrize(
    ("augmentation", "node", "shape"),
    [
        (darker, "omni.replicator.core.OgnAugmentCPU", None),
        (swap_channels, "omni.replicator.core.OgnAugment", (-1, -1, 3)),
        ("Brightness", "omni.replicator.core.OgnAugment", None),
        ("Rotate", "omni.replicator.core.AugRotateExp", None),
    ],
)
def test_an_augmentation_tells_its_node_and_shape(augmentation, node, shape):
    if isinstance(augmentation, str):
        made = annotators.get_augmentation(augmentation)
    else:
        made = annotators.Augmentation.from_function(augmentation, data_out_shape=shape)
    assert (made.node_type_id, made.data_out_shape) == (node, shape)


# Warp arrays


def of(augmentation, **kwargs):
    return annotators.Augmentation.from_function(augmentation, **kwargs)


@pytest.mark.parametrize(
    ("make", "is_warp"),
    [
        (lambda: annotators.get("rgb").augment(swap_channels, first=0), True),
        (lambda: annotators.augment("rgb", swap_channels, first=0), True),
        (lambda: annotators.get("rgb", device="cpu").augment(swap_channels, first=0), True),
        (lambda: of(swap_channels, first=0).apply("rgb"), True),
        (lambda: annotators.get("rgb").augment_compose([of(swap_channels, first=0), of(darker)]), True),
        (lambda: annotators.get("rgb").augment("Brightness"), True),
        (lambda: annotators.get("rgb").augment("Rotate"), False),
        (lambda: annotators.get("rgb").augment(darker), False),
        (lambda: annotators.get("rgb").augment(swap_channels, first=0, device="cpu"), False),
    ],
)
def test_an_annotator_with_a_kernel_gives_warp_arrays_as_in_replicator(frame, make, is_warp):
    annotator = make().attach(PRODUCT)
    computed = data_of(annotator, frame)
    data = annotator.get_data(use_legacy_structure=False)["data"]
    assert isinstance(data, wp.array if is_warp else np.ndarray)
    np.testing.assert_array_equal(data.numpy() if is_warp else data, computed)
    np.testing.assert_array_equal(annotator.get_data(device="CPU", use_legacy_structure=False)["data"], computed)


def test_kernels_of_a_registered_annotator_give_numpy_as_in_replicator(frame):
    annotators.register("swapped", annotators.get("rgb").augment(swap_channels, first=0))
    try:
        annotator = annotators.get("swapped").attach(PRODUCT)
        annotator.compute(frame)
        assert isinstance(annotator.get_data(), np.ndarray)
    finally:
        annotators.unregister_annotator("swapped")


def test_a_node_asks_for_the_aovs_that_it_reads(frame):
    assert annotators.get("rgb").aovs == frozenset()
    assert annotators.get("rgb").augment("BackgroundRand").aovs == {"instance"}

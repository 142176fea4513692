"""PytorchWriter and its listener; all but the first tests need torch."""

import sys

import numpy as np
import pytest
from PIL import Image

import usdsdg as rep
from usdsdg import writers
from usdsdg.compat.isaacsim.replicator.writers import PytorchListener
from usdsdg.errors import Unsupported, WriterError


def test_without_torch_an_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(Unsupported, match="pip install torch"):
        writers.get("PytorchWriter", init_params={"listener": PytorchListener()})


def test_a_listener_is_needed():
    with pytest.raises(WriterError, match="expected a PytorchListener"):
        writers.get("PytorchWriter", init_params={"listener": 3})


def test_a_listener_has_nothing_before_the_first_frame():
    assert PytorchListener().get_rgb_data() is None


@pytest.fixture
def torch():
    return pytest.importorskip("torch")


@pytest.fixture
def products(stage):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "cube")])
    places = ((4, 0, 2), (0, 5, 1), (3, 3, 3))
    return [rep.create.render_product(rep.create.camera(position=each, look_at=(0, 0, 0)), (32, 24)) for each in places]


def run(products, *, count=2, **options):
    listener = PytorchListener()
    writer = rep.WriterRegistry.get("PytorchWriter")
    writer.initialize(listener=listener, **options)
    writer.attach(products)
    for _ in range(count):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return listener, writer


def test_one_camera_without_files(torch, products, tmp_path):
    listener, _ = run(products[:1], device="cpu")
    images = listener.get_rgb_data()
    assert images.device.type == "cpu"
    assert images.dtype == torch.uint8
    assert list(images.shape) == [1, 3, 24, 32]
    assert listener.data["device"] == "cpu"


def test_files_are_what_the_listener_received(torch, products, tmp_path):
    listener, _ = run(products, device="cpu", output_dir=str(tmp_path))
    images = listener.get_rgb_data()
    assert list(images.shape) == [3, 3, 24, 32]
    names = [f"rgb_1_{product.path.rsplit('/', 1)[-1]}.png" for product in products]
    files = np.stack([np.array(Image.open(tmp_path / name))[..., :3] for name in names])
    np.testing.assert_array_equal(images.numpy().transpose(0, 2, 3, 1), files)
    assert files.std() > 0


def test_the_file_of_the_only_camera_is_named_after_the_annotator(torch, products, tmp_path):
    run(products[:1], device="cpu", output_dir=str(tmp_path))
    assert (tmp_path / "rgb_1_LdrColor.png").exists()


def test_one_picture_is_not_copied_to_become_a_tensor(torch, products):
    listener, writer = run(products[:1], device="cpu")
    (seen,) = writer.get_data()["renderProducts"].values()
    assert listener.data["pytorch_rgb"].data_ptr() == seen["LdrColor"]["data"].ctypes.data


def test_earlier_tensors_stay_as_they_were(torch, products):
    listener, _ = run(products[:1], count=1, device="cpu")
    first = listener.get_rgb_data()
    before = first.clone()
    before_address = first.data_ptr()
    rep.orchestrator.step()
    assert torch.equal(first, before)
    assert listener.get_rgb_data().data_ptr() != before_address


def test_a_tiled_sensor_has_one_picture(torch, products, tmp_path):
    cameras = [rep.create.camera(position=each, look_at=(0, 0, 0)) for each in ((4, 0, 2), (0, 5, 1))]
    tiled = rep.create.render_product_tiled(cameras, tile_resolution=(16, 12))
    listener, _ = run([tiled], count=1, device="cpu", tiled_sensor=True, output_dir=str(tmp_path))
    assert (tmp_path / "rgb_0.png").exists()
    height, width = np.array(Image.open(tmp_path / "rgb_0.png")).shape[:2]
    assert list(listener.get_rgb_data().shape) == [1, 3, height, width]


def test_sizes_that_differ_are_an_error(torch, products):
    other = rep.create.render_product(rep.create.camera(position=(4, 0, 2), look_at=(0, 0, 0)), (16, 12))
    with pytest.raises(WriterError, match=r"several sizes \(16x12, 32x24\)"):
        run([products[0], other], device="cpu")


def test_without_a_gpu_the_default_device_is_the_cpu_with_a_warning(torch, products, recwarn):
    if torch.cuda.is_available():
        pytest.skip("there is one")
    listener, _ = run(products[:1])
    assert listener.get_rgb_data().device.type == "cpu"
    assert any("no CUDA device" in str(each.message) for each in recwarn)


def test_on_a_gpu_tensors_are_there(torch, products):
    if not torch.cuda.is_available():
        pytest.skip("no GPU")
    listener, writer = run(products)
    assert listener.get_rgb_data().device.type == "cuda"
    alone, writer = run(products[:1])
    (seen,) = writer.get_data()["renderProducts"].values()
    assert alone.data["pytorch_rgb"].data_ptr() == seen["LdrColor"]["data"].ptr


@pytest.mark.parametrize("device", [None, "gpu", "mps"])
def test_devices_that_torch_does_not_have_are_refused(torch, device):
    if device == "mps" and torch.backends.mps.is_available():
        pytest.skip("torch has it")
    with pytest.raises(WriterError, match=f"PytorchWriter: .*device.* {device!r}"):
        writers.get("PytorchWriter", init_params={"listener": PytorchListener(), "device": device})


def test_pictures_that_make_no_tensor_make_no_files(torch, products, tmp_path):
    products[0].set_resolution((16, 12))
    with pytest.raises(WriterError, match="several sizes"):
        run(products, device="cpu", output_dir=str(tmp_path))
    rep.orchestrator.wait_until_complete()
    assert list(tmp_path.glob("*.png")) == []

"""CosmosWriter: clips, their pictures and their videos."""

import dataclasses

import numpy as np
import pytest
from PIL import Image

from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import mask_of, street
from tests.dataset_files import data_names
from tests.image_files.test_motion_jpeg import images_of
from usdsdg import annotators, writers
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings

PRODUCT = "/Render/HydraTextures/rp1"
MODALITIES = ["depth", "edges", "rgb", "segmentation", "shaded_seg"]


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (64, 48), filters=[None])


def started(folder, **options):
    writer = writers.get("CosmosWriter", init_params={"output_dir": str(folder), **options})
    writer.attach(known(PRODUCT))
    return writer


def receive(writer, frame, count=1, **outputs):
    for _ in range(count):
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}, **outputs))


def finish(writer):
    writer.on_final_frame()
    writer.backend.wait_until_done()


def files(folder):
    return data_names(folder)


def clip(number, count):
    """Files of a clip of `count` frames."""
    name = f"clip_{number:04d}"
    pictures = [f"{name}/{each}/{each}_{index:04d}.png" for each in MODALITIES for index in range(count)]
    return [*pictures, *(f"{name}/{each}.mp4" for each in MODALITIES)]


def picture(path):
    with Image.open(path) as image:
        return np.asarray(image)


def test_clips_and_their_videos(frame, tmp_path):
    writer = started(tmp_path)
    receive(writer, frame, 3)
    writer.next_clip()
    receive(writer, frame, 2)
    finish(writer)
    assert files(tmp_path) == sorted([*clip(0, 3), *clip(1, 2), "metadata.txt"])
    for modality in MODALITIES:
        shown = images_of((tmp_path / f"clip_0000/{modality}.mp4").read_bytes())
        still = picture(tmp_path / f"clip_0000/{modality}/{modality}_0002.png")
        still = np.stack([still] * 3, axis=-1) if still.ndim == 2 else still[..., :3]
        assert len(shown) == 3
        assert np.abs(shown[2].astype(int) - still).mean() < 4


def test_pictures_of_another_size_are_in_no_video(frame, tmp_path):
    """A track of MP4 has one size; a video of several was not shown whole by players."""
    forget_warnings()
    writer = started(tmp_path)
    receive(writer, frame, 2)
    receive(writer, make_frame(street(), (32, 40), filters=[None]), 2)
    receive(writer, frame)
    with pytest.warns(UsdsdgWarning, match=r"the picture 2 of clip_0000 has 32 x 40 pixels and the first one 64 x 48"):
        finish(writer)
    assert set(clip(0, 5)) < set(files(tmp_path))
    for modality in MODALITIES:
        shown = images_of((tmp_path / f"clip_0000/{modality}.mp4").read_bytes())
        assert [image.shape[:2] for image in shown] == [(48, 64)] * 3


def test_a_clip_that_goes_on_after_its_video_keeps_its_frames(frame, tmp_path):
    writer = started(tmp_path)
    for _ in range(2):
        receive(writer, frame, 2)
        finish(writer)
    assert files(tmp_path) == sorted([*clip(0, 4), "metadata.txt"])
    assert len(images_of((tmp_path / "clip_0000/rgb.mp4").read_bytes())) == 4


def test_an_on_time_trigger_begins_clips(frame, tmp_path):
    writer = started(tmp_path)
    for fired in (1, 1, 2):
        receive(writer, frame, trigger_outputs={"on_time": fired})
    finish(writer)
    assert files(tmp_path) == sorted([*clip(1, 2), *clip(2, 1), "metadata.txt"])


def test_an_empty_clip_leaves_no_files(frame, tmp_path):
    writer = started(tmp_path)
    finish(writer)
    writer.next_clip()
    receive(writer, frame)
    writer.detach()
    writer.backend.wait_until_done()
    assert files(tmp_path) == sorted([*clip(1, 1), "metadata.txt"])


def colors_of(folder, frame, modality, path):
    image = picture(folder / f"clip_0000/{modality}/{modality}_0000.png")
    return {tuple(color) for color in image[mask_of(frame, path)].tolist()}


def test_gprims_are_told_apart_labeled_or_not(frame, tmp_path):
    writer = started(tmp_path)
    receive(writer, frame)
    finish(writer)
    every = [colors_of(tmp_path, frame, "segmentation", f"/World/{name}") for name in ("Ground", "Apple1", "Apple2")]
    assert all(len(colors) == 1 for colors in every)
    assert len(set.union(*every)) == 3
    edges = picture(tmp_path / "clip_0000/edges/edges_0000.png")
    assert set(np.unique(edges)) == {0, 255}
    depth = picture(tmp_path / "clip_0000/depth/depth_0000.png")
    near, far = mask_of(frame, "/World/Pear"), mask_of(frame, "/World/Ground")
    assert depth[near, 0].min() > depth[far, 0].max()


def test_labeled_things_are_told_apart(frame, tmp_path):
    writer = started(tmp_path, use_instance_id=False)
    receive(writer, frame)
    finish(writer)
    assert colors_of(tmp_path, frame, "segmentation", "/World/Ground") == {(0, 0, 0, 255)}
    apples = [colors_of(tmp_path, frame, "segmentation", f"/World/Apple{n}") for n in (1, 2)]
    assert len(set.union(*apples)) == 2


def test_colors_of_a_mapping(frame, tmp_path):
    writer = started(tmp_path, segmentation_mapping={"apple": [10, 200, 30, 255], "class:pear": (1, 2, 3, 255)})
    receive(writer, frame)
    finish(writer)
    for name, color in (("Apple1", (10, 200, 30, 255)), ("Apple2", (10, 200, 30, 255)), ("Pear", (1, 2, 3, 255))):
        assert colors_of(tmp_path, frame, "segmentation", f"/World/{name}") == {color}
    lit = colors_of(tmp_path, frame, "shaded_seg", "/World/Apple1")
    assert len(lit) > 0
    for red, green, blue in lit:  # which keeps its hue
        assert green > 4 * blue > 4 * red


def test_several_products_get_folders(frame, tmp_path):
    two = {f"/Render/HydraTextures/{name}": dataclasses.replace(frame, memo={}) for name in ("left", "right")}
    writer = writers.get("CosmosWriter", init_params={"output_dir": str(tmp_path)})
    writer.attach(known(*two))
    writer.receive(annotators.build_payload(writer, two))
    finish(writer)
    expected = [f"{side}/{name}" for side in ("left", "right") for name in clip(0, 1)]
    assert files(tmp_path) == sorted([*expected, "metadata.txt"])


def test_a_backend_takes_the_place_of_the_folder(frame, tmp_path):
    backend = writers.DiskBackend(str(tmp_path / "backend"))
    writer = started(tmp_path / "ignored", backend=backend)
    receive(writer, frame)
    finish(writer)
    assert files(tmp_path) == sorted(f"backend/{name}" for name in [*clip(0, 1), "metadata.txt"])


def test_a_backend_that_cannot_be_read_gets_pictures_only(frame, tmp_path):
    forget_warnings()

    class Sink(writers.BaseBackend):
        def __init__(self):
            self.paths = []

        def write_blob(self, path, data):
            self.paths.append(path)

    writer = writers.get("CosmosWriter", init_params={"backend": Sink()})
    writer.attach(known(PRODUCT))
    receive(writer, frame)
    with pytest.warns(UsdsdgWarning, match="Sink has no read_blob, so only images are written, no videos"):
        finish(writer)
    assert sorted(writer.backend.paths) == sorted([*(n for n in clip(0, 1) if n.endswith("png")), "metadata.txt"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "nowhere to write"),
        ({"output_dir": "x", "segmentation_mapping": {"apple": "red"}}, r"segmentation_mapping\['apple'\] is 'red'"),
        ({"output_dir": "x", "segmentation_mapping": {"apple": [1, 2, 3]}}, r"expected a color"),
        ({"output_dir": "x", "segmentation_mapping": {"apple": [1, 2, 3, 256]}}, r"expected a color"),
        ({"output_dir": "x", "segmentation_mapping": {"apple": -1}}, r"expected a color"),
    ],
)
def test_wrong_options_are_refused(options, message, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    with pytest.raises(WriterError, match=message):
        writers.get("CosmosWriter", init_params=options)

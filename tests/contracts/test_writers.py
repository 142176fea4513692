"""Contract of every registered writer."""

import inspect
import json
import re
import tarfile
import tempfile
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from PIL import Image
from scipy.io import loadmat

from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators, writers
from usdsdg.errors import WriterError
from usdsdg.stores import open_store
from usdsdg.writers.formats.rerun import rrd_content

# Options with which a writer writes as many files as possible.
OPTIONS = {
    "BasicWriter": dict.fromkeys(["rgb", "semantic_segmentation", "bounding_box_3d", "camera_params", "normals"], True),
    "PoseWriter": {"write_debug_images": True},
    "CocoWriter": {},
    "KittiWriter": {"colorize_instance_segmentation": True, "bbox_height_threshold": 0},
    "CosmosWriter": {},
    "YoloWriter": {"task": "segment"},
    "BopWriter": {},
    "VocWriter": {},
    "CvatWriter": {},
    "DOPEWriter": {"class_name_to_index_map": {"apple": 1}},
    "YCBVideoWriter": {
        "num_frames": 9,
        "class_name_to_index_map": {"apple": 1, "Pear": 2, "secret": 3, "far": 4},
        **dict.fromkeys(["rgb", "bounding_box_2d_tight", "semantic_segmentation", "pose", "exact"], True),
        "distance_to_image_plane": True,
    },
    "DataVisualizationWriter": {"bounding_box_2d_tight": True, "bounding_box_3d": True},
    "WebDatasetWriter": {"masks": True, "depth": True, "shard_samples": 1},
    "ParquetWriter": {"masks": True, "shard_samples": 1},
    "RerunWriter": {"semantic_segmentation": True},
}
if not find_spec("pyarrow"):  # of the extra `parquet`
    del OPTIONS["ParquetWriter"]
if not find_spec("rerun"):  # of the extra `rerun`
    del OPTIONS["RerunWriter"]
# PytorchWriter needs a listener, and torch.
WITHOUT_FILES = {"FPSWriter", "PytorchWriter"}
NEEDED = {"class_name_to_index_map", "num_frames"}
WRONG = [
    ({"frame_paddign": 3}, "has no option 'frame_paddign'. Did you mean 'frame_padding'?"),
    ({"frame_padding": "3"}, "frame_padding is '3'; expected a whole number."),
    ({"frame_padding": -1}, "frame_padding is -1"),
    ({"output_dir": 7}, "output_dir is 7; expected text or a path"),
    ({"image_output_format": None}, "image_output_format is None; expected text."),
]
PRODUCT = "/Render/HydraTextures/rp"


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (40, 30), filters=["class:*"])


def run(name, folder, frame, count=3):
    writer = writers.get(name)
    writer.initialize(output_dir=str(folder), **OPTIONS[name])
    writer.attach(known(PRODUCT))
    place = writer.backend.output_dir
    try:
        for _ in range(count):
            writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        writer.on_final_frame()
        writer.backend.wait_until_done()
    finally:
        writer.detach()
    store = open_store(place)
    return {path: comparable(path, store.get(path)) for path, _ in store.list()}


def comparable(path, data):
    """The bytes of a file; of a recording what it holds, since Rerun orders metadata at random."""
    if not path.endswith(rrd_content.SUFFIX):
        return data
    with tempfile.NamedTemporaryFile(suffix=rrd_content.SUFFIX) as file:
        file.write(data)
        file.flush()
        return rrd_content.content(Path(file.name))


def test_every_writer_is_tested():
    assert set(OPTIONS) | WITHOUT_FILES | {"ParquetWriter", "RerunWriter"} == set(writers.get_writers())


@pytest.mark.parametrize("name", OPTIONS)
def test_the_same_frames_give_the_same_bytes(name, frame, tmp_path):
    assert run(name, tmp_path / "a", frame) == run(name, tmp_path / "b", frame)


@pytest.mark.parametrize("name", OPTIONS)
def test_urls_get_the_same_files_as_folders(name, frame, tmp_path):
    in_folder = run(name, (tmp_path / "a b").as_uri(), frame)
    at_url = run(name, f"memory://writers/{name}/a b", frame)
    beside = {path for path in in_folder if path.startswith(".usdsdg/aggregates/")}
    assert at_url == {path: data for path, data in in_folder.items() if path not in beside}


@pytest.mark.parametrize("name", OPTIONS)
def test_every_file_can_be_read(name, frame, tmp_path):
    assert run(name, tmp_path / "run", frame)
    for path in tmp_path.rglob("*"):
        if path.suffix == ".png":
            with Image.open(path) as image:
                assert image.size == (40, 30)
                image.load()
        elif path.suffix == ".jpg":
            with Image.open(path) as image:
                assert image.size == (40, 30)
        elif path.suffix == ".xml":
            assert ElementTree.parse(path).getroot().tag.startswith("annotation")
        elif "ImageSets" in path.parts and path.suffix == ".txt":
            assert {len(line.split()) for line in path.read_text().splitlines()} <= {1, 2}
        elif path.name == "labelmap.txt":
            assert {line.count(":") for line in path.read_text().splitlines()} == {3}
        elif path.suffix == ".npy":
            np.load(path)
        elif path.suffix == ".jsonl":
            assert all(set(json.loads(line)) & {"frame", "about", "kind"} for line in path.read_text().splitlines())
        elif path.suffix == ".mp4":
            assert path.read_bytes()[4:8] == b"ftyp"
        elif path.parent.name == "calib":
            assert {line.partition(":")[0] for line in path.read_text().splitlines()} >= {"P2", "R0_rect"}
        elif path.parent.name == "object_detection":
            assert {len(line.split()) for line in path.read_text().splitlines()} == {15}
        elif "labels" in path.relative_to(tmp_path).parts and path.suffix == ".txt":
            assert all(len(line.split()) % 2 for line in path.read_text().splitlines())
        elif path.suffix == ".mat":
            assert "poses" in loadmat(path)
        elif path.suffix == ".xyz":
            assert np.loadtxt(path).shape[1] == 3
        elif path.name == "train.txt" or path.name.endswith("-box.txt"):
            assert path.read_text()
        elif path.suffix == ".ply":
            assert path.read_bytes().startswith(b"ply\n")
        elif path.suffix == ".tar":
            with tarfile.open(path) as tar:
                assert len(tar.getnames()) == 4
        elif path.suffix == ".rrd":
            assert len(rrd_content.content(path)) > 8
        elif path.suffix == ".parquet":
            assert path.read_bytes()[-4:] == b"PAR1"
        elif path.suffix == ".yaml":
            assert yaml.safe_load(path.read_text())["names"]
        elif path.is_file():
            json.loads(path.read_text())


@pytest.mark.parametrize("name", OPTIONS)
def test_no_frame_overwrites_another(name, frame, tmp_path):
    sizes = [len(run(name, tmp_path / str(count), frame, count)) for count in (1, 2, 3)]
    assert sizes[2] - sizes[1] == sizes[1] - sizes[0] > 0


@pytest.mark.parametrize("name", OPTIONS)
def test_a_writer_that_is_attached_again_replaces_no_files(name, frame, tmp_path):
    writer = writers.get(name, init_params={"output_dir": str(tmp_path / "apart"), **OPTIONS[name]})
    for _ in range(2):
        writer.attach(known(PRODUCT))
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        writer.detach()
    writer.backend.wait_until_done()
    apart = {str(p.relative_to(tmp_path / "apart")) for p in (tmp_path / "apart").rglob("*") if p.is_file()}
    assert apart == set(run(name, tmp_path / "together", frame, count=2))


# CocoWriter makes a new folder by itself.
@pytest.mark.parametrize("name", sorted(set(OPTIONS) - {"CocoWriter"}))
def test_two_writers_in_one_folder_give_a_warning(name, frame, tmp_path, recwarn):
    pair = [writers.get(name, init_params={"output_dir": str(tmp_path), **OPTIONS[name]}) for _ in range(2)]
    for writer in pair:
        writer.attach(known(PRODUCT))
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        writer.detach()
    for writer in pair:
        writer.backend.wait_until_done()
    messages = "|".join(str(each.message) for each in recwarn)
    assert f"{tmp_path} is written to by several writers: files of the same names, such as metadata.txt" in messages


def has(name, option):
    return option.replace("paddign", "padding") in inspect.signature(writers.get_writers()[name].__init__).parameters


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [(name, wrong, message) for name in OPTIONS for wrong, message in WRONG if has(name, *wrong)],
)
def test_wrong_options_are_errors_that_name_them(name, options, message, tmp_path):
    needed = {option: value for option, value in OPTIONS[name].items() if option in NEEDED}
    with pytest.raises(WriterError, match=re.escape(message)):
        writers.get(name, init_params={"output_dir": str(tmp_path), **needed, **options})
    with pytest.raises(WriterError, match=re.escape(message)):
        writers.get_writers()[name](**{"output_dir": str(tmp_path), **needed, **options})


@pytest.mark.parametrize("name", OPTIONS)
def test_no_temporary_file_is_left(name, frame, tmp_path):
    assert not [path for path in run(name, tmp_path / "run", frame) if path.rsplit("/", 1)[-1].startswith(".")]

"""Records of frames: what is in them, that they are read back, small, and the same bytes each time."""

import gc
import io
import json
import weakref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import usdsdg as rep
from tests.verify import datasets
from usdsdg.record import frame_record, id_runs, npz, samples
from usdsdg.session.settings.store import get_settings
from usdsdg.writers.journal import recipe


@given(ids=arrays.arrays(np.int32, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(-1, 3)))
def test_run_lengths_give_the_image_again(ids):
    np.testing.assert_array_equal(id_runs.decode(*id_runs.encode(ids), ids.shape), ids)


def test_ids_of_any_size_keep_their_value():
    for top in (3, 200, 40_000, 70_000, 2**40):
        ids = np.array([[-1, 0], [top, top]])
        values, lengths = id_runs.encode(ids)
        np.testing.assert_array_equal(values, [-1, 0, top])
        np.testing.assert_array_equal(lengths, [1, 1, 2])


def test_numpy_opens_a_record_and_bytes_repeat():
    content = {"a": np.arange(5.0), "b": np.zeros((2, 3), np.int8)}
    data = npz.encode(content)
    assert npz.encode(content) == data
    with np.load(io.BytesIO(data)) as read:
        assert set(read) == {"a", "b"}
        np.testing.assert_array_equal(read["a"], content["a"])


SMALL = st.one_of(
    arrays.arrays(kind, arrays.array_shapes(min_dims=0, max_dims=3, min_side=0), elements=st.integers(0, 100))
    for kind in (np.uint8, np.int32, np.float32, np.float64)
)


@given(content=st.dictionaries(st.text(max_size=5), SMALL, max_size=5))
def test_packed_arrays_are_read_back(content):
    data, places = npz.packed(content)
    read = npz.unpacked(data, json.loads(json.dumps(places)))
    assert list(read) == list(content)
    for name, array in content.items():
        assert read[name].dtype == array.dtype
        np.testing.assert_array_equal(read[name], array)


@pytest.mark.parametrize(
    "places", [[["a", "<f4", [3]]], [["a", "<f4", [1]]], [["a", "|O", [1]]], [["a", "<f4", [-2]]], [["a", "x", [2]]]]
)
def test_places_of_other_arrays_are_an_error(places):
    with pytest.raises((ValueError, TypeError)):
        npz.unpacked(np.zeros(8, np.uint8), places)


def test_means_of_blocks_are_those_of_their_pixels():
    image = np.random.default_rng(1).integers(0, 256, (35, 50, 4), np.uint8)
    means = samples.block_means(image)
    assert means.shape == (2, 3, 3)
    expected = image[17:34, 16:32, :3].reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(means[1, 1], expected, atol=0.51)


def test_the_grid_has_every_eighth_pixel():
    image = np.arange(20 * 30).reshape(20, 30)
    rows, columns = samples.grid_pixels((20, 30))
    np.testing.assert_array_equal(samples.grid(image), image[rows, columns])
    assert samples.grid(np.zeros((2, 1))).shape == (1, 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return datasets.make(tmp_path_factory.mktemp("recorded"), ("basic_ids", "pose", "cosmos"), frames=2)


def records(folder):
    return [frame_record.decode(path.read_bytes()) for path in sorted((folder / ".usdsdg" / "frames").iterdir())]


def test_a_record_has_what_was_in_view(folder):
    first, second = records(folder / "basic_ids")
    assert (first.number, second.number) == (0, 1)
    assert first.writer == "BasicWriter"
    assert first.seed == 1
    assert first.parameters["rgb"] is True
    assert "output_dir" not in first.parameters
    assert first.annotators["semantic_segmentation"]["filter"] == "class:*"
    assert "Replicator/rgb/rgb_0000.jpg" in first.files
    left, right = first.products
    assert (left.name, right.name) == ("Replicator", "Replicator_01")
    assert left.size == datasets.SIZE
    assert left.cameras[0].prim_path == "/World/Left"
    assert left.gprim_image is not None
    selection = left.selections["class:*"]
    shown = np.append(selection.member_of_gprim, -1)[left.gprim_image]
    assert left.amodal is not None
    for index, row in enumerate(selection.rows):
        assert (shown == index).sum() <= left.amodal[row, 0]
    assert {label["class"] for label in selection.labels} <= {"mug", "can", "box", "ball", "mug,lid"}


def test_the_same_run_has_the_same_records(folder, tmp_path):
    again = datasets.make(tmp_path, ("basic_ids", "pose", "cosmos"), frames=2)
    for name in ("basic_ids", "pose", "cosmos"):
        for path in (folder / name / ".usdsdg" / "frames").iterdir():
            assert path.read_bytes() == (again / name / ".usdsdg" / "frames" / path.name).read_bytes()


def test_recipes_name_the_version_of_records():
    assert recipe.RECORDS == frame_record.VERSION
    assert recipe.installed()["frame records"] == str(frame_record.VERSION)


def test_a_record_of_version_1_is_read(folder):
    """It had a member for each array, edits among them, and no places of arrays in its facts."""
    data = next((folder / "pose" / ".usdsdg" / "frames").iterdir()).read_bytes()
    members = npz.decode(data)
    facts = json.loads(members["facts"].tobytes())
    separate = npz.unpacked(members["arrays"], facts.pop("arrays"))
    text = np.frombuffer(json.dumps(facts | {"version": 1}).encode(), np.uint8)
    old = frame_record.decode(npz.encode({"facts": text, **separate}))
    new = frame_record.decode(data)
    assert frame_record.encode(old) == frame_record.encode(new) == data
    assert old.edits == new.edits


def test_a_record_is_small(folder):
    records = list(folder.glob("*/.usdsdg/frames/*.npz"))
    assert records
    for path in records:
        assert path.stat().st_size < 12_000


def test_the_setting_turns_records_off(stage, tmp_path):
    get_settings().set("/usdsdg/labels/record", False)
    _write(rep.writers.get("BasicWriter"), tmp_path, semantic_segmentation=True)
    assert not (tmp_path / ".usdsdg" / "frames").exists()


def test_writers_that_share_a_folder_have_records_of_their_own(stage, tmp_path):
    _write(rep.writers.get("BasicWriter"), tmp_path, detach=False, semantic_segmentation=True)
    with pytest.warns(UserWarning, match="several writers"):
        _write(rep.writers.get("PoseWriter"), tmp_path, skip_empty_frames=False)
    names = {path.name for path in (tmp_path / ".usdsdg" / "frames").iterdir()}
    assert names == {"000000.npz", "000001.npz", "PoseWriter-1-000000.npz"}


def test_a_writer_of_ones_own_with_a_folder_has_a_record(stage, tmp_path):
    class Own(rep.Writer):
        def __init__(self, output_dir):
            self._output_dir = output_dir
            self.annotators = [rep.annotators.get("semantic_segmentation")]

        def write(self, data):
            pass

    rep.WriterRegistry.register(Own)
    writer = rep.writers.get("Own")
    try:
        _write(writer, tmp_path, detach=False)
    finally:
        rep.WriterRegistry.unregister("Own")
    (record,) = records(tmp_path)
    assert record.writer == "Own"
    assert record.products[0].gprim_image is not None

    # The stage beside the records was written once; a file that is written anew is another one.
    (copy,) = (tmp_path / ".usdsdg" / "stages").iterdir()
    written = copy.stat().st_ino, copy.stat().st_mtime_ns
    for _ in range(2):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()
    assert (copy.stat().st_ino, copy.stat().st_mtime_ns) == written
    assert [each.stage["file"] for each in records(tmp_path)] == [f".usdsdg/stages/{copy.name}"] * 3


def test_writers_that_have_ended_are_not_held_for_the_stages_beside_their_records(stage, tmp_path):
    ended = []
    for _ in range(3):
        writer = rep.writers.get("BasicWriter")
        _write(writer, tmp_path, semantic_segmentation=True)
        ended.append(weakref.ref(writer.backend))
    del writer
    gc.collect()
    assert [each() for each in ended[:-1]] == [None] * 2  # the last frame's may be


def test_a_writer_without_labels_needs_no_rays_for_its_record(stage, tmp_path):
    _write(rep.writers.get("BasicWriter"), tmp_path, rgb=True)
    (record,) = records(tmp_path)
    assert record.products[0].runs is None
    assert record.products[0].checksums.keys() == {"LdrColor"}
    assert json.dumps(record.parameters) == '{"rgb": true}'


def _write(writer, folder, *, detach=True, **options):
    rep.create.cube(semantics=[("class", "cube")])
    product = rep.create.render_product(rep.create.camera(position=(4, 4, 4), look_at=(0, 0, 0)), (32, 24))
    writer.initialize(output_dir=str(folder), **options)
    writer.attach(product)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    if detach:
        writer.detach()


def test_the_stage_is_copied_where_prims_come_and_in_long_runs_less_often(stage, tmp_path):
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), semantic_segmentation=True)
    rep.create.cube(semantics=[("class", "cube")])
    product = rep.create.render_product(rep.create.camera(position=(4, 4, 4), look_at=(0, 0, 0)), (32, 24))
    writer.attach(product)
    for _ in range(12):
        rep.functional.create.sphere(semantics=[("class", "ball")])
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    has_stage = [bool(record.stage) for record in records(tmp_path)]
    assert has_stage == [True] * 8 + [False] * 4
    assert len(list((tmp_path / ".usdsdg" / "stages").iterdir())) == 8

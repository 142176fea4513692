"""WebDatasetWriter and ParquetWriter: what is in their shards, by readers of their own."""

import io
import json
import sys
import tarfile
from functools import partial

import numpy as np
import pytest
from PIL import Image
from pxr import UsdGeom

import usdsdg as rep
from tests.annotators.ray_caster import known
from tests.writers.formats.test_writer_yolo import PRODUCT, members_of
from tests.writers.formats.test_writer_yolo import write as written
from usdsdg import annotators, writers
from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.verify.verify import verify
from usdsdg.writers.formats.shards.packing import InOrder, Limits
from usdsdg.writers.formats.shards.shard_writer import limits_of
from usdsdg.writers.formats.shards.tar_shard import Archive, TarSample

SIZE = (64, 48)


pytestmark = pytest.mark.usefixtures("classes_of_the_frame")


write = partial(written, kind="WebDatasetWriter")


def members(path):
    """Return the files of a tar by name, in order."""
    with tarfile.open(path) as tar:
        assert all((each.mtime, each.uid, each.gid, each.uname, each.gname) == (0, 0, 0, "", "") for each in tar)
        return {each.name: tar.extractfile(each).read() for each in tar}


def check_objects(objects, ids, frame):
    """Compare objects, and the image of their ids, with the frame's masks."""
    selection, seen = frame.selection("class:*"), members_of(frame)
    visible = [index for index in range(len(selection.labels)) if (seen == index).any()]
    names = sorted({labels["class"] for labels in selection.labels})
    assert [each["id"] for each in objects] == list(range(1, len(visible) + 1))
    assert len(visible) > 2
    for each, index in zip(objects, visible, strict=True):
        mask = seen == index
        rows, columns = np.nonzero(mask)
        assert (ids == each["id"]).tolist() == mask.tolist()
        assert each["bbox"] == [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
        assert each["area"] == mask.sum()
        assert (each["label"], each["category"]) == (names[each["category"]], names.index(each["label"]))
        assert each["visibility"] == pytest.approx(1.0 - frame.occlusion("class:*")[index], abs=1e-6)


def test_a_sample_has_its_files_side_by_side(frame, tmp_path):
    folder = write(tmp_path, [frame, frame], masks=True, depth=True)
    found = members(folder / "train-000000.tar")
    kinds = ("png", "instances.png", "depth.npy", "json")
    assert list(found) == [f"{key}.{kind}" for key in ("000000", "000001") for kind in kinds]
    image = np.array(Image.open(io.BytesIO(found["000001.png"])))
    assert np.array_equal(image, frame.aovs["LdrColor"][..., :3])
    values = json.loads(found["000001.json"])
    facts = {name: values[name] for name in ("key", "frame", "view", "width", "height")}
    assert facts == {"key": "000001", "frame": 1, "view": "rp1", "width": 64, "height": 48}
    check_objects(values["objects"], np.array(Image.open(io.BytesIO(found["000001.instances.png"]))), frame)
    depth = np.load(io.BytesIO(found["000001.depth.npy"]))
    assert (depth.dtype, depth.shape) == (np.float32, (48, 64))
    index = json.loads((folder / "index.json").read_text())
    assert index["shards"] == {"train": {"train-000000.tar": 2}}
    assert index["classes"] == sorted({labels["class"] for labels in frame.selection("class:*").labels})


def test_shards_end_at_their_limits(frame, tmp_path):
    folder = write(tmp_path / "samples", [frame] * 7, splits={"train": 4, "val": 3}, shard_samples=2)
    counts = json.loads((folder / "index.json").read_text())["shards"]
    assert {split: list(shards.values()) for split, shards in counts.items()} == {"train": [2, 2], "val": [2, 1]}
    keys = [name.split(".")[0] for path in sorted(folder.glob("*.tar")) for name in members(path)]
    assert len(set(keys)) == 7
    lengths = [len(data) for data in members(folder / "val-000001.tar").values()]
    two = 2 * sum(512 + -(-length // 512) * 512 for length in lengths)
    folder = write(tmp_path / "bytes", [frame] * 5, shard_megabytes=two / 1e6)
    counts = json.loads((folder / "index.json").read_text())["shards"]["train"]
    assert list(counts.values()) == [2, 2, 1]


def test_products_have_samples_of_their_own(frame, tmp_path):
    folder = write(tmp_path, [{PRODUCT: frame, f"{PRODUCT}2": frame}], image_output_format="jpg")
    assert list(members(folder / "train-000000.tar")) == [
        "rp1_000000.jpg", "rp1_000000.json", "rp12_000000.jpg", "rp12_000000.json",
    ]  # fmt: skip


def test_small_and_hidden_objects_are_left_out(frame, tmp_path):
    pixels = frame.visible_pixels("class:*")
    least = int(np.median(pixels[pixels > 0])) + 1
    found = members(write(tmp_path, [frame], masks=True, min_pixels=least) / "train-000000.tar")
    objects = json.loads(found["000000.json"])["objects"]
    assert len(objects) == (pixels >= least).sum()
    ids = np.array(Image.open(io.BytesIO(found["000000.instances.png"])))
    assert sorted(set(ids.ravel().tolist()) - {0}) == [each["id"] for each in objects]


def test_samples_are_packed_in_their_order():
    taken = []
    in_order = InOrder(taken.append)
    for place in (3, 1, 0, 4, 2):
        in_order.put(place, str(place))
    assert taken == ["0", "1", "2", "3", "4"]
    limits = Limits(samples=2, size=10**9)
    assert [limits.begins_shard(1) for _ in range(5)] == [False, False, True, False, True]


def test_archives_are_those_of_tarfile():
    made = [TarSample(str(place), {"txt": b"x" * size, "json": b"{}"}) for place, size in enumerate((1, 512, 9000))]
    assert made[0].size == 2048
    assert [TarSample.of_record(each.record()) for each in made] == made
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for each in made:
            for extension, data in each.members.items():
                member = tarfile.TarInfo(f"{each.key}.{extension}")
                member.size = len(data)
                tar.addfile(member, io.BytesIO(data))
    assert b"".join(Archive(lambda: made)) == buffer.getvalue()


def test_a_sample_larger_than_a_shard_has_one_of_its_own():
    limits = Limits(samples=9, size=2500)
    assert [limits.begins_shard(size) for size in (1024, 5632, 1024, 1024)] == [False, True, True, False]


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"shard_samples": 0}, "expected more than 0"),
        ({"shard_megabytes": -1.0}, "expected more than 0"),
        ({"min_visibility": 1.5}, "expected a fraction"),
        ({"min_pixels": 0}, "expected 1 or more"),
        ({"splits": {"train": -1}}, "expected shares above 0"),
    ],
)
def test_options_that_cannot_be(tmp_path, options, reason):
    with pytest.raises(WriterError, match=reason):
        writers.get("WebDatasetWriter", init_params={"output_dir": str(tmp_path), **options})


# Parquet


@pytest.fixture
def parquet():
    return pytest.importorskip("pyarrow.parquet", reason="pyarrow is of the extra `parquet`")


def test_a_row_has_images_that_datasets_decodes(parquet, frame, tmp_path):
    options = {"masks": True, "shard_samples": 5, "row_group_samples": 2, "splits": {"train": 5, "val": 1}}
    folder = write(tmp_path, [frame] * 6, kind="ParquetWriter", **options)
    assert sorted(path.name for path in (folder / "data").iterdir()) == ["train-00000.parquet", "val-00000.parquet"]
    table = parquet.ParquetFile(folder / "data/train-00000.parquet")
    assert [table.metadata.row_group(group).num_rows for group in range(table.num_row_groups)] == [2, 2, 1]
    row = table.read().to_pylist()[3]
    image, ids = (np.array(Image.open(io.BytesIO(row[name]["bytes"]))) for name in ("image", "instances"))
    assert np.array_equal(image, frame.aovs["LdrColor"][..., :3])
    assert row["image"]["path"] == f"{row['key']}.image.png"
    listed = row["objects"]
    objects = [dict(zip(listed, values)) for values in zip(*listed.values())]
    check_objects(objects, ids, frame)
    features = json.loads(table.schema_arrow.metadata[b"huggingface"])["info"]["features"]
    assert features["image"] == {"_type": "Image"}
    names = sorted({labels["class"] for labels in frame.selection("class:*").labels})
    assert features["objects"]["category"] == {"feature": {"names": names, "_type": "ClassLabel"}, "_type": "Sequence"}
    assert list(features) == table.schema_arrow.names


def test_classes_that_come_later_are_named_in_all_shards(parquet, frame, tmp_path):
    writer = writers.get("ParquetWriter", init_params={"output_dir": str(tmp_path), "shard_samples": 1})
    writer.attach(known(PRODUCT))
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.backend.wait_until_done()
    current().class_tables.of("class:*").add([{"class": "zebra"}])
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    writer.detach()
    named = []
    for path in sorted((tmp_path / "data").iterdir()):
        features = json.loads(parquet.ParquetFile(path).schema_arrow.metadata[b"huggingface"])["info"]["features"]
        named.append(features["objects"]["category"]["feature"]["names"])
        assert len(parquet.read_table(path).to_pylist()[0]["objects"]["id"]) > 2
    assert named[0] == named[1]
    assert named[0][-1] == "zebra"


def test_classes_of_one_name_are_told_apart(parquet, stage, tmp_path):
    """`datasets` reads no ClassLabel that has a name twice."""
    for name, kind, x in (("a", "class", -1), ("b", "color", 1)):
        prim = UsdGeom.Cube.Define(stage, f"/World/{name}").GetPrim()
        UsdGeom.XformCommonAPI(prim).SetTranslate((1.5 * x, 0, -8))
        add_labels(prim, {kind: ["car"]})
    UsdGeom.Camera.Define(stage, "/Camera")
    writer = rep.writers.get("ParquetWriter")
    writer.initialize(output_dir=str(tmp_path), semantic_types=["class", "color"], shard_samples=1)
    writer.attach(rep.create.render_product("/Camera", (64, 48)))
    for _ in range(2):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    for path in sorted((tmp_path / "data").iterdir()):
        table = parquet.ParquetFile(path)
        features = json.loads(table.schema_arrow.metadata[b"huggingface"])["info"]["features"]
        names = features["objects"]["category"]["feature"]["names"]
        assert len(names) == len(set(names)) == 2
        [row] = table.read().to_pylist()
        assert sorted(row["objects"]["category"]) == [0, 1]
        assert row["objects"]["label"] == ["car", "car"]
    assert verify(tmp_path).faults == []


def test_shards_may_be_as_large_as_one_likes():
    assert limits_of({"shard_megabytes": float("inf"), "shard_samples": 3}) == {"samples": 3, "bytes": sys.maxsize}

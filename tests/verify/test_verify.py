"""`usdsdg verify`: datasets of every format are clean, and faults that are put into them are found."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from PIL import Image
from pxr import UsdGeom

import usdsdg as rep
from tests.sampled_cases import sampled
from tests.verify import datasets
from tests.verify.all_label_faults import KINDS
from usdsdg.cli.app import app
from usdsdg.errors import DatasetError
from usdsdg.session.session import current
from usdsdg.verify import verify, verify_all


@pytest.fixture(scope="module")
def clean(tmp_path_factory) -> Path:
    return datasets.make(tmp_path_factory.mktemp("datasets"), frames=4)


@pytest.mark.parametrize("name", datasets.DATASETS)
def test_a_dataset_as_it_was_written_has_no_fault(clean, name):
    report = verify(clean / name)
    assert report.faults == []
    assert report.notes == []
    assert report.recorded == 4
    assert report.formats.total() == 4 * datasets.DATASETS[name][2]


@pytest.mark.parametrize("name", datasets.DATASETS)
def test_without_a_record_the_files_are_checked_against_each_other(clean, tmp_path, name):
    shutil.copytree(clean / name, tmp_path / name, ignore=shutil.ignore_patterns(".usdsdg"))
    report = verify(tmp_path / name)
    assert report.faults == []
    assert "no record" in report.notes[0]


def test_there_are_forty_kinds_of_faults():
    assert len({kind.name for kind in KINDS}) == len(KINDS) >= 40


@pytest.mark.parametrize("kind", KINDS, ids=[kind.name for kind in KINDS])
def test_a_fault_is_found(clean, tmp_path, kind):
    shutil.copytree(clean / kind.dataset, tmp_path / "data")
    kind.inject(tmp_path / "data")
    assert verify(tmp_path / "data").faults


def test_a_fault_names_file_frame_and_values(clean, tmp_path):
    shutil.copytree(clean / "basic", tmp_path / "data")
    rows = np.load(tmp_path / "data" / "bounding_box_2d_tight_0002.npy")
    (path, *_) = json.loads((tmp_path / "data" / "bounding_box_2d_tight_prim_paths_0002.json").read_text())
    rows["x_max"][0] -= 1
    np.save(tmp_path / "data" / "bounding_box_2d_tight_0002.npy", rows)
    first, *_ = verify(tmp_path / "data").faults
    assert (first.file, first.frame) == ("bounding_box_2d_tight_0002.npy", "0002")
    assert first.what == f"the tight box of {path}"
    assert str(int(rows["x_max"][0])) in first.found
    assert str(int(rows["x_max"][0]) + 1) in first.expected


def test_damaged_and_missing_files_are_faults(clean, tmp_path):
    folder = shutil.copytree(clean / "basic", tmp_path / "data")
    (folder / "rgb_0000.png").write_bytes(b"no picture")
    (folder / "camera_params_0001.json").unlink()
    (folder / ".usdsdg" / "frames" / "000002.npz").write_bytes(b"no record")
    found = {(fault.file, fault.what.split(":")[0]) for fault in verify(folder).faults}
    assert ("camera_params_0001.json", "is missing") in found
    assert any(file == "rgb_0000.png" and what.startswith("cannot be read") for file, what in found)
    assert any(file == ".usdsdg/frames/000002.npz" for file, _ in found)


def test_a_folder_without_a_dataset_is_an_error(tmp_path):
    with pytest.raises(DatasetError, match="none does not exist; give the folder"):
        verify(tmp_path / "none")
    with pytest.raises(DatasetError, match="nothing in"):
        verify(tmp_path)


def test_the_folder_in_which_scripts_write_is_named_for_one_that_is_not_here(tmp_path, monkeypatch):
    monkeypatch.setattr(current(), "disk_root", tmp_path / "output")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "output" / "_boxes").mkdir(parents=True)
    with pytest.raises(DatasetError, match=re.escape(f"_boxes does not exist; did you mean {tmp_path}/output/_boxes?")):
        verify("_boxes")
    with pytest.raises(DatasetError, match="_balls does not exist; give the folder"):
        verify("_balls")


def test_the_command_ends_with_1_where_there_are_faults(clean, tmp_path):
    run = CliRunner().invoke
    fine = run(app, ["verify", str(clean / "coco")])
    assert fine.exit_code == 0
    assert "0 faults" in fine.output
    folder = shutil.copytree(clean / "coco", tmp_path / "data")
    next(kind for kind in KINDS if kind.name == "missing category").inject(folder)
    broken = run(app, ["verify", str(folder), "--json"])
    assert broken.exit_code == 1
    (fault,) = json.loads(broken.output)["faults"]
    assert fault["found"] == "none"


def written(writer, folder, eye, frames=1, **options):
    """Write frames of the stage, and return what is found in them."""
    made = rep.writers.get(writer)
    made.initialize(output_dir=str(folder), **options)
    made.attach(rep.create.render_product(eye, (64, 48)))
    for _ in range(frames):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return [(fault.what, fault.expected, fault.found) for fault in verify(folder).faults]


@pytest.mark.parametrize("colorize", [True, False])
def test_objects_may_change_their_class(stage, tmp_path, colorize):
    rep.create.light(light_type="dome")
    balls = rep.create.sphere(count=3, position=[(0, y, 0) for y in (-1, 0, 1)], semantics=[("class", "ball")])
    kinds = [[("class", "ball")], [("class", "egg")]]
    with rep.trigger.on_frame(), balls:
        rep.modify.semantics(rep.distribution.choice(kinds), mode="replace")
    eye = rep.create.camera(position=(6, 0, 0), look_at=(0, 0, 0))
    kind = "instance_segmentation"
    options = {kind: True, f"colorize_{kind}": colorize}
    assert written("BasicWriter", tmp_path, eye, frames=5, **options) == []
    tables = [json.loads(file.read_text()) for file in sorted(tmp_path.glob(f"{kind}_semantics_mapping_*.json"))]
    assert len({json.dumps(table) for table in tables}) > 1, "no object has changed its class"


@pytest.mark.parametrize("types", [["class", "shape"], ["shape"]])
def test_labels_may_be_of_other_types_than_class(stage, tmp_path, types):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "box"), ("shape", "cuboid")])
    rep.create.sphere(position=(0, 2, 0), semantics=[("class", "ball")])
    eye = rep.create.camera(position=(9, 0, 0), look_at=(0, 0, 0))
    kinds = ("bounding_box_2d_tight", "bounding_box_3d", "instance_segmentation", "semantic_segmentation", "occlusion")
    assert written("BasicWriter", tmp_path, eye, semantic_types=types, **dict.fromkeys(kinds, True)) == []
    assert len(np.load(tmp_path / "bounding_box_2d_tight_0000.npy")) == len(types)


def test_masks_that_were_augmented_are_not_compared(stage, tmp_path):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "box")])
    made = rep.writers.get("BasicWriter")
    made.initialize(output_dir=str(tmp_path), instance_segmentation=True)
    made.augment_annotator(
        "instance_segmentation_fast", rep.annotators.Augmentation.from_function(lambda data_in: data_in[::-1])
    )
    made.attach(rep.create.render_product(rep.create.camera(position=(9, 0, 1), look_at=(0, 0, 1)), (64, 48)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert verify(tmp_path).faults == []


def test_objects_may_reach_far_beyond_the_picture_of_bop(stage, tmp_path):
    rep.create.light(light_type="dome")
    rep.create.cube(position=(0, 0, 0), rotation=(40, 30, 20), scale=(0.2, 30, 0.2), semantics=[("class", "beam")])
    eye = rep.create.camera(position=(2, 0, 0), look_at=(0, 0, 0), focal_length=10)
    assert written("BopWriter", tmp_path, eye) == []
    file = next(tmp_path.rglob("scene_gt_info.json"))
    info = json.loads(file.read_text())
    x, y, width, height = info["0"][0]["bbox_obj"]
    assert -64 in (x, x + width - 191 - 64) or -48 in (y, y + height - 143 - 48), "nothing is cut"
    info["0"][0]["bbox_obj"] = [x - 9, y, width, height]
    file.write_text(json.dumps(info))
    assert any("projects to its box" in fault.what for fault in verify(tmp_path).faults)


@pytest.mark.parametrize("lens", ["orthographic", "fisheyePolynomial"])
def test_keypoints_of_dope_may_be_of_any_lens(stage, tmp_path, lens):
    rep.create.light(light_type="dome")
    rep.create.cube(position=(0, 0.5, 0), rotation=(40, 30, 20), semantics=[("class", "cube")])
    eye = rep.create.camera(position=(6, 0, 1), look_at=(0, 0, 0), **(
        {"projection_type": lens} if lens != "orthographic" else {"horizontal_aperture": 50}
    ))  # fmt: skip
    if lens == "orthographic":
        UsdGeom.Camera(stage.GetPrimAtPath(f"{eye.prims[0]}/Camera")).GetProjectionAttr().Set(lens)
    folder = tmp_path / "dope"
    assert written("DOPEWriter", folder, eye, class_name_to_index_map={}, exact=True) == []
    file = next(folder.rglob("*.json"))
    values = json.loads(file.read_text())
    values["objects"][0]["projected_cuboid"][0][0] += 1
    file.write_text(json.dumps(values))
    assert any("projected_cuboid" in fault.what for fault in verify(folder).faults)


def test_an_image_that_is_transparent_outside_of_the_lens_has_no_fault(stage, tmp_path):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "cube")])
    eye = rep.create.camera(position=(2, 1, 2), look_at=(0, 0, 0), projection_type="fisheyePolynomial")
    writer = rep.writers.get("CocoWriter")
    writer.initialize(output_dir=str(tmp_path / "coco"))
    writer.attach(rep.create.render_product(eye, (64, 48)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert verify(tmp_path / "coco").faults == []


@pytest.mark.parametrize("options", [{}, {"plain_names": True, "panoptic": True}])
def test_objects_of_no_category_are_others_and_no_fault(stage, tmp_path, options):
    rep.create.light(light_type="dome")
    for number, name in enumerate(("box", "pear")):
        rep.create.cube(position=(1.5 * number, 0, 0), semantics=[("class", name)])
    writer = rep.writers.get("CocoWriter")
    # The id of Replicator's "other" is taken.
    table = {"box": {"name": "box", "id": 201}}
    writer.initialize(output_dir=str(tmp_path / "coco"), coco_categories=table, **options)
    camera = rep.create.camera(position=(0.7, -6, 1), look_at=(0.7, 0, 0))
    writer.attach(rep.create.render_product(camera, (64, 48)))
    rep.orchestrator.step()
    writer.detach()
    rep.orchestrator.wait_until_complete()
    assert verify(tmp_path / "coco").faults == []
    (path,) = (tmp_path / "coco").rglob("instances_train.json" if options else "coco_annotations_*.json")
    assert sorted(each["category_id"] for each in json.loads(path.read_text())["annotations"]) == [201, 202]


@pytest.mark.parametrize("name", ["voc", "cvat", "kitti_plain"])
def test_a_dataset_without_any_object_has_no_fault(stage, tmp_path, name):
    rep.create.light(light_type="dome")
    rep.create.cube()
    kind, options, _ = datasets.DATASETS[name]
    writer = rep.writers.get(kind)
    writer.initialize(output_dir=str(tmp_path), **options)
    writer.attach(rep.create.render_product(rep.create.camera(position=(0, -5, 0), look_at=(0, 0, 0)), (64, 48)))
    for _ in range(2):
        rep.orchestrator.step()
    writer.detach()
    rep.orchestrator.wait_until_complete()
    report = verify(tmp_path)
    assert report.faults == []
    assert report.formats[kind] == 2


def test_a_folder_of_several_datasets_has_a_report_of_each(clean, tmp_path):
    names = ["basic", "coco", "yolo"]
    for name in names:
        shutil.copytree(clean / name, tmp_path / "all" / name)
    (tmp_path / "all" / "notes.txt").write_text("beside them")
    reports = verify_all(tmp_path / "all")
    assert [report.folder for report in reports] == [str(tmp_path / "all" / name) for name in names]
    for report, name in zip(reports, names):
        assert report.values() == {**verify(clean / name).values(), "folder": report.folder}
        assert report.recorded


def test_the_command_ends_as_the_worst_of_several_datasets(clean, tmp_path):
    for name in ("basic", "coco"):
        shutil.copytree(clean / name, tmp_path / name)
    done = CliRunner().invoke(app, ["verify", str(tmp_path)])
    assert done.exit_code == 0
    assert [line.split(": ")[:2] for line in done.stdout.splitlines()] == [
        [str(tmp_path / name), "0 faults; images"] for name in ("basic", "coco")
    ]
    next(iter(sorted((tmp_path / "basic").glob("rgb_*.png")))).unlink()
    done = CliRunner().invoke(app, ["verify", str(tmp_path), "--json"])
    assert done.exit_code == 1
    values = json.loads(done.stdout)
    assert (values["folder"], values["clean"]) == (str(tmp_path), False)
    assert [each["clean"] for each in values["datasets"]] == [False, True]


def test_a_folder_of_folders_without_a_dataset_is_an_error(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name / ".usdsdg").mkdir(parents=True)
        (tmp_path / name / "notes.txt").write_text("nothing")
    with pytest.raises(DatasetError, match="nothing in"):
        verify_all(tmp_path)


DAMAGED_YAML = {
    "a: [1, {": "cannot be read: it is not valid YAML at line 1",
    "a: \0": "cannot be read: it is not valid YAML",
    "[" * 5000: "cannot be read: it is not valid YAML",
    "[1, 2]": "cannot be read: it is no mapping, but a list",
    "": "cannot be read: it is empty",
    "names: 3": "is not as its format has it: names is a int",
    "names: {a: b}": "is not as its format has it",
    "kpt_shape: x": "is not as its format has it: kpt_shape is 'x'",
}


@pytest.mark.parametrize("text", sampled(DAMAGED_YAML, 3))
@pytest.mark.parametrize("name", sampled(["yolo", "keypoints"]))
def test_a_damaged_description_of_yolo_is_one_fault(clean, tmp_path, name, text):
    folder = shutil.copytree(clean / name, tmp_path / "data")
    (folder / "data.yaml").write_text(text)
    (fault,) = verify(folder).faults
    assert fault.file == "data.yaml"
    assert fault.what.startswith(DAMAGED_YAML[text])
    shown = CliRunner().invoke(app, ["inspect", str(folder)])
    assert shown.exit_code == 0
    assert "unreadable file: data.yaml: " in shown.output
    assert "Traceback" not in shown.output


def test_other_faults_are_found_beside_a_damaged_description_of_yolo(clean, tmp_path):
    folder = shutil.copytree(clean / "yolo", tmp_path / "data")
    (folder / "data.yaml").write_text("a: [1, {")
    labels = next(file for file in sorted(folder.glob("labels/train/*.txt")) if file.read_text())
    labels.write_text("".join(labels.read_text().splitlines(keepends=True)[1:]))
    found = verify(folder).faults
    assert {fault.file for fault in found} == {"data.yaml", labels.relative_to(folder).as_posix()}


def test_yolo_takes_names_as_a_list(clean, tmp_path):
    folder = shutil.copytree(clean / "yolo", tmp_path / "data")
    described = yaml.safe_load((folder / "data.yaml").read_text())
    (folder / "data.yaml").write_text(yaml.safe_dump({**described, "names": [*described["names"].values()]}))
    assert verify(folder).is_clean


# JSON that is valid, and not what a file should have.
OTHER_JSON = ("[1, 2]", "3", '"text"', "null", '{"a": 5}', "[[]]")


@pytest.mark.parametrize("text", OTHER_JSON)
@pytest.mark.parametrize("name", sampled(list(datasets.DATASETS)))
def test_json_of_another_form_is_a_fault(clean, tmp_path, name, text):
    kinds: dict[str, Path] = {}
    for file in sorted((clean / name).rglob("*.json")):
        if ".usdsdg" not in file.parts:
            kinds.setdefault(re.sub(r"\d+", "", file.name), file.relative_to(clean / name))
    for place, file in enumerate(kinds.values()):
        folder = shutil.copytree(clean / name, tmp_path / str(place), ignore=shutil.ignore_patterns(".usdsdg"))
        (folder / file).write_text(text)
        faults = verify(folder).faults
        assert any(fault.file == file.as_posix() for fault in faults) or text == '{"a": 5}', file
        assert not any("indices must be" in fault.line() or "has no attribute" in fault.line() for fault in faults)
        shown = CliRunner().invoke(app, ["inspect", str(folder)])
        assert "Traceback" not in shown.output
        assert shown.exception is None or isinstance(shown.exception, SystemExit)


@pytest.fixture
def unrecorded(clean, tmp_path):
    """Return a copy of a dataset without what is beside it."""
    return lambda name: shutil.copytree(clean / name, tmp_path / name, ignore=shutil.ignore_patterns(".usdsdg"))


@pytest.mark.parametrize("name", ["coco", "coco_plain", "coco_polygons"])
@pytest.mark.parametrize("recorded", [True, False])
def test_a_picture_of_coco_that_is_in_no_annotation_file_is_named(clean, unrecorded, tmp_path, name, recorded):
    folder = shutil.copytree(clean / name, tmp_path / "recorded") if recorded else unrecorded(name)
    file = next(file for file in sorted(folder.rglob("*.json")) if "images" in file.read_text())
    values = json.loads(file.read_text())
    left_out = values["images"].pop(0)
    values["annotations"] = [each for each in values["annotations"] if each["image_id"] != left_out["id"]]
    file.write_text(json.dumps(values))
    found = [fault for fault in verify(folder).faults if fault.what.endswith("is not in `images`")]
    assert [fault.file for fault in found] == [file.relative_to(folder).as_posix()]
    assert left_out["file_name"] in found[0].what


def test_labels_of_yolo_without_a_picture_are_a_fault(unrecorded):
    folder = unrecorded("yolo")
    picture = sorted(folder.glob("images/train/*.*"))[1]
    picture.unlink()
    (fault,) = verify(folder).faults
    assert (fault.file, fault.what) == (f"labels/train/{picture.stem}.txt", "has no picture")


def test_labels_of_yolo_that_are_no_text_cannot_be_read(unrecorded):
    folder = unrecorded("yolo")
    labels = sorted(folder.glob("labels/train/*.txt"))[0]
    labels.write_bytes(b"\xff\xfe\x00")
    (fault,) = verify(folder).faults
    assert fault.file == labels.relative_to(folder).as_posix()
    assert fault.what.startswith("cannot be read: ")


@pytest.mark.parametrize("kind", ["normals", "semantic_segmentation"])
@pytest.mark.parametrize("recorded", [True, False])
def test_a_picture_of_another_size_is_a_fault(clean, unrecorded, tmp_path, kind, recorded):
    folder = shutil.copytree(clean / "basic", tmp_path / "recorded") if recorded else unrecorded("basic")
    Image.new("RGBA", (1, 1)).save(folder / f"{kind}_0001.png")
    found = [fault for fault in verify(folder).faults if fault.what == "has another size"]
    assert [fault.file for fault in found] == [f"{kind}_0001.png"]


def test_a_segment_without_its_annotation_is_a_fault(unrecorded):
    folder = unrecorded("coco_plain")
    file = folder / "annotations/instances_train.json"
    values = json.loads(file.read_text())
    largest = max(values["annotations"], key=lambda each: each["area"])
    values["annotations"].remove(largest)
    file.write_text(json.dumps(values))
    (fault,) = verify(folder).faults
    assert fault.file == "annotations/instances_train.json"
    assert fault.what.endswith("of annotations/panoptic_train.json has no annotation")


@pytest.mark.parametrize("name", ["location_camera_frame", "location_world_frame"])
def test_a_place_that_is_not_that_of_the_keypoints_is_a_fault(unrecorded, name):
    folder = unrecorded("pose")
    file = sorted(folder.glob("*.json"))[1]
    values = json.loads(file.read_text())
    values["objects"][0][name][0] += 0.05
    file.write_text(json.dumps(values))
    (fault,) = verify(folder).faults
    assert fault.file == file.name
    assert fault.what.startswith(name)

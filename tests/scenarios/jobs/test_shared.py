"""What jobs share: folders of meshes and their units, decks of classes, skies, and mistakes in configurations."""

from __future__ import annotations

import json
import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.scenarios.jobs.own_meshes import write_three
from usdsdg.errors import AssetError, ConfigError, WriterError
from usdsdg.image_files import radiance_hdr
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.jobs import load_job
from usdsdg.scenarios.shared.decks import deal, variants
from usdsdg.scenarios.shared.mesh_folder import files_by_label, read_assets
from usdsdg.scenarios.shared.pictures import mean_luminance, pictures_in
from usdsdg.writers.formats.splits import Splits

CONFIGS = Path(__file__).parents[3] / "configs"


def test_meshes_of_odd_sizes_get_plausible_units_and_it_is_said(tmp_path, capsys):
    found = {each.label: each for each in read_assets(files_by_label(str(write_three(tmp_path))), "auto")}
    sizes = {label: np.array(each.high) - each.low for label, each in found.items()}
    np.testing.assert_allclose(sizes["block"], (0.12, 0.08, 0.05), rtol=1e-5)
    np.testing.assert_allclose(sizes["panel"], (0.024, 0.003, 0.018), rtol=1e-5)
    np.testing.assert_allclose(sizes["wedge"], (0.2, 0.1, 0.15), rtol=1e-5)
    said = capsys.readouterr().err
    assert "block.obj is read in mm: 0.12 x 0.08 x 0.05 m" in said
    assert "panel.obj is read in mm" in said
    assert "wedge.obj" not in said


def test_meshes_in_one_unit_are_read_in_it_together(tmp_path):
    for name, size in {"washer": 2.5, "bolt": 40.0, "plate": 180.0}.items():
        write_three(tmp_path / "other")
        (tmp_path / f"{name}.obj").write_text(f"v 0 0 0\nv {size} 0 0\nv 0 {size} 1\nf 1 2 3\n")
    files = {label: each for label, each in files_by_label(str(tmp_path)).items() if label != "other"}
    sizes = {each.label: each.high[0] for each in read_assets(files, "auto")}
    # A washer of 2.5 m would be plausible alone, but is not beside a bolt of 40 m.
    assert sizes == pytest.approx({"washer": 0.0025, "bolt": 0.04, "plate": 0.18}, rel=1e-5)


def test_a_folder_of_a_class_may_hold_several_shapes(tmp_path, capsys):
    write_three(tmp_path / "boxes")
    (tmp_path / "01_rod.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")
    (tmp_path / "01_rod.stl").write_bytes(b"")
    by_label = files_by_label(str(tmp_path))
    assert {label: len(files) for label, files in by_label.items()} == {"boxes": 3, "rod": 1}
    assert "without 01_rod.stl" in capsys.readouterr().err
    assert list(files_by_label(str(tmp_path), {"rod": "Stick", "boxes": ""})) == ["stick"]
    with pytest.raises(ConfigError, match=r"labels names rodd, which .* has not; did you mean rod"):
        files_by_label(str(tmp_path), {"rodd": "stick"})
    with pytest.raises(ConfigError, match="leaves out every mesh"):
        files_by_label(str(tmp_path), {"rod": "", "boxes": ""})


def test_names_that_a_number_tells_apart_keep_it(tmp_path):
    for name in ("1_cup", "2_cup", "3_mug"):
        (tmp_path / f"{name}.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")
    assert list(files_by_label(str(tmp_path))) == ["1_cup", "2_cup", "mug"]


@pytest.mark.parametrize("shares", [{"a": 1.0, "b": 1.0, "c": 1.0}, {"a": 3.0, "b": 1.0, "c": 2.0}])
def test_classes_are_balanced_from_the_beginning(shares):
    hands = deal(Draws(3), [2, 3, 0, 4] * 30, shares)
    assert [len(hand) for hand in hands] == [2, 3, 0, 4] * 30
    counts = Counter(label for hand in hands for label in hand)
    total = sum(shares.values())
    assert all(counts[label] == pytest.approx(270 * share / total, abs=6) for label, share in shares.items())
    taken = Counter(label for hand in hands[:8] for label in hand)
    assert all(taken[label] >= 18 * share / total - 12 for label, share in shares.items())
    shapes = variants(hands, {"a": 1, "b": 2, "c": 3})
    of_c = Counter(number for row in shapes for label, number in row if label == "c")
    assert max(of_c.values()) - min(of_c.values()) <= 1


def test_the_brightness_of_a_sky_is_a_mean_over_directions(tmp_path):
    image = np.zeros((64, 128, 3), np.float32)
    image[:16] = 8.0  # the upper 45 degrees: (1 - sin 45) / 2 of all directions
    (tmp_path / "sky.hdr").write_bytes(radiance_hdr.encode(image))
    assert mean_luminance(str(tmp_path / "sky.hdr")) == pytest.approx(8 * (1 - np.sqrt(0.5)) / 2, rel=0.01)
    Image.new("RGB", (64, 32), (188, 188, 188)).save(tmp_path / "gray.png")
    assert mean_luminance(str(tmp_path / "gray.png")) == pytest.approx(0.5029, abs=1e-3)
    Image.new("RGB", (64, 32)).save(tmp_path / "black.png")
    with pytest.raises(AssetError, match="black"):
        mean_luminance(str(tmp_path / "black.png"))
    with pytest.raises(AssetError, match="the sky cannot be read"):
        mean_luminance(str(tmp_path / "none.png"))


def test_the_brightness_of_a_sky_that_was_replaced_is_that_of_the_new_one(tmp_path):
    for scale in (1.0, 2.0):
        (tmp_path / "sky.hdr").write_bytes(radiance_hdr.encode(np.full((8, 16, 3), scale, np.float32)))
        os.utime(tmp_path / "sky.hdr", (scale, scale))
        assert mean_luminance(str(tmp_path / "sky.hdr")) == pytest.approx(scale, rel=0.01)


def test_pictures_that_cannot_be_opened_are_named(tmp_path):
    Image.new("RGB", (40, 30)).save(tmp_path / "good.jpg")
    assert [(each.width, each.height) for each in pictures_in(str(tmp_path))] == [(40, 30)]
    (tmp_path / "bad.png").write_text("no picture")
    with pytest.raises(ConfigError, match=r"cannot be opened:\n  .*bad.png"):
        pictures_in(str(tmp_path))


def test_an_option_that_a_format_needs_is_asked_for_where_a_configuration_has_it():
    with pytest.raises(ConfigError) as caught:
        load_job(CONFIGS / "detection.yaml", ["formats={dope: {}}"])
    assert str(caught.value).endswith(
        "DOPEWriter needs class_name_to_index_map: give it as an option: formats: {dope: {option: value}}."
    )


def test_all_mistakes_are_reported_at_once_with_what_is_expected(tmp_path):
    mistakes = {
        "meshes": str(tmp_path / "none"),
        "mesh_unit": "milimeter",
        "num_frmaes": 3,
        "formats": "{yolo: {tsk: detect}, cocoo: {}}",
        "objects.per_image": "[6, 1]",
        "objects.class_balence": "even",
        "occlusion.share": 30,
        "distractors.shapes": "[ball]",
        "backgrounds.pictures": str(tmp_path),
        "camera.calibration": str(tmp_path / "none.yaml"),
        "rendering.samples": 1,
        "min_pixels": 2000,
        "resolution": "[40, 30]",
    }
    with pytest.raises(ConfigError) as caught:
        load_job(CONFIGS / "detection.yaml", [f"{key}={value}" for key, value in mistakes.items()])
    message = str(caught.value)
    for part in (
        "no file for", "'auto', 'm', 'cm', 'mm', 'inch' or 'foot'", "did you mean num_frames?", "no option 'tsk'",
        "'task'", "cocoo is no format", "did you mean coco", "[6, 1] is the wrong way round",
        "did you mean class_balance?", "less than or equal to 1", "'capsule'", "has no pictures; expected files .jpg",
        "the calibration cannot be read", "greater than or equal to 4",
        "[40, 30] has fewer pixels than min_pixels, 2000",
    ):  # fmt: skip
        assert part in message, part


def test_jobs_have_names_with_near_misses(tmp_path):
    config = tmp_path / "job.yaml"
    config.write_text("job: detecton\n")
    with pytest.raises(ConfigError, match="'detecton' is not known; did you mean detection"):
        load_job(config)


@pytest.mark.parametrize("job", ["detection", "bin_picking"])
@pytest.mark.parametrize("name", ["a/b", "../../esc", "..", ".hidden", "a\\b", "a\nb"])
def test_parts_that_are_no_names_of_files_are_refused(job, name):
    splits = json.dumps({"train": 1.0, name: 1.0})
    with pytest.raises(ConfigError, match=r"splits: '.*': a part is called as a file is"):
        load_job(CONFIGS / f"{job}.yaml", [f"splits={splits}"])
    with pytest.raises(WriterError, match="a part is called as a file is"):
        Splits("YoloWriter", {name: 1.0})


def test_all_formats_are_named(tmp_path):
    for name, near in (("nope", " (did you mean dope?)"), ("zzzzz", "")):
        with pytest.raises(ConfigError) as caught:
            load_job(CONFIGS / "detection.yaml", [f"formats={{{name}: {{}}}}"])
        assert f"{name} is no format; expected some of basic, bop, coco" in str(caught.value)
        assert str(caught.value).endswith(f"ycbvideo, yolo{near}")

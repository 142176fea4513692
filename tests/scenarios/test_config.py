"""Configuration files: what is read, and how every mistake is reported."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence
from pathlib import Path

import pytest
import yaml

from usdsdg.cli.commands.generate import generate
from usdsdg.errors import ConfigError
from usdsdg.scenarios import config_errors
from usdsdg.scenarios.jobs import JOBS, load_job
from usdsdg.scenarios.object_based.config import ObjectBasedConfig

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.fixture
def written(tmp_path):
    def write(text: str, name: str = "job.yaml") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


TARGET = "labeled_assets_and_properties: [{url: /Isaac/a.usd, label: a}]\n"


def load_config(path: Path, overrides: Sequence[str] = ()) -> ObjectBasedConfig:
    config = load_job(path, overrides)[1]
    assert isinstance(config, ObjectBasedConfig)
    return config


def problems(path: Path, *overrides: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        load_config(path, overrides)
    head, *lines = str(caught.value).splitlines()
    assert str(path) in head
    return [line.strip() for line in lines]


def test_omitted_keys_take_the_defaults_of_isaac_sims_example(written):
    config = load_config(written(TARGET))
    assert config.working_area_size == (3, 3, 3)
    assert (config.num_frames, config.num_cameras, config.rt_subframes) == (10, 1, -1)
    assert config.disable_render_products_between_captures is True
    assert config.simulation_duration_between_captures == 0.025
    assert config.camera_distance_to_target_min_max == (0.1, 0.5)
    assert config.shape_distractors_num == 350
    assert config.writer_type is None
    # The default is ten, but there are no URLs.
    assert config.mesh_distractors_wanted == 0
    # The values of the example's capture function, which has no keys for them.
    expected = {"every": 5, "spp": 128, "sub_frames": 8, "duration": 0.025, "denoise": False}
    assert config.path_tracing.model_dump() == expected


def test_the_default_configuration_has_the_numbers_of_isaac_sims_example():
    values = yaml.safe_load((CONFIGS / "object_based.yaml").read_text())
    assert values["working_area_size"] == [5, 5, 3]
    assert [a["count"] for a in values["labeled_assets_and_properties"]] == [5, 7]
    assert len(values["mesh_distractors_urls"]) == 15
    assert (values["shape_distractors_num"], values["mesh_distractors_num"]) == (150, 175)
    assert values["writer_kwargs"]["output_dir"] == "_out_object_based"
    assert load_config(CONFIGS / "object_based.yaml").resolution == (640, 480)


def test_the_json_and_yaml_configurations_are_equal():
    assert load_config(CONFIGS / "object_based.json") == load_config(CONFIGS / "object_based.yaml")


@pytest.mark.parametrize("name", ["dope", "centerpose"])
def test_variants_differ_only_in_the_writer(name):
    default = load_config(CONFIGS / "object_based.yaml").model_dump()
    variant = load_config(CONFIGS / f"object_based_{name}.yaml").model_dump()
    assert {key for key in default if default[key] != variant[key]} == {"writer_kwargs"}
    assert variant["writer_kwargs"]["format"] == name


def test_all_mistakes_are_reported_at_once_with_their_lines(written):
    path = written(
        "num_frmaes: 3\n"
        "working_area_size: [5, -5, 3]\n"
        "labeled_assets_and_properties:\n"
        "  - label: x\n"
        "    cuont: 3\n"
        "  - {url: /a.usd, scale_min_max: [2, 1]}\n"
        "camera_distance_to_target_min_max: [0.7, 0.2]\n"
        "path_tracing: {every: true}\n"
    )
    messages = problems(path)
    assert [line.split(": ")[0] for line in messages] == [f"line {n}" for n in (1, 2, 4, 5, 6, 7, 8)]
    assert "num_frmaes: unknown key; did you mean num_frames" in messages[0]
    assert "working_area_size[1]: -5: must be greater than 0" in messages[1]
    assert "labeled_assets_and_properties[0].url: missing; expected path of a USD file" in messages[2]
    assert "labeled_assets_and_properties[0].cuont: unknown key; did you mean count?" in messages[3]
    assert "scale_min_max: [2.0, 1.0] is the wrong way round" in messages[4]
    assert "path_tracing.every: True is not a whole number" in messages[6]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("resolution: [640]", "resolution[1]: missing; expected width and height in pixels"),
        ("resolution: [640, 480, 3]", "has too many entries"),
        ("resolution: 640", "resolution: 640 is not a list"),
        (
            "resolution: [100000, 100000]",
            "resolution: an image of 100000 x 100000 pixels cannot be made; expected 1 to",
        ),
        ("resolution: [16384, 16384]", "no more than 67108864 in all"),
        ("num_frames: 2.5", "num_frames: 2.5 is not a whole number"),
        ("num_frames: '3'", "num_frames: '3' is not a whole number"),
        ("num_frames: -1", "num_frames: -1: must be greater than or equal to 0"),
        ("working_area_size: [.inf, 1, 1]", "working_area_size[0]: inf is not a finite number"),
        ("writer_kwargs: 5", "writer_kwargs: 5 is not a mapping"),
        ("path_tracing: 3", "path_tracing: 3 is not a mapping"),
        ("env_url: 3", "env_url: 3 is not text"),
        ("launch_config: {renderer: Fast}", "expected RayTracedLighting or PathTracing"),
        ("launch_config: {window: 3}", "launch_config.window: unknown key; known here: renderer, headless"),
        ("shape_distractors_types: [torus]", "'torus'"),
        ("shape_distractors_types: []\nshape_distractors_num: 3", "shape_distractors_types lists nothing"),
        ("mesh_distractors_urls: []\nmesh_distractors_num: 3", "mesh_distractors_urls lists nothing to choose from"),
        ("camera_properties_kwargs: {focalLenght: 3}", "did you mean focalLength?"),
        (
            "writer_type: YoloWriter\nwriter_kwargs: {output_dir: out, format: null}",
            "line 2: writer_kwargs: YoloWriter has no option 'format'",
        ),
        (
            "writer_type: DOPEWriter\nwriter_kwargs: {output_dir: out}",
            "class_name_to_index_map: give it in writer_kwargs",
        ),
        ("writer_type: PoseWritr", "writer_type: No writer is named 'PoseWritr'. Did you mean 'PoseWriter'"),
        (
            "camera_properties_kwargs: {clippingRange: 3}",
            "clippingRange: 3 does not fit; expected a value of type float2",
        ),
        ("simulation_duration_between_captures: 1e300", "less than or equal to 3600"),
        ("working_area_size: [1, 1, 1e300]", "less than or equal to 1000000"),
        ("camera_collider_radius: 1e300", "camera_collider_radius: 1e+300: must be less than or equal to 1000000"),
        ("camera_look_at_target_offset: 1e300", "less than or equal to 1000000"),
        ("camera_distance_to_target_min_max: [1, 1e300]", "target_min_max[1]: 1e+300: must be less than or equal to"),
        ("shape_distractors_scale_min_max: [1, 1e300]", "less than or equal to 1000000"),
        ("path_tracing: {spp: 10000000000}", "less than or equal to 1048576"),
        ("workers: 4", "workers: unknown key; it is the option --workers of `usdsdg generate`"),
        ("output_dir: dataset", "output_dir: unknown key; here it is writer_kwargs.output_dir"),
        ("spp: 3", "spp: unknown key; did you mean path_tracing.spp?"),
        ("path_tracing: {num_frames: 3}", "path_tracing.num_frames: unknown key; num_frames stands at the top of"),
        ("window: 3", "window: unknown key; known here: launch_config"),
        ("assets-root: /assets", "assets-root: unknown key; it is the option --assets-root of"),
        ("num_frames: 3\nnum_frames: 4", "num_frames: given twice (also on line 1)"),
    ],
)
def test_every_mistake_names_the_key_and_the_expected_value(written, text, expected):
    messages = problems(written(f"{text}\n{TARGET}"))
    assert len(messages) == 1
    assert expected in messages[0]


@pytest.mark.parametrize("job", JOBS)
def test_names_of_other_jobs_are_told_with_keys_that_there_are(job):
    model = JOBS[job].model
    known = {key for other in JOBS.values() for key in other.model.model_fields} | {"field_of_view"}
    for name, meant in model.other_names.items():
        assert name not in model.model_fields
        assert name in known
        assert re.split(r"[^a-z_]", meant)[0] in model.model_fields


def test_all_options_of_the_command_are_told_from_keys():
    flags = {flag for option in generate.params for flag in option.opts if flag.startswith("--")}
    # The first is how keys are set, the second a key as well, and the third looks like num_frames.
    options = {flag.strip("-").replace("-", "_") for flag in flags} - {"set", "seed", "frames"}
    assert set(config_errors._OPTIONS) == options


def test_cameras_need_something_to_look_at(written):
    assert "cameras need one to look at" in problems(written("num_frames: 3\n"))[0]
    assert load_config(written("num_cameras: 0\n")).num_cameras == 0


def test_the_two_names_of_the_scale_must_agree(written):
    asset = "labeled_assets_and_properties: [{url: /a.usd, scale_min_max: [1, 2], randomize_scale: [%s]}]\n"
    assert load_config(written(asset % "1, 2")).labeled_assets_and_properties[0].scale_range == (1, 2)
    assert "expected only one of them" in problems(written(asset % "1, 3"))[0]


def test_overrides_reach_into_mappings_and_lists():
    config = load_config(
        CONFIGS / "object_based.yaml",
        [
            "num_frames=3",
            "path_tracing.spp=16",
            "resolution=[320, 240]",
            "resolution.1=200",
            "labeled_assets_and_properties[1].count=2",
            "writer_kwargs.format=dope",
            "simulation_duration_between_captures=1e-3",
        ],
    )
    assert (config.num_frames, config.path_tracing.spp, config.resolution) == (3, 16, (320, 200))
    assert [asset.count for asset in config.labeled_assets_and_properties] == [5, 2]
    assert config.writer_kwargs["format"] == "dope"
    assert config.simulation_duration_between_captures == 0.001


def test_an_override_below_a_key_that_is_wrong_is_named_beside_its_line(written):
    path = written("job: detection\nformats: {yolo: {}}\n")
    with pytest.raises(ConfigError, match=r"line 2 with override 'formats\.yollo=\{\}': formats: yollo is no format"):
        load_job(path, ["formats.yollo={}", "num_frames=3"])


def test_a_bad_override_is_named_instead_of_a_line():
    messages = problems(
        CONFIGS / "object_based.yaml",
        "num_frames=many", "labeled_assets_and_properties.4.count=1", "num_cameras", "seed.x=1",
    )  # fmt: skip
    assert "override 'num_frames=many': num_frames: 'many' is not a whole number" in messages[-1] + messages[0]
    assert any("labeled_assets_and_properties has entries 0 to 1, no 4" in line for line in messages)
    assert any("expected key=value" in line for line in messages)
    assert any("seed is 0, which has nothing below it" in line for line in messages)


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.yaml", "seed: 0\nnum_frames: [1", "line 2: not valid YAML"),
        ("a.json", '{"num_frames": 1,\n"seed" 2}', "line 2: not valid JSON"),
        ("a.json", "[1]", "expected a mapping"),
        ("a.yaml", "seed: 0\nwriter_kwargs: &again {deeper: [*again]}", "line 2: not valid YAML: it contains itself"),
        ("a.yaml", "a: " + "[" * 5000, "nested too deeply"),
        ("a.json", "[" * 100_000, "nested too deeply"),
        ("a.yaml", 'seed: 0\nnum_frames: !!int ""', "line 2: not valid YAML: '' is no int"),
        ("a.toml", "", "a configuration is a .yaml, .yml or .json file"),
    ],
)
def test_unreadable_files_are_errors_that_say_why(written, name, text, expected):
    with pytest.raises(ConfigError, match=expected.replace("[", r"\[")):
        load_config(written(text, name))


def test_text_in_another_encoding_is_an_error_with_the_remedy(tmp_path):
    (tmp_path / "a.yaml").write_text("seed: 0\n", encoding="utf-16")  # as the shell of Windows writes it
    with pytest.raises(ConfigError, match=r"is not in UTF-8 .*Save it as UTF-8"):
        load_config(tmp_path / "a.yaml")


def test_a_link_to_nothing_is_named_with_what_it_leads_to(tmp_path):
    (tmp_path / "a.yaml").symlink_to("elsewhere.yaml")
    with pytest.raises(ConfigError, match=r"a\.yaml is a link to elsewhere\.yaml, which is not there"):
        load_config(tmp_path / "a.yaml")


def test_an_anchor_may_be_used_by_a_sibling_key(written):
    text = "camera_distance_to_target_min_max: &range [1, 2]\nshape_distractors_scale_min_max: *range\n"
    assert load_config(written(text + TARGET)).shape_distractors_scale_min_max == (1, 2)


def test_an_override_that_contains_itself_is_named(written):
    messages = problems(written(TARGET), "writer_kwargs=&again {deeper: *again}")
    assert "writer_kwargs: '&again {deeper: *again}' is not a mapping" in messages[0]


def test_a_missing_file_suggests_files_of_similar_names():
    with pytest.raises(ConfigError, match=r"did you mean object_based\.yaml"):
        load_config(CONFIGS / "objekt_based.yaml")
    with pytest.raises(ConfigError, match=r"there is no folder .*nowhere; `usdsdg new detection` writes"):
        load_config(CONFIGS / "nowhere" / "job.yaml")
    with pytest.raises(ConfigError, match=r"there is no file .*; `usdsdg new detection` writes"):
        load_config(CONFIGS.parent / "docs" / "images" / "job.yaml")


@pytest.mark.parametrize(
    ("override", "expected"),
    [
        ("env_url=\udcff", "override 'env_url=\\udcff': it is not UTF-8 text"),
        ("resolution[²]=3", "resolution: has entries 0 to 1, no ²"),
        ("num_frames=" + "x" * 5000, f"num_frames: '{'x' * 75} ... is not a whole number"),
    ],
)
def test_odd_text_of_the_command_line_is_named_and_shortened(written, override, expected):
    messages = problems(written(f"resolution: [32, 24]\n{TARGET}"), override)
    assert expected.replace("resolution: has", "resolution has") in messages[0]
    assert len(messages[0]) < 400


@pytest.mark.parametrize("name", ["job.yaml", "job.json"])
def test_half_characters_of_escapes_are_named_with_their_keys(written, name):
    values = {"env_url": "a\udcff", "labeled_assets_and_properties": [{"url": "/a.usd", "\ud800": 1}]}
    messages = problems(written(json.dumps(values), name))
    assert len(messages) == 2
    assert "env_url: it is not UTF-8 text" in messages[0]
    assert "labeled_assets_and_properties[0].'\\ud800': the key is not UTF-8 text" in messages[1]


def test_a_mark_of_the_byte_order_is_no_part_of_json(written):
    values = {"num_frames": 3, "labeled_assets_and_properties": [{"url": "/a.usd"}]}
    assert load_config(written("\ufeff" + json.dumps(values), "job.json")).num_frames == 3


def test_json_indented_with_tabs_is_read(written):
    values = {"num_frames": 3, "labeled_assets_and_properties": [{"url": "/a.usd"}]}
    assert load_config(written(json.dumps(values, indent="\t"), "job.json")).num_frames == 3


@pytest.mark.parametrize("text", ["aa #1", "#1", "aa # b # c", "aa #[", "{a: 1} # b"])
def test_an_override_has_no_comments(written, text):
    """YAML would take what follows for a comment, and drop it."""
    config = load_config(written(TARGET), [f"writer_kwargs.output_dir={text}"])
    assert config.writer_kwargs["output_dir"] == text


def test_number_signs_in_quotes_and_words_stay_in_overrides(written):
    overrides = ["writer_kwargs={output_dir: 'x #1', format: x#1}", "writer_kwargs.name='x #1'"]
    config = load_config(written(TARGET), overrides)
    assert config.writer_kwargs == {"output_dir": "x #1", "format": "x#1", "name": "x #1"}


@pytest.mark.parametrize(
    ("text", "overrides", "there"),
    [
        ("job: detection\nmeshes: parts\n", [], "parts"),
        ("job: bin_picking\n", ["meshes=parts"], "parts"),
        ("job: detection\nmeshes: ''\ncamera: {calibration: 'cameras.yaml#left'}\n", [], "cameras.yaml"),
    ],
)
def test_a_path_that_lies_beside_the_configuration_is_named(written, monkeypatch, text, overrides, there):
    path = written(text)
    (path.parent / "parts").mkdir()
    (path.parent / "cameras.yaml").write_text("nothing: 1\n")
    (path.parent / "elsewhere").mkdir()
    monkeypatch.chdir(path.parent / "elsewhere")
    with pytest.raises(ConfigError) as caught:
        load_job(path, overrides)
    assert f"beside the configuration lies one: give {os.path.join('..', there)}" in str(caught.value)
    assert ".;" not in str(caught.value)
    monkeypatch.chdir(path.parent)
    with pytest.raises(ConfigError) as caught:
        load_job(path, overrides)
    assert "beside the configuration" not in str(caught.value)

"""The JSON schema of configurations accepts what runs, and refuses keys and types that a run would refuse."""

import copy
import json
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft202012Validator

from usdsdg.scenarios.config_schema import config_schema
from usdsdg.scenarios.jobs import JOBS

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = sorted([*(ROOT / "configs").iterdir(), *(ROOT / "usdsdg" / "cli" / "starting_points").glob("*.yaml")])


def loaded(path: Path) -> dict:
    text = path.read_text(encoding="utf-8")
    return json.loads(text) if path.suffix == ".json" else yaml.safe_load(text)


def problems(values: dict, job: str | None = None) -> list[str]:
    return [each.message for each in Draft202012Validator(config_schema(job)).iter_errors(values)]


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.name)
def test_configurations_are_valid_and_a_misspelled_key_is_not(path):
    values = loaded(path)
    own = values.get("job", "object_based")
    for job in (None, own):
        assert problems(values, job) == []
        wrong = {f"{key}x" if number == 1 else key: value for number, (key, value) in enumerate(values.items())}
        assert any(f"{list(values)[1]}x" in message for message in problems(wrong, job))
    for other in JOBS.keys() - {own}:
        assert problems(values, other)


def test_keys_inside_of_sections_and_their_types_are_checked():
    values = loaded(ROOT / "configs" / "detection.yaml")
    for section, key, wrong in (("objects", "per_imag", [1, 2]), ("camera", "field_of_view", "wide")):
        changed = copy.deepcopy(values)
        changed[section][key] = wrong
        assert problems(changed)
    assert problems(values | {"job": "detectoin"})


@pytest.mark.parametrize("job", [None, *JOBS])
def test_it_is_a_schema_and_every_key_says_what_it_is(job):
    schema = config_schema(job)
    Draft202012Validator.check_schema(schema)
    for definition in schema["$defs"].values():
        for name, key in definition["properties"].items():
            assert name == "job" or "description" in key, (definition["title"], name)

"""Files of settings are bounded: whatever they stand for, reading ends at once."""

import json

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from usdsdg.arguments import yaml_bounds
from usdsdg.arguments.yaml_bounds import TooLarge, check_yaml, load_json, read_bounded
from usdsdg.cli.options.file_kinds import FileKind, check_kind
from usdsdg.errors import ConfigError
from usdsdg.replicator_yaml import ParserError, parse
from usdsdg.scenarios.config_file import read_config
from usdsdg.scenarios.object_based.config import ObjectBasedConfig

# Unbounded, most of these files take minutes or for ever; bounded, a fraction of a second.
pytestmark = pytest.mark.timeout(30)


def bomb(levels=12, width=9):
    lines = [f"a0: &a0 [{', '.join('x' * width)}]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * width)}]" for n in range(1, levels)]
    return "\n".join(lines) + "\n"


def merge_bomb():
    lines = ["a0: &a0 {k: 1}"] + [f"a{n}: &a{n}\n  <<: [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12)]
    return "\n".join(lines) + "\n"


TOO_LARGE = {
    "aliases": (bomb(), "aliases written out"),
    "merge keys": (merge_bomb(), "aliases written out"),
    "brackets": ("a: " + "[" * 5000 + "]" * 5000, "more than 50 in each other"),
    "open brackets": ("a: " + "[" * 100_000, "more than 50 in each other"),
    "indents": ("".join(f"{' ' * n}k:\n" for n in range(200)), "more than 50 in each other"),
    "depth by aliases": ("a0: &a0 [x]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}]\n" for n in range(1, 60)), "50 in each"),
    "keys": ("".join(f"key{n}: 1\n" for n in range(20_000)), "more than 1000 keys"),
    "values": ("a:\n" + "  - {b: 1, c: 2}\n" * 30_000, "more than 10000 values"),
    "integer": (f"num_frames: {'9' * 6000}\n", "a number of 6000 digits"),
    "negative integer": (f"num_frames: -{'1' * 5000}\n", "a number of 5001 digits"),
    "base 60": (f"num_frames: {'1:' * 60_000}1\n", "a number of 120001 digits"),
    "binary": (f"num_frames: 0b{'10' * 60_000}\n", "a number of 120002 digits"),
    "text": (f"num_frames: {'x' * 900_000}\n", "a text of 900000 characters"),
    "size": (f"# {'x' * 3_000_000}\n", "more than 1 MB"),
}  # fmt: skip


@pytest.mark.parametrize("what", TOO_LARGE)
def test_a_file_that_stands_for_too_much_is_refused_at_once(tmp_path, what):
    text, words = TOO_LARGE[what]
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=words):
        read_config(path, [], ObjectBasedConfig)
    with pytest.raises(ParserError, match=f"scene.yaml.*{words}"):
        parse(path)
    check_kind(path, FileKind.SCRIPT)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 100_000 + "]" * 100_000, "nested"),
        ('{"a":' * 200 + "1" + "}" * 200, "more than 50 in each other"),
        (f'{{"num_frames": {"9" * 6000}}}', "a number of 6000 digits"),
        (f'{{"a": [{{"b": -{"9" * 6000}}}]}}', "a number of 6001 digits"),
        (json.dumps({f"k{n}": 1 for n in range(20_000)}), "more than 1000 keys"),
    ],
)
def test_json_has_the_same_bounds(tmp_path, text, words):
    path = tmp_path / "config.json"
    path.write_text(text)
    with pytest.raises(ConfigError, match=words):
        read_config(path, [], ObjectBasedConfig)
    with pytest.raises(TooLarge, match=words):
        load_json(text, "config.json")


def test_overrides_have_the_same_bounds(tmp_path):
    path = tmp_path / "config.yaml"
    path.write_text("num_frames: 1\n")
    with pytest.raises(ConfigError, match="more than 50 in each other"):
        read_config(path, ["num_frames=" + "[" * 5000], ObjectBasedConfig)


def test_many_problems_are_counted_and_the_first_are_told(tmp_path):
    path = tmp_path / "config.yaml"
    path.write_text("".join(f"key{number}: 1\n" for number in range(999)))
    with pytest.raises(ConfigError, match="has 1000 problems") as refused:
        read_config(path, [], ObjectBasedConfig)
    assert "and 970 more" in str(refused.value)
    assert len(str(refused.value).splitlines()) == 32


def test_files_within_the_bounds_are_returned_as_they_are(tmp_path):
    path = tmp_path / "a.yaml"
    for text in ("", "a: [1, 2\n", "\ta", "a: &a\n  b: *a\n", "é: 1e-3\n", bomb(levels=3)):
        path.write_text(text, encoding="utf-8")
        assert read_bounded(path) == text


def written_out(value):
    if isinstance(value, dict):
        return 1 + sum(1 + written_out(each) for each in value.values())
    return 1 + sum(map(written_out, value)) if isinstance(value, list) else 1


VALUES = st.recursive(
    st.integers() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(min_size=1, max_size=2), inner, max_size=4),
)


@settings(max_examples=60)
@given(VALUES)
def test_the_number_of_values_that_is_counted_is_that_of_the_loaded_ones(value):
    text = yaml.dump([value])
    count = written_out([value])
    bound = yaml_bounds.MAX_VALUES
    try:
        yaml_bounds.MAX_VALUES = count
        check_yaml(text, "text")
        yaml_bounds.MAX_VALUES = count - 1
        with pytest.raises(TooLarge):
            check_yaml(text, "text")
    finally:
        yaml_bounds.MAX_VALUES = bound


@given(st.text(alphabet="a1&*[]{}:,- \n<!|>'\"#%@`?", max_size=60))
def test_nothing_but_a_bound_is_an_error(text):
    check_yaml(text, "text")

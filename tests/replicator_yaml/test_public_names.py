"""What a file may call, and that it cannot reach anything else."""

import inspect
import re
import textwrap
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import usdsdg as rep
from tests.contracts import mirror
from usdsdg.replicator_yaml import ParserError, parse
from usdsdg.replicator_yaml import public_names as names
from usdsdg.session.settings.store import get_settings

# Functions that take a function, which a file cannot give, context managers, and objects.
NOT_FOR_FILES = {"register", "on_condition", "on_key_press", "mdl_from_json", "normalized_decal_position", "frame"} | {
    "ReplicatorItem", "ReplicatorWrapper", "auto_connect", "sequential",
}  # fmt: skip


@pytest.fixture
def parsed(tmp_path, stage):
    def parse_text(text):
        (tmp_path / "scene.yaml").write_text(textwrap.dedent(text))
        return parse(tmp_path / "scene.yaml")

    return parse_text


def test_every_listed_name_is_a_function():
    listed = [f"{family}.{name}" for family in names.FAMILIES for name in names.public_functions(family)]
    assert len(listed) > 150
    assert [name for name in listed if names.public_function(name) is None] == []


@pytest.mark.parametrize("family", ["create", "get", "modify", "randomizer", "distribution", "physics", "trigger"])
def test_all_functions_of_a_family_are_listed_but_those_that_take_functions(family):
    table = {path.split(".")[1] for path in mirror.names() if re.fullmatch(rf"{family}\.\w+", path)}
    there = {name for name in table if hasattr(getattr(rep, family), name)}
    assert there - set(names.FUNCTIONS[family].split()) <= NOT_FOR_FILES


@pytest.mark.parametrize(
    "name",
    [
        "writers.backends.os.system", "backends.io_queue.submit", "writers.registry.near_misses", "create.objects.Any",
        "functional.create.arguments.os", "writers.set_disk_root", "distribution.importlib.import_module",
        "utils.files.Path.unlink", "writers.register_writer", "errors.Path", "rng.reset_all", "create.register",
        "randomizer.register.__globals__", "create.cube.__call__", "annotators.Augmentation.from_function",
        "orchestrator.get_orchestrator", "open_stage.x", "session.x", "app.x", "os.system", "trigger.on_condition",
    ],
)  # fmt: skip
def test_what_modules_import_cannot_be_called(parsed, name):
    with pytest.raises(ParserError, match=r"scene.yaml, line 3: .*there is no|line 3: randomizer"):
        parsed(f"x:\n  y:\n    {name}: {{command: 'touch PWNED'}}\n")


@pytest.mark.parametrize("name", ["write_json", "write_pickle", "write_np", "write_image", "read_exr"])
def test_files_of_any_name_are_not_written_or_read(parsed, tmp_path, name):
    with pytest.raises(ParserError, match=f"functional.{name} takes files of any name.*writers"):
        parsed(f"x:\n  functional.{name}: {{path: {tmp_path}/x, data: 3}}\n")
    assert not (tmp_path / "x").exists()


def test_prims_do_not_lead_to_their_stage(parsed, tmp_path):
    with pytest.raises(ParserError, match=r"no function prim.GetStage that a YAML file may call"):
        parsed(
            f"""
            prim:
              functional.create.cube: null
            stage:
              prim.GetStage: null
            file:
              stage.Export: {{filename: {tmp_path}/x.usda}}
            """
        )
    assert not (tmp_path / "x.usda").exists()


def test_methods_that_a_subclass_of_ours_inherits_can_be_called(stage):
    class Mine(rep.Writer):
        def write(self, data): ...

    writer = Mine()
    writer.hook = print
    assert names.public_method(writer, ["attach"]) == writer.attach
    assert names.public_method(writer, ["hook"]) is None
    assert names.public_method(writer, ["__class__", "mro"]) is None
    assert names.public_method("text", ["upper"]) is None


def test_functions_that_a_script_registers_can_be_called(parsed):
    def my_shape(count: int = 1):
        return rep.create.sphere(count=count)

    rep.randomizer.register(my_shape)
    try:
        assert len(parsed("x:\n  randomizer.my_shape: {count: 2}\n")["x"].prims) == 2
    finally:
        del rep.randomizer.my_shape


@pytest.mark.parametrize("setting", ["/app/scripting/ignoreWarningDialog", "app//scripting/ignoreWarningDialog"])
def test_a_file_cannot_have_scripts_of_a_stage_run(parsed, setting):
    with pytest.raises(ParserError, match=r"line 2: .* decides which scripts run"):
        parsed(f"x:\n  settings.carb_settings: {{setting: {setting}, value: true}}\n")
    with pytest.raises(ParserError, match="decides which scripts run"):
        parsed("x:\n  modify.attribute: {name: 'omni:scripting:scripts', value: [evil.py], input_prims: /World}\n")
    assert not get_settings().get_as_bool("/app/scripting/ignoreWarningDialog")


WORDS = ["os", "system", "backends", "writers", "create", "cube", "path", "utils", "registry", "sys", "modules", "get"]


@settings(max_examples=200)
@given(st.lists(st.sampled_from([*WORDS, "__class__", "__globals__", "functional"]), min_size=2, max_size=5))
def test_what_a_name_leads_to_is_ours(parts):
    found = names.public_function(".".join(parts))
    assert found is None or inspect.getmodule(found).__name__.startswith("usdsdg")


def test_functions_that_call_each_other_end(parsed):
    text = "r:\n  randomizer.register:\n    forever:\n      x:\n        randomizer.forever: null\n"
    try:
        with pytest.raises(ParserError, match="more than 20 calls deep"):
            parsed(text + "y:\n  randomizer.forever: null\n")
    finally:
        del rep.randomizer.forever


def test_a_file_makes_a_bounded_number_of_calls(parsed):
    lines = ["r:", "  randomizer.register:", "    f0: {x: {utils.get_replicator_graph_exists: null}}"]
    lines += [f"    f{n}: {{x: {{randomizer.f{n - 1}: null}}, y: {{randomizer.f{n - 1}: null}}}}" for n in range(1, 16)]
    try:
        with pytest.raises(ParserError, match="makes more than 4000 calls"):
            parsed("\n".join([*lines, "y:", "  randomizer.f15: null"]))
    finally:
        for number in range(16):
            delattr(rep.randomizer, f"f{number}")


def test_a_file_that_is_its_own_profile_is_an_error(parsed, tmp_path):
    (tmp_path / "b.yaml").write_text("profiles: [scene.yaml]\n")
    with pytest.raises(ParserError, match="is a profile of itself"):
        parsed("profiles: [b.yaml]\n")


def test_many_profiles_are_an_error(parsed, tmp_path):
    Path(tmp_path / "b.yaml").write_text("a: 1\n")
    with pytest.raises(ParserError, match="more than 8 profiles"):
        parsed(f"profiles: [{', '.join(['b.yaml'] * 9)}]\n")


def test_a_description_for_another_extension_is_told(parsed):
    described = "omni.replicator.object:\n  version: 0.4.4\n  num_frames: 3\n"
    with pytest.raises(ParserError, match=r"line 1: this describes scenes for the extension omni\.replicator\.object"):
        parsed(described)

"""An asset that cannot be opened is an error with exit code 1 wherever one is taken, and not a warning of USD."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from pxr import Usd

import usdsdg as rep
from tests import forked
from tests.demo_assets import share_demo_assets
from tests.sampled_cases import sampled
from usdsdg.cli.app import app
from usdsdg.compat.isaacsim.core.utils.stage import add_reference_to_stage
from usdsdg.compat.isaacsim.replicator.behavior.utils.scene_utils import create_asset
from usdsdg.compat.omni.kit import commands
from usdsdg.errors import AssetError, AssetNotFound, AssetUnreadable
from usdsdg.session.stage_context import current_stage

CONFIGS = Path(__file__).parents[2] / "configs"


def torn(file):
    made = Usd.Stage.CreateNew(str(file))
    made.SetDefaultPrim(made.DefinePrim("/thing", "Cube"))
    made.GetRootLayer().Save()
    file.write_bytes(file.read_bytes()[:100])


BROKEN = {
    "torn.usdc": (torn, "cannot be opened as USD"),
    "nonsense.usda": (lambda file: file.write_text("#usda 1.0\ndef Xform {{{"), "cannot be opened as USD"),
    "page.usd": (lambda file: file.write_text("<html>not found</html>"), "cannot be opened as USD"),
    "nothing.usd": (lambda file: file.write_bytes(b""), "is an empty file"),
    "pointer.usdz": (lambda file: file.write_text("version https://git-lfs.github.com/spec/v1\n"), "Git LFS"),
    "folder.usd": (lambda file: file.mkdir(), "it is a folder"),
    "cut.glb": (lambda file: file.write_bytes(b"glTF\x02\0\0\0\xff\xff\0\0"), "cut off"),
    "points.obj": (lambda file: file.write_text("v 0 0 0\n"), "no triangles"),
}


pytestmark = pytest.mark.usefixtures("own_cache")


@pytest.fixture(params=list(BROKEN))
def broken(request, tmp_path):
    """A file that cannot be opened, and why."""
    make, why = BROKEN[request.param]
    file = tmp_path / "assets" / request.param
    file.parent.mkdir()
    make(file)
    return file, why


def test_functions_that_take_an_asset(stage, broken):
    file, why = str(broken[0]), broken[1]
    for take in (
        rep.create.from_usd,
        lambda file: rep.create.from_usd(file, semantics=[("class", "thing")]),
        lambda file: rep.randomizer.instantiate([file], size=1),
        lambda file: rep.randomizer.instantiate([file], size=1, mode="point_instance"),
        lambda file: rep.functional.create.reference(usd_path=file),
        lambda file: rep.functional.create.reference(usd_path=file, prim_path="/thing"),
        lambda file: add_reference_to_stage(file, "/World/thing"),
    ):
        with pytest.raises(AssetUnreadable, match=why) as error:
            take(file)
        assert broken[0].name in str(error.value)


# Functions of scripts by which the prim at a path refers to a file.
REFERRING = {
    "CreateReference": lambda file, path: commands.execute("CreateReference", path_to=path, asset_path=file),
    "CreatePayload": lambda file, path: commands.execute("CreatePayload", path_to=path, asset_path=file),
    "create_asset": lambda file, path: create_asset(current_stage(), file, path),
    "add_reference_to_stage": add_reference_to_stage,
}


@pytest.mark.parametrize("name", list(REFERRING))
def test_an_asset_that_cannot_be_opened_is_named_with_the_prim_that_refers_to_it(stage, broken, name):
    file, why = str(broken[0]), broken[1]
    with pytest.raises(AssetUnreadable, match=why) as error:
        REFERRING[name](file, "/World/thing")
    assert str(error.value).startswith(f"/World/thing cannot refer to {file}: ")
    assert "replace the file" in str(error.value)
    assert not stage.GetPrimAtPath("/World/thing")  # nothing half made


@pytest.mark.parametrize("name", list(REFERRING))
def test_a_missing_asset_is_named_with_the_prim_that_refers_to_it(stage, tmp_path, name):
    file = str(tmp_path / "gone.glb")
    with pytest.raises(AssetNotFound, match=r"gone\.glb") as error:
        REFERRING[name](file, "/World/thing")
    assert str(error.value).startswith(f"/World/thing cannot refer to {file}: ")
    assert not stage.GetPrimAtPath("/World/thing")


@pytest.mark.parametrize("broken", [name for name in BROKEN if name != "folder.usd"], indirect=True)
def test_folders_of_assets(stage, broken):
    with pytest.raises(AssetUnreadable, match=broken[1]):
        rep.create.from_dir(str(broken[0].parent))


@pytest.mark.parametrize("broken", sampled(BROKEN), indirect=True)
def test_commands_end_with_exit_code_1(broken, tmp_path):
    share_demo_assets(tmp_path / "cache")
    file, why = broken
    config = {
        "labeled_assets_and_properties": [{"url": str(file), "label": "thing", "count": 1}],
        "writer_type": "BasicWriter", "writer_kwargs": {"output_dir": str(tmp_path / "out"), "rgb": True},
    }  # fmt: skip
    (tmp_path / "config.json").write_text(json.dumps(config))
    for command in (
        ("generate", str(tmp_path / "config.json")),
        ("generate", str(CONFIGS / "detection.yaml"), "--set", f"meshes={file.parent}"),
        ("render", str(file), str(tmp_path / "picture")),
        ("convert", str(file), str(tmp_path / "thing.usda")),
    ):
        result = CliRunner().invoke(app, list(command), env={"COLUMNS": "400", "TERM": "dumb"})
        assert result.exit_code == 1, command
        assert file.name in result.output, command
        assert command[0] != "generate" or why in result.output


@pytest.mark.parametrize(
    "line",
    [
        "rep.create.from_usd(FILE, semantics=[('class', 'thing')])",
        "stage.DefinePrim('/World/thing').GetReferences().AddReference(FILE)",
        "omni.kit.commands.execute('CreateReference', path_to='/World/thing', asset_path=FILE)",
        "create_asset(stage, FILE, '/World/thing')",
        "create_asset(stage, FILE.replace('torn.usdc', 'torn.usdc/gone.glb'), '/World/thing')",
    ],
)
def test_scripts_end_with_exit_code_1(tmp_path, line):
    torn(tmp_path / "torn.usdc")
    (tmp_path / "script.py").write_text(
        "import omni.kit.commands, omni.replicator.core as rep, omni.usd\n"
        "from isaacsim.replicator.behavior.utils.scene_utils import create_asset\n"
        f"FILE = {str(tmp_path / 'torn.usdc')!r}\n"
        f"stage = omni.usd.get_context().get_stage()\n{line}\nrep.orchestrator.step()\n"
    )
    ended = forked.run(["-m", "usdsdg", "run", "script.py"], cwd=tmp_path)
    assert ended.returncode == 1
    assert "torn.usdc" in ended.stderr


def test_a_file_without_a_default_prim_says_what_it_has(stage, tmp_path):
    made = Usd.Stage.CreateNew(str(tmp_path / "rootless.usda"))
    made.DefinePrim("/Mug", "Xform")
    made.GetRootLayer().Save()
    for take in (rep.create.from_usd, lambda file: rep.randomizer.instantiate([file], size=1)):
        with pytest.raises(AssetError, match=r"rootless.usda has no default prim.*\(it has /Mug\)"):
            take(str(tmp_path / "rootless.usda"))

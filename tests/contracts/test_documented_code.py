"""The Python and YAML code in README.md and docs/ runs as written, but for sizes and numbers of images, and buckets.

Pages that are done step by step, with files and commands, are walked by tests/site.
"""

import pytest
from pxr import Usd, UsdGeom, UsdLux

from tests import forked
from tests.demo_assets import share_demo_assets
from tests.scripts.conftest import ROOT, usdsdg
from tests.site import walk
from tests.site.test_blocks import READ

SMALLER = {
    "(640, 480)": "(32, 24)",
    "[512, 512]": "[32, 32]",
    "samples=64": "samples=1",
    "num_frames=10": "num_frames=2",
    '"num_frames=8"': '"num_frames=2", "resolution=[32,24]"',
    '"num_frames=64"': '"num_frames=2", "resolution=[32,24]"',
    "count=256": "count=2",
    '["1024", "128"]': '["2", "24"]',
    '["1024", "320"], worlds=32, device="cuda"': '["2", "24"], worlds=2',
    '"s3://bucket': '"memory://bucket',
    '"gs://bucket': '"memory://other',
}
TRAINING = ROOT / "docs/training.md"
PAGES = [page for page in READ if "```python" in page.read_text(encoding="utf-8") and page != TRAINING]


def each_block(page, language: str) -> list[str]:
    """Return the code blocks of a page that are run, in order, with smaller sizes."""
    found = [each.code for each in walk.blocks(page) if each.language == language and not each.reason]
    for large, small in SMALLER.items():
        found = [text.replace(large, small) for text in found]
    return found


def blocks(page, language: str) -> str:
    """Return all code blocks of a page in order; later ones use names of earlier ones."""
    return "\n".join(each_block(page, language))


def save_scene(path) -> None:
    """Save a scene with the two cameras that docs/renderer.md uses."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.Cube.Define(stage, "/World/Cube").AddTranslateOp().Set((0, 0, -10))
    UsdLux.DomeLight.Define(stage, "/World/Sky").CreateIntensityAttr(1000)
    for side in ("Left", "Right"):
        UsdGeom.Camera.Define(stage, f"/World/{side}")
    stage.Save()


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """Writers write below a temporary home folder; the kernel cache stays where it is."""
    monkeypatch.setenv("WARP_CACHE_PATH", walk.kernels())
    monkeypatch.setenv("HOME", str(tmp_path))
    share_demo_assets(tmp_path / ".cache")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_documented_python_runs(page, tmp_path):
    save_scene(tmp_path / "scene.usda")
    (tmp_path / "script.py").write_text(blocks(page, "python"))
    usdsdg("run", "--quiet", "script.py", cwd=tmp_path)
    if page.stem == "README":
        assert (tmp_path / "omni.replicator_out/cubes/rgb_0001.png").is_file()


def test_documented_yaml_runs_and_its_images_are_not_black(tmp_path):
    (tmp_path / "scene.yaml").write_text(blocks(ROOT / "docs/yaml.md", "yaml"))
    done = usdsdg("run", "--quiet", "scene.yaml", cwd=tmp_path)
    assert "black" not in done.stderr
    assert len(list((tmp_path / "omni.replicator_out/cubes_of_yaml").glob("rgb_*.png"))) == 10


@pytest.mark.parametrize("number", [0, 1, 2, 3])
def test_documented_streams_run(number, tmp_path):
    code = each_block(TRAINING, "python")[number]
    if "torch" in code:
        pytest.importorskip("torch")
    for folder in ("configs", "examples"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    shown = "len(pictures.shape) > 2" if "pictures" in code else "len(picture.shape) == 3"
    done = forked.run(["-c", f"{code}\nassert {shown} and len(boxes)"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr

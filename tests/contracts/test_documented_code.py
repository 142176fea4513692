"""The Python and YAML code in README.md and docs/ runs as written, except for the size and number of images."""

import re

import pytest
import warp as wp
from pxr import Usd, UsdGeom, UsdLux

from tests.scripts.conftest import ROOT, usdsdg

SMALLER = {
    "(640, 480)": "(32, 24)",
    "[512, 512]": "[32, 32]",
    "samples=64": "samples=1",
    "num_frames=10": "num_frames=2",
}
PAGES = sorted(path for path in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")] if "```python" in path.read_text())


def blocks(page, language: str) -> str:
    """Return all code blocks of a page in order; later ones use names of earlier ones."""
    text = "\n".join(
        re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    )
    for large, small in SMALLER.items():
        text = text.replace(large, small)
    return text


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
    wp.init()
    monkeypatch.setenv("WARP_CACHE_PATH", wp.config.kernel_cache_dir)
    monkeypatch.setenv("HOME", str(tmp_path))


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
    assert len(list((tmp_path / "omni.replicator_out/cubes").glob("rgb_*.png"))) == 10

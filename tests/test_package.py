"""The wheel and the sdist have all that the product needs: installed in an environment of their own, away from here."""

import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest

import usdsdg

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("usdsdg", "usdsdg_physics", "usdsdg_render")


def run(*command: str | Path, cwd: Path) -> str:
    """Run a command where nothing of this checkout is found; return what it printed."""
    environment = {
        name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "USDSDG_ASSETS_ROOT")
    }
    done = subprocess.run(
        [str(each) for each in command], cwd=cwd, capture_output=True, text=True, timeout=200, env=environment
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def sdist(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("sdist")
    run(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", folder, cwd=ROOT)
    (archive,) = folder.glob("*.tar.gz")
    return archive


@pytest.fixture(scope="module")
def wheel(sdist, tmp_path_factory) -> Path:
    """The wheel that is built from the sdist, not from the checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (source,) = (each for each in folder.iterdir() if each.is_dir())
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=source)
    (archive,) = folder.glob("*.whl")
    return archive


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    """The `bin` folder of an environment with the wheel; its dependencies are those of this one."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False, symlinks=True)
    place = sysconfig.get_path("purelib", vars={"base": str(folder), "platbase": str(folder)})
    # A folder in a .pth adds its packages, and not what its own .pth files add, such as this checkout.
    (Path(place) / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        folder,
        "install",
        "--no-deps",
        "--no-index",
        "-q",
        "--ignore-installed",
    ]
    run(*pip, wheel, cwd=folder)
    return folder / ("Scripts" if os.name == "nt" else "bin")


def files_below(*folders: str) -> set[str]:
    """Return all files below folders of the repository, but those that running its programs leaves."""
    found = {path.relative_to(ROOT) for name in folders for path in (ROOT / name).rglob("*") if path.is_file()}
    return {
        path.as_posix() for path in found if not any(part.startswith(("__pycache__", "_out")) for part in path.parts)
    }


def test_the_wheel_has_every_file_of_the_packages_and_nothing_else(wheel):
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert names == files_below(*PACKAGES)


def test_the_sdist_has_what_the_tests_need(sdist):
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "Dockerfile", "SECURITY.md"} <= names
    assert files_below("benchmarks", "configs", "docs", "examples", "tests", *PACKAGES) <= names


def test_the_metadata_has_one_version_and_what_an_index_shows(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (each for each in archive.namelist() if each.endswith("/METADATA"))
        metadata = Parser().parsestr(archive.read(name).decode())
    assert metadata["Version"] == usdsdg.__version__
    assert set(metadata["Requires-Python"].split(",")) == {">=3.11", "<3.14"}
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata["License-Expression"] == "Apache-2.0"
    assert {"stores", "exr", "meshes", "parquet", "denoise", "ray"} <= set(metadata.get_all("Provides-Extra"))


def test_the_installed_wheel_makes_a_dataset(installed, tmp_path):
    program = installed / "usdsdg"
    where = run(installed / "python", "-c", "import usdsdg, usdsdg_render; print(usdsdg.__file__)", cwd=tmp_path)
    assert where.startswith(str(installed.parent))
    assert run(program, "--version", cwd=tmp_path) == f"usdsdg {usdsdg.__version__}\n"
    run(program, "new", "detection", cwd=tmp_path)
    run(
        program,
        "generate",
        "detection.yaml",
        "-q",
        "--inspect",
        "--set",
        "num_frames=1",
        "--set",
        "resolution=[64,48]",
        cwd=tmp_path,
    )
    assert list((tmp_path / "_out_detection" / "yolo").rglob("*.png"))
    assert "<html" in next((tmp_path / "_out_detection").rglob("inspect.html")).read_text(encoding="utf-8")[:200]
    run(program, "verify", "_out_detection", cwd=tmp_path)

"""The object-based scenario at a small size, run as a user would run it, once for all tests of this folder."""

import subprocess
from pathlib import Path

import pytest

from tests import forked

ROOT = Path(__file__).resolve().parents[2]

SMALL = [
    "num_frames=2", "resolution=[160,120]", "shape_distractors_num=20", "mesh_distractors_num=15",
    "path_tracing.spp=8", "path_tracing.sub_frames=4", "rt_subframes=1",
]  # fmt: skip
ALL_LABELS = [
    "rgb", "bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d", "instance_segmentation",
    "semantic_segmentation", "distance_to_camera", "distance_to_image_plane", "camera_params", "occlusion", "normals",
]  # fmt: skip


def usdsdg(*arguments: str, cwd: Path, expect: int = 0, fresh: bool = False) -> subprocess.CompletedProcess[str]:
    """Run the command line in `cwd`; `fresh` as in `forked.run`."""
    done = forked.run(["-m", "usdsdg", *arguments], cwd=cwd, fresh=fresh)
    assert done.returncode == expect, f"{done.stdout}\n{done.stderr}"
    return done


def generate(folder: Path, *more: str) -> Path:
    """Generate one small dataset of the default configuration; return its folder."""
    overrides = [f"--set={item}" for item in (*SMALL, *more)]
    usdsdg("generate", str(ROOT / "configs" / "object_based.yaml"), "--quiet", *overrides, cwd=folder)
    return folder / "_out_object_based"


def basic_writer() -> list[str]:
    """Overrides that make BasicWriter write everything, with ids instead of colors."""
    return [
        "writer_type=BasicWriter",
        "writer_kwargs={output_dir: _out_object_based, colorize_instance_segmentation: false, "
        + "colorize_semantic_segmentation: false, "
        + ", ".join(f"{name}: true" for name in ALL_LABELS)
        + "}",
    ]


@pytest.fixture(scope="session")
def labeled(tmp_path_factory) -> Path:
    """A dataset of BasicWriter with all labels of the tests."""
    return generate(tmp_path_factory.mktemp("labeled"), *basic_writer())


@pytest.fixture(scope="session")
def posed(tmp_path_factory) -> Path:
    """A dataset of PoseWriter."""
    return generate(tmp_path_factory.mktemp("posed"))

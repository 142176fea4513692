"""`python -m docs.pictures [NAME ...]` makes pictures of the documentation again: these, or all.

Beside a picture in docs/gallery or docs/images stands the program that makes it; those of examples are made by these.
`viewer.png` alone is a screenshot of a browser.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
# Pictures by example: its options, and the files of its output folder that are shown.
EXAMPLES = {
    "first_script": ("--frames 1 --width 320", {"example_first_script": "rgb_0000.png"}),
    "yolo_writer": ("--frames 1 --width 320", {"example_yolo_writer": "picture_0000.png"}),
    "hidden_parts": ("--width 480", {"example_hidden_parts": "hidden_parts.png"}),
    "physics_drop": ("--width 240", {"example_physics_drop": "picture.png"}),
    "fisheye_points": ("--width 240", {"example_fisheye_points": "views.png"}),
    "own_assets": ("--width 200", {"example_own_assets": "dataset/000003_overlay.png"}),
    "many_cameras": ("--width 160", {"example_many_cameras": "masks.png"}),
    "depth_of_field": ("--width 320", {"example_depth_of_field": "picture.png"}),
    "own_annotators": (
        "--width 256",
        {
            "example_own_annotators": "keypoints.png",
            **{
                f"annotator_{each}": f"{each}.png"
                for each in ("amodal_boxes", "oriented_boxes", "object_coordinates", "correspondence")
            },
        },
    ),
}
# Pictures of examples stand in tables, where a page shows many of them.
MOST_BYTES = {"example": 60_000, "annotator": 60_000}
MOST_BYTES_OF_OTHERS = 200_000
COLORS = (256, 128)  # of palettes, which a picture that is larger gets


def names() -> list[str]:
    """Return the names of all pictures that programs make."""
    return sorted({*_beside(), *(name for _, shown in EXAMPLES.values() for name in shown)})


def make(wanted: set[str]) -> list[Path]:
    """Make pictures by their names, each in place of the one that is there.

    Returns:
        Their files.

    Raises:
        subprocess.CalledProcessError: a program failed.
    """
    made = []
    for name, program in _beside().items():
        if name in wanted:
            made += _run([str(program)], {f"{name}.png": program.with_suffix(".png")})
    for example, (options, shown) in EXAMPLES.items():
        targets = {f"out/{file}": IMAGES / f"{name}.png" for name, file in shown.items() if name in wanted}
        if targets:
            # An example that imports `omni` is a script for `usdsdg run`.
            start = ["-m", "usdsdg", "run"] if example == "first_script" else []
            arguments = [*start, str(ROOT / "examples" / f"{example}.py"), "--out", "out", *shlex.split(options)]
            made += _run(arguments, targets)
    return made


def save_small(picture: Image.Image, file: Path) -> None:
    """Save a picture as PNG without alpha; with a palette if it is larger than such pictures may be."""
    limit = MOST_BYTES.get(file.stem.split("_")[0], MOST_BYTES_OF_OTHERS)
    picture.convert("RGB").save(file, optimize=True)
    for colors in COLORS:
        if file.stat().st_size > limit:
            picture.convert("RGB").quantize(colors).save(file, optimize=True)


def _beside() -> dict[str, Path]:
    """Return the programs that stand beside their pictures, by the names of these."""
    return {file.stem: file for room in ("gallery", "images") for file in sorted((ROOT / "docs" / room).glob("*.py"))}


def _run(arguments: list[str], targets: dict[str, Path]) -> list[Path]:
    """Run a program in an empty folder, and copy files that it writes there."""
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    with tempfile.TemporaryDirectory() as folder:
        variables = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        subprocess.run([sys.executable, *arguments], cwd=folder, env=variables, check=True)
        for file, target in targets.items():
            with Image.open(Path(folder) / file) as picture:
                save_small(picture, target)
    return list(targets.values())


def main() -> None:
    wanted = set(sys.argv[1:]) or set(names())
    if unknown := wanted - set(names()):
        sys.exit(f"no program makes {', '.join(sorted(unknown))}; there are {', '.join(names())}")
    for file in make(wanted):
        print(file.relative_to(ROOT))


if __name__ == "__main__":
    main()

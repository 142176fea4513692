"""`isaacsim.benchmark.services.validation`: images of all render products against those of an earlier run."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pxr import Usd

from usdsdg import orchestrator
from usdsdg.errors import DatasetError, Unsupported
from usdsdg.session import render_products
from usdsdg.writers import registry as writers

DEFAULT_BLUR = 3
DEFAULT_TOLERANCE = 5.0
DEFAULT_TIMESTAMP_TOLERANCE_SEC = 0.01

_INDEXED = re.compile(r"(\w+)_(\d+)\.png", re.IGNORECASE)
_TIMED = re.compile(r"(\w+)_(\d+\.\d+)\.png", re.IGNORECASE)

# A captured file, and the earlier file it is compared with or why there is none.
Pair = tuple[Path, Path | str]


class Validator:
    """Captures an image of every render product, and compares it with the image of an earlier run.

    Args:
        tolerance: Mean difference of pixels, of 255, that images may have.
        blur_kernel: Width [pixels] of a Gaussian that both images are blurred with before; 0 for none.
        regenerate_golden: Write the images to `golden_root`, in place of those there, and compare nothing.
        output_root: Parent folder of captured images.
        golden_root: Parent folder of the images to compare with.
        auto_cleanup: Whether captured images are deleted after the comparison.
    """

    def __init__(
        self,
        *,
        tolerance: float = DEFAULT_TOLERANCE,
        blur_kernel: int = DEFAULT_BLUR,
        regenerate_golden: bool = False,
        output_root: str = "captures",
        golden_root: str = "golden_data",
        auto_cleanup: bool = True,
    ) -> None:
        self.tolerance, self.blur_kernel, self.regenerate_golden = tolerance, blur_kernel, regenerate_golden
        self.output_root, self.golden_root, self.auto_cleanup = str(output_root), str(golden_root), auto_cleanup
        self.render_product_map: dict[str, str] = {}
        self._captured: Path | None = None
        self._benchmark_name = ""

    @classmethod
    def from_cli_args(cls, args: Any, *, auto_cleanup: bool | None = None) -> Validator:
        """Return a validator with the options that `args` has: tolerance, blur_kernel, output_dir, golden_dir, ..."""
        return cls(
            tolerance=getattr(args, "tolerance", DEFAULT_TOLERANCE),
            blur_kernel=getattr(args, "blur_kernel", DEFAULT_BLUR),
            regenerate_golden=getattr(args, "regenerate_golden", False),
            output_root=str(Path(getattr(args, "output_dir", "captures")).absolute()),
            golden_root=str(Path(getattr(args, "golden_dir", "golden_data")).absolute()),
            auto_cleanup=True if auto_cleanup is None else auto_cleanup,
        )

    def run(self, stage: Usd.Stage, *, benchmark_name: str) -> bool:
        """Capture, compare, and return whether all images agree; True where they were regenerated."""
        self.build_render_product_map(stage)
        self.capture_images(stage, benchmark_name=benchmark_name)
        return self.regenerate_golden or self.validate_images()

    # --- images of this run ---
    def build_render_product_map(
        self, stage: Usd.Stage, root_prim_path: str = "/Render/OmniverseKit/HydraTextures"
    ) -> dict[str, str]:
        """Return the folder name, its camera's path, of each render product by its prim path; a number makes it unique.

        `root_prim_path` is ignored: render products are listed wherever they are.
        """
        self.render_product_map = {}
        for product in render_products.products():
            name = camera = product.camera_path.lstrip("/")
            number = 0
            while name in self.render_product_map.values():
                number += 1
                name = f"{camera}_{number}"
            self.render_product_map[product.path] = name
        return self.render_product_map

    def capture_images(
        self,
        stage: Usd.Stage,
        *,
        benchmark_name: str,
        output_root: str | None = None,
        golden_root: str | None = None,
        writer_name: str = "BasicWriter",
    ) -> str:
        """Write one image of each render product; return their folder.

        Raises:
            Unsupported: there is no render product.
        """
        if not self.render_product_map and not self.build_render_product_map(stage):
            raise Unsupported("Validator: there is no render product; create one with rep.create.render_product")
        self.output_root, self.golden_root = output_root or self.output_root, golden_root or self.golden_root
        folder = Path(self.output_root) / f"{benchmark_name}_{datetime.now():%Y%m%d_%H%M%S}"
        if self.regenerate_golden:
            folder = Path(self.golden_root) / benchmark_name
            shutil.rmtree(folder, ignore_errors=True)
        writer = writers.get(writer_name)
        writer.initialize(output_dir=str(folder), rgb=True)
        writer.attach(list(self.render_product_map))
        orchestrator.step()
        orchestrator.wait_until_complete()
        writer.detach()
        self.rename_writer_folders(str(folder))
        self._captured, self._benchmark_name = folder, benchmark_name
        if self.regenerate_golden:
            print(f"Validator: wrote the images to compare with to {folder}; look at them")
        return str(folder)

    def rename_writer_folders(self, output_dir: str) -> None:
        """Move each render product's files to the folder of its camera's path."""
        root = Path(output_dir)
        for path, name in self.render_product_map.items():
            # With a single render product there is no folder for it.
            found = root / path.rsplit("/", 1)[-1]
            if not found.is_dir():
                found = root / "rgb" if (root / "rgb").is_dir() else root
            files = [each for each in found.rglob("*.png") if each.is_file()]
            target = root / name
            for file in files:
                inner = file.relative_to(found).parts[-1]
                (target / "rgb").mkdir(parents=True, exist_ok=True)
                file.rename(target / "rgb" / inner)
            if found != root:
                shutil.rmtree(found, ignore_errors=True)

    def rename_captured_frames_to_timestamps(self, run_dir: str, frame_timestamps: list[float]) -> None:
        """Rename `rgb_0001.png` to `rgb_<frame_timestamps[1]>.png`, everywhere below a folder."""
        for file in sorted(Path(run_dir).rglob("*.png")):
            parts = _INDEXED.fullmatch(file.name)
            if parts and int(parts[2]) < len(frame_timestamps):
                file.rename(file.with_name(f"{parts[1]}_{frame_timestamps[int(parts[2])]:.6f}.png"))

    @staticmethod
    def parse_timestamp_from_basename(basename: str) -> float | None:
        """Return the seconds of `rgb_12.500000.png`, None of other names."""
        parts = _TIMED.fullmatch(basename)
        return float(parts[2]) if parts else None

    def clear_last_capture(self) -> None:
        """Delete the images of the last capture."""
        if self._captured is not None:
            shutil.rmtree(self._captured, ignore_errors=True)
        self._captured = None

    # --- comparison ---
    def validate_images(self, captured_dir: str | None = None, golden_dir: str | None = None) -> bool:
        """Return whether images of the last capture, or of a folder, agree with earlier ones; print those that do not.

        Raises:
            DatasetError: nothing was captured and no folder is given.
        """
        captured = Path(captured_dir) if captured_dir else self._captured
        if captured is None:
            raise DatasetError("validate_images: capture images first, or give captured_dir")
        golden = Path(golden_dir) if golden_dir else Path(self.golden_root) / self._benchmark_name
        fits = True
        for name in sorted(self.render_product_map.values()):
            if not ((captured / name).is_dir() and (golden / name).is_dir()):
                print(f"Validator: {name}: no folder {golden / name} to compare {captured / name} with")
                fits = False
                continue
            frames = self._compared(name, _same_names(captured / name, golden / name))
            fits = fits and all(frame["passed"] for frame in frames)
        print(f"Validator: {'all images agree' if fits else 'images differ'}")
        if self.auto_cleanup:
            self.clear_last_capture()
        return fits

    def validate_frames(self, captured_run_dir: str, golden_benchmark_dir: str) -> dict[str, Any]:
        """Compare all frames of two runs by their names; counts are of render products.

        Returns:
            "total", "passed", "failed", and "render_products": for each "passed", "total_files", "failures" and
            "frame_results".

        Raises:
            DatasetError: a folder is missing.
        """
        products = self._compare_runs(captured_run_dir, golden_benchmark_dir, _same_names)
        passed = sum(each["passed"] for each in products.values())
        return _result(products, len(products), passed)

    def validate_frames_by_timestamp(
        self,
        captured_run_dir: str,
        golden_benchmark_dir: str,
        time_tolerance_sec: float = DEFAULT_TIMESTAMP_TOLERANCE_SEC,
    ) -> dict[str, Any]:
        """Compare frames of two runs with the nearest simulation time in their names; counts are of frames.

        Returns and raises what `validate_frames` does.
        """

        def pairs(captured: Path, golden: Path) -> Iterator[Pair]:
            return _nearest_times(captured, golden, time_tolerance_sec)

        products = self._compare_runs(captured_run_dir, golden_benchmark_dir, pairs)
        frames = [frame for each in products.values() for frame in each["frame_results"]]
        return _result(products, len(frames), sum(frame["passed"] for frame in frames))

    def _compare_runs(
        self, captured: str, golden: str, pairs: Callable[[Path, Path], Iterator[Pair]]
    ) -> dict[str, dict[str, Any]]:
        for folder in (captured, golden):
            if not Path(folder).is_dir():
                raise DatasetError(f"Validator: {folder} is not a folder")
        names = self.render_product_map.values() or [each.name for each in Path(captured).iterdir() if each.is_dir()]
        found = {}
        for name in sorted(names):
            mine, theirs = Path(captured) / name, Path(golden) / name
            if mine.is_dir() and theirs.is_dir():
                frames = self._compared(name, pairs(mine, theirs))
                failures = [f"{frame['file']}: {frame.get('reason')}" for frame in frames if not frame["passed"]]
                passed = bool(frames) and not failures
                found[name] = {
                    "passed": passed, "total_files": len(frames), "failures": failures, "frame_results": frames,
                }  # fmt: skip
        return found

    def _compared(self, name: str, pairs: Iterator[Pair]) -> list[dict[str, Any]]:
        frames = []
        for captured, golden in pairs:
            frame: dict[str, Any] = {"file": captured.name, "passed": False}
            if isinstance(golden, str):
                frame["reason"] = golden
            else:
                frame |= self._difference(captured, golden)
            frames.append(frame)
            if not frame["passed"]:
                print(f"Validator: {name}: {captured.name}: {frame['reason']}")
        return frames

    def _difference(self, captured: Path, golden: Path) -> dict[str, Any]:
        mine, theirs = (np.asarray(Image.open(file)).astype(np.float32) for file in (captured, golden))
        if mine.shape != theirs.shape:
            return {"passed": False, "reason": f"its shape is {mine.shape}, not {theirs.shape}"}
        if self.blur_kernel > 0:
            mine, theirs = (_blurred(image, self.blur_kernel | 1) for image in (mine, theirs))
        mean = float(np.abs(np.rint(mine) - np.rint(theirs)).mean())
        reason = f"the mean difference is {mean:.2f}, above {self.tolerance}"
        return {"passed": mean <= self.tolerance, "mean_diff": mean, "reason": reason}


def _same_names(captured: Path, golden: Path) -> Iterator[Pair]:
    for file in sorted(captured.rglob("*.png")):
        other = golden / file.relative_to(captured)
        if other.is_file():
            yield file, other


def _nearest_times(captured: Path, golden: Path, tolerance: float) -> Iterator[Pair]:
    known = sorted(
        (time, file)
        for file in golden.rglob("*.png")
        if (time := Validator.parse_timestamp_from_basename(file.name)) is not None
    )
    for file in sorted(captured.rglob("*.png")):
        time = Validator.parse_timestamp_from_basename(file.name)
        if time is None:
            continue
        off, nearest = min(((abs(other - time), path) for other, path in known), default=(np.inf, file))
        yield file, nearest if off <= tolerance else f"no earlier frame within {tolerance} s of {time:.6f} s"


def _blurred(image: np.ndarray, width: int) -> np.ndarray:
    """Return an image (H, W) or (H, W, C) blurred with a Gaussian of `width` pixels, mirrored at its borders."""
    # The usual spread for a kernel of this width.
    spread = 0.3 * ((width - 1) * 0.5 - 1) + 0.8
    offsets = np.arange(width) - width // 2
    weights = np.exp(-(offsets**2) / (2.0 * spread**2))
    weights /= weights.sum()
    for axis in (0, 1):
        margins = np.zeros((image.ndim, 2), int)
        margins[axis] = width // 2
        padded, length = np.pad(image, margins, mode="reflect"), image.shape[axis]
        image = sum(w * np.take(padded, np.arange(i, i + length), axis) for i, w in enumerate(weights))  # type: ignore[assignment]
    return image


def _result(products: dict[str, dict[str, Any]], total: int, passed: int) -> dict[str, Any]:
    return {"render_products": products, "total": total, "passed": passed, "failed": total - passed}

"""The interface of path tracers that render the benchmark scene, and a process of its own for each.

Each has its own process because threads that one leaves spinning would be counted for the others, and because
Blender's libraries conflict with those of USD. Only records without USD types are passed.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from typing import Any, NamedTuple, Protocol

import numpy as np

# Surfaces that a path may hit.
SURFACES = 3


class View(NamedTuple):
    """A pinhole camera that looks along -z; lengths as in `CameraView`."""

    prim_path: str
    width: int
    height: int
    local_to_world: np.ndarray  # (4, 4), row vectors
    focal_length: float
    horizontal_aperture: float
    clipping_range: tuple[float, float]


class TimedImage(NamedTuple):
    """An image and the time that it took."""

    image: np.ndarray  # (H, W, 3) float32 mean radiance [nits]
    cpu: float  # seconds of the tracer's process, all threads together
    wall: float


class PathTracer(Protocol):
    """Renders a scene with paths of SURFACES surfaces, without clamps or filters."""

    name: str

    def render(self, view: View, samples: int, seed: int) -> np.ndarray:
        """Return the mean radiance (H, W, 3) float32 [nits]; noise differs between seeds."""
        ...


class TracerProcess:
    """A path tracer in another process, which `close` ends.

    Args:
        kind: "module:class" of the tracer, which takes the scene and the options.
    """

    def __init__(self, kind: str, scene: Any, **options: Any) -> None:
        # OpenBLAS threads spin for a while after each call.
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", "benchmarks.tracer_process", kind]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        self.name: str = self._ask((scene, options))

    def render(self, view: View, samples: int, seed: int) -> TimedImage:
        return TimedImage(*self._ask((view, samples, seed)))

    def close(self) -> None:
        """End the process."""
        self._process.stdin.close()
        self._process.wait()

    def _ask(self, question: Any) -> Any:
        pickle.dump(question, self._process.stdin)
        self._process.stdin.flush()
        try:
            return pickle.load(self._process.stdout)
        except EOFError:
            raise RuntimeError(f"{self._process.args[-1]} ended with {self._process.wait()}, see above") from None

"""Path tracers that draw the benchmark scene: what they have in common, and a process of its own for each.

A process of its own because threads that one of them leaves spinning would be counted for the others, and because
Blender's libraries do not get along with those of USD. Only records without USD cross over.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from typing import Any, NamedTuple, Protocol

import numpy as np

# Surfaces that a path may meet.
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


class Drawn(NamedTuple):
    """A picture and what it took."""

    picture: np.ndarray  # (H, W, 3) float32 mean radiance [nits]
    cpu: float  # seconds of the tracer's process, all threads together
    wall: float


class PathTracer(Protocol):
    """Draws the scene that it was made of, with paths of SURFACES surfaces and neither clamp nor filter."""

    name: str

    def picture(self, view: View, samples: int, seed: int) -> np.ndarray:
        """(H, W, 3) float32 mean radiance [nits]; each seed gives noise of its own."""
        ...


class TracerProcess:
    """A path tracer at the other end of a pipe; it ends with this object's `close`.

    Args:
        kind: "module:class" of the tracer, which takes the scene and the options.
    """

    def __init__(self, kind: str, scene: Any, **options: Any) -> None:
        # Threads of linear algebra spin for a while after each call.
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", "benchmarks.tracer_process", kind]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        self.name: str = self._ask((scene, options))

    def draw(self, view: View, samples: int, seed: int) -> Drawn:
        return Drawn(*self._ask((view, samples, seed)))

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

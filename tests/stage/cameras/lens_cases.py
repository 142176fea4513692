"""Calibrated cameras of all projection types, for tests of everything that uses lenses."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from usdsdg.image_files import exr
from usdsdg.stage.cameras.lens_attributes import LensParameters

# Strong barrel distortion, decentered, with different focal lengths; coefficients typical of calibrations.
_BARREL = LensParameters(
    nominal_size=(1920.0, 1200.0),
    center=(943.8, 602.3),
    focal=(640.0, 620.0),
    max_fov=170.0,
    polynomial=(-0.08, 0.012, -0.003, 0.02, -0.001, 0.0002),
    tangential=(0.0011, -0.0007),
    thin_prism=(-0.0006, 0.0002, 0.0019, -0.0003),
)
# NVIDIA's f-theta lens for 1936 x 1216 pixels: the default of Omniverse's property window.
F_THETA = LensParameters(
    polynomial=(0.0, 2.45417095720768e-3, 3.72747912535942e-8, -1.43520517692508e-9, 9.76e-13, 0.0)
)


def mei_directions(fractions: np.ndarray) -> np.ndarray:
    """Return the unit directions (N, 3) of Mei's unified model at fractions (N, 2) of an image with aspect ratio 8 : 5.

    It has two focal lengths and is decentered; directions are zero beyond 95 % of the mirror's visible radius.
    """
    xi, focal, center = 1.3, (0.42, 0.68), (0.47, 0.52)
    x, y = ((fractions - center) / focal).T
    r2 = x * x + y * y
    seen = r2 < 0.95**2 / (xi**2 - 1)
    scale = (xi + np.sqrt(np.maximum(1 + (1 - xi**2) * r2, 0))) / (1 + r2)
    return np.where(seen, [scale * x, -scale * y, xi - scale], 0.0).T


def write_directions(file: Path, size: tuple[int, int]) -> str:
    """Write an EXR file of `mei_directions` with width x height texels; return its path."""
    across, down = np.meshgrid(*((np.arange(each) + 0.5) / each for each in size))
    directions = mei_directions(np.stack([across, down], axis=-1).reshape(-1, 2))
    file.write_bytes(exr.encode(directions.reshape(size[1], size[0], 3).astype(np.float32)))
    return str(file)


_FOLDER = tempfile.TemporaryDirectory()
_TABLE = LensParameters(
    nominal_size=(480.0, 300.0),
    center=(243.0, 149.0),
    direction_texture=write_directions(Path(_FOLDER.name) / "directions.exr", (480, 300)),
)
PANORAMAS = ("fisheyeSpherical", "omniDirectionalStereo")

# Arguments of CameraView.
CASES = {
    "pinhole": {},
    "orthographic": dict(projection_type="orthographic", horizontal_aperture=60.0),
    "pinholeOpenCV": dict(projection_type="pinholeOpenCV", lens_parameters=_BARREL),
    "pinholeOpenCV by default": dict(projection_type="pinholeOpenCV"),
    "fisheyeOpenCV": dict(projection_type="fisheyeOpenCV", lens_parameters=_BARREL),
    "fisheyePolynomial": dict(projection_type="fisheyePolynomial", lens_parameters=F_THETA),
    "fisheyePolynomial by default": dict(projection_type="fisheyePolynomial"),
    "fisheyeKannalaBrandtK3": dict(projection_type="fisheyeKannalaBrandtK3", lens_parameters=_BARREL, focal_length=8.0),
    "fisheyeRadTanThinPrism": dict(projection_type="fisheyeRadTanThinPrism", lens_parameters=_BARREL, focal_length=8.0),
    "fisheyeSpherical": dict(projection_type="fisheyeSpherical"),
    "fisheyeOrthographic": dict(projection_type="fisheyeOrthographic", focal_length=6.0),
    "fisheyeEquidistant": dict(projection_type="fisheyeEquidistant", focal_length=3.0, vertical_aperture_offset=2.0),
    "fisheyeEquisolid": dict(projection_type="fisheyeEquisolid", focal_length=3.0),
    "omniDirectionalStereo": dict(
        projection_type="omniDirectionalStereo", lens_parameters=LensParameters(eye_distance=0.06, left_eye=True)
    ),
    "generalizedProjection": dict(projection_type="generalizedProjection", lens_parameters=_TABLE),
}
LENSES = {name: values for name, values in CASES.items() if name not in ("pinhole", "orthographic")}
